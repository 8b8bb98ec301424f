// SPDX-License-Identifier: MIT
// mrcal's Python module, which writes what its users have, reads ours and projects alike, and we read what it
// writes.
#include <cstdio>
#include <sstream>

#include <gtest/gtest.h>

#include "alidade/camera/camera_variant.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "apps/run_program.h"
#include "support/model_fixture.h"
#include "support/peer.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

constexpr double kMrcalTolerance = 1e-9;  // px
constexpr int kColumns = 40;
constexpr int kRows = 30;

// For each our_*.cameramodel of the folder: the pixels of its rays; the same camera written anew, with ten
// digits as mrcal writes them, a pose and a comment; and the pixels of that as mrcal reads it.
constexpr const char* kScript = R"(
import glob, os, sys
import numpy as np
import mrcal

folder = sys.argv[1]
for path in sorted(glob.glob(folder + '/our_*.cameramodel')):
    name = os.path.basename(path)[len('our_'):-len('.cameramodel')]
    rays = np.loadtxt(folder + '/rays_' + name + '.txt')
    model = mrcal.cameramodel(path)
    np.savetxt(folder + '/pixels_' + name + '.txt', mrcal.project(rays, *model.intrinsics()), fmt='%.17g')
    anew = mrcal.cameramodel(intrinsics=model.intrinsics(), imagersize=model.imagersize(),
                             extrinsics_rt_fromref=np.array((0.01, 0.02, 0.03, 1., 2., 3.)))
    anew.write(folder + '/their_' + name + '.cameramodel', note='from a test')
    reread = mrcal.cameramodel(folder + '/their_' + name + '.cameramodel')
    np.savetxt(folder + '/anew_' + name + '.txt', mrcal.project(rays, *reread.intrinsics()), fmt='%.17g')
)";

std::vector<Eigen::Vector2d> pixelsIn(const std::string& text) {
  std::vector<Eigen::Vector2d> pixels;
  std::istringstream stream(text);
  for (Eigen::Vector2d pixel; stream >> pixel.x() >> pixel.y();) pixels.push_back(pixel);
  return pixels;
}

struct MrcalCase {
  AnyCamera camera;
  std::vector<Eigen::Vector3d> rays;
};

template <class M>
void addCases(std::vector<MrcalCase>& cases) {
  Random random(13);
  std::vector<AnyCamera> cameras = {AnyCamera(Camera<M>(ModelFixture<M>::paramSets().front()))};
  for (int i = 0; i < 3; ++i) cameras.emplace_back(Camera<M>(ModelFixture<M>::randomParams(random)));
  for (const AnyCamera& camera : cameras) {
    MrcalCase one{.camera = camera, .rays = {}};
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const auto ray = camera.unproject({column * (kTestImage.width - 1.0) / (kColumns - 1),
                                           row * (kTestImage.height - 1.0) / (kRows - 1)});
        // Nearer to the camera's plane a rounding of the ray is more than the tolerance.
        if (ray && ray->z() > 0.05 && camera.project(*ray).ok()) one.rays.push_back(*ray);
      }
    }
    cases.push_back(std::move(one));
  }
}

// Compares with the rays' pixels that mrcal gave.
int compare(const AnyCamera& camera, const std::vector<Eigen::Vector3d>& rays,
            const std::string& pixels_text) {
  const std::vector<Eigen::Vector2d> pixels = pixelsIn(pixels_text);
  EXPECT_EQ(pixels.size(), rays.size());
  for (std::size_t i = 0; i < std::min(pixels.size(), rays.size()); ++i) {
    const Projection ours = camera.project(rays[i]);
    if (!ours.ok()) continue;  // ten digits move the rim of the domain
    EXPECT_LT((ours.pixel - pixels[i]).norm(), kMrcalTolerance) << camera.modelId();
  }
  return static_cast<int>(pixels.size());
}

TEST(MrcalFiles, GoBothWays) {
  ALIDADE_NEED_PEER("/usr/lib/python3/dist-packages/mrcal/__init__.py", "python3-mrcal");
  std::vector<MrcalCase> cases;
  addCases<Pinhole>(cases);
  addCases<Radtan>(cases);
  addCases<Rational>(cases);
  addCases<ThinPrism>(cases);
  const ScratchFolder folder;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string id = std::to_string(100 + i);
    folder.write("our_" + id + ".cameramodel",
                 formatText(cameraFormat("mrcal"),
                            std::vector<NamedCamera>{
                                {.name = "", .camera = cases[i].camera, .image_size = kTestImage}}));
    std::string rays;
    for (const Eigen::Vector3d& ray : cases[i].rays)
      rays += exactText(ray.x()) + " " + exactText(ray.y()) + " " + exactText(ray.z()) + "\n";
    folder.write("rays_" + id + ".txt", rays);
  }
  const RunResult run = runProgram("/usr/bin/python3", {"-c", kScript, folder.path()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  int num_points = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string id = std::to_string(100 + i);
    num_points += compare(cases[i].camera, cases[i].rays, folder.read("pixels_" + id + ".txt"));
    const CameraSource source = loadCameras(folder.path("their_" + id + ".cameramodel"));
    EXPECT_EQ(source.format, "mrcal");
    const StatedCamera& read = source.cameras.at(0);
    EXPECT_EQ(read.camera.modelId(), cases[i].camera.modelId());
    EXPECT_EQ(read.image_size, std::optional(kTestImage));
    EXPECT_TRUE(read.remarks.empty());
    EXPECT_TRUE(read.camera_from_rig);
    num_points += compare(read.camera, cases[i].rays, folder.read("anew_" + id + ".txt"));
  }
  EXPECT_EQ(cases.size(), 16u);
  EXPECT_GT(num_points, 10000);
}

}  // namespace
}  // namespace alidade
