// SPDX-License-Identifier: MIT
// What is odd about the images of a rig is told, and what is in order is not.
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/camera/triangulation.h"
#include "alidade/rig/rig_calibrator.h"
#include "alidade/rig/rig_validation.h"
#include "rig_scene.h"

namespace alidade {
namespace {

using testing::Contains;
using testing::Field;
using testing::Not;

constexpr double kNoise = 0.1;

auto hasId(const char* id) {
  return Contains(Field(&Diagnosis::id, testing::Eq(id)));
}

BoardShape unevenShape(std::uint64_t seed) {
  constexpr double kScatter = 3e-4;
  Random random(seed);
  BoardShape shape;
  for (int i = 0; i < kCharuco.numCorners(); ++i)
    shape.offsets_m.push_back(kScatter * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
  return shape;
}

// Each camera's views twice, as from a tripod; `takes` says which of the two copies a camera has.
RigScene twice(const RigScene& scene, const std::vector<std::vector<int>>& takes) {
  RigScene result{.cameras = scene.cameras, .views = {}};
  Random random(7);
  for (std::size_t c = 0; c < scene.views.size(); ++c) {
    RigViews& of_camera = result.views.emplace_back(RigViews{.name = scene.views[c].name, .views = {}});
    for (const View& view : scene.views[c].views) {
      const int number = std::stoi(view.image.substr(std::string("frame").size()));
      for (const int take : takes[c]) {
        View copy = view;
        copy.image = "frame" + std::to_string(2 * number + take) + ".png";
        addCornerNoise(copy, 0.01, random);
        for (Corner& corner : copy.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
        of_camera.views.push_back(std::move(copy));
      }
    }
  }
  return result;
}

TEST(RigData, FramesOfABoardThatStoodStillAreOne) {
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 16, kNoise, 61);
  const RigCalibration once = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  ASSERT_GT(once.links.num_linked, 10U);
  // The first camera has both copies, the second one the first, the third one the other.
  const RigScene series = twice(scene, {{0, 1}, {0}, {1}});
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), series.views, optionsFor(scene));
  EXPECT_EQ(rig.links.num_linked, once.links.num_linked);
  EXPECT_EQ(rig.links.num_common_views, once.links.num_common_views);
  EXPECT_TRUE(rig.links.unlinked.empty());
}

// A camera that saw the board move keeps its frames apart.
TEST(RigData, FramesThatACameraTellsApartAreTwo) {
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 16, kNoise, 61);
  RigScene series = twice(scene, {{0, 1}, {0, 1}, {0}});
  for (View& view : series.views[1].views) {
    const int number = std::stoi(view.image.substr(std::string("frame").size()));
    for (Corner& corner : view.corners) corner.pixel.x() += number % 2 == 1 ? 3 : 0;
  }
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), series.views, optionsFor(scene));
  EXPECT_GT(rig.links.num_linked, 10U);
  EXPECT_TRUE(rig.links.unlinked.empty()) << rig.links.unlinked.size();
}

TEST(RigData, TheSameImagesTwiceAreNoRig) {
  RigScene scene = sceneOf(threeCameras(), kCharuco, 16, kNoise, 67);
  scene.views[1].views = scene.views[0].views;
  scene.cameras[1] = scene.cameras[0];
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  EXPECT_THAT(rig.diagnoses, hasId("same_images"));
  EXPECT_EQ(rig.verdict(), Verdict::kNo);
}

// One bad view a frame of five cameras is not a fifth of the views.
TEST(RigData, OneBadViewOfManyIsAWarning) {
  std::vector<TrueCamera> cameras = threeCameras();
  cameras.push_back({cameras[2].camera, cameras[2].size, poseAt(0.05, 0.1, 0, 0.05)});
  cameras.push_back({cameras[2].camera, cameras[2].size, poseAt(-0.08, 0.1, 0, -0.02)});
  RigScene scene = sceneOf(cameras, kCharuco, 16, kNoise, 71);
  for (std::size_t i = 0; i < 5; ++i) {
    // The camera sees another frame's board here.
    View& bad = scene.views[3].views[i];
    const View other = scene.views[3].views[scene.views[3].views.size() - 1 - i];
    bad.corners = other.corners;
    Random random(i);
    addCornerNoise(bad, 0.5, random);
    for (Corner& corner : bad.corners) {
      corner.pixel += Eigen::Vector2d(4, 3);
      corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
    }
  }
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  EXPECT_GE(rig.links.unlinked.size(), 4U);
  EXPECT_LT(5 * rig.links.num_lone_views, rig.links.num_common_views);
  const auto found = std::ranges::find(rig.diagnoses, "not_simultaneous", &Diagnosis::id);
  ASSERT_NE(found, rig.diagnoses.end());
  EXPECT_EQ(found->severity, Severity::kWarning);
}

// Views that contradict each other are each explained by themselves.
TEST(RigData, ViewsThatAreLeftAloneFitAsAlone) {
  std::vector<TrueCamera> cameras = threeCameras();
  cameras.pop_back();
  RigScene scene = sceneOf(cameras, kCharuco, 16, kNoise, 73);
  std::vector<View>& second = scene.views[1].views;
  const std::size_t half = second.size() / 2;
  // Half of the frames show the board of the next frame.
  for (std::size_t i = half; i + 1 < second.size(); ++i) second[i].corners = second[i + 1].corners;
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  EXPECT_GE(rig.links.unlinked.size(), 4U);
  std::size_t num_alone = 0;
  for (const RigImage& image : rig.links.unlinked) {
    for (const FitView& view : rig.fit.views) {
      double sum = 0;
      for (const Eigen::Vector2d& error : view.errors) sum += error.squaredNorm();
      EXPECT_LT(std::sqrt(sum / static_cast<double>(view.errors.size())), 4 * kNoise) << view.image;
      num_alone += view.camera == image.camera && view.image == image.image ? 1 : 0;
    }
  }
  EXPECT_EQ(num_alone, rig.links.unlinked.size());
}

TEST(RigData, ErrorsOfHeldOutFramesAreJudged) {
  std::vector<TrueCamera> cameras = threeCameras();
  cameras.pop_back();
  const RigScene few = sceneOf(cameras, kCharuco, 4, 0.5, 79);
  RigOptions options = optionsFor(few);
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), few.views, options);
  EXPECT_TRUE(rig.holdout.num_corners == 0 || rig.holdout.rms_px > 1.05 * rms(rig.fit));
  options.camera.tolerance_px = 0.1;
  const RigCalibration strict = calibrate(std::span(&kCharuco, 1), few.views, options);
  EXPECT_THAT(strict.diagnoses, testing::AnyOf(hasId("holdout_error"), hasId("no_holdout")));
  const RigScene many = sceneOf(cameras, kCharuco, 30, kNoise, 83);
  const RigCalibration good = calibrate(std::span(&kCharuco, 1), many.views, optionsFor(many));
  EXPECT_THAT(good.diagnoses, Not(hasId("holdout_error")));
  EXPECT_THAT(good.diagnoses, Not(hasId("no_holdout")));
}

TEST(RigData, AnUnknownUncertaintyIsNotZero) {
  RigScene scene = sceneOf(threeCameras(), kCharuco, 16, kNoise, 89);
  RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  EXPECT_EQ(rig.cameras[0].link.position_std_m, Eigen::Vector3d(0, 0, 0));
  EXPECT_GT(rig.cameras[1].link.position_std_m.minCoeff(), 0);
  EXPECT_GT(rig.cameras[1].link.distance_std_m, 0);
  EXPECT_LT(rig.cameras[1].link.distance_std_m, 1.001 * rig.cameras[1].link.position_std_m.norm());
  EXPECT_TRUE(CameraLink().position_std_m.array().isNaN().all());
}

// Lenses from few frames are not contradicted by many others beyond what their files state.
TEST(RigData, GivenLensesCountWithTheirUncertainty) {
  std::size_t num_contradicted = 0;
  constexpr std::size_t kNumSets = 8;
  for (std::uint64_t seed = 0; seed < kNumSets; ++seed) {
    const RigScene first = sceneOf(threeCameras(), kCharuco, 7, 0.3, 300 + seed);
    const RigScene other = sceneOf(threeCameras(), kCharuco, 30, 0.3, 400 + seed);
    const RigRecord record = recordOf(calibrate(std::span(&kCharuco, 1), first.views, optionsFor(first)), "");
    const RigValidation validation =
        validateRig(record, std::span(&kCharuco, 1), other.views, 1, optionsFor(other));
    for (const Diagnosis& diagnosis : validation.diagnoses) {
      if (diagnosis.id == "lens_contradicted" || diagnosis.id == "pose_contradicted") ++num_contradicted;
    }
  }
  EXPECT_EQ(num_contradicted, 0U);
}

BoardShape stretchedShape(const Board& board, double stretch, double scatter_m, std::uint64_t seed) {
  Random random(seed);
  BoardShape shape;
  for (const Eigen::Vector3d& p : board.corners()) {
    const double x = random.normal();
    shape.offsets_m.emplace_back(stretch * p.x() + scatter_m * x, scatter_m * random.normal(), 0);
  }
  return shape;
}

// Images show the ratio of a board's width and height, not which of them is as stated.
TEST(RigData, LengthsAreAsUncertainAsTheSizeOfAStretchedBoard) {
  int num_lengths = 0;
  int num_within = 0;
  int num_wide = 0;  // more than the stretch explains
  for (const double stretch : {0.0, 0.003, -0.004}) {
    for (const double scatter_m : {0.0, 1e-4}) {
      for (std::uint64_t seed = 0; seed < 2; ++seed) {
        const BoardShape shape = stretchedShape(kCharuco, stretch, scatter_m, 7 + seed);
        const RigScene scene = sceneOf(threeCameras(), kCharuco, 20, 0.1, 310 + seed, shape);
        RigOptions options = optionsFor(scene);
        options.camera.board_shape = BoardShapeMode::kAuto;
        const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, options);
        for (std::size_t c = 1; c < 3; ++c) {
          const double truth = scene.cameras[c].camera_from_rig.inverse().translation.norm();
          const double found = rig.fit.cameras[c].camera_from_rig.inverse().translation.norm();
          const double std = rig.cameras[c].link.distance_std_m;
          num_within += std::abs(found - truth) < 3 * std ? 1 : 0;
          num_wide += std > std::abs(stretch) * truth + 5e-4 * truth ? 1 : 0;
          ++num_lengths;
        }
      }
    }
  }
  EXPECT_EQ(num_lengths, 24);
  EXPECT_GE(num_within, 23);
  EXPECT_LE(num_wide, 1);
}

// A rig calibrated with a gap of 0.3, while the board is printed with another one. Its lengths are right
// within this many stated deviations, and these are below the share of the length.
RigCalibration rigByTags(double printed_gap, double most_sigmas, double most_share) {
  AprilGrid board{.columns = 4, .rows = 3, .tag_m = 0.06, .gap = printed_gap};
  const RigScene scene = sceneOf(threeCameras(), board, 20, 0.1, 5);
  board.gap = 0.3;
  const Board stated = board;
  RigCalibration rig = calibrate(std::span(&stated, 1), scene.views, optionsFor(scene));
  for (std::size_t c = 1; c < 3; ++c) {
    const double truth = scene.cameras[c].camera_from_rig.inverse().translation.norm();
    const double std = rig.cameras[c].link.distance_std_m;
    EXPECT_NEAR(rig.fit.cameras[c].camera_from_rig.inverse().translation.norm(), truth, most_sigmas * std)
        << printed_gap;
    EXPECT_LT(std, most_share * truth) << printed_gap;
  }
  return rig;
}

TEST(RigData, LengthsFollowTheTagsOfABoardWithAnotherGap) {
  for (const double gap : {0.26, 0.31}) {
    const RigCalibration rig = rigByTags(gap, 4, 1e-3);
    const auto named = std::ranges::find(rig.diagnoses, DiagnosisId("board_gap"), &Diagnosis::id);
    ASSERT_NE(named, rig.diagnoses.end());
    EXPECT_EQ(named->severity, gap == 0.31 ? Severity::kWarning : Severity::kFailure);
  }
}

// A gap that is too little off to be used.
TEST(RigData, LengthsAreAsUncertainAsAGapThatIsNotUsed) {
  for (const double gap : {0.303, 0.305}) {
    const RigCalibration rig = rigByTags(gap, 3, 5e-3);
    EXPECT_FALSE(onlyBoard(rig.fit).target.refutedGap());
  }
}

// A board of paper bends differently in each frame, but before all cameras alike.
TEST(RigData, ABoardThatFlexesLinksCamerasAsWellAsARigidOne) {
  constexpr int kNumFrames = 24;
  int num_checked = 0;
  for (const double bend : {5e-4, 1e-3, 3e-3}) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      RigScene scene = sceneOf(threeCameras(), kCharuco, kNumFrames, 0, 410 + seed);
      Random same(410 + seed);
      const std::vector<SE3> poses =
          randomViews(scene.cameras[0].camera, scene.cameras[0].size, kCharuco, kNumFrames, same);
      Random random(500 + seed);
      std::vector<BoardShape> shapes(kNumFrames);
      for (BoardShape& shape : shapes) {
        shape.bend_x_m = bend * random.normal();
        shape.bend_y_m = bend * random.normal();
      }
      for (std::size_t c = 0; c < 3; ++c) {
        const TrueCamera& camera = scene.cameras[c];
        for (View& view : scene.views[c].views) {
          const auto frame = static_cast<std::size_t>(std::stoi(view.image.substr(5)));
          const SE3 camera_from_board =
              camera.camera_from_rig * scene.cameras[0].camera_from_rig.inverse() * poses[frame];
          for (Corner& corner : view.corners) {
            corner.pixel =
                camera.camera.project(camera_from_board * pointOn(kCharuco, shapes[frame], corner.id)).pixel;
          }
          addCornerNoise(view, kNoise, random);
          for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
        }
      }
      RigOptions options = optionsFor(scene);
      options.camera.board_shape = BoardShapeMode::kAuto;
      const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, options);
      EXPECT_TRUE(rig.links.unlinked.empty()) << bend;
      EXPECT_THAT(rig.diagnoses, hasId("board_flexes")) << bend;
      EXPECT_LT(rms(rig.fit), 1.1 * std::sqrt(2.0) * kNoise) << bend;
      for (std::size_t c = 1; c < 3; ++c) {
        const Eigen::Matrix<double, 6, 1> off = poseError(scene, rig, c);
        const CameraLink& link = rig.cameras[c].link;
        EXPECT_LT(off.head<3>().cwiseQuotient(link.translation_std_m).cwiseAbs().maxCoeff(), 4.5) << bend;
        EXPECT_LT(off.tail<3>().cwiseQuotient(link.rotation_std_rad).cwiseAbs().maxCoeff(), 4.5) << bend;
        EXPECT_LT(link.translation_std_m.maxCoeff(), 1e-3) << bend;
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 18);
}

TEST(RigData, AnUnevenBoardContradictsNoRigThatWasMadeFromIt) {
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 30, 0.05, 97, unevenShape(5));
  RigOptions options = optionsFor(scene);
  options.camera.board_shape = BoardShapeMode::kAuto;
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, options);
  ASSERT_TRUE(onlyBoard(rig.fit).isUneven());
  const RigValidation validation =
      validateRig(recordOf(rig, ""), std::span(&kCharuco, 1), scene.views, 1, options);
  EXPECT_THAT(validation.diagnoses, Not(hasId("lens_contradicted")));
  EXPECT_THAT(validation.diagnoses, Not(hasId("pose_contradicted")));
  EXPECT_LT(validation.rms_px, 1.05 * rms(rig.fit));
}

// A file may have any frame for its rig.
TEST(RigData, PosesAreTestedInAnyFrame) {
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 12, kNoise, 101);
  const RigScene other = sceneOf(threeCameras(), kCharuco, 30, kNoise, 103);
  const RigRecord record = recordOf(calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene)), "");
  const RigValidation plain = validateRig(record, std::span(&kCharuco, 1), other.views, 1, optionsFor(other));
  // The same rig in a frame far off: tangents are those of a small motion there.
  const SE3 rig_from_frame{SO3::exp(Eigen::Vector3d(0.4, -1.1, 0.3)), Eigen::Vector3d(2, -1, 3)};
  const Eigen::Matrix<double, 6, 6> adjoint = rig_from_frame.inverse().adjoint();
  RigRecord moved = record;
  const Eigen::Index count = numRigUnknowns(rigOf(record));
  Eigen::MatrixXd covariance = fullMatrix(record.covariance, count).view();
  Eigen::MatrixXd transport = Eigen::MatrixXd::Identity(count, count);
  for (std::size_t c = 0; c < 3; ++c) {
    moved.cameras[c].camera_from_rig = record.cameras[c].camera_from_rig * rig_from_frame;
    if (c > 0) {
      const Eigen::Index at = count - 12 + 6 * static_cast<Eigen::Index>(c - 1);
      transport.block<6, 6>(at, at) = adjoint;
    }
  }
  moved.covariance = lowerTriangle(transport * covariance * transport.transpose());
  const RigValidation far = validateRig(moved, std::span(&kCharuco, 1), other.views, 1, optionsFor(other));
  for (std::size_t c = 1; c < 3; ++c) {
    EXPECT_NEAR(far.cameras[c].sigmas, plain.cameras[c].sigmas, 0.05) << c;
    EXPECT_LT(plain.cameras[c].sigmas, 3.5) << c;
  }
}

}  // namespace
}  // namespace alidade
