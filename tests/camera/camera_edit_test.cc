// SPDX-License-Identifier: MIT
#include "alidade/camera/camera_edit.h"
#include "alidade/camera/camera_variant.h"

#include <functional>
#include <limits>

#include <gmock/gmock.h>

#include "alidade/core/error.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kSamePx = 1e-9;

// All cameras of the test fixture, of all models.
std::vector<AnyCamera> allCameras() {
  std::vector<AnyCamera> cameras;
  AllModels::forEach([&]<class M>() {
    for (const auto& params : ModelFixture<M>::paramSets()) cameras.emplace_back(Camera<M>(params));
  });
  return cameras;
}

bool canTurn(const AnyCamera& camera) {
  const auto names = camera.parameterNames();
  const auto value = [&](std::string_view name) {
    const auto found = std::ranges::find(names, name);
    return found == names.end() ? 0.0 : camera.parameters()[static_cast<std::size_t>(found - names.begin())];
  };
  const bool has_shear = std::ranges::find(names, "shear") != names.end();
  return (has_shear || value("skew") == 0) && value("tau_x") * value("tau_y") == 0;
}

// Compares the pixels of rays all over the image with what `move` makes of the old ones; returns how many.
int numCompared(const AnyCamera& camera, const EditedCamera& edited,
                const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& move) {
  int num_compared = 0;
  for (int y = 0; y < kTestImage.height; y += 100) {
    for (int x = 0; x < kTestImage.width; x += 120) {
      const auto ray = camera.unproject({x, y});
      if (!ray) continue;
      const Projection before = camera.project(*ray);
      if (!before.ok()) continue;
      const Projection after = edited.camera.project(edited.new_from_old * *ray);
      EXPECT_TRUE(after.ok()) << camera.modelId();
      EXPECT_LE((after.pixel - move(before.pixel)).norm(), kSamePx) << camera.modelId();
      ++num_compared;
    }
  }
  return num_compared;
}

TEST(RotateCamera, ShowsPointsAtTheTurnedPixels) {
  const double w = kTestImage.width;
  const double h = kTestImage.height;
  using Move = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;
  const std::vector<std::pair<int, Move>> turns = {
      {0, [](const Eigen::Vector2d& p) { return p; }},
      {1, [=](const Eigen::Vector2d& p) { return Eigen::Vector2d(h - 1 - p.y(), p.x()); }},
      {2, [=](const Eigen::Vector2d& p) { return Eigen::Vector2d(w - 1 - p.x(), h - 1 - p.y()); }},
      {3, [=](const Eigen::Vector2d& p) { return Eigen::Vector2d(p.y(), w - 1 - p.x()); }},
      {-1, [=](const Eigen::Vector2d& p) { return Eigen::Vector2d(p.y(), w - 1 - p.x()); }},
  };
  std::size_t num_cameras = 0;
  int num_compared = 0;
  int num_refused = 0;
  for (const AnyCamera& camera : allCameras()) {
    for (const auto& [num_turns, move] : turns) {
      if (num_turns % 2 != 0 && !canTurn(camera)) {
        EXPECT_THAT([&] { static_cast<void>(rotateCamera(camera, kTestImage, num_turns)); },
                    ThrowsMessage<Error>(HasSubstr("--model")));
        ++num_refused;
        continue;
      }
      const EditedCamera edited = rotateCamera(camera, kTestImage, num_turns);
      EXPECT_EQ(edited.size.width, num_turns % 2 == 0 ? kTestImage.width : kTestImage.height);
      EXPECT_EQ(edited.size.height, num_turns % 2 == 0 ? kTestImage.height : kTestImage.width);
      EXPECT_EQ(edited.new_from_old.determinant(), 1);
      num_compared += numCompared(camera, edited, move);
    }
    ++num_cameras;
  }
  EXPECT_GE(num_cameras, 9U);
  EXPECT_GE(num_compared, 500 * static_cast<int>(num_cameras));
  EXPECT_EQ(num_refused, 3 * 7) << "sensors with skew, and with a tilt about both axes";
}

TEST(RotateCamera, TurnsFrameAndCoefficientsAsItsDescriptionSays) {
  const std::vector<double> params = {500, 510, 320, 230, -0.2, 0.05, 1e-3, -2e-3, 0.01};
  const EditedCamera edited =
      rotateCamera(AnyCamera::make("radtan", params), {.width = 640, .height = 480}, 1);
  EXPECT_THAT(edited.camera.parameters(), ElementsAre(510, 500, 249, 320, -0.2, 0.05, -2e-3, -1e-3, 0.01));
  EXPECT_EQ(edited.new_from_old * Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(-2, 1, 3));
}

TEST(RotateCamera, FourTurnsAreNone) {
  int num_cameras = 0;
  for (const AnyCamera& camera : allCameras()) {
    EditedCamera edited = rotateCamera(camera, kTestImage, 4);
    EXPECT_TRUE(std::equal(camera.parameters().begin(), camera.parameters().end(),
                           edited.camera.parameters().begin()));
    edited = rotateCamera(camera, kTestImage, 0);
    if (!canTurn(camera)) continue;
    for (int i = 0; i < 4; ++i) edited = rotateCamera(edited.camera, edited.size, 1);
    EXPECT_EQ(edited.size, kTestImage);
    for (std::size_t i = 0; i < camera.parameters().size(); ++i) {
      EXPECT_NEAR(edited.camera.parameters()[i], camera.parameters()[i], 1e-12);
      EXPECT_FALSE(edited.camera.parameters()[i] == 0 && std::signbit(edited.camera.parameters()[i]));
    }
    ++num_cameras;
  }
  EXPECT_GE(num_cameras, 9);
}

TEST(ResizeCamera, MovesThePrincipalPointWithThePixelsCentres) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{100, 90, 4, 3});
  const EditedCamera half = resizeCamera(camera, {.width = 10, .height = 8}, {.width = 5, .height = 4});
  EXPECT_THAT(half.camera.parameters(), ElementsAre(50, 45, 1.75, 1.25));
}

TEST(EditCamera, MovesPixelsAsTheImageDoes) {
  std::size_t num_cameras = 0;
  int num_compared = 0;
  for (const AnyCamera& camera : allCameras()) {
    const EditedCamera crop =
        cropCamera(camera, kTestImage, {.x = 100, .y = 60, .width = 800, .height = 640});
    EXPECT_EQ(crop.size, (ImageSize{.width = 800, .height = 640}));
    num_compared += numCompared(
        camera, crop, [](const Eigen::Vector2d& p) { return Eigen::Vector2d(p.x() - 100, p.y() - 60); });

    const EditedCamera resized = resizeCamera(camera, kTestImage, {.width = 960, .height = 400});
    EXPECT_EQ(resized.size, (ImageSize{.width = 960, .height = 400}));
    num_compared += numCompared(camera, resized, [](const Eigen::Vector2d& p) {
      return Eigen::Vector2d((p.x() + 0.5) / 2 - 0.5, (p.y() + 0.5) / 3 - 0.5);
    });

    const EditedCamera binned = binCamera(camera, kTestImage, 7);
    EXPECT_EQ(binned.size, (ImageSize{.width = 274, .height = 171}));
    num_compared += numCompared(camera, binned, [](const Eigen::Vector2d& p) {
      return Eigen::Vector2d((p.x() + 0.5) / 7 - 0.5, (p.y() + 0.5) / 7 - 0.5);
    });
    ++num_cameras;
  }
  EXPECT_GE(num_cameras, 9U);
  EXPECT_GE(num_compared, 300 * static_cast<int>(num_cameras));
}

TEST(EditCamera, BinningIsCroppingTheRemainderAndResizing) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{500, 510, 321, 239});
  const EditedCamera binned = binCamera(camera, {.width = 643, .height = 482}, 4);
  const EditedCamera cropped =
      cropCamera(camera, {.width = 643, .height = 482}, {.width = 640, .height = 480});
  const EditedCamera resized = resizeCamera(cropped.camera, cropped.size, {.width = 160, .height = 120});
  EXPECT_EQ(binned.size, resized.size);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_DOUBLE_EQ(binned.camera.parameters()[i], resized.camera.parameters()[i]);
  // 4 x 4 pixels become one: its centre is (1.5, 1.5) of theirs.
  const Projection projection = binned.camera.project({(1.5 - 321) / 500, (1.5 - 239) / 510, 1});
  EXPECT_LE(projection.pixel.norm(), 1e-12);
}

TEST(EditCamera, GivesTheDerivativeOfItsParameters) {
  const ImageSize size{.width = 640, .height = 480};
  const std::vector<double> a = {500, 510, 320, 230, -0.2, 0.05, 1e-3, -2e-3, 0.01};
  const std::vector<double> b = {520, 515, 318, 233, -0.1, 0.02, 3e-3, 5e-3, -0.02};
  using Edit = std::function<EditedCamera(const AnyCamera&)>;
  const std::vector<Edit> edits = {
      [&](const AnyCamera& c) { return cropCamera(c, size, {.x = 3, .y = 5, .width = 9, .height = 7}); },
      [&](const AnyCamera& c) { return resizeCamera(c, size, {.width = 200, .height = 300}); },
      [&](const AnyCamera& c) { return binCamera(c, size, 3); },
      [&](const AnyCamera& c) { return rotateCamera(c, size, 1); },
      [&](const AnyCamera& c) { return rotateCamera(c, size, 3); },
  };
  int num_edits = 0;
  for (const Edit& edit : edits) {
    const EditedCamera from_a = edit(AnyCamera::make("radtan", a));
    const EditedCamera from_b = edit(AnyCamera::make("radtan", b));
    for (std::size_t i = 0; i < a.size(); ++i) {
      double expected = 0;
      for (std::size_t j = 0; j < a.size(); ++j)
        expected +=
            from_a.J_new_old(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * (b[j] - a[j]);
      EXPECT_NEAR(from_b.camera.parameters()[i] - from_a.camera.parameters()[i], expected, 1e-12);
    }
    ++num_edits;
  }
  EXPECT_EQ(num_edits, 5);
}

TEST(EditCamera, RefusesImagesThatDoNotExist) {
  const ImageSize size{.width = 640, .height = 480};
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240});
  constexpr int kHuge = std::numeric_limits<int>::max();
  const std::vector<std::function<EditedCamera()>> edits = {
      [&] { return cropCamera(camera, size, {.x = -1, .y = 0, .width = 10, .height = 10}); },
      [&] { return cropCamera(camera, size, {.x = 0, .y = 0, .width = 0, .height = 10}); },
      [&] { return cropCamera(camera, size, {.x = 631, .y = 0, .width = 10, .height = 10}); },
      [&] { return cropCamera(camera, size, {.x = 0, .y = 471, .width = 10, .height = 10}); },
      [&] { return cropCamera(camera, size, {.x = kHuge, .y = 0, .width = kHuge, .height = 1}); },
      [&] { return resizeCamera(camera, size, {.width = 0, .height = 10}); },
      [&] { return resizeCamera(camera, size, {.width = 10, .height = -10}); },
      [&] { return resizeCamera(camera, size, {.width = kMaxImageSide + 1, .height = 10}); },
      [&] { return resizeCamera(camera, size, {.width = kMaxImageSide, .height = kMaxImageSide}); },
      [&] { return binCamera(camera, size, 0); },
      [&] { return binCamera(camera, size, 481); },
  };
  int num_refused = 0;
  for (const auto& edit : edits) {
    try {
      static_cast<void>(edit());
      ADD_FAILURE() << "edit " << num_refused << " was not refused";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kUsage);
      EXPECT_THAT(e.what(), HasSubstr("expected"));
    }
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 11);
}

}  // namespace
}  // namespace alidade
