// SPDX-License-Identifier: MIT
#include "alidade/camera/triangulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "alidade/core/error.h"
#include "alidade/geometry/least_squares.h"

namespace alidade {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using Matrix32 = Eigen::Matrix<double, 3, 2>;

// The point is anchor + direction / inverse_m. Seen from any camera, its direction is direction + inverse_m *
// (anchor - camera) up to a positive factor, which is continuous at infinity.
struct PointState {
  Vector3d direction;
  double inverse_m = 0;
};

// The contribution of one pixel.
struct PixelRow {
  Vector2d error;  // px, projected minus given pixel
  Matrix23 J_px_m;
  Vector3d m;                                // the point in the camera frame times inverse_m
  Vector2d J_px_inverse = Vector2d::Zero();  // by inverse_m alone, for an entrance pupil that moves
};

// Two directions normal to a unit vector, and to each other.
Matrix32 tangentBasis(const Vector3d& unit) {
  Matrix32 basis;
  basis.col(0) = unit.unitOrthogonal();
  basis.col(1) = unit.cross(basis.col(0));
  return basis;
}

// True if the point is so near that an entrance pupil matters if it moves.
bool isNear(const AnyCamera& camera, double inverse_m) {
  constexpr double kNear = 1e-4;  // per metre
  return !camera.pupil().isFixed() && inverse_m > kNear;
}

// The pixel of a point from `m`, which is the point times inverse_m. The derivatives J_px_m of a near one are
// by the point itself.
Projection seenBy(const AnyCamera& camera, const Vector3d& m, double inverse_m, double* J_px_m,
                  double* J_px_params = nullptr) {
  if (!isNear(camera, inverse_m)) return camera.project(m, J_px_m, J_px_params);
  return camera.projectPoint(m / inverse_m, J_px_m, J_px_params);
}

class PointProblem {
 public:
  PointProblem(const AnyRig& rig, std::span<const RigPixel> pixels) : rig_(rig), pixels_(pixels) {
    anchor_ = centreOf(pixels.front());
    for (const RigPixel& pixel : pixels) unit_m_ = std::max(unit_m_, (centreOf(pixel) - anchor_).norm());
  }

  [[nodiscard]] const MountedCamera& cameraOf(const RigPixel& pixel) const {
    return rig_.camera(pixel.camera);
  }
  [[nodiscard]] Vector3d centreOf(const RigPixel& pixel) const {
    return cameraOf(pixel).camera_from_rig.inverse().translation;
  }
  // The largest distance of a camera from the first one; inverse distances in this unit are dimensionless.
  [[nodiscard]] double unit() const { return unit_m_; }
  [[nodiscard]] double leastSigma() const {
    return std::ranges::min_element(pixels_, {}, &RigPixel::sigma_px)->sigma_px;
  }
  [[nodiscard]] Vector3d pointOf(const PointState& state) const {
    return anchor_ + state.direction / state.inverse_m;
  }

  // Nothing if a camera does not see the point.
  [[nodiscard]] std::optional<double> rowsAt(const PointState& state, std::vector<PixelRow>& rows) const {
    rows.resize(pixels_.size());
    double cost = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const SE3& camera_from_rig = cameraOf(pixels_[i]).camera_from_rig;
      PixelRow& row = rows[i];
      row.J_px_inverse.setZero();
      row.m = camera_from_rig.rotation * state.direction + state.inverse_m * (camera_from_rig * anchor_);
      const AnyCamera& camera = cameraOf(pixels_[i]).camera;
      const Projection projection = seenBy(camera, row.m, state.inverse_m, row.J_px_m.data());
      if (!projection.ok()) return std::nullopt;
      if (isNear(camera, state.inverse_m)) {
        row.J_px_m /= state.inverse_m;
        row.J_px_inverse = -row.J_px_m * row.m / state.inverse_m;
      }
      row.error = projection.pixel - pixels_[i].pixel;
      cost += (row.error / pixels_[i].sigma_px).squaredNorm();
    }
    return cost;
  }

  // 2 x 3, divided by sigma_px: derivatives by the two tangents of the direction and by the inverse distance
  // in 1 / unit().
  [[nodiscard]] Eigen::Matrix<double, 2, 3> byState(const PixelRow& row, const RigPixel& pixel,
                                                    const Matrix32& basis) const {
    const SE3& camera_from_rig = cameraOf(pixel).camera_from_rig;
    Matrix3d J_m_state;
    J_m_state << camera_from_rig.rotation.matrix() * basis, camera_from_rig * anchor_ / unit_m_;
    Eigen::Matrix<double, 2, 3> J = row.J_px_m * J_m_state;
    J.col(2) += row.J_px_inverse / unit_m_;
    return J / pixel.sigma_px;
  }

  // Normal equations for these rows.
  void normals(const PointState& state, const std::vector<PixelRow>& rows, Matrix3d& H,
               Vector3d& gradient) const {
    const Matrix32 basis = tangentBasis(state.direction);
    H.setZero();
    gradient.setZero();
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const auto J = byState(rows[i], pixels_[i], basis);
      H += J.transpose() * J;
      gradient += J.transpose() * (rows[i].error / pixels_[i].sigma_px);
    }
  }

  [[nodiscard]] PointState moved(const PointState& state, const Vector3d& step) const {
    const Vector3d turned = state.direction + tangentBasis(state.direction) * step.head<2>();
    return {turned.normalized(), state.inverse_m + step.z() / unit_m_};
  }

 private:
  const AnyRig& rig_;
  std::span<const RigPixel> pixels_;
  Vector3d anchor_;
  double unit_m_ = 0;
};

// The ray of the first pixel, with the inverse distance that brings the point closest to the other rays:
// linear, since (direction + inverse_m * offset) x ray = 0. Nothing if the rays lie on the line through the
// cameras.
std::optional<PointState> linearStart(const PointProblem& problem, std::span<const RigPixel> pixels,
                                      const std::vector<RigRay>& rays) {
  const Vector3d& direction = rays.front().direction;
  double across = 0;
  double along = 0;
  for (std::size_t i = 1; i < pixels.size(); ++i) {
    const Vector3d normal = (rays.front().origin - rays[i].origin).cross(rays[i].direction);
    across += normal.squaredNorm();
    along -= normal.dot(direction.cross(rays[i].direction));
  }
  constexpr double kOnLine = 1e-10;  // rad
  if (!(std::sqrt(across) > kOnLine * problem.unit())) return std::nullopt;
  return PointState{direction, along / across};
}

// The linear start; if a camera does not see that point, the best of many distances.
std::optional<PointState> visibleStart(const PointProblem& problem, const PointState& linear) {
  std::vector<PixelRow> rows;
  if (problem.rowsAt(linear, rows)) return linear;
  std::optional<PointState> best;
  double best_cost = std::numeric_limits<double>::infinity();
  constexpr int kNumDistances = 25;  // 0, and 1e-3 to 1e3 times the distance of the cameras
  for (int i = 0; i < kNumDistances; ++i) {
    const double inverse = i == 0 ? 0 : std::pow(10.0, 3 - 6.0 * (i - 1) / (kNumDistances - 2));
    const PointState state{linear.direction, inverse / problem.unit()};
    const auto cost = problem.rowsAt(state, rows);
    if (!cost || *cost >= best_cost) continue;
    best = state;
    best_cost = *cost;
  }
  return best;
}

struct PointSolution {
  PointState state;
  std::vector<PixelRow> rows;
  Matrix3d covariance;  // of direction (tangents) and inverse distance in 1 / unit(), caused by noise of the
                        // pixels
};

// Runs Levenberg-Marquardt until a step is far below the standard deviation.
TriangulationStatus solvePoint(const PointProblem& problem, PointState start, PointSolution& best) {
  constexpr int kMaxIterations = 200;
  constexpr double kConverged = 1e-18;        // squared step in squared standard deviations
  constexpr double kConvergedOfCost = 1e-14;  // the same if errors are large, as a share of the cost
  constexpr double kNearest = 1e-6;           // closest valid distance, in unit()
  constexpr double kRoundingOfPixel = 1e-9;   // px
  best.state = std::move(start);
  double cost = *problem.rowsAt(best.state, best.rows);
  const double rounding = kRoundingOfPixel / problem.leastSigma();
  Vector3d scale;
  Matrix3d scaled;
  Vector3d scaled_gradient;
  TriangulationStatus status = TriangulationStatus::kNotConverged;
  // The normal equations at the best state, scaled so that undetermined directions are not confused with
  // small units.
  // @returns true to continue from there
  const auto linearise = [&] {
    if (std::abs(best.state.inverse_m) * problem.unit() > 1 / kNearest) return false;
    Matrix3d H;
    Vector3d gradient;
    problem.normals(best.state, best.rows, H, gradient);
    scale = H.diagonal().cwiseSqrt();
    status = TriangulationStatus::kUndetermined;
    if (!(scale.minCoeff() > 0) || !scale.allFinite()) return false;
    scaled = scale.asDiagonal().inverse() * H * scale.asDiagonal().inverse();
    const Eigen::LLT<Matrix3d> undamped(scaled);
    constexpr double kSingular = 1e-12;
    if (undamped.info() != Eigen::Success || !(undamped.rcond() > kSingular)) return false;
    scaled_gradient = gradient.cwiseQuotient(scale);
    status = TriangulationStatus::kNotConverged;
    if (!(scaled_gradient.dot(undamped.solve(scaled_gradient)) <=
          kConverged + kConvergedOfCost * cost + rounding * rounding))
      return true;
    best.covariance =
        scale.asDiagonal().inverse() * undamped.solve(Matrix3d::Identity()) * scale.asDiagonal().inverse();
    status = TriangulationStatus::kOk;
    return false;
  };
  if (!linearise()) return status;
  std::vector<PixelRow> rows;
  int num_taken = 0;
  const DampingRule rule{
      .raised = [](double damping) { return 10 * damping > 1e12 ? HUGE_VAL : std::max(1e-4, 10 * damping); },
      .lowered = [](double damping) { return damping < 1e-9 ? 0 : damping / 10; },
      .max_steps = std::numeric_limits<int>::max()};
  minimise(rule, [&](double damping) {
    const Matrix3d damped = scaled + damping * Matrix3d::Identity();
    const Vector3d step = -damped.llt().solve(scaled_gradient).cwiseQuotient(scale);
    const PointState next = problem.moved(best.state, step);
    const auto next_cost = problem.rowsAt(next, rows);
    if (!next_cost || !(std::sqrt(*next_cost) <= std::sqrt(cost) + rounding)) return StepResult::kWorse;
    best.state = next;
    std::swap(best.rows, rows);
    cost = *next_cost;
    return ++num_taken < kMaxIterations && linearise() ? StepResult::kBetter : StepResult::kConverged;
  });
  return status;
}

// First columns of a camera's parameters and pose in the joint covariance.
struct RigColumns {
  Eigen::Index parameters = 0;
  std::optional<Eigen::Index> pose;
};

RigColumns columnsOf(const AnyRig& rig, std::size_t camera) {
  RigColumns columns;
  Eigen::Index num_parameters = 0;
  for (std::size_t i = 0; i < rig.size(); ++i) {
    if (i == camera) columns.parameters = num_parameters;
    num_parameters += static_cast<Eigen::Index>(rig.camera(i).camera.parameters().size());
  }
  if (camera > 0) columns.pose = num_parameters + 6 * static_cast<Eigen::Index>(camera - 1);
  return columns;
}

// 3 x unknowns of the rig: derivative of the state by the unknowns, times -1.
Eigen::MatrixXd stateByRig(const AnyRig& rig, const PointProblem& problem, std::span<const RigPixel> pixels,
                           const PointSolution& solution) {
  const Matrix32 basis = tangentBasis(solution.state.direction);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(3, numRigUnknowns(rig));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const RigPixel& pixel = pixels[i];
    const PixelRow& row = solution.rows[i];
    const MountedCamera& camera = rig.camera(pixel.camera);
    const Eigen::Matrix<double, 3, 2> weighted =
        problem.byState(row, pixel, basis).transpose() / pixel.sigma_px;
    const auto num_parameters = static_cast<Eigen::Index>(camera.camera.parameters().size());
    Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> by_parameters(2, num_parameters);
    expect(seenBy(camera.camera, row.m, solution.state.inverse_m, nullptr, by_parameters.data()).ok(),
           "the cameras see the point");
    const RigColumns columns = columnsOf(rig, pixel.camera);
    sum.middleCols(columns.parameters, num_parameters) += weighted * by_parameters;
    if (!columns.pose) continue;
    // camera_from_rig * Exp(xi) * point, times inverse_m.
    const Matrix3d R = camera.camera_from_rig.rotation.matrix();
    const Vector3d point =
        R.transpose() * (row.m - solution.state.inverse_m * camera.camera_from_rig.translation);
    Eigen::Matrix<double, 3, 6> J_m_xi;
    J_m_xi << solution.state.inverse_m * R, -R * hat(point);
    sum.middleCols(*columns.pose, 6) += weighted * row.J_px_m * J_m_xi;
  }
  return solution.covariance * sum;
}

// True if a camera sees the point more than a right angle away from its pixel's ray.
bool isBehind(const AnyRig& rig, std::span<const RigPixel> pixels, const std::vector<RigRay>& rays,
              const PointSolution& solution) {
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const SE3& camera_from_rig = rig.camera(pixels[i].camera).camera_from_rig;
    if (!(solution.rows[i].m.dot(camera_from_rig.rotation * rays[i].direction) > 0)) return true;
  }
  return false;
}

Triangulation answerOf(const AnyRig& rig, const PointProblem& problem, std::span<const RigPixel> pixels,
                       const PointSolution& solution, const Eigen::MatrixXd& rig_covariance) {
  Matrix3d by_rig = Matrix3d::Zero();
  if (rig_covariance.size() > 0) {
    const Eigen::MatrixXd G = stateByRig(rig, problem, pixels, solution);
    by_rig = G * rig_covariance * G.transpose();
  }
  const double inverse = solution.state.inverse_m * problem.unit();  // dimensionless
  const double std = std::sqrt(solution.covariance(2, 2) + by_rig(2, 2));
  constexpr double kSignificant = 3;
  constexpr double kRounding = 1e-13;
  Triangulation answer;
  if (inverse < -kSignificant * std - kRounding) {
    answer.status = TriangulationStatus::kBehind;
    return answer;
  }
  if (inverse <= kRounding) {
    answer.status = TriangulationStatus::kAtInfinity;
    return answer;
  }
  answer.status = TriangulationStatus::kOk;
  answer.p_rig = problem.pointOf(solution.state);
  double sum = 0;
  for (const PixelRow& row : solution.rows) {
    answer.residuals.push_back(row.error);
    sum += row.error.squaredNorm();
  }
  answer.error_px = std::sqrt(sum / static_cast<double>(pixels.size()));
  Matrix3d J_p_state;
  J_p_state << tangentBasis(solution.state.direction), -solution.state.direction / inverse;
  J_p_state *= problem.unit() / inverse;
  answer.covariance_by_pixels = J_p_state * solution.covariance * J_p_state.transpose();
  answer.covariance_by_rig = J_p_state * by_rig * J_p_state.transpose();
  return answer;
}

}  // namespace

std::string_view statusId(TriangulationStatus status) {
  switch (status) {
    case TriangulationStatus::kOk:
      return "ok";
    case TriangulationStatus::kTooFewCameras:
      return "too_few_cameras";
    case TriangulationStatus::kNoRay:
      return "no_ray";
    case TriangulationStatus::kAtInfinity:
      return "at_infinity";
    case TriangulationStatus::kBehind:
      return "behind";
    case TriangulationStatus::kUndetermined:
      return "undetermined";
    case TriangulationStatus::kNotConverged:
      return "not_converged";
  }
  return "";
}

std::optional<double> epipolarDistance(const MountedCamera& a, const MountedCamera& b,
                                       const Vector2d& pixel_a, const Vector2d& pixel_b) {
  double sum = 0;
  for (const bool is_in_a : {true, false}) {
    const MountedCamera& camera = is_in_a ? a : b;
    const MountedCamera& other = is_in_a ? b : a;
    Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_ray_pixel;
    const auto ray = camera.camera.unproject(is_in_a ? pixel_a : pixel_b, J_ray_pixel.data());
    const auto ray_of_other = other.camera.unproject(is_in_a ? pixel_b : pixel_a);
    if (!ray || !ray_of_other) return std::nullopt;
    const SE3 camera_from_other = camera.camera_from_rig * other.camera_from_rig.inverse();
    // The plane through both centres that contains the other ray.
    const Vector3d to_other =
        camera_from_other * other.camera.startOf(*ray_of_other) - camera.camera.startOf(*ray);
    const Vector3d normal = to_other.cross(camera_from_other.rotation * *ray_of_other);
    constexpr double kSamePlace = 1e-9;  // m
    constexpr double kLeastSine = 1e-6;  // of the ray with the line through both cameras
    if (!(normal.norm() > std::max(kSamePlace, kLeastSine * to_other.norm()))) return std::nullopt;
    const Vector2d gradient = J_ray_pixel.transpose() * normal;
    sum += 0.5 * std::pow(normal.dot(*ray) / gradient.norm(), 2);
  }
  return std::sqrt(sum);
}

Eigen::Index numRigUnknowns(const AnyRig& rig) {
  auto count = 6 * static_cast<Eigen::Index>(rig.size() - 1);
  for (const MountedCamera& camera : rig.cameras())
    count += static_cast<Eigen::Index>(camera.camera.parameters().size());
  return count;
}

Triangulation triangulate(const AnyRig& rig, std::span<const RigPixel> pixels,
                          const Eigen::MatrixXd& rig_covariance) {
  expect(rig_covariance.size() == 0 ||
             (rig_covariance.rows() == numRigUnknowns(rig) && rig_covariance.cols() == numRigUnknowns(rig)),
         "the covariance has a row for each unknown of the rig");
  Triangulation failed;
  const auto is_other = [&](const RigPixel& pixel) { return pixel.camera != pixels.front().camera; };
  failed.status = TriangulationStatus::kTooFewCameras;
  if (std::ranges::none_of(pixels, is_other)) return failed;
  std::vector<RigRay> rays;
  failed.status = TriangulationStatus::kNoRay;
  for (const RigPixel& pixel : pixels) {
    expect(pixel.sigma_px > 0, "a standard deviation is positive");
    const auto ray = rig.unproject(pixel.camera, pixel.pixel);
    if (!ray) return failed;
    rays.push_back(*ray);
  }
  const PointProblem problem(rig, pixels);
  failed.status = TriangulationStatus::kUndetermined;
  const auto linear = linearStart(problem, pixels, rays);
  if (!linear) return failed;
  failed.status = TriangulationStatus::kBehind;
  const auto start = visibleStart(problem, *linear);
  if (!start) return failed;
  PointSolution solution;
  failed.status = solvePoint(problem, *start, solution);
  if (failed.status != TriangulationStatus::kOk) return failed;
  failed.status = TriangulationStatus::kBehind;
  if (isBehind(rig, pixels, rays, solution)) return failed;
  return answerOf(rig, problem, pixels, solution, rig_covariance);
}

}  // namespace alidade
