// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/errors.h"

#include <cmath>

#include "alidade/adjust/board/view_kernel.h"

namespace alidade {
namespace {

// Root of the mean of the squared errors times the corners' weights.
double rootMean(const Fit& fit, double (*weight)(const Observation&)) {
  double sum = 0;
  std::size_t count = 0;
  for (const FitView& view : fit.views) {
    for (std::size_t i = 0; i < view.errors.size(); ++i)
      sum += weight(view.corners[i]) * view.errors[i].squaredNorm();
    count += view.errors.size();
  }
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace

std::vector<Eigen::Vector2d> reprojectionErrors(std::string_view model_id, std::span<const double> params,
                                                const SE3& camera_from_board,
                                                std::span<const Observation> corners) {
  std::vector<Eigen::Vector2d> errors(corners.size());
  viewKernel(model_id, params.size()).errors(params.data(), camera_from_board, groupsOf(corners), errors);
  return errors;
}

std::vector<Eigen::Vector2d> viewErrors(const Fit& fit, const FitView& view) {
  const FitCamera& camera = fit.cameras[view.camera];
  return reprojectionErrors(camera.model, camera.params, cameraFromBoard(fit, view),
                            cornersOnShape(fit, view));
}

double viewCost(std::string_view model_id, std::span<const double> params, const SE3& pose,
                std::span<const Observation> corners, HuberLoss loss) {
  double cost = 0;
  const auto errors = reprojectionErrors(model_id, params, pose, corners);
  for (std::size_t i = 0; i < errors.size(); ++i)
    cost += 0.5 * loss.rho(corners[i].weight * errors[i].squaredNorm());
  return cost;
}

std::vector<Eigen::Vector2d> weightedErrors(const Fit& fit) {
  std::vector<Eigen::Vector2d> errors;
  for (const FitView& view : fit.views) {
    for (std::size_t i = 0; i < view.errors.size(); ++i)
      errors.emplace_back(std::sqrt(view.corners[i].weight) * view.errors[i]);
  }
  return errors;
}

double weightedRms(const Fit& fit) {
  return rootMean(fit, [](const Observation& corner) { return corner.weight; });
}

double rms(const Fit& fit) {
  return rootMean(fit, [](const Observation&) { return 1.0; });
}

void NeighbourDifferences::add(const Board& board, std::span<const Observation> corners,
                               std::span<const Eigen::Vector2d> errors) {
  constexpr int kUnseen = -1;
  index_of_.assign(static_cast<std::size_t>(board.numCorners()), kUnseen);
  for (std::size_t i = 0; i < corners.size(); ++i)
    index_of_[static_cast<std::size_t>(corners[i].id)] = static_cast<int>(i);
  const auto addPair = [&](int id, int neighbour) {
    const int a = index_of_[static_cast<std::size_t>(id)];
    const int b = index_of_[static_cast<std::size_t>(neighbour)];
    if (a == kUnseen || b == kUnseen) return;
    const auto i = static_cast<std::size_t>(a);
    const auto j = static_cast<std::size_t>(b);
    // The sum of the variances of both corners, relative to a corner of weight 1.
    const double variance = 1 / corners[i].weight + 1 / corners[j].weight;
    sum_ += 2 * (errors[i] - errors[j]).squaredNorm() / variance;
    ++num_pairs_;
  };
  for (int id = 0; id < board.numCorners(); ++id) {
    if ((id + 1) % board.columns() != 0) addPair(id, id + 1);
    if (id + board.columns() < board.numCorners()) addPair(id, id + board.columns());
  }
}

// A difference has twice the variance, and there are two coordinates.
double NeighbourDifferences::sigma() const {
  return std::sqrt(sum_ / (4.0 * num_pairs_));
}

double localSigma(const Fit& fit) {
  NeighbourDifferences differences;
  for (const FitView& view : fit.views) differences.add(boardOf(fit, view).target, view.corners, view.errors);
  return differences.sigma();
}

}  // namespace alidade
