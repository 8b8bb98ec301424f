// SPDX-License-Identifier: MIT
// Calibrates from exact corners of a known camera, writes the camera file into the folder given, and reads it
// back.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "../own_eigen.h"
#include "alidade/calibrate.h"
#include "alidade/files.h"

namespace {

constexpr alidade::ImageSize kSize{640, 480};
const std::vector<double> kTrueParams = {532, 533, 321, 237, -0.28, 0.06, 1e-3, -5e-4, 0.0};

// Boards tilted about both axes, at the image's middle and towards its corners.
std::vector<alidade::View> exactViews(const alidade::AnyCamera& camera, const alidade::Checkerboard& board) {
  std::vector<alidade::View> views;
  for (int i = 0; i < 12; ++i) {
    alidade::SE3 camera_from_board;
    camera_from_board.rotation = alidade::SO3::exp({0.5 * std::cos(i), 0.5 * std::sin(i), 0.1 * i});
    const Eigen::Vector3d centre(0.06 * std::cos(2 * i), 0.04 * std::sin(2 * i), 0.35);
    camera_from_board.translation = centre - camera_from_board.rotation * board.middle();
    alidade::View view{.image = "view_" + std::to_string(i), .size = kSize, .corners = {}};
    for (int id = 0; id < board.numCorners(); ++id) {
      const auto projection = camera.project(camera_from_board * board.corner(id));
      if (projection.ok()) view.corners.push_back({.id = id, .pixel = projection.pixel});
    }
    views.push_back(std::move(view));
  }
  return views;
}

// Copies and destroys what the library allocated. Exact corners leave next to no uncertainty.
bool hasCovariance(const alidade::Calibration& calibration) {
  const alidade::Uncertainty& known = calibration.uncertainty;
  if (!known.covariance) return false;
  alidade::DenseMatrix covariance = *known.covariance;
  covariance = known.statedCovariance();
  if (covariance.rows() != static_cast<Eigen::Index>(kTrueParams.size())) return false;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    if (!(covariance(i, i) >= 0 && covariance(i, i) < 1e-6)) return false;
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const alidade::Checkerboard board{.columns = 9, .rows = 6, .square_m = 0.025};
  const auto truth = alidade::AnyCamera::make("radtan", kTrueParams);
  const auto result = alidade::calibrate(board, exactViews(truth, board), {.model = "radtan"});
  if (!ownEigenWorks() || !hasCovariance(result)) {
    std::fprintf(stderr,
                 "everything: the covariance is missing or wrong, or the solution of a linear system is\n");
    return 1;
  }

  const std::string path = std::string(argv[1]) + "/camera.yaml";
  alidade::saveCamera(path, alidade::recordOf(result, "package test"));
  const alidade::CameraRecord file = alidade::loadCamera(path);
  if (!file.calibration || file.calibration->num_views != 12 || !alidade::statedCovariance(file)) return 1;

  const auto params = file.camera.parameters();
  if (file.camera.modelId() != "radtan" || params.size() != kTrueParams.size()) return 1;
  for (std::size_t i = 0; i < params.size(); ++i) {
    // Exact corners give the truth back up to the solver's last digits.
    if (std::abs(params[i] - kTrueParams[i]) <= 1e-6 * (1 + std::abs(kTrueParams[i]))) continue;
    std::fprintf(stderr, "everything: parameter %zu is %.9g, not %.9g\n", i, params[i], kTrueParams[i]);
    return 1;
  }
  return 0;
}
