// SPDX-License-Identifier: MIT
#include "alidade/footage/follow/image_patch.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "alidade/core/random.h"

namespace alidade {
namespace {

// A smooth picture that is known everywhere: waves of 5 to 20 pixels in all directions.
class Waves {
 public:
  explicit Waves(std::uint64_t seed) {
    Random random(seed);
    for (Wave& wave : waves_) {
      const double angle = random.uniform(0, 6.283185307179586);
      const double length = random.uniform(5, 20);
      wave.frequency = 6.283185307179586 / length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      wave.phase = random.uniform(0, 6.283185307179586);
    }
  }
  // Mean 120, standard deviation about 20.
  [[nodiscard]] double at(const Eigen::Vector2d& place) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += std::sin(wave.frequency.dot(place) + wave.phase);
    return 120 + 28 * sum / std::sqrt(static_cast<double>(waves_.size()));
  }

 private:
  struct Wave {
    Eigen::Vector2d frequency;
    double phase = 0;
  };
  std::array<Wave, 24> waves_;
};

constexpr int kSide = 80;
constexpr double kMiddle = 40;

// Pixels show the waves at shape^-1 * (pixel - place) + centre.
GrayImage pictureOf(const Waves& waves, const Eigen::Vector2d& place, const Eigen::Matrix2d& shape,
                    double contrast, double brightness, double noise, std::uint64_t seed) {
  Random random(seed);
  GrayImage image{{kSide, kSide}, std::vector<std::uint8_t>(kSide * kSide)};
  const Eigen::Matrix2d back = shape.inverse();
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const Eigen::Vector2d at = back * (Eigen::Vector2d(x, y) - place) + Eigen::Vector2d(kMiddle, kMiddle);
      const double gray = 120 + contrast * (waves.at(at) - 120) + brightness + noise * random.normal();
      image.pixels[static_cast<std::size_t>(y * kSide + x)] =
          static_cast<std::uint8_t>(std::clamp(std::lround(gray), 0L, 255L));
    }
  }
  return image;
}

GrayImage firstPicture(const Waves& waves, double noise, std::uint64_t seed) {
  return pictureOf(waves, {kMiddle, kMiddle}, Eigen::Matrix2d::Identity(), 1, 0, noise, seed);
}

TEST(ImagePatch, IsFoundMovedDeformedAndInOtherLight) {
  constexpr int kCases = 300;
  constexpr double kNoise = 2;
  int num_found = 0;
  double square = 0;
  double normalised = 0;
  for (int i = 0; i < kCases; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    Random random(streamSeed(5, seed));
    const Waves waves(streamSeed(6, seed));
    const auto patch = ImagePatch::at(firstPicture(waves, kNoise, streamSeed(7, seed)), {kMiddle, kMiddle});
    ASSERT_TRUE(patch) << i;
    Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();
    for (double& value : shape.reshaped()) value += random.uniform(-0.2, 0.2);
    const Eigen::Vector2d place(kMiddle + random.uniform(-5, 5), kMiddle + random.uniform(-5, 5));
    const GrayImage image = pictureOf(waves, place, shape, random.uniform(0.7, 1.3), random.uniform(-15, 15),
                                      kNoise, streamSeed(8, seed));
    PatchPlace guess;
    guess.pixel =
        (place + Eigen::Vector2d(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7))).cast<float>();
    const auto found = patch->findIn(image, guess);
    if (!found || found->correlation < 0.95F) continue;
    ++num_found;
    const Eigen::Vector2d error = found->pixel.cast<double>() - place;
    square += error.squaredNorm() / 2;
    normalised += error.dot(found->covariance.cast<double>().inverse() * error) / 2;
    EXPECT_LT((found->shape.cast<double>() - shape).cwiseAbs().maxCoeff(), 0.1) << i;
  }
  std::printf("%d of %d found; RMS %.4f px, squared error over stated variance %.2f\n", num_found, kCases,
              std::sqrt(square / num_found), normalised / num_found);
  EXPECT_GE(num_found, kCases * 9 / 10);
  EXPECT_LT(std::sqrt(square / num_found), 0.06);
  EXPECT_GT(normalised / num_found, 0.7);
  EXPECT_LT(normalised / num_found, 1.5);
}

TEST(ImagePatch, NeedsTextureInTwoDirectionsAndRoom) {
  GrayImage image{{kSide, kSide}, std::vector<std::uint8_t>(kSide * kSide, 100)};
  EXPECT_FALSE(ImagePatch::at(image, {kMiddle, kMiddle}));
  for (int y = 0; y < kSide; ++y) {
    for (int x = kSide / 2; x < kSide; ++x) image.pixels[static_cast<std::size_t>(y * kSide + x)] = 200;
  }
  EXPECT_FALSE(ImagePatch::at(image, {kMiddle, kMiddle}));
  const GrayImage waves = firstPicture(Waves(1), 1, 2);
  EXPECT_TRUE(ImagePatch::at(waves, {kMiddle, kMiddle}));
  for (const float near : {0.0F, 5.0F, -1.0F, static_cast<float>(kSide) - 6.0F})
    EXPECT_FALSE(ImagePatch::at(waves, {near, kMiddle})) << near;
}

TEST(ImagePatch, IsNotFoundWhereItIsNot) {
  constexpr int kCases = 200;
  int num_alike = 0;
  for (int i = 0; i < kCases; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    const auto patch = ImagePatch::at(firstPicture(Waves(streamSeed(9, seed)), 2, seed), {kMiddle, kMiddle});
    ASSERT_TRUE(patch);
    const GrayImage other = firstPicture(Waves(streamSeed(10, seed)), 2, seed);
    PatchPlace guess;
    guess.pixel = {kMiddle, kMiddle};
    const auto found = patch->findIn(other, guess);
    num_alike += found && found->correlation > 0.9F ? 1 : 0;
  }
  EXPECT_EQ(num_alike, 0);
}

// With any shape, at any distance from the edges: nothing outside the image is read (the sanitizers see it).
TEST(ImagePatch, IsNotFoundPastTheEdge) {
  const Waves waves(3);
  const GrayImage image = firstPicture(waves, 0, 4);
  const auto patch = ImagePatch::at(image, {kMiddle, kMiddle});
  ASSERT_TRUE(patch);
  for (const float x : {-100.0F, 0.0F, 7.0F, static_cast<float>(kSide) - 7.0F, 1e9F, std::nanf("")}) {
    PatchPlace guess;
    guess.pixel = {x, kMiddle};
    EXPECT_FALSE(patch->findIn(image, guess)) << x;
  }
  Random random(11);
  int num_found = 0;
  constexpr int kCases = 20000;
  for (int i = 0; i < kCases; ++i) {
    PatchPlace guess;
    for (float& value : guess.shape.reshaped()) value = static_cast<float>(random.uniform(-1.5, 1.5));
    guess.pixel = {static_cast<float>(random.uniform(0, kSide)), static_cast<float>(random.uniform(0, 25))};
    num_found += patch->findIn(image, guess) ? 1 : 0;
  }
  EXPECT_LT(num_found, kCases / 10);
}

}  // namespace
}  // namespace alidade
