// SPDX-License-Identifier: MIT
#include "commands/rig/rectified_pair.h"

#include <algorithm>

#include "alidade/camera/any_rig.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/files/camera_source.h"
#include "alidade/imagery/rectification.h"

namespace alidade {
namespace {

void requireOneSize(const std::vector<NamedCamera>& pair) {
  if (pair[0].image_size == pair[1].image_size) return;
  throw inputError({.where = pair[1].where,
                    .found = "found an image of " + sizeText(pair[1].image_size) + " pixels",
                    .expected = sizeText(pair[0].image_size) +
                                " as of the first camera, because rectified images have one size",
                    .next_step = "crop or resize the images of one camera, or write each camera to a file of "
                                 "its own (FILE#NAME)"});
}

SE3 secondFromFirst(const SE3& first, const SE3& second) {
  return second * first.inverse();
}

// True if the files state the poses of the cameras.
bool standEqually(const std::vector<NamedCamera>& pair, const std::vector<std::string>& texts) {
  std::vector<SE3> read;
  for (const std::string& text : texts) {
    const CameraSource source = parseCameras(text, "file");
    if (!source.cameras.front().camera_from_rig) return false;
    read.push_back(*source.cameras.front().camera_from_rig);
  }
  const SE3 stated = secondFromFirst(*pair[0].camera_from_rig, *pair[1].camera_from_rig);
  const SE3 back = secondFromFirst(read[0], read[1]);
  constexpr double kSame = 1e-9;
  return (back.rotation.inverse() * stated.rotation).log().norm() < kSame &&
         (back.translation - stated.translation).norm() <= kSame * (1 + stated.translation.norm());
}

}  // namespace

std::vector<std::string> rectifiedPairTexts(const CameraFormat& format, std::vector<NamedCamera> pair) {
  expect(format.holds_rectification && pair.size() == 2, "two cameras, and a format that rectifies them");
  requireOneSize(pair);
  const AnyRig rig(mapped(pair, [](const NamedCamera& named) {
    return MountedCamera{.name = named.name,
                         .camera = named.camera,
                         .image_size = named.image_size,
                         .camera_from_rig = named.camera_from_rig.value()};
  }));
  std::size_t first = 0;
  Rectification r = rectify(rig, 0, 1, {});
  if (r.baseline_m < 0) {
    first = 1;
    r = rectify(rig, 1, 0, {});
  }
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::size_t view = i == first ? 0 : 1;
    pair[i].rectified = {.rectified_from_camera = r.views[view].rectified_from_camera,
                         .pixel_from_first = r.projectionMatrix(view)};
    texts.push_back(formatText(format, std::span(&pair[i], 1)));
  }
  if (!standEqually(pair, texts)) {
    throw inputError({.where = pair[0].where,
                      .found = "found poses that would differ when they are read from the format " +
                               std::string(format.title) + ": their numbers are extreme",
                      .expected = "the same poses",
                      .next_step = "check the unit, which is metres"});
  }
  return texts;
}

std::string fileNameOf(const std::string& camera) {
  std::string name = camera;
  std::replace(name.begin(), name.end(), '/', '_');
  return name.empty() || name.front() == '.' ? "camera" + name : name;
}

}  // namespace alidade
