// SPDX-License-Identifier: MIT
#include "alidade/camera/model_fit.h"
#include "alidade/camera/camera_variant.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include <gmock/gmock.h>

#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/same_lens.h"
#include "alidade/core/error.h"
#include "support/image_sizes.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

using testing::HasSubstr;

bool isKnown(const std::string& id) {
  return std::find(modelIds().begin(), modelIds().end(), id) != modelIds().end();
}

AnyCamera make(std::string_view id, const std::vector<double>& params) {
  return AnyCamera::make(id, params);
}

std::vector<RaySample> samplesOf(const AnyCamera& camera) {
  std::vector<RaySample> samples;
  for (int y = 0; y < kVga.height; y += 20) {
    for (int x = 0; x < kVga.width; x += 20) {
      if (const auto ray = camera.unproject({x, y})) samples.push_back({{x, y}, *ray});
    }
  }
  return samples;
}

double costOf(const AnyCamera& camera, const std::vector<RaySample>& samples) {
  double sum = 0;
  for (const RaySample& sample : samples)
    sum += (camera.project(sample.ray).pixel - sample.pixel).squaredNorm();
  return sum;
}

struct Conversion {
  std::string from;
  std::vector<double> params;
  std::string to;
};

TEST(FitModel, FindsTheSameLensByAlgebra) {
  const std::vector<double> affine = {500, 510, 321, 238};
  const auto with = [&affine](std::initializer_list<double> lens) {
    std::vector<double> params = affine;
    params.insert(params.end(), lens);
    return params;
  };
  const std::vector<Conversion> conversions = {
      {"pinhole", affine, "pinhole"},
      {"pinhole", affine, "radtan"},
      {"radtan", with({0, 0, 0, 0, 0}), "pinhole"},
      {"radtan", with({-0.2, 0.05, 1e-3, -2e-3, 0.01}), "radtan"},
      // From here on with models that need not be there.
      {"radtan", with({-0.2, 0.05, 1e-3, -2e-3, 0.01}), "rational"},
      {"radtan", with({-0.2, 0.05, 1e-3, -2e-3, 0.01}), "thin_prism"},
      {"rational", with({-0.2, 0.05, 1e-3, -2e-3, 0.01, 0, 0, 0}), "radtan"},
      {"rational", with({0.35, 0.05, 5e-4, -4e-4, 0.01, 0.68, 0.12, 0.005}), "thin_prism"},
      {"thin_prism", with({-0.2, 0.05, 1e-3, -2e-3, 0, 0, 0, 0, 0, 0, 0, 0}), "radtan"},
      {"pinhole", affine, "ucm"},
      {"pinhole", affine, "eucm"},
      {"pinhole", affine, "double_sphere"},
      {"pinhole", affine, "omni"},
      {"pinhole", affine, "fov"},
      {"fov", with({0}), "radtan"},
      {"ucm", with({0.62}), "omni"},
      {"ucm", with({0.62}), "eucm"},
      {"ucm", with({0.62}), "double_sphere"},
      {"omni", with({1.3, 0, 0, 0, 0}), "ucm"},
      {"omni", with({1.3, 0, 0, 0, 0}), "eucm"},
      {"omni", with({0, -0.2, 0.05, 1e-3, -2e-3}), "radtan"},
      {"radtan", with({-0.2, 0.05, 1e-3, -2e-3, 0}), "omni"},
      {"eucm", with({0.6, 1}), "double_sphere"},
      {"eucm", with({0.6, 1}), "omni"},
      {"double_sphere", with({0, 0.6}), "eucm"},
      {"radtan", with({-0.2, 0.05, 1e-3, -2e-3, 0.01}), "brown"},
      {"radtan", with({-0.2, 0.05, 1e-3, -2e-3, 0.01}), "tilted"},
      {"tilted", with({0.3, 0.05, 1e-3, -2e-3, 0, 0.6, 0, 0, 1e-3, 0, -1e-3, 0, 0, 0}), "thin_prism"},
      {"pinhole", affine, "ocam"},
      {"ocam", with({-0.2, 0, -0.02, 0, 0, 0, 0}), "division"},
      {"division", with({-0.2, -0.02}), "ocam"},
      {"pinhole", affine, "inverse_brown"},
      {"kannala_brandt", with({0.01, 0.02, -0.01, 0.001}), "kannala_brandt_skew"},
      {"kannala_brandt", with({0.01, 0.02, -0.01, 0.001}), "thin_prism_fisheye"},
      {"kannala_brandt", with({0.01, 0.02, -0.01, 0.001}), "fisheye624"},
      {"fisheye624", with({0.01, 0.02, -0.01, 0.001, 0, 0, 0, 0, 0, 0, 0, 0}), "thin_prism_fisheye"},
  };
  std::size_t num_exact = 0;
  std::size_t num_absent = 0;
  for (const Conversion& c : conversions) {
    if (!isKnown(c.from) || !isKnown(c.to)) {
      ++num_absent;
      continue;
    }
    const ModelFit fit = fitModel(make(c.from, c.params), kVga, c.to);
    EXPECT_EQ(fit.camera.modelId(), c.to);
    EXPECT_TRUE(fit.is_exact) << c.from << " to " << c.to;
    EXPECT_LE(fit.max_error_px, 1e-9) << c.from << " to " << c.to;
    EXPECT_EQ(fit.num_unreached, 0) << c.from << " to " << c.to;
    EXPECT_EQ(fit.num_pixels, 160 * 120);
    EXPECT_TRUE(fit.domain.full_image);
    ++num_exact;
  }
  EXPECT_EQ(num_exact + num_absent, 36U);
  EXPECT_EQ(num_absent, modelIds().size() == 2 ? 32U : num_absent);
  EXPECT_EQ(num_absent, modelIds().size() == 20 ? 0U : num_absent);
  RecordProperty("conversions_of_absent_models", static_cast<int>(num_absent));
}

TEST(FitModel, AlgebraRefusesWhatOnlyNearlyHolds) {
  EXPECT_FALSE(sameLensParameters(make("radtan", {500, 510, 321, 238, 0, 0, 0, 1e-9, 0}), "pinhole"));
  EXPECT_TRUE(sameLensParameters(make("radtan", {500, 510, 321, 238, 0, 0, 0, 0, 0}), "pinhole"));
  EXPECT_THROW(static_cast<void>(sameLensParameters(make("pinhole", {1, 1, 0, 0}), "pinhol")), Error);
}

TEST(FitLens, FindsTheParametersThatMadeThePixels) {
  int num_found = 0;
  AllModels::forEach([&]<class M>() {
    if (M::kId != "pinhole" && M::kId != "radtan") return;  // larger ones have parameters that can stand in
    std::vector<double> truth = {500, 510, 321, 238};
    if (M::kId == "radtan") truth.insert(truth.end(), {-0.25, 0.06, 2e-3, -1e-3, -0.01});
    const std::vector<RaySample> samples = samplesOf(make(M::kId, truth));
    std::vector<double> start = startParameters(M::kId, 300, kVga);
    const LensFit fit = fitLens(M::kId, samples, start);
    for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_NEAR(fit.params[i], truth[i], 1e-8) << M::kId;
    EXPECT_LE(fit.cost, 1e-15);
    EXPECT_LE(fit.num_iterations, 30);
    EXPECT_EQ(fit.cost, costOf(make(M::kId, fit.params), samples));
    ++num_found;
  });
  EXPECT_EQ(num_found, 2);
}

TEST(FitModel, IsBestAmongItsNeighbours) {
  const AnyCamera source = make("radtan", {500, 510, 330, 238, -0.05, 0.01, 1e-3, -2e-3, 0});
  const ModelFit fit = fitModel(source, kVga, "pinhole");
  EXPECT_FALSE(fit.is_exact);
  EXPECT_GT(fit.rms_px, 0.1);
  EXPECT_GT(fit.max_error_px, fit.rms_px);
  EXPECT_EQ(fit.num_unreached, 0);
  EXPECT_TRUE(fit.domain.full_image);
  // The stated error is the error at the stated place.
  const auto ray = source.unproject(fit.worst_pixel);
  ASSERT_TRUE(ray);
  EXPECT_NEAR((fit.camera.project(*ray).pixel - fit.worst_pixel).norm(), fit.max_error_px, 1e-9);

  const std::vector<RaySample> samples = samplesOf(source);
  const LensFit best = fitLens("pinhole", samples, startParameters("pinhole", 500, kVga));
  int num_neighbours = 0;
  for (std::size_t i = 0; i < best.params.size(); ++i) {
    for (const double change : {-0.01, 0.01}) {
      std::vector<double> params = best.params;
      params[i] += change;
      EXPECT_GT(costOf(make("pinhole", params), samples), best.cost);
      ++num_neighbours;
    }
  }
  EXPECT_EQ(num_neighbours, 8);
}

TEST(FitModel, CountsPixelsThatItsSourceOrItsTargetCannotSee) {
  // A fold at 45 degrees leaves the corners without rays.
  const AnyCamera folded = make("radtan", {535, 535, 319.5, 239.5, -1.0 / 3, 0, 0, 0, 0});
  const ModelFit fit = fitModel(folded, kVga, "pinhole");
  EXPECT_GT(fit.num_without_ray, 50);
  EXPECT_EQ(fit.num_pixels + fit.num_without_ray, 160 * 120);
  EXPECT_EQ(fit.num_unreached, 0);
  EXPECT_EQ(fit.unreachedShare(), 0);

  // The perspective plane up to 89.98 degrees, of which radtan leaves out the last.
  const AnyCamera wide = make("pinhole", {0.1, 0.1, 319.5, 239.5});
  const ModelFit part = fitModel(wide, kVga, "radtan");
  EXPECT_TRUE(part.is_exact);
  EXPECT_GT(part.unreachedShare(), 0.5);
  ASSERT_TRUE(part.unreached_pixel);
  EXPECT_FALSE(part.domain.full_image);

  try {
    static_cast<void>(fitModel(make("radtan", {5, 5, 3195, 2395, -0.3, 0, 0, 0, 0}), kVga, "pinhole"));
    ADD_FAILURE() << "a camera without rays was fitted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kInput);
    EXPECT_THAT(e.what(), HasSubstr("rays for 0 of 19200 sampled pixels"));
  }
}

// A fit's own figures against those of all pixels at a half pixel's step, which it has not looked at.
void expectTrueFigures(const AnyCamera& source, ImageSize size, const ModelFit& fit) {
  double sum = 0;
  double worst = 0;
  long num_pixels = 0;
  long num_without_ray = 0;
  long num_unreached = 0;
  const auto error = [&](const Eigen::Vector2d& pixel) -> std::optional<double> {
    const auto ray = source.unproject(pixel);
    num_without_ray += ray ? 0 : 1;
    if (!ray) return std::nullopt;
    ++num_pixels;
    const Projection projection = fit.camera.project(*ray);
    num_unreached += projection.ok() ? 0 : 1;
    return projection.ok() ? std::optional((projection.pixel - pixel).norm()) : std::nullopt;
  };
  for (double y = -0.5; y <= size.height - 0.5; y += 0.5) {
    for (double x = -0.5; x <= size.width - 0.5; x += 0.5) {
      const auto distance = error({x, y});
      if (!distance) continue;
      sum += *distance * *distance;
      worst = std::max(worst, *distance);
    }
  }
  const double rms = std::sqrt(sum / static_cast<double>(num_pixels - num_unreached));
  EXPECT_NEAR(fit.rms_px, rms, 0.03 * rms);
  EXPECT_GE(fit.max_error_px, 0.995 * worst) << "the largest error is understated";
  EXPECT_LE(fit.max_error_px, 1.05 * worst);
  const auto all = static_cast<double>(num_pixels + num_without_ray);
  EXPECT_EQ(num_pixels + num_without_ray, (2L * size.width + 1) * (2L * size.height + 1));
  EXPECT_NEAR(fit.num_without_ray / (160.0 * 120.0), static_cast<double>(num_without_ray) / all, 1e-3);
  EXPECT_NEAR(fit.unreachedShare(), static_cast<double>(num_unreached) / static_cast<double>(num_pixels),
              1e-4);
  const auto at_worst = error(fit.worst_pixel);
  ASSERT_TRUE(at_worst);
  EXPECT_NEAR(*at_worst, fit.max_error_px, 1e-6);
  std::printf("%s to %s: RMS %.4f px, at most %.4f px; of all pixels %.4f and %.4f px\n",
              std::string(source.modelId()).c_str(), std::string(fit.camera.modelId()).c_str(), fit.rms_px,
              fit.max_error_px, rms, worst);
}

// A fisheye lens of 185 degrees, whose polynomial ends inside the image's corners, there and back.
TEST(FitModel, StatesTheErrorsOfAFisheyeAsAllPixelsHaveThem) {
  constexpr ImageSize kFisheyeSize{.width = 1280, .height = 960};
  const AnyCamera fisheye =
      make("kannala_brandt", {383.57, 384.65, 639.54, 477.31, 0.04275, -0.05002, 0.01984, -0.00294});
  const ModelFit there = fitModel(fisheye, kFisheyeSize, "double_sphere");
  EXPECT_FALSE(there.is_exact);
  EXPECT_GT(there.rms_px, 0.1) << "these are not the same lens";
  expectTrueFigures(fisheye, kFisheyeSize, there);
  const ModelFit back = fitModel(there.camera, kFisheyeSize, "kannala_brandt");
  EXPECT_LT(back.rms_px, 0.01) << "the polynomial can follow a double sphere";
  expectTrueFigures(there.camera, kFisheyeSize, back);
}

// Any pair of models: what comes out is a camera, judged truly, and a wide enough one comes close.
TEST(FitModel, TakesEveryModelToEveryOther) {
  int num_pairs = 0;
  AllModels::forEach([&]<class M>() {
    const AnyCamera source(Camera<M>(ModelFixture<M>::paramSets().front()));
    for (const std::string& id : modelIds()) {
      const ModelFit fit = fitModel(source, kTestImage, id);
      EXPECT_EQ(fit.camera.modelId(), id);
      if (fit.unreachedShare() < 1) {
        EXPECT_GE(fit.max_error_px, fit.rms_px) << M::kId << " to " << id;
      } else {
        EXPECT_TRUE(std::isnan(fit.max_error_px) && std::isnan(fit.rms_px)) << M::kId << " to " << id;
      }
      if (id == M::kId) {
        EXPECT_TRUE(fit.is_exact);
      }
      ++num_pairs;
    }
  });
  EXPECT_EQ(num_pairs, static_cast<int>(modelIds().size() * modelIds().size()));
}

}  // namespace
}  // namespace alidade
