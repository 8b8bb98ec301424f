// SPDX-License-Identifier: MIT
#include "alidade/adjust/scene/scene_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>

#include "alidade/adjust/board/manifolds.h"

namespace alidade {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// Of a point in the camera's frame by the pose (right perturbation) and by the homogeneous point.
struct PointInCamera {
  Eigen::Vector3d at;
  Eigen::Matrix<double, 3, 6> J_pose;
  Eigen::Matrix<double, 3, 4> J_point;
};

PointInCamera inCamera(const SE3& camera_from_world, const Eigen::Vector4d& point) {
  const Eigen::Matrix3d R = camera_from_world.rotation.matrix();
  PointInCamera p;
  p.J_point << R, camera_from_world.translation;
  p.at = p.J_point * point;
  p.J_pose << R * point.w(), -R * hat(point.head<3>());
  return p;
}

// Its parameter blocks are the pose, the point and, where images have one, the coefficients of the field.
class SightingBlock final : public ceres::CostFunction {
 public:
  SightingBlock(const SceneFit& fit, const SceneSighting& sighting)
      : camera_(fit.camera),
        target_(sighting.pixel - fit.readout * sighting.readout_px),
        scale_(1 / sighting.sigma_px),
        has_field_(fit.field_px > 0) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {7, 4};
    if (!has_field_) return;
    mutable_parameter_block_sizes()->push_back(ErrorField::kSize);
    basis_ = ErrorField::basisAt(sighting.pixel, fit.size);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const SE3 pose = fromBlock(blocks[0]);
    const PointInCamera p = inCamera(pose, Eigen::Map<const Eigen::Vector4d>(blocks[1]));
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
    const bool is_derived = jacobians != nullptr;
    const Projection projection = camera_.project(p.at, is_derived ? J_px_cam.data() : nullptr);
    if (!projection.ok()) return false;
    Eigen::Vector2d error = projection.pixel - target_;
    if (has_field_) {
      const Eigen::Map<const ErrorField::Coefficients> field(blocks[2]);
      error += Eigen::Vector2d(field.head<ErrorField::kTerms>().dot(basis_),
                               field.tail<ErrorField::kTerms>().dot(basis_));
    }
    Eigen::Map<Eigen::Vector2d>{residuals} = scale_ * error;
    if (!is_derived) return true;
    if (jacobians[0] != nullptr) {
      Eigen::Matrix<double, 6, 7, Eigen::RowMajor> tangent_by_block;
      SE3Manifold().MinusJacobian(blocks[0], tangent_by_block.data());
      Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>>{jacobians[0]} =
          scale_ * (J_px_cam * p.J_pose) * tangent_by_block;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 4, Eigen::RowMajor>>{jacobians[1]} = scale_ * J_px_cam * p.J_point;
    }
    if (has_field_ && jacobians[2] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, ErrorField::kSize, Eigen::RowMajor>> J(jacobians[2]);
      J.setZero();
      J.block<1, ErrorField::kTerms>(0, 0) = scale_ * basis_.transpose();
      J.block<1, ErrorField::kTerms>(1, ErrorField::kTerms) = scale_ * basis_.transpose();
    }
    return true;
  }

 private:
  const AnyCamera& camera_;
  Eigen::Vector2d target_;
  double scale_;
  bool has_field_;
  ErrorField::Basis basis_;
};

class FieldPrior final : public ceres::SizedCostFunction<ErrorField::kSize, ErrorField::kSize> {
 public:
  explicit FieldPrior(double field_px) : scale_(1 / field_px) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    Eigen::Map<ErrorField::Coefficients>{residuals} =
        scale_ * Eigen::Map<const ErrorField::Coefficients>(blocks[0]);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, ErrorField::kSize, ErrorField::kSize, Eigen::RowMajor>>{jacobians[0]}
          .setIdentity() *= scale_;
    }
    return true;
  }

 private:
  double scale_;
};

// Holds the free scale by the distance of a frame from the first one, which costs the pixels nothing.
class DistanceHold final : public ceres::SizedCostFunction<1, 7> {
 public:
  DistanceHold(const Eigen::Vector3d& first, double distance) : first_(first), distance_(distance) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const SE3 pose = fromBlock(blocks[0]);
    const Eigen::Vector3d at = pose * first_;
    residuals[0] = kWeight * (at.norm() / distance_ - 1);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> tangent_by_block;
    SE3Manifold().MinusJacobian(blocks[0], tangent_by_block.data());
    Eigen::Matrix<double, 1, 6> J;
    J.head<3>() = kWeight / distance_ * at.normalized().transpose() * pose.rotation.matrix();
    J.tail<3>() = -J.head<3>() * hat(first_);
    Eigen::Map<Eigen::Matrix<double, 1, 7>>{jacobians[0]} = J * tangent_by_block;
    return true;
  }

 private:
  static constexpr double kWeight = 100;
  Eigen::Vector3d first_;
  double distance_;
};

// The frame that is farthest from the first one, if it is elsewhere.
std::size_t farthestFrame(const SceneFit& fit, double* distance) {
  const Eigen::Vector3d first = fit.camera_from_world.front().inverse().translation;
  std::size_t farthest = 0;
  *distance = 0;
  for (std::size_t i = 1; i < fit.camera_from_world.size(); ++i) {
    const double d = (fit.camera_from_world[i] * first).norm();
    if (d <= *distance) continue;
    *distance = d;
    farthest = i;
  }
  return farthest;
}

Eigen::Vector2d fieldAt(const SceneFit& fit, std::uint32_t frame, const ErrorField::Basis& basis) {
  const ErrorField::Coefficients& field = fit.fields[frame];
  return {field.head<ErrorField::kTerms>().dot(basis), field.tail<ErrorField::kTerms>().dot(basis)};
}

// Observes the flag only; Ceres' own rules decide when to stop.
class CancelWatch final : public ceres::IterationCallback {
 public:
  explicit CancelWatch(const CancelFlag* cancel) : cancel_(cancel) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return cancel_ != nullptr && cancel_->load() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const CancelFlag* cancel_;
};

// The sightings of one point among all.
struct PointRange {
  std::size_t begin = 0;
  std::size_t end = 0;
};

std::vector<PointRange> rangesOf(const SceneFit& fit) {
  std::vector<PointRange> ranges;
  for (std::size_t i = 0; i < fit.sightings.size();) {
    std::size_t end = i + 1;
    while (end < fit.sightings.size() && fit.sightings[end].point == fit.sightings[i].point) ++end;
    ranges.push_back({i, end});
    i = end;
  }
  return ranges;
}

// What one sighting adds to the normal equations: its frame's pose (6), then its frame's error field, by
// which the weighted error has the derivative J. A frame that is held has no pose, a fit may have no fields.
struct SightingColumns {
  static constexpr int kSize = 6 + ErrorField::kSize;
  Eigen::Index pose_at = -1;  // in the normal equations; -1: none
  Eigen::Index field_at = -1;
  Eigen::Matrix<double, 2, kSize> J;
  Eigen::Matrix<double, kSize, 3> W;  // J's product with the point's derivative

  // Calls act(place in the normal equations, columns of J) for each part that is there.
  template <class Act>
  void forEach(const Act& act) const {
    if (pose_at >= 0) act(pose_at, Eigen::seqN(Eigen::fix<0>, Eigen::fix<6>));
    if (field_at >= 0) act(field_at, Eigen::seqN(Eigen::fix<6>, Eigen::fix<ErrorField::kSize>));
  }

  // Adds a product of this one's columns and those of another sighting of an earlier or the same frame: the
  // lower triangle of the normal equations, in which fields come after all poses.
  template <class Product>
  void addProducts(Eigen::MatrixXd& sum, const SightingColumns& other, const Product& lazy) const {
    const Eigen::Matrix<double, kSize, kSize> product = lazy;
    constexpr int kField = ErrorField::kSize;
    if (pose_at >= 0 && other.pose_at >= 0)
      sum.block<6, 6>(pose_at, other.pose_at) += product.template topLeftCorner<6, 6>();
    if (field_at < 0) return;
    sum.block<kField, kField>(field_at, other.field_at) +=
        product.template bottomRightCorner<kField, kField>();
    if (other.pose_at >= 0)
      sum.block<kField, 6>(field_at, other.pose_at) += product.template bottomLeftCorner<kField, 6>();
    if (pose_at >= 0 && this != &other)
      sum.block<kField, 6>(other.field_at, pose_at) +=
          product.template topRightCorner<6, kField>().transpose();
  }
};

// By how much the pose of each frame changes if the scene grows about the first camera.
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

// The sums over all points: normal equations of poses, fields and camera with each point eliminated.
class SceneSums {
 public:
  explicit SceneSums(const SceneFit& fit)
      : fit_(fit),
        has_fields_(fit.field_px > 0),
        num_params_(static_cast<Eigen::Index>(fit.camera.parameters().size())),
        num_extra_(num_params_ + 1),
        num_pose_(6 * static_cast<Eigen::Index>(fit.camera_from_world.size() - fit.num_held_frames)),
        num_field_(has_fields_ ? ErrorField::kSize * static_cast<Eigen::Index>(fit.camera_from_world.size())
                               : 0),
        num_gone_(num_pose_ + num_field_),
        reduced_(Eigen::MatrixXd::Zero(num_gone_ + num_extra_, num_gone_ + num_extra_)),
        gradients_(
            Eigen::MatrixXd::Zero(num_gone_ + num_extra_, static_cast<Eigen::Index>(fit.points.size()))) {
    for (const PointRange& range : rangesOf(fit)) addPoint(range);
    reduced_.triangularView<Eigen::StrictlyUpper>() = reduced_.transpose().eval();
    num_redundant_ -= static_cast<double>(num_pose_) - (fit.num_held_frames == 1 ? 1 : 0);
  }

  // With poses and fields eliminated too.
  [[nodiscard]] SceneEquations equations() const {
    SceneEquations result;
    result.cost = cost_;
    result.num_redundant = num_redundant_;
    Eigen::MatrixXd A = reduced_.topLeftCorner(num_gone_, num_gone_);
    holdScale(A);
    // The priors' gradients at the fields as they are; with the points' they sum to nothing at the optimum.
    Eigen::VectorXd prior = Eigen::VectorXd::Zero(num_gone_);
    const double precision = has_fields_ ? 1 / (fit_.field_px * fit_.field_px) : 0;
    for (Eigen::Index i = 0; i < num_field_; ++i) {
      const double value =
          fit_.fields[static_cast<std::size_t>(i / ErrorField::kSize)][i % ErrorField::kSize];
      A(num_pose_ + i, num_pose_ + i) += precision;
      prior[num_pose_ + i] = precision * value;
      result.cost += 0.5 * precision * value * value;
      result.field_square += value * value;
    }
    const Eigen::LDLT<Eigen::MatrixXd> factor(A);
    const Eigen::MatrixXd B = reduced_.topRightCorner(num_gone_, num_extra_);
    const Eigen::MatrixXd T = num_gone_ > 0 ? Eigen::MatrixXd(factor.solve(B)) : B;
    result.information =
        Eigen::MatrixXd(reduced_.bottomRightCorner(num_extra_, num_extra_) - B.transpose() * T);
    result.point_gradients =
        Eigen::MatrixXd(gradients_.bottomRows(num_extra_) - T.transpose() * gradients_.topRows(num_gone_));
    result.prior_gradient = Eigen::MatrixXd(-T.transpose() * prior);
    if (num_gone_ > 0) {
      const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(num_gone_, num_gone_));
      result.pose_covariance = Eigen::MatrixXd(inverse.topLeftCorner(num_pose_, num_pose_));
      result.field_variance = inverse.bottomRightCorner(num_field_, num_field_).trace();
    }
    return result;
  }

 private:
  // What a point and its sightings share.
  struct PointSums {
    Eigen::Matrix<double, 4, 3> tangent;
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, Eigen::Dynamic, 3> W_camera;
  };

  void addPoint(const PointRange& range) {
    const std::uint32_t point = fit_.sightings[range.begin].point;
    PointSums sums{.tangent = pointTangent(fit_.points[point]),
                   .W_camera = Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(num_extra_, 3)};
    auto gradient = gradients_.col(static_cast<Eigen::Index>(point));
    columns_.clear();
    for (std::size_t i = range.begin; i < range.end; ++i) {
      expect(i == range.begin || fit_.sightings[i - 1].frame < fit_.sightings[i].frame,
             "sightings are in order of frames");
      addSighting(fit_.sightings[i], sums, gradient);
    }
    eliminate(sums, gradient);
  }

  void addSighting(const SceneSighting& sighting, PointSums& sums, Eigen::Ref<Eigen::VectorXd> gradient) {
    Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 25> J_camera(2, num_extra_);
    const SceneProjection p = projectSighting(fit_, sighting);
    expect(p.ok, "every sighting projects");
    const double scale = 1 / sighting.sigma_px;
    Eigen::Vector2d error = scale * p.error;
    cost_ += 0.5 * fit_.loss.rho(error.squaredNorm());
    num_redundant_ += 2;
    const double weight = std::sqrt(fit_.loss.weight(error.squaredNorm()));
    error *= weight;
    SightingColumns& own = columns_.emplace_back();
    own.pose_at = sighting.frame >= fit_.num_held_frames
                      ? 6 * static_cast<Eigen::Index>(sighting.frame - fit_.num_held_frames)
                      : -1;
    own.field_at =
        has_fields_ ? num_pose_ + ErrorField::kSize * static_cast<Eigen::Index>(sighting.frame) : -1;
    own.J.setZero();
    own.J.leftCols<6>() = weight * scale * p.J_pose;
    if (has_fields_) {
      own.J.block<1, ErrorField::kTerms>(0, 6) = weight * scale * p.field.transpose();
      own.J.block<1, ErrorField::kTerms>(1, 6 + ErrorField::kTerms) = weight * scale * p.field.transpose();
    }
    J_camera.leftCols(num_params_) = weight * scale * p.J_params;
    J_camera.col(num_params_) = weight * scale * sighting.readout_px;
    const Eigen::Matrix<double, 2, 3> J_point = weight * scale * p.J_point * sums.tangent;
    sums.V.noalias() += J_point.transpose() * J_point;
    sums.v.noalias() += J_point.transpose() * error;
    own.W.noalias() = own.J.transpose() * J_point;
    sums.W_camera.noalias() += J_camera.transpose() * J_point;
    own.forEach([&](Eigen::Index at, auto part) {
      gradient.segment(at, part.size()).noalias() += own.J(Eigen::all, part).transpose() * error;
      reduced_.block(num_gone_, at, num_extra_, part.size()).noalias() +=
          J_camera.transpose() * own.J(Eigen::all, part);
    });
    own.addProducts(reduced_, own, own.J.transpose() * own.J);
    gradient.tail(num_extra_).noalias() += J_camera.transpose() * error;
    reduced_.bottomRightCorner(num_extra_, num_extra_).noalias() += J_camera.transpose() * J_camera;
  }

  // Takes the point out of the sums.
  void eliminate(PointSums& sums, Eigen::Ref<Eigen::VectorXd> gradient) {
    num_redundant_ -= 3;
    // A point that its sightings do not place: what is left of it is held.
    sums.V.diagonal().array() += 1e-12 * sums.V.trace();
    const Eigen::LDLT<Eigen::Matrix3d> factor(sums.V);
    const Eigen::Vector3d shift = factor.solve(sums.v);
    const Eigen::Matrix<double, Eigen::Dynamic, 3> WV_camera =
        factor.solve(sums.W_camera.transpose()).transpose();
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const SightingColumns& own = columns_[i];
      const Eigen::Matrix<double, SightingColumns::kSize, 3> WV = factor.solve(own.W.transpose()).transpose();
      for (std::size_t k = 0; k <= i; ++k)
        own.addProducts(reduced_, columns_[k], -WV.lazyProduct(columns_[k].W.transpose()));
      own.forEach([&](Eigen::Index at, auto part) {
        gradient.segment(at, part.size()).noalias() -= own.W(part, Eigen::all) * shift;
        reduced_.block(num_gone_, at, num_extra_, part.size()).noalias() -=
            WV_camera * own.W(part, Eigen::all).transpose();
      });
    }
    gradient.tail(num_extra_).noalias() -= sums.W_camera * shift;
    reduced_.bottomRightCorner(num_extra_, num_extra_).noalias() -= WV_camera * sums.W_camera.transpose();
  }

  // Free scale, along the frames' displacement; and translations, which a rotation alone leaves undetermined.
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
  bool has_fields_;
  Eigen::Index num_params_;
  Eigen::Index num_extra_;  // the camera's unknowns
  Eigen::Index num_pose_;
  Eigen::Index num_field_;
  Eigen::Index num_gone_;                 // poses and fields, which stand before the camera
  Eigen::MatrixXd reduced_;               // its lower triangle, until all points are added
  Eigen::MatrixXd gradients_;             // a column a point
  std::vector<SightingColumns> columns_;  // of the point at hand
  double cost_ = 0;
  double num_redundant_ = 0;
};

}  // namespace

ErrorField::Basis ErrorField::basisAt(const Eigen::Vector2d& pixel, const ImageSize& size) {
  const double x = (2 * pixel.x() + 1) / size.width - 1;
  const double y = (2 * pixel.y() + 1) / size.height - 1;
  Basis basis;
  basis << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  return basis;
}

Eigen::Matrix<double, 4, 3> pointTangent(const Eigen::Vector4d& point) {
  // The columns of a Householder reflection that takes the point to an axis, without that axis.
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

SceneProjection projectSighting(const SceneFit& fit, const SceneSighting& sighting) {
  SceneProjection result;
  const PointInCamera p = inCamera(fit.camera_from_world[sighting.frame], fit.points[sighting.point]);
  const auto num_params = static_cast<Eigen::Index>(fit.camera.parameters().size());
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor, 2, 24> J_params(2, num_params);
  const Projection projection = fit.camera.project(p.at, J_px_cam.data(), J_params.data());
  if (!projection.ok()) return result;
  result.ok = true;
  result.error = projection.pixel + fit.readout * sighting.readout_px - sighting.pixel;
  result.J_pose = J_px_cam * p.J_pose;
  result.J_point = J_px_cam * p.J_point;
  result.J_params = J_params;
  if (fit.field_px > 0) {
    result.field = ErrorField::basisAt(sighting.pixel, fit.size);
    result.error += fieldAt(fit, sighting.frame, result.field);
  }
  return result;
}

Eigen::Vector2d sightingError(const SceneFit& fit, const SceneSighting& sighting) {
  const Eigen::Vector4d& point = fit.points[sighting.point];
  const SE3& pose = fit.camera_from_world[sighting.frame];
  const Projection projection =
      fit.camera.project(pose.rotation * Eigen::Vector3d(point.head<3>()) + pose.translation * point.w());
  Eigen::Vector2d error = projection.pixel + fit.readout * sighting.readout_px - sighting.pixel;
  if (fit.field_px > 0) error += fieldAt(fit, sighting.frame, ErrorField::basisAt(sighting.pixel, fit.size));
  return error;
}

namespace {

void holdScale(ceres::Problem& problem, const SceneFit& fit, std::vector<PoseBlock>& poses) {
  double distance = 0;
  const std::size_t farthest = farthestFrame(fit, &distance);
  if (fit.num_held_frames > 1 || distance == 0 || !problem.HasParameterBlock(poses[farthest].data())) return;
  const Eigen::Vector3d first = fit.camera_from_world.front().inverse().translation;
  problem.AddResidualBlock(new DistanceHold(first, distance), nullptr, poses[farthest].data());
}

ceres::Solver::Options sceneSolverOptions(const SolveOptions& options) {
  ceres::Solver::Options solver;
  solver.num_threads = 1;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = 1e-10;
  solver.parameter_tolerance = 1e-10;
  solver.max_num_consecutive_invalid_steps = 50;
  // Damping holds the points that no parallax places, and must stay above the rounding of their elimination.
  // With more of it, scenes creep along their long valleys.
  solver.max_trust_region_radius = 1e7;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace

SceneFit solveScene(SceneFit fit, const SolveOptions& options) {
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.enable_fast_removal = false;
  ceres::Problem problem(problem_options);
  SE3Manifold pose_manifold;
  ceres::SphereManifold<4> point_manifold;
  std::unique_ptr<ceres::LossFunction> loss;
  if (std::isfinite(fit.loss.threshold_px)) loss = std::make_unique<ceres::HuberLoss>(fit.loss.threshold_px);

  std::vector<PoseBlock> poses;
  for (const SE3& pose : fit.camera_from_world) poses.push_back(toBlock(pose));
  for (const SceneSighting& sighting : fit.sightings) {
    std::vector<double*> blocks = {poses[sighting.frame].data(), fit.points[sighting.point].data()};
    if (fit.field_px > 0) blocks.push_back(fit.fields[sighting.frame].data());
    problem.AddResidualBlock(new SightingBlock(fit, sighting), loss.get(), blocks);
  }
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (Eigen::Vector4d& point : fit.points) {
    if (!problem.HasParameterBlock(point.data())) continue;
    problem.SetManifold(point.data(), &point_manifold);
    ordering->AddElementToGroup(point.data(), 0);
  }
  bool has_free_pose = false;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!problem.HasParameterBlock(poses[i].data())) continue;
    // A group for each: Ceres orders a group by addresses, and the order decides how sums are rounded.
    ordering->AddElementToGroup(poses[i].data(), static_cast<int>(i) + 1);
    problem.SetManifold(poses[i].data(), &pose_manifold);
    if (i < fit.num_held_frames) problem.SetParameterBlockConstant(poses[i].data());
    has_free_pose = has_free_pose || i >= fit.num_held_frames;
    if (fit.field_px == 0) continue;
    problem.AddResidualBlock(new FieldPrior(fit.field_px), nullptr, fit.fields[i].data());
    ordering->AddElementToGroup(fit.fields[i].data(), static_cast<int>(poses.size() + i) + 1);
  }
  holdScale(problem, fit, poses);

  double cost = 0;
  const bool is_evaluable = problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
  if (!is_evaluable || !std::isfinite(cost)) {
    fit.summary = {.reason = "a point cannot be projected at the start", .cost = kNoNumber};
    return fit;
  }
  ceres::Solver::Options solver = sceneSolverOptions(options);
  // As in solve(): the dense factorisation fails where rounding leaves the scale's free direction singular.
  solver.linear_solver_type = has_free_pose ? ceres::SPARSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
  if (has_free_pose) solver.linear_solver_ordering = ordering;
  CancelWatch watch(options.cancel);
  solver.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  throwIfCancelled(options.cancel);

  for (std::size_t i = fit.num_held_frames; i < poses.size(); ++i)
    fit.camera_from_world[i] = fromBlock(poses[i].data());
  fit.summary = {.reason = summary.message,
                 .num_iterations = static_cast<int>(summary.iterations.size()) - 1,
                 .cost = summary.final_cost};
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
    case ceres::USER_SUCCESS:
      fit.summary.termination = Termination::kConverged;
      break;
    case ceres::NO_CONVERGENCE:
      fit.summary.termination = Termination::kIterationLimit;
      break;
    default:
      fit.summary.termination = Termination::kFailed;
  }
  return fit;
}

SceneEquations sceneEquations(const SceneFit& fit) {
  return SceneSums(fit).equations();
}

std::vector<Eigen::Vector2d> heldOutErrors(const SceneFit& fit) {
  std::vector<Eigen::Vector2d> errors(fit.sightings.size(), Eigen::Vector2d::Constant(kNoNumber));
  std::vector<SceneProjection> projections;
  for (const PointRange& range : rangesOf(fit)) {
    if (range.end - range.begin < 3) continue;
    projections.clear();
    const Eigen::Matrix<double, 4, 3> tangent = pointTangent(fit.points[fit.sightings[range.begin].point]);
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
    for (std::size_t i = range.begin; i < range.end; ++i) {
      projections.push_back(projectSighting(fit, fit.sightings[i]));
      if (!projections.back().ok) continue;
      const Eigen::Matrix<double, 2, 3> J = projections.back().J_point * tangent / fit.sightings[i].sigma_px;
      V += J.transpose() * J;
    }
    const Eigen::Matrix3d V_inverse = V.inverse();
    for (std::size_t i = range.begin; i < range.end; ++i) {
      const SceneProjection& p = projections[i - range.begin];
      if (!p.ok) continue;
      const Eigen::Matrix<double, 2, 3> J = p.J_point * tangent / fit.sightings[i].sigma_px;
      const Eigen::Matrix2d left = Eigen::Matrix2d::Identity() - J * V_inverse * J.transpose();
      constexpr double kFree = 1e-3;  // of the point's freedom that the other sightings must not leave
      if (left.determinant() > kFree) errors[i] = left.inverse() * p.error;
    }
  }
  return errors;
}

}  // namespace alidade
