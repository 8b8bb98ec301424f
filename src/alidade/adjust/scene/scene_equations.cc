// SPDX-License-Identifier: MIT
#include "alidade/adjust/scene/scene_fit.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "alidade/core/error.h"
#include "alidade/core/vector_code.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/least_squares.h"

namespace alidade {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// Damps a point, and holds it where its sightings do not determine it.
void dampPoint(Eigen::Matrix3d& V, double damping) {
  V.diagonal() *= 1 + damping;
  V.diagonal().array() += 1e-12 * V.trace();
}

// The sightings of each point.
std::vector<std::span<const SceneSighting>> sightingsByPoint(const SceneFit& fit) {
  std::vector<std::span<const SceneSighting>> points;
  for (auto begin = fit.sightings.begin(); begin != fit.sightings.end();) {
    const auto end = std::find_if(begin, fit.sightings.end(),
                                  [&](const SceneSighting& s) { return s.point != begin->point; });
    points.emplace_back(begin, end);
    begin = end;
  }
  return points;
}

// The sightings of one frame in the normal equations, each with its columns of J and Y. Rows: those of the
// pose (6), then those of the error field, if there are fields, then zeros.
struct FrameColumns {
  Eigen::Index pose_at = -1;  // column in the normal equations; -1: none
  Eigen::Index field_at = -1;
  std::vector<std::uint32_t> points;  // of the sightings, ascending
  Eigen::MatrixXd J;                  // 2 per sighting: derivatives of the weighted error, transposed
  Eigen::MatrixXd Y;  // 3 per sighting: product of J, the derivative by the point and the root of its
                      // covariance, with which a point's products of two frames are Y Y^T

  // Calls act(column in the normal equations, first row, number of rows) for each part that exists.
  template <class Act>
  void forEach(const Act& act) const {
    if (pose_at >= 0) act(pose_at, Eigen::Index{0}, Eigen::Index{6});
    if (field_at >= 0) act(field_at, Eigen::Index{6}, Eigen::Index{ErrorField::kSize});
  }
};

// Several numbers at any address of a double.
#if defined(ALIDADE_HAS_VECTORS)
constexpr int kWidth = 4;
using Several =
    double __attribute__((vector_size(kWidth * sizeof(double)), aligned(alignof(double)), may_alias));
#else
constexpr int kWidth = 1;
using Several = double;
#endif
// Rows of FrameColumns, filled up with zeros.
constexpr Eigen::Index kPaddedPoseRows = 8;
constexpr Eigen::Index kPaddedRows = 28;
static_assert(kPaddedRows >= 6 + ErrorField::kSize);

// Sets `product` to the sum of a b^T over pairs of columns (a, b) of kNum vectors each.
template <int kNum>
void sumProducts(const std::vector<std::pair<const double*, const double*>>& columns,
                 Eigen::MatrixXd& product) {
  constexpr int kRows = kNum * kWidth;
  constexpr std::size_t kChunk = 24;  // pairs whose columns stay in the processor's first cache
  product.setZero(kRows, kRows);
  callVectorised([&]() ALIDADE_INLINE_LAMBDA {
    for (std::size_t begin = 0; begin < columns.size(); begin += kChunk) {
      const std::size_t end = std::min(columns.size(), begin + kChunk);
      for (int j = 0; j < kRows; j += 2) {
        auto* const to = reinterpret_cast<Several*>(product.col(j).data());
        Several first[kNum];
        Several second[kNum];
        for (int i = 0; i < kNum; ++i) {
          first[i] = to[i];
          second[i] = to[kNum + i];
        }
        for (std::size_t c = begin; c < end; ++c) {
          const auto* const rows = reinterpret_cast<const Several*>(columns[c].first);
          const double* const b = columns[c].second;
#pragma GCC unroll 8
          for (int i = 0; i < kNum; ++i) {
            first[i] += rows[i] * b[j];
            second[i] += rows[i] * b[j + 1];
          }
        }
        for (int i = 0; i < kNum; ++i) {
          to[i] = first[i];
          to[kNum + i] = second[i];
        }
      }
    }
  });
}

// Subtracts the product of two frames' columns for the points that both see from the lower triangle of the
// normal equations, in which fields come after all poses. `other` is the same or an earlier frame.
void subtractProduct(Eigen::MatrixXd& sum, const FrameColumns& own, const FrameColumns& other,
                     const Eigen::MatrixXd& product) {
  own.forEach([&](Eigen::Index at, Eigen::Index row, Eigen::Index rows) {
    other.forEach([&](Eigen::Index other_at, Eigen::Index column, Eigen::Index columns) {
      if (at >= other_at) {
        sum.block(at, other_at, rows, columns) -= product.block(row, column, rows, columns);
      } else if (&own != &other) {
        sum.block(other_at, at, columns, rows) -= product.block(row, column, rows, columns).transpose();
      }
    });
  });
}

// Change of the pose of each frame if the scene grows about the first camera's centre.
Eigen::VectorXd scaleDirection(const SceneFit& fit) {
  const std::size_t num_free = fit.camera_from_world.size() - fit.num_held_frames;
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * num_free));
  const Eigen::Vector3d first = fit.camera_from_world.front().inverse().translation;
  for (std::size_t i = 0; i < num_free; ++i) {
    const SE3 world_from_camera = fit.camera_from_world[i + fit.num_held_frames].inverse();
    direction.segment<3>(static_cast<Eigen::Index>(6 * i)) = first - world_from_camera.translation;
  }
  return direction;
}

// Columns of the camera's unknowns in the sums.
enum class CameraColumns : std::uint8_t { kNone, kAll };

// The sums over all points: normal equations of poses, fields and camera with each point eliminated.
class SceneSums {
 public:
  // With the camera's columns, the gradient of each point is kept, too. Damping raises the diagonal by this
  // share.
  SceneSums(const SceneFit& fit, CameraColumns columns, double damping = 0)
      : fit_(fit),
        damping_(damping),
        has_fields_(fit.field_px > 0),
        has_camera_(columns == CameraColumns::kAll),
        num_extra_(has_camera_ ? static_cast<Eigen::Index>(fit.camera.parameters().size()) + 1 : 0),
        num_pose_(6 * static_cast<Eigen::Index>(fit.camera_from_world.size() - fit.num_held_frames)),
        num_field_(has_fields_ ? ErrorField::kSize * static_cast<Eigen::Index>(fit.camera_from_world.size())
                               : 0),
        num_gone_(num_pose_ + num_field_),
        reduced_(Eigen::MatrixXd::Zero(num_gone_ + num_extra_, num_gone_ + num_extra_)),
        gradients_(Eigen::MatrixXd::Zero(num_gone_ + num_extra_,
                                         has_camera_ ? static_cast<Eigen::Index>(fit.points.size()) : 1)),
        frames_(fit.camera_from_world.size()) {
    prepareFrames();
    for (const auto& sightings : sightingsByPoint(fit)) addPoint(sightings);
    addFrames();
    reduced_.triangularView<Eigen::StrictlyUpper>() = reduced_.transpose().eval();
    num_redundant_ -= static_cast<double>(num_pose_) - (fit.num_held_frames == 1 ? 1 : 0);
  }

  // The equations with poses and fields also eliminated.
  [[nodiscard]] SceneEquations equations() const {
    SceneEquations result;
    result.cost = cost_;
    result.num_redundant = num_redundant_;
    const Eigen::MatrixXd A = poseAndFieldEquations();
    // At the optimum, the gradients of the priors cancel those of the points.
    const Eigen::VectorXd prior = priorGradient();
    for (const ErrorField::Coefficients& field : fit_.fields) result.field_square += field.squaredNorm();
    result.cost += 0.5 * priorPrecision() * result.field_square;
    const Eigen::MatrixXd B = reduced_.topRightCorner(num_gone_, num_extra_);
    // The root of the inverse is faster than a pivoted factor, which also exists where rounding makes A
    // indefinite.
    Eigen::MatrixXd T = B;
    const auto root = num_gone_ > 0 ? inverseRootOf(A) : std::nullopt;
    Eigen::MatrixXd inverse;
    if (root) T = *root * (root->transpose() * B);
    if (num_gone_ > 0 && !root) T = solveSpd(A, B, &inverse);
    result.information =
        Eigen::MatrixXd(reduced_.bottomRightCorner(num_extra_, num_extra_) - B.transpose() * T);
    result.point_gradients =
        Eigen::MatrixXd(gradients_.bottomRows(num_extra_) - T.transpose() * gradients_.topRows(num_gone_));
    result.prior_gradient = Eigen::MatrixXd(-T.transpose() * prior);
    if (num_gone_ > 0) {
      result.J_optimum_camera = Eigen::MatrixXd(-T);
      if (root) {
        result.pose_covariance =
            Eigen::MatrixXd(root->topRows(num_pose_) * root->topRows(num_pose_).transpose());
        result.field_variance = root->bottomRows(num_field_).squaredNorm();
      } else {
        result.pose_covariance = Eigen::MatrixXd(inverse.topLeftCorner(num_pose_, num_pose_));
        result.field_variance = inverse.bottomRightCorner(num_field_, num_field_).trace();
      }
    }
    return result;
  }

  // A Gauss-Newton step of poses and fields, and the decrease of the cost that it promises together with the
  // points' own steps.
  struct Step {
    Eigen::VectorXd change;  // NaN if the equations are singular
    double promise = 0;
  };
  [[nodiscard]] Step step() const {
    Step step{.change = Eigen::VectorXd::Zero(num_gone_), .promise = promise_};
    if (num_gone_ == 0) return step;
    const Eigen::VectorXd gradient = gradients_.col(0) + priorGradient();
    const Eigen::MatrixXd A = poseAndFieldEquations();
    const Eigen::MatrixXd L = choleskyOf(A);
    const Eigen::VectorXd half = solveLower(L, gradient);
    step.change = -L.transpose().triangularView<Eigen::Upper>().solve(half);
    step.promise += 0.5 * half.squaredNorm();
    // A factor that broke off solves other equations.
    constexpr double kUnsolved = 0.1;
    if (!((A * step.change + gradient).norm() <= kUnsolved * gradient.norm())) {
      step.change.setConstant(kNoNumber);
      step.promise = std::numeric_limits<double>::infinity();
    }
    return step;
  }

 private:
  [[nodiscard]] double priorPrecision() const {
    return has_fields_ ? 1 / (fit_.field_px * fit_.field_px) : 0;
  }

  [[nodiscard]] Eigen::MatrixXd poseAndFieldEquations() const {
    Eigen::MatrixXd A = reduced_.topLeftCorner(num_gone_, num_gone_);
    holdScale(A);
    A.diagonal().tail(num_field_).array() += priorPrecision();
    return A;
  }

  // At the present fields.
  [[nodiscard]] Eigen::VectorXd priorGradient() const {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(num_gone_);
    for (Eigen::Index i = 0; i < num_field_; i += ErrorField::kSize)
      gradient.segment<ErrorField::kSize>(num_pose_ + i) =
          priorPrecision() * fit_.fields[static_cast<std::size_t>(i / ErrorField::kSize)];
    return gradient;
  }

  void prepareFrames() {
    std::vector<Eigen::Index> count(frames_.size(), 0);
    for (const SceneSighting& sighting : fit_.sightings) ++count[sighting.frame];
    const Eigen::Index rows = has_fields_ ? kPaddedRows : kPaddedPoseRows;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      FrameColumns& frame = frames_[i];
      if (i >= fit_.num_held_frames) frame.pose_at = 6 * static_cast<Eigen::Index>(i - fit_.num_held_frames);
      if (has_fields_) frame.field_at = num_pose_ + ErrorField::kSize * static_cast<Eigen::Index>(i);
      frame.J.setZero(rows, 2 * count[i]);
      frame.Y.setZero(rows, 3 * count[i]);
    }
  }

  // Adds the products of each frame, and subtracts those of each pair of frames through the points that both
  // see.
  void addFrames() {
    std::vector<std::pair<const double*, const double*>> columns;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const FrameColumns& own = frames_[i];
      Eigen::MatrixXd product = -own.J * own.J.transpose();
      product.diagonal() *= 1 + damping_;
      subtractProduct(reduced_, own, own, product);
      for (std::size_t k = 0; k <= i; ++k) {
        const FrameColumns& other = frames_[k];
        columns.clear();
        for (std::size_t a = 0, b = 0; a < own.points.size() && b < other.points.size();) {
          const auto order = own.points[a] <=> other.points[b];
          if (order == 0) {
            for (int d = 0; d < 3; ++d)
              columns.emplace_back(own.Y.col(static_cast<Eigen::Index>(3 * a) + d).data(),
                                   other.Y.col(static_cast<Eigen::Index>(3 * b) + d).data());
          }
          a += order <= 0 ? 1 : 0;
          b += order >= 0 ? 1 : 0;
        }
        if (columns.empty()) continue;
        has_fields_ ? sumProducts<kPaddedRows / kWidth>(columns, product)
                    : sumProducts<kPaddedPoseRows / kWidth>(columns, product);
        subtractProduct(reduced_, own, other, product);
      }
    }
  }

  void addPoint(std::span<const SceneSighting> sightings) {
    tangent_ = pointTangent(fit_.points[sightings.front().point]);
    V_.setZero();
    v_.setZero();
    W_camera_.setZero(num_extra_, 3);
    places_.clear();
    expect(sightings.front().point >= last_point_, "sightings are in order of points");
    last_point_ = sightings.front().point;
    auto gradient = gradients_.col(has_camera_ ? static_cast<Eigen::Index>(sightings.front().point) : 0);
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      expect(i == 0 || sightings[i - 1].frame < sightings[i].frame, "sightings are in order of frames");
      addSighting(sightings[i], gradient);
    }
    eliminate(gradient);
  }

  void addSighting(const SceneSighting& sighting, Eigen::Ref<Eigen::VectorXd> gradient) {
    Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 25> J_camera(2, num_extra_);
    const SceneProjection p = projectSighting(fit_, sighting, has_camera_);
    expect(p.ok, "every sighting projects");
    const double scale = 1 / sighting.sigma_px;
    Eigen::Vector2d error = scale * p.error;
    cost_ += 0.5 * fit_.loss.rho(error.squaredNorm());
    num_redundant_ += 2;
    const double weight = std::sqrt(fit_.loss.weight(error.squaredNorm()));
    error *= weight;
    FrameColumns& frame = frames_[sighting.frame];
    const auto index = static_cast<Eigen::Index>(frame.points.size());
    frame.points.push_back(sighting.point);
    places_.emplace_back(&frame, index);
    auto J = frame.J.middleCols<2>(2 * index);
    J.topRows<6>() = weight * scale * p.J_pose.transpose();
    if (has_fields_) {
      J.block<ErrorField::kTerms, 1>(6, 0) = weight * scale * p.field;
      J.block<ErrorField::kTerms, 1>(6 + ErrorField::kTerms, 1) = weight * scale * p.field;
    }
    if (has_camera_) J_camera << weight * scale * p.J_params, weight * scale * sighting.readout_px;
    const Eigen::Matrix<double, 2, 3> J_point = weight * scale * p.J_point * tangent_;
    V_.noalias() += J_point.transpose() * J_point;
    v_.noalias() += J_point.transpose() * error;
    frame.Y.middleCols<3>(3 * index).noalias() = J.lazyProduct(J_point);
    W_camera_.noalias() += J_camera.transpose() * J_point;
    frame.forEach([&](Eigen::Index at, Eigen::Index row, Eigen::Index rows) {
      gradient.segment(at, rows).noalias() += J.middleRows(row, rows).lazyProduct(error);
      if (has_camera_)
        reduced_.block(num_gone_, at, num_extra_, rows).noalias() +=
            J_camera.transpose().lazyProduct(J.middleRows(row, rows).transpose());
    });
    gradient.tail(num_extra_).noalias() += J_camera.transpose() * error;
    reduced_.bottomRightCorner(num_extra_, num_extra_).noalias() += J_camera.transpose() * J_camera;
  }

  // Eliminates the point from the sums.
  void eliminate(Eigen::Ref<Eigen::VectorXd> gradient) {
    num_redundant_ -= 3;
    dampPoint(V_, damping_);
    const Eigen::LLT<Eigen::Matrix3d> factor(V_);
    const Eigen::Vector3d shift = factor.matrixL().solve(v_);
    promise_ += 0.5 * shift.squaredNorm();
    const Eigen::Matrix3d root = factor.matrixU().solve(Eigen::Matrix3d::Identity());
    const Eigen::Matrix<double, Eigen::Dynamic, 3> Y_camera = W_camera_ * root;
    for (const auto& [frame, index] : places_) {
      auto Y = frame->Y.middleCols<3>(3 * index);
      Y = Y.lazyProduct(root).eval();
      frame->forEach([&](Eigen::Index at, Eigen::Index row, Eigen::Index rows) {
        gradient.segment(at, rows).noalias() -= Y.middleRows(row, rows).lazyProduct(shift);
        if (has_camera_)
          reduced_.block(num_gone_, at, num_extra_, rows).noalias() -=
              Y_camera.lazyProduct(Y.middleRows(row, rows).transpose());
      });
    }
    gradient.tail(num_extra_).noalias() -= Y_camera * shift;
    reduced_.bottomRightCorner(num_extra_, num_extra_).noalias() -= Y_camera * Y_camera.transpose();
  }

  // Holds the free scale, along the frames' displacement, and the translations, which a pure rotation leaves
  // undetermined.
  void holdScale(Eigen::MatrixXd& A) const {
    if (num_pose_ == 0) return;
    auto poses = A.topLeftCorner(num_pose_, num_pose_);
    const double trace = poses.trace();
    if (fit_.num_held_frames == 1) {
      const Eigen::VectorXd scale = scaleDirection(fit_);
      if (scale.norm() > 0)
        poses += trace / static_cast<double>(num_pose_) * scale.normalized() * scale.normalized().transpose();
    }
    poses.diagonal().array() += 1e-13 * trace;
  }

  const SceneFit& fit_;
  double damping_;
  bool has_fields_;
  bool has_camera_;
  Eigen::Index num_extra_;  // number of unknowns of the camera
  Eigen::Index num_pose_;
  Eigen::Index num_field_;
  Eigen::Index num_gone_;      // number of columns of poses and fields, which precede the camera
  Eigen::MatrixXd reduced_;    // its lower triangle, until all points are added
  Eigen::MatrixXd gradients_;  // one column per point
  std::vector<FrameColumns> frames_;
  // State of the current point:
  std::vector<std::pair<FrameColumns*, Eigen::Index>> places_;  // of its sightings
  Eigen::Matrix<double, 4, 3> tangent_;
  Eigen::Matrix3d V_;
  Eigen::Vector3d v_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> W_camera_;
  std::uint32_t last_point_ = 0;
  double cost_ = 0;
  double promise_ = 0;  // decrease of the cost by the points' own steps
  double num_redundant_ = 0;
};

// The scene with its poses and fields, then the camera's unknowns, changed by these amounts, and with the
// points where they fit best to first order. A sighting may have no pixel afterwards.
SceneFit movedBy(const SceneFit& fit, const Eigen::VectorXd& change, const Eigen::VectorXd& camera_change,
                 double damping) {
  const bool has_camera = camera_change.size() > 0;
  const std::size_t num_free = fit.camera_from_world.size() - fit.num_held_frames;
  const auto poseChange = [&](std::size_t frame) -> Vector6d {
    if (frame < fit.num_held_frames) return Vector6d::Zero();
    return change.segment<6>(static_cast<Eigen::Index>(6 * (frame - fit.num_held_frames)));
  };
  const auto fieldChange = [&](std::size_t frame) -> ErrorField::Coefficients {
    return change.segment<ErrorField::kSize>(
        static_cast<Eigen::Index>(6 * num_free + ErrorField::kSize * frame));
  };
  SceneFit moved = fit;
  for (const auto& sightings : sightingsByPoint(fit)) {
    Eigen::Vector4d& point = moved.points[sightings.front().point];
    const Eigen::Matrix<double, 4, 3> tangent = pointTangent(point);
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (const SceneSighting& sighting : sightings) {
      const SceneProjection p = projectSighting(fit, sighting, has_camera);
      if (!p.ok) continue;
      const double precision = 1 / (sighting.sigma_px * sighting.sigma_px);
      const double weight = precision * fit.loss.weight(precision * p.error.squaredNorm());
      Eigen::Vector2d error = p.error + p.J_pose * poseChange(sighting.frame);
      if (has_camera)
        error += p.J_params * camera_change.head(camera_change.size() - 1) +
                 sighting.readout_px * camera_change[camera_change.size() - 1];
      if (fit.field_px > 0) error += ErrorField::at(p.field, fieldChange(sighting.frame));
      const Eigen::Matrix<double, 2, 3> J_point = p.J_point * tangent;
      V += weight * J_point.transpose() * J_point;
      pull += weight * J_point.transpose() * error;
    }
    dampPoint(V, damping);
    point = (point - tangent * solveSpd3(V, pull)).normalized();
  }
  for (std::size_t i = fit.num_held_frames; i < fit.camera_from_world.size(); ++i)
    moved.camera_from_world[i] = fit.camera_from_world[i] * SE3::exp(poseChange(i));
  for (std::size_t i = 0; i < fit.fields.size() && fit.field_px > 0; ++i) moved.fields[i] += fieldChange(i);
  return moved;
}

}  // namespace

Eigen::Matrix<double, 4, 3> pointTangent(const Eigen::Vector4d& point) {
  // The columns of a Householder reflection that maps the point to an axis, without that axis.
  Eigen::Index largest = 0;
  point.cwiseAbs().maxCoeff(&largest);
  Eigen::Vector4d v = point.normalized();
  v[largest] += v[largest] < 0 ? -1 : 1;
  const Eigen::Matrix4d reflection = Eigen::Matrix4d::Identity() - 2 / v.squaredNorm() * v * v.transpose();
  Eigen::Matrix<double, 4, 3> tangent;
  for (Eigen::Index i = 0, column = 0; i < 4; ++i) {
    if (i != largest) tangent.col(column++) = reflection.col(i);
  }
  return tangent;
}

SceneEquations sceneEquations(const SceneFit& fit) {
  return SceneSums(fit, CameraColumns::kAll).equations();
}

void followCamera(SceneFit& fit, const Eigen::MatrixXd& J_optimum_camera, const AnyCamera& camera,
                  const Eigen::VectorXd& delta) {
  fit = movedBy(fit, J_optimum_camera * delta, delta, 0);
  fit.camera = camera;
  fit.readout += delta[delta.size() - 1];
}

SceneFit solveScene(SceneFit fit, const SolveOptions& options) {
  double cost = sceneCost(fit);
  if (!std::isfinite(cost)) {
    fit.summary = {.reason = "a point cannot be projected at the start",
                   .cost = std::numeric_limits<double>::quiet_NaN()};
    return fit;
  }
  int num_steps = 0;
  // Damping holds points without parallax, and must stay above the rounding of their elimination. With more
  // damping, scenes converge slowly along their long valleys.
  const DampingRule rule{.start = 1e-4,
                         .raised = [](double damping) { return damping > 1e10 ? HUGE_VAL : damping * 4; },
                         .lowered = [](double damping) { return std::max(1e-7, damping / 3); },
                         .max_steps = options.max_iterations};
  bool is_stuck = false;
  const bool is_converged = minimise(rule, [&](double damping) {
    throwIfCancelled(options.cancel);
    ++num_steps;
    const SceneSums::Step step = SceneSums(fit, CameraColumns::kNone, damping).step();
    constexpr double kNothing = 1e-12;  // of the variance of a coordinate
    const bool is_last = step.promise <= std::max(kNothing, 1e-15 * cost);
    SceneFit trial = movedBy(fit, step.change, {}, damping);
    const double trial_cost = sceneCost(trial);
    const bool is_small = is_last || std::abs(cost - trial_cost) <= options.function_tolerance * cost;
    is_stuck = damping > 1e10;
    if (!(trial_cost < cost)) {
      return is_small ? StepResult::kConverged : StepResult::kWorse;
    }
    fit = std::move(trial);
    cost = trial_cost;
    return is_small ? StepResult::kConverged : StepResult::kBetter;
  });
  fit.summary = {.termination = is_converged ? Termination::kConverged
                                : is_stuck   ? Termination::kFailed
                                             : Termination::kIterationLimit,
                 .reason = is_converged ? "the cost no longer falls"
                           : is_stuck   ? "no step lowers the cost"
                                        : "the cost still falls",
                 .num_iterations = num_steps,
                 .cost = cost};
  return fit;
}

std::vector<Eigen::Vector2d> heldOutErrors(const SceneFit& fit) {
  std::vector<Eigen::Vector2d> errors;
  std::vector<SceneProjection> projections;
  for (const auto& sightings : sightingsByPoint(fit)) {
    if (sightings.size() < 3) {
      errors.insert(errors.end(), sightings.size(), Eigen::Vector2d::Constant(kNoNumber));
      continue;
    }
    projections.clear();
    const Eigen::Matrix<double, 4, 3> tangent = pointTangent(fit.points[sightings.front().point]);
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
    for (const SceneSighting& sighting : sightings) {
      const SceneProjection& p = projections.emplace_back(projectSighting(fit, sighting));
      if (!p.ok) continue;
      const Eigen::Matrix<double, 2, 3> J = p.J_point * tangent / sighting.sigma_px;
      V += J.transpose() * J;
    }
    const Eigen::Matrix3d V_inverse = V.inverse();
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      Eigen::Vector2d& error = errors.emplace_back(Eigen::Vector2d::Constant(kNoNumber));
      const SceneProjection& p = projections[i];
      if (!p.ok) continue;
      const Eigen::Matrix<double, 2, 3> J = p.J_point * tangent / sightings[i].sigma_px;
      const Eigen::Matrix2d left = Eigen::Matrix2d::Identity() - J * V_inverse * J.transpose();
      constexpr double kFree = 1e-3;  // least share of the point's freedom that the other sightings must
                                      // determine
      if (left.determinant() > kFree) error = left.inverse() * p.error;
    }
  }
  return errors;
}

}  // namespace alidade
