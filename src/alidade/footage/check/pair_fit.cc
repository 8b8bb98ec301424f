// SPDX-License-Identifier: MIT
#include "alidade/footage/check/pair_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "alidade/adjust/board/observation.h"
#include "alidade/footage/geometry/essential.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/least_squares.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr HuberLoss kLoss{.threshold_px = 2.5};  // in units of the noise
constexpr double kNoRay = 10.0;                  // error of a match that has lost its rays

// A match as unit rays, and their derivatives by the pixels.
struct PairRays {
  Eigen::Vector3d first;
  Eigen::Vector3d second;
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_first;
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_second;
};

// The rays of a match; nothing if a pixel has no ray.
std::optional<PairRays> raysOf(const PosedPair& pair, const PixelMatch& match) {
  PairRays rays;
  const auto a = pair.first.unproject(match.a, rays.J_first.data());
  const auto b = a ? pair.second.unproject(match.b, rays.J_second.data()) : std::nullopt;
  if (!b) return std::nullopt;
  rays.first = *a;
  rays.second = *b;
  return rays;
}

double priorOf(CameraChangeKind kind, int width) {
  switch (kind) {
    case CameraChangeKind::kRotation:
    case CameraChangeKind::kPosition:
      return 0.2;  // radians
    case CameraChangeKind::kFocalLength:
      return 0.2;
    case CameraChangeKind::kFirstRadial:
      return 0.5;
    case CameraChangeKind::kPrincipalPoint:
      return 0.05 * width;
    default:
      return 1;
  }
}

bool hasNoDistortion(const AnyCamera& camera) {
  const auto params = camera.parameters();
  return std::all_of(params.begin() + 4, params.end(), [](double value) { return value == 0; });
}

CameraChangeKind lensChange(const AnyCamera& camera) {
  return hasNoDistortion(camera) ? CameraChangeKind::kFirstRadial : CameraChangeKind::kDistortion;
}

// Two directions perpendicular to the baseline, in the second camera's frame.
Eigen::Matrix<double, 3, 2> acrossBaseline(const Eigen::Vector3d& baseline) {
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = baseline.unitOrthogonal();
  across.col(1) = baseline.cross(across.col(0)).normalized();
  return across;
}

SE3 changedPose(const SE3& second_from_first, const PairFreedom& freedom, const Eigen::VectorXd& amounts) {
  SE3 pose = second_from_first;
  Eigen::Index at = 0;
  for (const auto& [kind, side] : freedom.parts) {
    if (kind == CameraChangeKind::kRotation) {
      // Points turn in the opposite direction to the camera.
      const SE3 turn{SO3::exp(-amounts.segment<3>(at)), Eigen::Vector3d::Zero()};
      pose = side == PairSide::kFirst ? pose * turn.inverse() : turn * pose;
    } else if (kind == CameraChangeKind::kPosition) {
      const Eigen::Vector3d sideways = acrossBaseline(pose.translation) * amounts.segment<2>(at);
      pose.translation = SO3::exp(pose.translation.cross(sideways)) * pose.translation;
    }
    at += numAmounts(kind);
  }
  return pose;
}

// Half of Huber's rho.
double cost(double r) {
  const double limit = kLoss.threshold_px;
  const double size = std::abs(r);
  return size <= limit ? 0.5 * r * r : limit * (size - 0.5 * limit);
}

double robustSum(const Eigen::VectorXd& r) {
  double sum = 0;
  for (const double value : r) sum += cost(value);
  return sum;
}

// Derivatives of a pair by each amount.
struct PairDirection {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Matrix3d essential = Eigen::Matrix3d::Zero();
  Eigen::VectorXd first = {};  // of the parameters; empty if they do not change
  Eigen::VectorXd second = {};
};

// @param here  the pair with these amounts
std::vector<PairDirection> directionsAt(const PosedPair& stated, const PairFreedom& freedom,
                                        const Eigen::VectorXd& amounts, const PosedPair& here) {
  std::vector<PairDirection> directions;
  for (const auto& [kind, side] : freedom.parts) {
    for (Eigen::Index k = 0; k < numAmounts(kind); ++k) {
      PairDirection& direction = directions.emplace_back();
      if (kind == CameraChangeKind::kRotation || kind == CameraChangeKind::kPosition) {
        constexpr double kStep = 1e-6;  // radians
        const auto at = static_cast<Eigen::Index>(directions.size()) - 1;
        const auto posed = [&](double step) {
          Eigen::VectorXd moved = amounts;
          moved[at] += step;
          return changedPose(stated.second_from_first, freedom, moved);
        };
        const SE3 plus = posed(kStep);
        const SE3 minus = posed(-kStep);
        direction.rotation = (plus.rotation.matrix() - minus.rotation.matrix()) / (2 * kStep);
        direction.translation = (plus.translation - minus.translation) / (2 * kStep);
        direction.essential = (essentialMatrix(plus) - essentialMatrix(minus)) / (2 * kStep);
        continue;
      }
      if (side != PairSide::kSecond)
        direction.first = directionsOf(kind, stated.first, here.first.parameters().size()).col(k);
      if (side != PairSide::kFirst)
        direction.second = directionsOf(kind, stated.second, here.second.parameters().size()).col(k);
    }
  }
  return directions;
}

// Change of a pixel's ray with the parameters, such that its pixel is constant. 3 x parameters.
Eigen::Matrix<double, 3, Eigen::Dynamic> rayByParameters(
    const AnyCamera& camera, const Eigen::Vector3d& ray,
    const Eigen::Matrix<double, 3, 2, Eigen::RowMajor>& J_ray_pixel) {
  const auto n = static_cast<Eigen::Index>(camera.parameters().size());
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J(2, n);
  if (!camera.project(ray, nullptr, J.data()).ok()) J.setZero();
  return -J_ray_pixel * J;
}

// The error of the epipolar constraint and its derivatives, before division by a standard deviation.
struct Constraint {
  double value = 0;
  Eigen::Vector3d line_first;
  Eigen::Vector3d line_second;
  Eigen::VectorXd J;
};

Constraint constraintOf(const PosedPair& here, const Eigen::Matrix3d& E,
                        const std::vector<PairDirection>& directions, const PairRays& rays) {
  Constraint constraint;
  constraint.line_second = E * rays.first;
  constraint.line_first = E.transpose() * rays.second;
  constraint.value = rays.second.dot(constraint.line_second);
  constraint.J = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(directions.size()));
  Eigen::RowVectorXd by_first;
  Eigen::RowVectorXd by_second;
  for (std::size_t k = 0; k < directions.size(); ++k) {
    const PairDirection& direction = directions[k];
    double& J = constraint.J[static_cast<Eigen::Index>(k)];
    J = rays.second.dot(direction.essential * rays.first);
    if (direction.first.size() > 0) {
      if (by_first.size() == 0)
        by_first = constraint.line_first.transpose() * rayByParameters(here.first, rays.first, rays.J_first);
      J += by_first.dot(direction.first);
    }
    if (direction.second.size() > 0) {
      if (by_second.size() == 0)
        by_second =
            constraint.line_second.transpose() * rayByParameters(here.second, rays.second, rays.J_second);
      J += by_second.dot(direction.second);
    }
  }
  return constraint;
}

// The errors and their derivatives at some amounts. The standard deviations are constant during a step
// (Sampson 1982), since the sum would also fall if they grew.
struct Linear {
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
  Eigen::VectorXd units;  // standard deviations of the constraint; 0: without rays
};

Eigen::VectorXd weightsOf(const Linear& linear) {
  return linear.r.unaryExpr([](double r) { return kLoss.weight(r * r); });
}

// The robust sum of errors of a pair for these standard deviations.
double costWith(const PosedPair& pair, std::span<const TimedMatch> matches, const Eigen::VectorXd& units) {
  const Eigen::Matrix3d E = essentialMatrix(pair.second_from_first);
  double sum = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const double unit = units[static_cast<Eigen::Index>(i)];
    const PixelMatch& match = matches[i].pixels;
    const auto a = unit > 0 ? pair.first.unproject(match.a) : std::nullopt;
    const auto b = a ? pair.second.unproject(match.b) : std::nullopt;
    sum += cost(b ? b->dot(E * *a) / unit : kNoRay);
  }
  return sum;
}

std::optional<Linear> linearAt(const PosedPair& pair, const PairFreedom& freedom,
                               std::span<const TimedMatch> matches, const Eigen::VectorXd& at, double noise) {
  const auto here = changedPair(pair, freedom, at);
  if (!here) return std::nullopt;
  const Eigen::Matrix3d E = essentialMatrix(here->second_from_first);
  const std::vector<PairDirection> directions = directionsAt(pair, freedom, at, *here);
  const auto n = static_cast<Eigen::Index>(matches.size());
  Linear linear{.r = Eigen::VectorXd::Constant(n, kNoRay),
                .J = Eigen::MatrixXd::Zero(n, at.size()),
                .units = Eigen::VectorXd::Zero(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const PixelMatch& match = matches[static_cast<std::size_t>(i)].pixels;
    const auto rays = raysOf(*here, match);
    if (!rays) continue;
    const Constraint constraint = constraintOf(*here, E, directions, *rays);
    const double unit = noise * match.sigma_px *
                        std::sqrt((rays->J_first.transpose() * constraint.line_first).squaredNorm() +
                                  (rays->J_second.transpose() * constraint.line_second).squaredNorm());
    if (!(unit > 0)) continue;
    linear.units[i] = unit;
    linear.r[i] = constraint.value / unit;
    linear.J.row(i) = constraint.J.transpose() / unit;
  }
  return linear;
}

// Covariance by the scatter of matches, or of instants if that is larger.
void addScatter(PairFit& fit, const Linear& linear, const PairFreedom& freedom,
                std::span<const TimedMatch> matches) {
  const Eigen::Index p = linear.J.cols();
  const Eigen::Index n = linear.J.rows();
  // In units of the prior, to scale all unknowns alike.
  const Eigen::MatrixXd J = linear.J * freedom.prior.asDiagonal();
  std::size_t num_instants = 0;
  for (const TimedMatch& match : matches) num_instants = std::max(num_instants, match.instant + 1);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(p, p);
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(p, p);
  std::vector<Eigen::MatrixXd> informations(num_instants, Eigen::MatrixXd::Zero(p, p));
  std::vector<Eigen::VectorXd> gradients(num_instants, Eigen::VectorXd::Zero(p));
  std::vector<bool> is_seen(num_instants, false);
  const Eigen::MatrixXd prior = Eigen::MatrixXd::Identity(p, p);
  const Eigen::VectorXd weights = weightsOf(linear);
  const Eigen::MatrixXd inverse = solveSpd(J.transpose() * weights.asDiagonal() * J + prior, prior);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double weight = weights[i];
    const Eigen::VectorXd row = J.row(i).transpose();
    const Eigen::VectorXd gradient = weight * linear.r[i] * row;
    const double leverage = std::clamp(weight * row.dot(inverse * row), 0.0, 1.0);
    fit.leverages.push_back(leverage);
    const std::size_t instant = matches[static_cast<std::size_t>(i)].instant;
    informations[instant] += weight * row * row.transpose();
    gradients[instant] += gradient;
    is_seen[instant] = true;
    // Uses the error that a match would have if it were not fitted (MacKinnon and White 1985, estimator HC3).
    const double unfitted = 1 / std::max(1e-3, 1 - leverage);
    scatter += unfitted * unfitted * gradient * gradient.transpose();
  }
  for (const Eigen::MatrixXd& part : informations) information += part;
  // At least the information in every direction; less could only be chance.
  const Eigen::MatrixXd base = information + 1e-9 * (1 + information.trace()) * prior;
  const SymmetricEigen eigen(scatter, base);
  const Eigen::VectorXd factors = eigen.eigenvalues().cwiseMax(1);
  fit.dispersion = factors.mean();
  const Eigen::MatrixXd half = base * eigen.eigenvectors();
  scatter = half * factors.asDiagonal() * half.transpose();
  // Disagreement of the instants' gradients at the common optimum: mean over the unknowns, and along the
  // change.
  const Eigen::VectorXd along = fit.amounts.cwiseQuotient(freedom.prior).normalized();
  double sum = 0;
  double sum_along = 0;
  double count = -1;
  for (std::size_t k = 0; k < num_instants; ++k) {
    if (!is_seen[k]) continue;
    sum += gradients[k].dot(solveSpd(fit.dispersion * informations[k] + 1e-3 * prior, gradients[k]));
    sum_along += std::pow(along.dot(gradients[k]), 2);
    count += 1;
  }
  if (count > 0) {
    const double expected = fit.dispersion * along.dot(information * along) + 1e-3;
    fit.disagreement =
        std::max(sum / (count * static_cast<double>(p)), sum_along * (count + 1) / count / expected);
  }
  scatter *= std::max(1.0, fit.disagreement);
  fit.covariance = freedom.prior.asDiagonal() * Eigen::MatrixXd(inverse * (scatter + prior) * inverse) *
                   freedom.prior.asDiagonal();
}

}  // namespace

std::vector<double> sampsonErrors(const PosedPair& pair, std::span<const TimedMatch> matches) {
  const Eigen::Matrix3d E = essentialMatrix(pair.second_from_first);
  std::vector<double> errors;
  errors.reserve(matches.size());
  for (const TimedMatch& match : matches) {
    const auto rays = raysOf(pair, match.pixels);
    if (!rays) {
      errors.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const Eigen::Vector3d line_second = E * rays->first;
    const Eigen::Vector3d line_first = E.transpose() * rays->second;
    const double variance = (rays->J_first.transpose() * line_first).squaredNorm() +
                            (rays->J_second.transpose() * line_second).squaredNorm();
    errors.push_back(rays->second.dot(line_second) / std::sqrt(variance));
  }
  return errors;
}

std::vector<PairFreedom> pairFreedoms(const PosedPair& pair, std::array<int, 2> widths) {
  using enum CameraChangeKind;
  using enum PairSide;
  std::vector<PairFreedom> freedoms;
  const auto add = [&](CameraChangeKind kind, PairSide side, std::vector<PairFreedom::Part> parts) {
    std::vector<double> prior;
    for (const PairFreedom::Part& part : parts) {
      const double one = priorOf(part.kind, widths[part.side == kFirst ? 0 : 1]);
      prior.insert(prior.end(), static_cast<std::size_t>(numAmounts(part.kind)), one);
    }
    freedoms.push_back({kind, side, std::move(parts),
                        Eigen::Map<Eigen::VectorXd>(prior.data(), static_cast<Eigen::Index>(prior.size()))});
  };
  const auto addOne = [&](CameraChangeKind kind, PairSide side) { add(kind, side, {{kind, side}}); };
  const CameraChangeKind first_lens = lensChange(pair.first);
  const CameraChangeKind second_lens = lensChange(pair.second);
  addOne(kRotation, kSecond);
  addOne(kRotation, kFirst);
  for (const PairSide side : {kSecond, kFirst, kBoth}) addOne(kFocalLength, side);
  if (first_lens == second_lens) addOne(first_lens, kBoth);
  addOne(second_lens, kSecond);
  addOne(first_lens, kFirst);
  addOne(kPosition, kSecond);
  addOne(kPrincipalPoint, kSecond);
  addOne(kPrincipalPoint, kFirst);
  std::vector<PairFreedom::Part> parts = {{kRotation, kSecond}, {kPosition, kSecond}};
  add(kPose, kSecond, parts);
  for (const PairSide side : {kFirst, kSecond}) {
    parts.push_back({kFocalLength, side});
    parts.push_back({side == kFirst ? first_lens : second_lens, side});
    parts.push_back({kPrincipalPoint, side});
  }
  add(kSeveral, kBoth, parts);
  return freedoms;
}

std::optional<PosedPair> changedPair(const PosedPair& pair, const PairFreedom& freedom,
                                     const Eigen::VectorXd& amounts) {
  PosedPair changed = pair;
  changed.second_from_first = changedPose(pair.second_from_first, freedom, amounts);
  Eigen::Index at = 0;
  for (const auto& [kind, side] : freedom.parts) {
    const Eigen::VectorXd by = amounts.segment(at, numAmounts(kind));
    at += numAmounts(kind);
    if (kind == CameraChangeKind::kRotation || kind == CameraChangeKind::kPosition) continue;
    for (const bool is_first : {true, false}) {
      if (side == (is_first ? PairSide::kSecond : PairSide::kFirst)) continue;
      AnyCamera& camera = is_first ? changed.first : changed.second;
      const auto moved = changedCamera(camera, kind, by);
      if (!moved) return std::nullopt;
      camera = *moved;
    }
  }
  return changed;
}

std::vector<std::optional<PairShift>> shiftsBy(const PosedPair& pair, const PairFreedom& freedom,
                                               const Eigen::VectorXd& amounts,
                                               std::span<const PixelMatch> seen, double distance) {
  std::vector<std::optional<PairShift>> shifts(seen.size());
  const auto here = changedPair(pair, freedom, amounts);
  if (!here) return shifts;
  const SE3& pose = here->second_from_first;
  const Eigen::Matrix3d R = pose.rotation.matrix();
  const Eigen::Matrix3d E = essentialMatrix(pose);
  const std::vector<PairDirection> directions = directionsAt(pair, freedom, amounts, *here);
  const auto num_params = static_cast<Eigen::Index>(here->second.parameters().size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto rays = raysOf(*here, seen[i]);
    if (!rays) continue;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_point;
    Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J_params(2, num_params);
    const Projection there =
        here->second.project(pose * (distance * rays->first), J_point.data(), J_params.data());
    if (!there.ok()) continue;
    const Constraint constraint = constraintOf(*here, E, directions, *rays);
    const double unit = (rays->J_second.transpose() * constraint.line_second).norm();
    if (!(unit > 0)) continue;
    PairShift& shift = shifts[i].emplace();
    shift.across_x_y << constraint.value / unit, there.pixel - seen[i].b;
    shift.J.resize(3, constraint.J.size());
    shift.J.row(0) = constraint.J.transpose() / unit;
    const Eigen::Matrix<double, 3, Eigen::Dynamic> J_ray =
        rayByParameters(here->first, rays->first, rays->J_first);
    for (std::size_t k = 0; k < directions.size(); ++k) {
      const PairDirection& direction = directions[k];
      Eigen::Vector3d point = distance * (direction.rotation * rays->first) + direction.translation;
      if (direction.first.size() > 0) point += distance * (R * (J_ray * direction.first));
      Eigen::Vector2d pixel = J_point * point;
      if (direction.second.size() > 0) pixel += J_params * direction.second;
      shift.J.block<2, 1>(1, static_cast<Eigen::Index>(k)) = pixel;
    }
  }
  return shifts;
}

double costOf(const PosedPair& pair, std::span<const TimedMatch> matches, double noise) {
  const std::vector<double> errors = sampsonErrors(pair, matches);
  double sum = 0;
  for (std::size_t i = 0; i < errors.size(); ++i)
    sum += cost(std::isfinite(errors[i]) ? errors[i] / (noise * matches[i].pixels.sigma_px) : kNoRay);
  return sum;
}

PairFit fitPair(const PosedPair& pair, const PairFreedom& freedom, std::span<const TimedMatch> matches,
                const Eigen::VectorXd& start, double noise, int max_steps, const CancelFlag* cancel) {
  PairFit fit{.amounts = start, .covariance = {}};
  const Eigen::VectorXd weight_of_prior = freedom.prior.cwiseAbs2().cwiseInverse();
  const auto priorCost = [&](const Eigen::VectorXd& at) {
    return 0.5 * at.dot(weight_of_prior.cwiseProduct(at));
  };
  auto linear = linearAt(pair, freedom, matches, start, noise);
  if (!linear) return fit;
  double least = robustSum(linear->r) + priorCost(start);
  const DampingRule rule{
      .raised = [](double damping) { return damping > 1e8 / 8 ? HUGE_VAL : std::max(1e-3, damping * 8); },
      .lowered = [](double damping) { return damping > 1e-3 ? damping / 8 : 0; },
      .max_steps = max_steps};
  fit.is_converged = minimise(rule, [&](double damping) {
    throwIfCancelled(cancel);
    // In units of the prior.
    const Eigen::MatrixXd J = linear->J * freedom.prior.asDiagonal();
    const Eigen::VectorXd weights = weightsOf(*linear);
    Eigen::MatrixXd A = J.transpose() * weights.asDiagonal() * J;
    A.diagonal().array() += 1;
    A.diagonal() += damping * A.diagonal();
    const Eigen::VectorXd gradient =
        J.transpose() * weights.cwiseProduct(linear->r) + fit.amounts.cwiseQuotient(freedom.prior);
    const Eigen::VectorXd delta = -solveSpd(A, gradient);
    constexpr double kLittle = 1e-3;  // of the cost, whose unit is the noise
    if (-0.5 * gradient.dot(delta) < kLittle)
      return damping < 1 ? StepResult::kConverged : StepResult::kFailed;
    const Eigen::VectorXd trial = fit.amounts + freedom.prior.cwiseProduct(delta);
    const auto moved = changedPair(pair, freedom, trial);
    if (!moved || !(costWith(*moved, matches, linear->units) + priorCost(trial) < least))
      return StepResult::kWorse;
    auto next = linearAt(pair, freedom, matches, trial, noise);
    if (!next) return StepResult::kWorse;
    fit.amounts = trial;
    linear = std::move(next);
    least = robustSum(linear->r) + priorCost(trial);
    return StepResult::kBetter;
  });
  fit.cost = robustSum(linear->r);
  fit.prior_cost = priorCost(fit.amounts);
  addScatter(fit, *linear, freedom, matches);
  return fit;
}

}  // namespace alidade
