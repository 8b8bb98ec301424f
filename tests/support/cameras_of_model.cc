// SPDX-License-Identifier: MIT
#include "support/cameras_of_model.h"

#include "alidade/camera/camera_variant.h"
#include "support/model_fixture.h"

namespace alidade {

std::vector<AnyCamera> camerasOf(const std::string& model_id) {
  std::vector<AnyCamera> cameras;
  AllModels::forEach([&]<class M>() {
    if (M::kId != model_id) return;
    for (const auto& params : ModelFixture<M>::paramSets()) cameras.emplace_back(Camera<M>(params));
  });
  return cameras;
}

}  // namespace alidade
