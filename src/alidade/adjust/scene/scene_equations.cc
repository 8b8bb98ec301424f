// SPDX-License-Identifier: MIT
#include "alidade/adjust/scene/scene_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "alidade/core/error.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

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

// The part of one sighting in the normal equations: derivatives J of the weighted error by its frame's pose
// (6), then by its frame's error field. A held frame has no pose columns, and a fit may have no fields.
struct SightingColumns {
  static constexpr int kField = ErrorField::kSize;
  static constexpr int kSize = 6 + kField;
  Eigen::Index pose_at = -1;  // column in the normal equations; -1: none
  Eigen::Index field_at = -1;
  Eigen::Matrix<double, kSize, 2> J;
  Eigen::Matrix<double, kSize, 3> W;  // product of J and the derivative by the point

  // Calls act(column in the normal equations, rows of J and W) for each part that exists.
  template <class Act>
  void forEach(const Act& act) const {
    if (pose_at >= 0) act(pose_at, Eigen::seqN(Eigen::fix<0>, Eigen::fix<6>));
    if (field_at >= 0) act(field_at, Eigen::seqN(Eigen::fix<6>, Eigen::fix<kField>));
  }

  // Adds `sign` times the product of its rows and those of another sighting in the same or an earlier frame:
  // the lower triangle of the normal equations, in which fields come after all poses. Plain loops compile in
  // a tenth of the time of fixed-size blocks.
  void addProducts(Eigen::MatrixXd& sum, const SightingColumns& other, double sign, const double* a,
                   const double* b, int depth) const {
    double product[kSize][kSize];  // by column, then by row
    for (int j = 0; j < kSize; ++j) {
      for (int i = 0; i < kSize; ++i) product[j][i] = a[i] * b[j];
      for (int k = 1; k < depth; ++k) {
        for (int i = 0; i < kSize; ++i) product[j][i] += a[k * kSize + i] * b[k * kSize + j];
      }
    }
    const auto add = [&](Eigen::Index row_at, Eigen::Index column_at, int row, int column, int rows,
                         int columns) {
      for (int j = 0; j < columns; ++j) {
        for (int i = 0; i < rows; ++i) sum(row_at + i, column_at + j) += sign * product[column + j][row + i];
      }
    };
    if (pose_at >= 0 && other.pose_at >= 0) add(pose_at, other.pose_at, 0, 0, 6, 6);
    if (field_at < 0) return;
    add(field_at, other.field_at, 6, 6, kField, kField);
    if (other.pose_at >= 0) add(field_at, other.pose_at, 6, 0, kField, 6);
    if (pose_at < 0 || this == &other) return;
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < kField; ++i) sum(other.field_at + i, pose_at + j) += sign * product[6 + i][j];
    }
  }
};

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
    for (const auto& sightings : sightingsByPoint(fit)) addPoint(sightings);
    reduced_.triangularView<Eigen::StrictlyUpper>() = reduced_.transpose().eval();
    num_redundant_ -= static_cast<double>(num_pose_) - (fit.num_held_frames == 1 ? 1 : 0);
  }

  // The equations with poses and fields also eliminated.
  [[nodiscard]] SceneEquations equations() const {
    SceneEquations result;
    result.cost = cost_;
    result.num_redundant = num_redundant_;
    Eigen::MatrixXd A = reduced_.topLeftCorner(num_gone_, num_gone_);
    holdScale(A);
    // Gradients of the priors at the present fields; at the optimum, they cancel those of the points.
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
    const Eigen::MatrixXd B = reduced_.topRightCorner(num_gone_, num_extra_);
    Eigen::MatrixXd inverse;
    const Eigen::MatrixXd T = num_gone_ > 0 ? solveSpd(A, B, &inverse) : B;
    result.information =
        Eigen::MatrixXd(reduced_.bottomRightCorner(num_extra_, num_extra_) - B.transpose() * T);
    result.point_gradients =
        Eigen::MatrixXd(gradients_.bottomRows(num_extra_) - T.transpose() * gradients_.topRows(num_gone_));
    result.prior_gradient = Eigen::MatrixXd(-T.transpose() * prior);
    if (num_gone_ > 0) {
      result.pose_covariance = Eigen::MatrixXd(inverse.topLeftCorner(num_pose_, num_pose_));
      result.field_variance = inverse.bottomRightCorner(num_field_, num_field_).trace();
    }
    return result;
  }

 private:
  void addPoint(std::span<const SceneSighting> sightings) {
    tangent_ = pointTangent(fit_.points[sightings.front().point]);
    V_.setZero();
    v_.setZero();
    W_camera_.setZero(num_extra_, 3);
    columns_.clear();
    auto gradient = gradients_.col(static_cast<Eigen::Index>(sightings.front().point));
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      expect(i == 0 || sightings[i - 1].frame < sightings[i].frame, "sightings are in order of frames");
      addSighting(sightings[i], gradient);
    }
    eliminate(gradient);
  }

  void addSighting(const SceneSighting& sighting, Eigen::Ref<Eigen::VectorXd> gradient) {
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
    own.J.topRows<6>() = weight * scale * p.J_pose.transpose();
    if (has_fields_) {
      own.J.block<ErrorField::kTerms, 1>(6, 0) = weight * scale * p.field;
      own.J.block<ErrorField::kTerms, 1>(6 + ErrorField::kTerms, 1) = weight * scale * p.field;
    }
    J_camera.leftCols(num_params_) = weight * scale * p.J_params;
    J_camera.col(num_params_) = weight * scale * sighting.readout_px;
    const Eigen::Matrix<double, 2, 3> J_point = weight * scale * p.J_point * tangent_;
    V_.noalias() += J_point.transpose() * J_point;
    v_.noalias() += J_point.transpose() * error;
    own.W.noalias() = own.J * J_point;
    W_camera_.noalias() += J_camera.transpose() * J_point;
    own.forEach([&](Eigen::Index at, auto part) {
      for (Eigen::Index i = 0; i < part.size(); ++i) {
        const Eigen::Vector2d J = own.J.row(part[i]).transpose();
        gradient[at + i] += J.dot(error);
        for (Eigen::Index k = 0; k < num_extra_; ++k)
          reduced_(num_gone_ + k, at + i) += J_camera.col(k).dot(J);
      }
    });
    own.addProducts(reduced_, own, 1, own.J.data(), own.J.data(), 2);
    gradient.tail(num_extra_).noalias() += J_camera.transpose() * error;
    reduced_.bottomRightCorner(num_extra_, num_extra_).noalias() += J_camera.transpose() * J_camera;
  }

  // Eliminates the point from the sums.
  void eliminate(Eigen::Ref<Eigen::VectorXd> gradient) {
    num_redundant_ -= 3;
    // Damps a point whose sightings do not determine it.
    V_.diagonal().array() += 1e-12 * V_.trace();
    const Eigen::LDLT<Eigen::Matrix3d> factor(V_);
    const Eigen::Vector3d shift = factor.solve(v_);
    const Eigen::Matrix<double, Eigen::Dynamic, 3> WV_camera =
        factor.solve(W_camera_.transpose()).transpose();
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const SightingColumns& own = columns_[i];
      const Eigen::Matrix<double, SightingColumns::kSize, 3> WV = factor.solve(own.W.transpose()).transpose();
      for (std::size_t k = 0; k <= i; ++k)
        own.addProducts(reduced_, columns_[k], -1, WV.data(), columns_[k].W.data(), 3);
      const auto every = Eigen::seqN(0, Eigen::fix<3>);
      own.forEach([&](Eigen::Index at, auto part) {
        gradient.segment(at, part.size()).noalias() -= own.W(part, every) * shift;
        reduced_.block(num_gone_, at, num_extra_, part.size()).noalias() -=
            WV_camera * own.W(part, every).transpose();
      });
    }
    gradient.tail(num_extra_).noalias() -= W_camera_ * shift;
    reduced_.bottomRightCorner(num_extra_, num_extra_).noalias() -= WV_camera * W_camera_.transpose();
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
  bool has_fields_;
  Eigen::Index num_params_;
  Eigen::Index num_extra_;  // number of unknowns of the camera
  Eigen::Index num_pose_;
  Eigen::Index num_field_;
  Eigen::Index num_gone_;      // number of columns of poses and fields, which precede the camera
  Eigen::MatrixXd reduced_;    // its lower triangle, until all points are added
  Eigen::MatrixXd gradients_;  // one column per point
  // State of the current point:
  std::vector<SightingColumns> columns_;
  Eigen::Matrix<double, 4, 3> tangent_;
  Eigen::Matrix3d V_;
  Eigen::Vector3d v_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> W_camera_;
  double cost_ = 0;
  double num_redundant_ = 0;
};

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
  return SceneSums(fit).equations();
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
