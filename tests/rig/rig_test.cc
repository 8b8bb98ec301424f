// SPDX-License-Identifier: MIT
// Rigs of simulated cameras: the truth is found, and what contradicts it is told.
#include <algorithm>
#include <cmath>
#include <set>

#include <gmock/gmock.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/noise/joint_information.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/rig_file.h"
#include "alidade/rig/rig_calibrator.h"
#include "alidade/rig/rig_start.h"
#include "alidade/rig/rig_validation.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "rig_scene.h"
#include "support/message_of.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;

TEST(BoardTurns, ExchangePointsThatLookTheSame) {
  const AsymmetricCircleGrid even{.columns = 4, .rows = 10, .spacing_m = 0.02, .diameter_m = 0.014};
  const std::vector<std::pair<Board, std::size_t>> boards = {
      {kCharuco, 1}, {kAmbiguous, 2}, {kSquare, 4}, {Board(even), 2}};
  int num_points = 0;
  for (const auto& [board, num_turns] : boards) {
    const std::vector<BoardTurn> turns = boardTurns(board);
    ASSERT_EQ(turns.size(), num_turns) << board.spec();
    for (const BoardTurn& turn : turns) {
      std::set<int> ids;
      for (int id = 0; id < board.numCorners(); ++id) {
        const int turned = turn.id_of[static_cast<std::size_t>(id)];
        ids.insert(turned);
        EXPECT_LT((turn.turned_from_board * board.corner(id) - board.corner(turned)).norm(), 1e-12);
        ++num_points;
      }
      EXPECT_EQ(static_cast<int>(ids.size()), board.numCorners());
    }
  }
  EXPECT_EQ(num_points, 70 + 2 * 48 + 4 * 36 + 2 * 40);
}

TEST(Rig, FindsExactCamerasFromExactCorners) {
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 20, 0, 3);
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  EXPECT_LT(rms(rig.fit), 1e-6);
  EXPECT_TRUE(rig.isUsable()) << rig.diagnoses.front().message();
  EXPECT_TRUE(rig.links.unlinked.empty());
  EXPECT_GE(rig.links.num_linked, 15u);
  for (std::size_t c = 1; c < 3; ++c) EXPECT_LT(poseError(scene, rig, c).norm(), 1e-7) << c;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(rig.fit.cameras[c].params[i], scene.cameras[c].camera.parameters()[i], 1e-4);
  }
}

// Each point is where all cameras together see it, and the joint fit has one board, not one for each camera.
TEST(Rig, FindsThePointsOfAnUnevenBoard) {
  constexpr double kUnevenNoise = 0.05;
  constexpr double kScatter = 3e-4;
  Random random(5);
  BoardShape shape;
  for (int i = 0; i < kCharuco.numCorners(); ++i)
    shape.offsets_m.push_back(kScatter * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 20, kUnevenNoise, 3, shape);
  RigOptions options = optionsFor(scene);
  options.camera.board_shape = BoardShapeMode::kAuto;
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, options);
  ASSERT_TRUE(onlyBoard(rig.fit).isUneven());
  EXPECT_TRUE(rig.links.unlinked.empty());
  EXPECT_NEAR(rms(rig.fit), std::sqrt(2.0) * kUnevenNoise, 0.1 * kUnevenNoise);
  double error = 0;
  for (std::size_t i = 0; i < shape.offsets_m.size(); ++i)
    error += (onlyBoard(rig.fit).shape.offsets_m[i] - shape.offsets_m[i]).squaredNorm();
  // Position, orientation and size of the board as a whole are what no view tells.
  EXPECT_LT(std::sqrt(error / (3.0 * static_cast<double>(shape.offsets_m.size()))), 0.35 * kScatter);
  for (std::size_t c = 1; c < 3; ++c) {
    const Eigen::Matrix<double, 6, 1> off = poseError(scene, rig, c);
    EXPECT_LT(off.head<3>().cwiseQuotient(rig.cameras[c].link.translation_std_m).cwiseAbs().maxCoeff(), 4)
        << c;
    EXPECT_LT(off.tail<3>().cwiseQuotient(rig.cameras[c].link.rotation_std_rad).cwiseAbs().maxCoeff(), 4)
        << c;
  }
}

// A camera that sees few boards by itself is known from those of the others.
TEST(Rig, JudgesItsCamerasByTheJointFit) {
  RigScene scene = sceneOf(threeCameras(), kCharuco, 24, 0.1, 9);
  scene.views[2].views.resize(6);
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  const RigCamera& few = rig.cameras[2];
  ASSERT_TRUE(few.alone.uncertainty.accuracy && few.calibration.uncertainty.accuracy);
  EXPECT_LT(few.calibration.uncertainty.accuracy->covered_px,
            0.8 * few.alone.uncertainty.accuracy->covered_px);
  for (const RigCamera& camera : rig.cameras) {
    EXPECT_EQ(onlyCamera(camera.calibration.fit).params,
              rig.fit.cameras[&camera - rig.cameras.data()].params);
    EXPECT_NEAR(rms(camera.calibration.fit), camera.rms_px, 1e-12);
  }
}

TEST(Rig, StatesItsUncertainty) {
  std::vector<TrueCamera> cameras = threeCameras();
  int num_within = 0;
  int num_all = 0;
  int num_by_frames = 0;
  double worst = 0;
  double sum_distance = 0;
  double sum_position = 0;
  constexpr int kNumSets = 60;
  for (std::uint64_t seed = 0; seed < kNumSets; ++seed) {
    const RigScene scene = sceneOf(cameras, kCharuco, 30, 0.2, 100 + seed);
    const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
    ASSERT_GT(rig.covariance.matrix.rows(), 0) << seed;
    num_by_frames += rig.covariance.is_by_frames ? 1 : 0;
    for (std::size_t c = 1; c < 3; ++c) {
      Eigen::Matrix<double, 6, 1> std;
      std << rig.cameras[c].link.translation_std_m, rig.cameras[c].link.rotation_std_rad;
      const Eigen::Matrix<double, 6, 1> z = poseError(scene, rig, c).cwiseQuotient(std);
      num_all += 6;
      num_within += static_cast<int>((z.cwiseAbs().array() < 1.96).count());
      worst = std::max(worst, z.cwiseAbs().maxCoeff());
      const auto centreOf = [](const SE3& camera_from_rig) { return camera_from_rig.inverse().translation; };
      const Eigen::Vector3d centre = centreOf(scene.cameras[c].camera_from_rig);
      const Eigen::Vector3d error = centreOf(rig.fit.cameras[c].camera_from_rig) - centre;
      sum_position += error.cwiseQuotient(rig.cameras[c].link.position_std_m).squaredNorm() / 3;
      const double distance_z = centre.normalized().dot(error) / rig.cameras[c].link.distance_std_m;
      sum_distance += distance_z * distance_z;
    }
  }
  EXPECT_EQ(num_all, 12 * kNumSets);
  EXPECT_GE(num_within, static_cast<int>(0.92 * num_all));
  EXPECT_LE(num_within, static_cast<int>(0.98 * num_all));
  EXPECT_LE(num_by_frames, kNumSets / 10);
  EXPECT_LT(worst, 5);
  // The standard error of a mean square of 120 such numbers is 0.13 or less.
  EXPECT_NEAR(sum_position / (2 * kNumSets), 1, 0.4);
  EXPECT_NEAR(sum_distance / (2 * kNumSets), 1, 0.4);
  RecordProperty("share_within", std::to_string(static_cast<double>(num_within) / num_all));
  RecordProperty("worst", std::to_string(worst));
}

TEST(Rig, NumbersAmbiguousBoardsAlike) {
  int num_turned = 0;
  for (const Board& board : {kAmbiguous, kSquare}) {
    RigScene scene = sceneOf(threeCameras(), board, 24, 0.1, 11);
    const std::vector<BoardTurn> turns = boardTurns(board);
    Random random(5);
    int num_here = 0;
    for (RigViews& camera : scene.views) {
      for (View& view : camera.views) {
        const std::size_t k = random.index(turns.size());
        if (k != 0) ++num_here;
        for (Corner& corner : view.corners) corner.id = turns[k].id_of[static_cast<std::size_t>(corner.id)];
        std::ranges::sort(view.corners, {}, &Corner::id);
      }
    }
    ASSERT_GT(num_here, 10);
    num_turned += num_here;
    const RigCalibration rig = calibrate(std::span(&board, 1), scene.views, optionsFor(scene));
    EXPECT_GT(rig.links.num_renumbered, 5u);
    EXPECT_TRUE(rig.links.unlinked.empty());
    EXPECT_NEAR(rms(rig.fit), 0.1 * std::sqrt(2), 0.02);
    for (std::size_t c = 1; c < 3; ++c) {
      EXPECT_LT(poseError(scene, rig, c).head<3>().norm(), 5e-3);
      EXPECT_LT(poseError(scene, rig, c).tail<3>().norm(), 5e-3);
    }
  }
  EXPECT_GT(num_turned, 40);
}

TEST(Rig, LinksCamerasThroughOthers) {
  RigScene scene = sceneOf(threeCameras(), kCharuco, 30, 0.1, 17);
  // The second camera has the first half of the frames, the third the second half.
  const auto keep = [&](std::size_t c, bool first_half) {
    std::erase_if(scene.views[c].views,
                  [&](const View& view) { return (std::stoi(view.image.substr(5)) < 15) != first_half; });
  };
  keep(1, true);
  keep(2, false);
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  for (std::size_t c = 1; c < 3; ++c) EXPECT_LT(poseError(scene, rig, c).norm(), 0.02);
  // Without the first camera nothing links them.
  scene.views.erase(scene.views.begin());
  scene.cameras.erase(scene.cameras.begin());
  EXPECT_THAT(messageOf([&] { (void)calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene)); }),
              AllOf(HasSubstr("nothing links: camera1 | camera2"), HasSubstr("next: ")));
}

TEST(Rig, FindsFramesThatWereNotTakenTogether) {
  RigScene scene = sceneOf(threeCameras(), kCharuco, 30, 0.1, 23);
  // Two views of the second camera are those of other moments.
  std::vector<View>& views = scene.views[1].views;
  std::swap(views[2].corners, views[9].corners);
  const std::vector<std::string> wrong = {views[2].image, views[9].image};
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  ASSERT_EQ(rig.links.unlinked.size(), 2u);
  for (const RigImage& view : rig.links.unlinked) {
    EXPECT_EQ(view.camera, 1u);
    EXPECT_THAT(wrong, Contains(view.image));
  }
  EXPECT_THAT(rig.diagnoses, Contains(Field(&Diagnosis::id, testing::Eq("not_simultaneous"))));
  EXPECT_LT(poseError(scene, rig, 1).norm(), 0.02);
}

// A camera moves after half of the frames, far or by a little; another one never does.
TEST(Rig, FindsACameraThatMoved) {
  constexpr int kNumFrames = 30;
  constexpr int kFirstMoved = 14;
  int num_found = 0;
  for (const double angle_rad : {0.2, 0.02, 0.002}) {
    for (const std::size_t mover : {std::size_t{0}, std::size_t{2}}) {
      RigScene scene = sceneOf(threeCameras(), kCharuco, kNumFrames, 0.1, 37);
      const SE3 motion{SO3::exp(Eigen::Vector3d(0, angle_rad, 0)), Eigen::Vector3d(0.1 * angle_rad, 0, 0)};
      std::vector<TrueCamera> moved = threeCameras();
      moved[mover].camera_from_rig = motion * moved[mover].camera_from_rig;
      // The boards stay where the unmoved first camera sees them.
      Random random(37);
      const std::vector<SE3> boards =
          randomViews(scene.cameras.front().camera, scene.cameras.front().size, kCharuco, kNumFrames, random);
      Random noise(41);
      std::erase_if(scene.views[mover].views,
                    [](const View& view) { return std::stoi(view.image.substr(5)) >= kFirstMoved; });
      for (int i = kFirstMoved; i < kNumFrames; ++i) {
        const TrueCamera& camera = moved[mover];
        View view = exactView(camera.camera, camera.size, kCharuco,
                              camera.camera_from_rig * boards[static_cast<std::size_t>(i)],
                              "frame" + std::to_string(i) + ".png");
        addCornerNoise(view, 0.1, noise);
        for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
        std::erase_if(view.corners, [&](const Corner& c) { return !isInOrNearImage(c.pixel, view.size); });
        if (view.corners.size() >= 12) scene.views[mover].views.push_back(std::move(view));
      }
      const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
      ASSERT_EQ(rig.motions.size(), 1u) << angle_rad << " " << mover;
      const CameraMotion& found = rig.motions.front();
      EXPECT_EQ(found.camera, mover);
      EXPECT_NEAR(std::stoi(found.from_frame.substr(5)), kFirstMoved, 1);
      EXPECT_NEAR((motion.inverse() * found.after_from_before).log().norm(), 0, 0.2 * angle_rad + 5e-4);
      EXPECT_THAT(rig.diagnoses, Contains(Field(&Diagnosis::id, testing::Eq("camera_moved"))));
      EXPECT_EQ(rig.isUsable(), found.effect_px < 5);
      ++num_found;
    }
  }
  EXPECT_EQ(num_found, 6);
}

TEST(Rig, FindsNoMotionWhereThereIsNone) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const RigScene scene = sceneOf(threeCameras(), kCharuco, 20, 0.2, 400 + seed);
    EXPECT_TRUE(calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene)).motions.empty()) << seed;
  }
}

TEST(Rig, ValidatesWithFramesThatItDidNotUse) {
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 30, 0.2, 43);
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  EXPECT_EQ(rig.holdout.num_folds, 5);
  EXPECT_GT(rig.holdout.num_corners, 3000);
  EXPECT_GT(rig.holdout.rms_px, rms(rig.fit));
  EXPECT_NEAR(rig.holdout.rms_px, 0.2 * std::sqrt(2), 0.02);
}

TEST(Rig, KeepsLensesThatAreGiven) {
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 20, 0.1, 47);
  RigOptions options = optionsFor(scene);
  const RigCalibration free = calibrate(std::span(&kCharuco, 1), scene.views, options);
  options.given = {recordOf(free, "").cameras[0].camera, std::nullopt,
                   bareRecord(scene.cameras[2].camera, scene.cameras[2].size, "")};
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, options);
  EXPECT_EQ(rig.fit.cameras[0].params, free.fit.cameras[0].params);
  EXPECT_THAT(rig.fit.cameras[2].params, testing::ElementsAreArray(scene.cameras[2].camera.parameters()));
  EXPECT_FALSE(rig.cameras[0].misfit);
  EXPECT_FALSE(rig.cameras[2].misfit);
  // What is known of a given lens counts: nothing is known better than from all views at once.
  const JointColumns columns = jointColumns(rig.fit);
  EXPECT_GT(rig.covariance.matrix(columns.params[0], columns.params[0]), 0);
  EXPECT_EQ(rig.covariance.matrix(columns.params[2], columns.params[2]), 0);
  EXPECT_GT(rig.cameras[1].link.transfer_px, 0.9 * free.cameras[1].link.transfer_px);
  EXPECT_EQ(recordOf(rig, "").cameras[2].camera.calibration, std::nullopt);
  // A wrong lens is told.
  std::vector<double> wrong(scene.cameras[2].camera.parameters().begin(),
                            scene.cameras[2].camera.parameters().end());
  wrong[0] *= 1.03;
  wrong[1] *= 1.03;
  options.given[2] = bareRecord(AnyCamera::make("pinhole", wrong), scene.cameras[2].size, "");
  const RigCalibration contradicted = calibrate(std::span(&kCharuco, 1), scene.views, options);
  ASSERT_TRUE(contradicted.cameras[2].misfit);
  EXPECT_GT(contradicted.cameras[2].misfit->effect_px, 1);
  EXPECT_THAT(contradicted.diagnoses, Contains(Field(&Diagnosis::id, testing::Eq("given_lens_misfits"))));
}

// Entrance pupils that move have no place in the covariance of a file, and are part of the uncertainty.
TEST(Rig, KnowsEntrancePupils) {
  const std::vector<double> fisheye = {420, 421, 512, 383, 0.01, -0.003, 0.001, 0};
  const AnyCamera moving = AnyCamera::make("kannala_brandt", fisheye).withPupil({.s1_m = 0.003});
  const RigScene scene =
      sceneOf({{moving, {1024, 768}, {}},
               {AnyCamera::make("kannala_brandt", fisheye), {1024, 768}, poseAt(-0.2, 0.01, 0.02, 0.15)},
               {moving.withPupil({.s1_m = 0.002}), {1024, 768}, poseAt(0.18, -0.02, 0.01, -0.1)}},
              kCharuco, 25, 0.1, 31);
  RigOptions options = optionsFor(scene);
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, options);
  EXPECT_EQ(rig.verdict(), Verdict::kTrustworthy);
  int num_moving = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const Calibration& camera = rig.cameras[c].calibration;
    const EntrancePupil found = camera.camera().pupil();
    EXPECT_EQ(found.isFixed(), c == 1) << c;
    if (found.isFixed()) continue;
    const double std_m = camera.uncertainty.pupil_std_m.front();
    EXPECT_NEAR(found.s1_m, scene.cameras[c].camera.pupil().s1_m, 3 * std_m);
    EXPECT_LT(std_m, 3e-4);
    ++num_moving;
  }
  EXPECT_EQ(num_moving, 2);
  EXPECT_LT(poseError(scene, rig, 2).head<3>().norm(), 3e-4);
  const RigRecord record = recordOf(rig, "");
  const std::size_t num_unknowns = 3 * 8 + 2 * 6;
  EXPECT_EQ(record.covariance.size(), num_unknowns * (num_unknowns + 1) / 2);
  EXPECT_EQ(record.cameras[2].camera.calibration->parameter_std.size(), 8U);
  const RigValidation valid = validateRig(record, std::span(&kCharuco, 1), scene.views, 1, options);
  EXPECT_EQ(valid.num_failed, 0U);
  EXPECT_NEAR(valid.length_ratio, 1, 4 * valid.length_ratio_std);
  EXPECT_LT(valid.length_ratio_std, 1e-3);
  // A given lens keeps its pupil, and is not contradicted by the lens that the images give.
  options.given = {record.cameras[0].camera, std::nullopt, record.cameras[2].camera};
  const RigCalibration given = calibrate(std::span(&kCharuco, 1), scene.views, options);
  EXPECT_EQ(given.fit.cameras[0].params, fitParams(record.cameras[0].camera.camera));
  EXPECT_FALSE(given.cameras[0].misfit);
  EXPECT_FALSE(given.cameras[2].misfit);
}

TEST(Rig, NeedsTwoCameras) {
  RigScene scene = sceneOf(threeCameras(), kCharuco, 6, 0.1, 29);
  scene.views.resize(1);
  try {
    (void)calibrate(std::span(&kCharuco, 1), scene.views, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
  }
}

TEST(RigValidation, TellsARightRigFromAWrongOne) {
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 30, 0.1, 53);
  RigRecord truth;
  for (std::size_t c = 0; c < 3; ++c) {
    const TrueCamera& camera = scene.cameras[c];
    truth.cameras.push_back(
        {.camera = bareRecord(camera.camera, camera.size, ""), .camera_from_rig = camera.camera_from_rig});
    truth.cameras.back().camera.name.name = scene.views[c].name;
  }
  const auto validated = [&](const RigRecord& rig, const Board& board) {
    return validateRig(rig, std::span(&board, 1), scene.views, 1, optionsFor(scene));
  };
  const RigValidation right = validated(truth, kCharuco);
  EXPECT_EQ(right.verdict(), Verdict::kTrustworthy);
  EXPECT_NEAR(right.rms_px, 0.1 * std::sqrt(2), 0.01);
  EXPECT_LT(right.freed_rms_px, right.rms_px);
  EXPECT_GT(right.num_points, 1500u);
  EXPECT_EQ(right.num_failed, 0u);
  // The noise of both pixels across the curve, larger in the image of the longer focal length.
  EXPECT_GT(right.epipolar_px, 0.1 * std::sqrt(2));
  EXPECT_LT(right.epipolar_px, 0.2);
  EXPECT_NEAR(right.length_ratio, 1, 4 * right.length_ratio_std);
  EXPECT_LT(right.length_ratio_std, 1e-3);
  for (std::size_t c = 1; c < 3; ++c) EXPECT_LT(right.cameras[c].sigmas, 3) << c;
  // Another pose of a camera.
  RigRecord moved = truth;
  moved.cameras[2].camera_from_rig.translation.x() += 0.004;
  const RigValidation wrong = validated(moved, kCharuco);
  EXPECT_THAT(wrong.diagnoses, Contains(Field(&Diagnosis::id, testing::Eq("pose_contradicted"))));
  EXPECT_GT(wrong.cameras[2].sigmas, 5);
  EXPECT_NEAR(wrong.cameras[2].freed_from_stated.translation.x(), -0.004, 0.002);
  EXPECT_LT(wrong.cameras[1].sigmas, 3);
  // A rig that is a hundredth too large, lenses being right.
  RigRecord large = truth;
  for (RigCameraRecord& camera : large.cameras) camera.camera_from_rig.translation *= 1.01;
  const RigValidation long_lengths = validated(large, kCharuco);
  EXPECT_NEAR(long_lengths.length_ratio, 1.01, 0.003);
  EXPECT_THAT(long_lengths.diagnoses, Contains(Field(&Diagnosis::id, testing::Eq("lengths_contradicted"))));
}

TEST(RigFile, HoldsItsCameras) {
  const RigScene scene = sceneOf(threeCameras(), kCharuco, 15, 0.1, 31);
  const RigCalibration rig = calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
  const std::string text = rigFileText(recordOf(rig, "a test"));
  const CameraSource source = parseCameras(text, "rig.yaml");
  ASSERT_EQ(source.cameras.size(), 3u);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(source.cameras[c].name, "camera" + std::to_string(c));
    EXPECT_THAT(source.cameras[c].camera.parameters(), testing::ElementsAreArray(rig.fit.cameras[c].params));
    EXPECT_EQ(source.cameras[c].image_size, scene.cameras[c].size);
  }
  ReadOptions only_one;
  only_one.only = "camera1";
  EXPECT_EQ(parseCameras(text, "rig.yaml", only_one).cameras.size(), 1u);
  std::string damaged = text;
  damaged.replace(damaged.find("quaternion_xyzw"), 15, "quaternion_xyz_");
  EXPECT_THAT(messageOf([&] { (void)parseCameras(damaged, "rig.yaml"); }),
              AllOf(HasSubstr("rig.yaml:"), HasSubstr("quaternion_xyz_")));
}

}  // namespace
}  // namespace alidade
