// SPDX-License-Identifier: MIT
// projectBatch() for python_bench.py, which calls it in its own process: both sides then alternate on the
// same processor, with the same memory allocator.
#include <cstddef>
#include <span>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/batch.h"

namespace alidade {
namespace {

struct PixelArrays {
  explicit PixelArrays(std::size_t n) : u(n), v(n), status(n) {}
  [[nodiscard]] PixelResults results() { return {u, v, status}; }

  std::vector<double> u, v;
  std::vector<ProjectStatus> status;
};

struct BatchScene {
  AnyCamera camera;
  std::vector<double> x, y, z;
  PixelArrays kept;

  void projectTo(PixelArrays& pixels, bool with_pose) const {
    const PointColumns points = {x, y, z};
    if (with_pose) {
      projectBatch(camera, SE3(), points, pixels.results());
    } else {
      projectBatch(camera, points, pixels.results());
    }
  }
};

}  // namespace
}  // namespace alidade

extern "C" {

/// @param params  of a `radtan` camera
/// @param points  n rows x, y, z, copied
void* newBatchScene(const double* params, const double* points, std::size_t n) {
  auto* scene = new alidade::BatchScene{.camera = alidade::AnyCamera::make("radtan", std::span(params, 9)),
                                        .x = std::vector<double>(n),
                                        .y = std::vector<double>(n),
                                        .z = std::vector<double>(n),
                                        .kept = alidade::PixelArrays(n)};
  for (std::size_t i = 0; i < n; ++i) {
    scene->x[i] = points[3 * i];
    scene->y[i] = points[3 * i + 1];
    scene->z[i] = points[3 * i + 2];
  }
  return scene;
}

/// Projects into arrays that all calls share.
void projectIntoKept(void* scene, bool with_pose) {
  auto& s = *static_cast<alidade::BatchScene*>(scene);
  s.projectTo(s.kept, with_pose);
}

/// Projects into new vectors, as Python's project() returns new arrays.
void projectIntoNew(void* scene, bool with_pose) {
  auto& s = *static_cast<alidade::BatchScene*>(scene);
  alidade::PixelArrays pixels(s.x.size());
  s.projectTo(pixels, with_pose);
}

void deleteBatchScene(void* scene) {
  delete static_cast<alidade::BatchScene*>(scene);
}
}
