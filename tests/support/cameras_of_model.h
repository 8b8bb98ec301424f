// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// A camera with each parameter set of the model in model_fixture.h.
[[nodiscard]] std::vector<AnyCamera> camerasOf(const std::string& model_id);

/// Runs the tests of a suite for each model by its id. A test that names types of models instead is compiled
/// ten times.
class OfModel : public testing::TestWithParam<std::string> {
 protected:
  [[nodiscard]] static std::vector<AnyCamera> cameras() { return camerasOf(GetParam()); }
};

/// Names the tests of OfModel after the models.
[[nodiscard]] inline std::string nameOfModel(const testing::TestParamInfo<std::string>& info) {
  return info.param;
}

}  // namespace alidade
