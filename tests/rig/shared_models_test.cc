// SPDX-License-Identifier: MIT
#include "alidade/rig/shared_models.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/calibrator.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

const Board kSmall = Checkerboard{.columns = 3, .rows = 3, .square_m = 0.03};

// A camera for which `chosen` was chosen among models with these excesses of held-out errors; 0.01 is their
// standard error.
Calibration chosenCamera(const std::string& chosen, double focal,
                         const std::vector<std::pair<std::string, double>>& excesses) {
  std::vector<double> params = {focal, focal, 640, 480};
  params.resize(parameterNames(chosen).size(), 0.01);
  Calibration alone{.fit = emptyFit(chosen, kQuadVga, params, kSmall, kNoLoss)};
  std::vector<Observation> corners(9);
  addView(alone.fit, 0, corners, SE3{SO3(), Eigen::Vector3d(0, 0, 1)});
  alone.choice.model.emplace();
  for (const auto& [id, excess] : excesses) {
    ModelCandidate candidate;
    candidate.id = id;
    candidate.excess = excess;
    candidate.excess_std = 0.01;
    candidate.verdict = id == chosen ? "chosen" : "worse";
    alone.choice.model->candidates.push_back(candidate);
  }
  return alone;
}

using Models = std::vector<std::string>;

TEST(SharedModels, AreThoseOfTheLowestErrorInSum) {
  const std::vector<Calibration> alone = {chosenCamera("radtan", 900, {{"radtan", 0}, {"ucm", 0.05}}),
                                          chosenCamera("ucm", 920, {{"radtan", 0.01}, {"ucm", 0}}),
                                          chosenCamera("radtan", 910, {{"radtan", 0}, {"ucm", 0.04}})};
  EXPECT_EQ(sharedModels(alone), (Models{"radtan", "radtan", "radtan"}));
}

TEST(SharedModels, LeaveACameraAClearGain) {
  const std::vector<Calibration> alone = {chosenCamera("radtan", 900, {{"radtan", 0}, {"ucm", 0.5}}),
                                          chosenCamera("radtan", 905, {{"radtan", 0}, {"ucm", 0.5}}),
                                          chosenCamera("ucm", 920, {{"radtan", 0.1}, {"ucm", 0}})};
  EXPECT_EQ(sharedModels(alone), (Models{"radtan", "radtan", "ucm"}));
}

TEST(SharedModels, AreOnlyOfEqualCameras) {
  std::vector<Calibration> alone = {chosenCamera("radtan", 900, {{"radtan", 0}, {"ucm", 0.05}}),
                                    chosenCamera("ucm", 1200, {{"radtan", 0.01}, {"ucm", 0}})};
  EXPECT_EQ(sharedModels(alone), (Models{"radtan", "ucm"})) << "of another focal length";
  alone[1] = chosenCamera("ucm", 900, {{"radtan", 0.01}, {"ucm", 0}});
  EXPECT_EQ(sharedModels(alone), (Models{"radtan", "radtan"}));
  onlyCamera(alone[1].fit).size = kVga;
  EXPECT_EQ(sharedModels(alone), (Models{"radtan", "ucm"})) << "of another size";
  alone[1] = chosenCamera("ucm", 900, {{"radtan", 0.01}, {"ucm", 0}});
  alone[1].choice.model.reset();
  EXPECT_EQ(sharedModels(alone), (Models{"radtan", "ucm"})) << "named by the user";
}

TEST(SharedModels, WereTriedInMostCameras) {
  const std::vector<Calibration> alone = {chosenCamera("ucm", 900, {{"ucm", 0}}),
                                          chosenCamera("radtan", 900, {{"radtan", 0}, {"rational", 0.01}}),
                                          chosenCamera("rational", 900, {{"radtan", 0.01}, {"rational", 0}})};
  EXPECT_EQ(sharedModels(alone), (Models{"radtan", "radtan", "radtan"}));
}

}  // namespace
}  // namespace alidade
