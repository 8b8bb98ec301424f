// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/camera/any_camera.h"
#include "alidade/detect/detect_images.h"
#include "alidade/guide/guidance.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/render.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr Checkerboard kBoard{.columns = 9, .rows = 6, .square_m = 0.025};

// Every so many of the candidates that are seen as a whole, or in part.
std::vector<ViewCandidate> someOf(const std::vector<ViewCandidate>& all, bool is_whole, std::size_t count) {
  std::vector<ViewCandidate> chosen;
  for (const ViewCandidate& candidate : all) {
    if (candidate.is_whole == is_whole) chosen.push_back(candidate);
  }
  std::vector<ViewCandidate> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(chosen.at(i * chosen.size() / count));
  return some;
}

// What is suggested must be of use: detection finds it in a photograph, with the right ids.
TEST(ViewCandidates, AreFoundInImages) {
  constexpr std::size_t kNumEach = 12;
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01});
  const auto all = viewCandidates(camera, kVga, kBoard, {.nearest_m = 0.1, .farthest_m = 1});
  std::vector<ViewCandidate> candidates = someOf(all, true, kNumEach);
  for (const ViewCandidate& part : someOf(all, false, kNumEach)) candidates.push_back(part);
  const Renderer renderer(camera, kVga);
  std::size_t num_found = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const SE3& pose = candidates[i].camera_from_board;
    const View exact = exactView(camera, kVga, kBoard, pose, "");
    const Detection found = findBoard(renderer.render(kBoard, pose, {.seed = i + 1, .samples = 89}), kBoard);
    std::size_t num_right = 0;
    for (const Corner& corner : found.corners) {
      const auto same = std::find_if(exact.corners.begin(), exact.corners.end(),
                                     [&](const Corner& c) { return c.id == corner.id; });
      if (same != exact.corners.end() && (same->pixel - corner.pixel).norm() < 0.5) ++num_right;
    }
    EXPECT_EQ(num_right, found.corners.size()) << i;
    if (5 * num_right >= 4 * candidates[i].corners.size()) {
      ++num_found;
    } else {
      std::printf("candidate %zu: %zu of %zu corners, %s: %s\n", i, num_right, candidates[i].corners.size(),
                  std::string(reasonCode(found.reason)).c_str(), found.detail.c_str());
    }
  }
  EXPECT_EQ(candidates.size(), 2 * kNumEach);
  EXPECT_GE(num_found, candidates.size() - 1);
}

}  // namespace
}  // namespace alidade
