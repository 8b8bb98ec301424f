// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/image_domain.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

// Noise-free corners leave rounding only.
constexpr double kMaxRmsPx = 1e-8;
constexpr double kRelative = 1e-6;

struct Lens {
  const char* name;
  const char* model;
  std::vector<double> distortion;  // at a field of view of 60 degrees; milder for wider ones
};

const std::vector<Lens>& lenses() {
  static const std::vector<Lens> all = {
      {"none", "pinhole", {}},
      {"barrel", "radtan", {-0.28, 0.08, 8e-4, -4e-4, -0.01}},
      {"pincushion", "radtan", {0.12, 0.05, -1e-3, 1e-3, 0.02}},
  };
  return all;
}

// The same look of the distortion at the image's border for every field of view, as real lenses have it:
// coefficients go with the powers of the border's radius on the normalised plane.
std::vector<double> parametersFor(const Lens& lens, double fov_deg, ImageSize size) {
  const double focal = focalForFov(fov_deg, size);
  const double scale = std::min(1.0, focal / focalForFov(60, size));
  std::vector<double> params = {focal, 1.003 * focal, 0.5 * size.width + 7.3, 0.5 * size.height - 5.1};
  const std::vector<int> powers = {2, 4, 1, 1, 6};
  for (std::size_t i = 0; i < lens.distortion.size(); ++i) {
    params.push_back(lens.distortion[i] * std::pow(scale, powers[i]));
  }
  return params;
}

TEST(Recovery, FindsTheTrueCameraWithoutAGuess) {
  const ImageSize size{.width = 1280, .height = 960};
  int num_sets = 0;
  for (const Lens& lens : lenses()) {
    for (const double fov_deg : {20.0, 35.0, 50.0, 65.0, 80.0, 95.0, 110.0}) {
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE(testing::Message() << lens.name << ", " << fov_deg << " degrees, seed " << seed);
        const std::vector<double> truth = parametersFor(lens, fov_deg, size);
        const AnyCamera camera = AnyCamera::make(lens.model, truth);
        ASSERT_TRUE(certifyDomain(camera, size).full_image);
        const SimulatedSet set = simulateSet(camera, size, 10, 0.0, streamSeed(seed, num_sets));
        const Calibration result = calibrate(set.board, set.views, {.model = lens.model});
        EXPECT_EQ(result.fit.summary.termination, Termination::kConverged) << result.fit.summary.reason;
        EXPECT_LE(rms(result.fit), kMaxRmsPx);
        EXPECT_TRUE(result.dropped.outliers.empty());
        for (std::size_t i = 0; i < truth.size(); ++i) {
          // Coefficients near zero are measured against the size that matters, 1.
          const double unit = i < 4 ? std::abs(truth[i]) : std::max(1.0, std::abs(truth[i]));
          EXPECT_NEAR(onlyCamera(result.fit).params[i], truth[i], kRelative * unit)
              << result.camera().parameterNames()[i];
        }
        ++num_sets;
      }
    }
  }
  EXPECT_EQ(num_sets, 3 * 7 * 4);
}

TEST(Recovery, DistortionOfAWideLensIsFoundFromNoiseToo) {
  const ImageSize size{.width = 1280, .height = 960};
  int num_sets = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<double> truth = parametersFor(lenses()[1], 100, size);
    const SimulatedSet set = simulateSet(AnyCamera::make("radtan", truth), size, 25, 0.3, seed);
    const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_NEAR(onlyCamera(result.fit).params[i], truth[i],
                  5 * result.uncertainty.parameterStdByNoise(static_cast<int>(i)));
    }
    ++num_sets;
  }
  EXPECT_EQ(num_sets, 20);
}

}  // namespace
}  // namespace alidade
