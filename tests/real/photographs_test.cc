// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/bend/shape_fit.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/core/random.h"
#include "alidade/detect/detect_images.h"
#include "alidade/detect/survey.h"
#include "alidade/files/corners_file.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/rig/rig_validation.h"
#include "alidade/target/board_spec.h"
#include "alidade/validate/held_out/held_out_images.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

// Photographs that this project does not hold: those of Debian's package opencv-doc, and a folder of public
// sets that ALIDADE_REAL_DATA names. Sets that are not there are not tested, and the first test says which.
struct PhotoSet {
  std::string name;
  std::string pattern;
  std::string board;
  int num_images;
  int min_whole;
  int min_with_corners;  // of all or some of the board's corners
};

// What calibrating a set with radtan must give.
struct CalibrationCase {
  std::string set;
  double max_rms_px;
  double fx;  // what other programs find on the same files, and how far they are from each other
  double fx_spread;
};

std::string publicData(const std::string& path) {
  const char* root = std::getenv("ALIDADE_REAL_DATA");
  return (root != nullptr ? std::string(root) : std::string("/nonexistent")) + "/" + path;
}

const std::string kOpencvData = "/usr/share/doc/opencv-doc/examples/data/";

std::vector<PhotoSet> photoSets() {
  return {
      {"opencv_left", kOpencvData + "left[0-9][0-9].jpg", "checkerboard:9x6:25mm", 13, 13, 13},
      {"opencv_right", kOpencvData + "right[0-9][0-9].jpg", "checkerboard:9x6:25mm", 13, 13, 13},
      {"sony_chess", publicData("sony_chess"), "checkerboard:4x6:30mm", 13, 13, 13},
      {"bumblebee2_left", publicData("bumblebee2_stereo_chess/left*.jpg"), "checkerboard:4x6:30mm", 11, 11,
       11},
      {"bumblebee2_right", publicData("bumblebee2_stereo_chess/right*.jpg"), "checkerboard:4x6:30mm", 11, 11,
       11},
      {"lifecam_480", publicData("photonvision_chess/lifecam_480_10x10"), "checkerboard:10x10:25.4mm", 14, 14,
       14},
      {"picam_640", publicData("photonvision_chess/picam_640_7x7"), "checkerboard:7x7:25.4mm", 25, 25, 25},
      {"gloworm_320", publicData("photonvision_chess/gloworm_320_8x6"), "checkerboard:8x6:25.4mm", 25, 25,
       25},
      {"camodocal_fisheye", publicData("camodocal_fisheye/images"), "checkerboard:9x6:25mm", 63, 60, 63},
      {"dyfcalid_fisheye", publicData("dyfcalid_fisheye/images"), "checkerboard:7x6:25mm", 10, 10, 10},
      // Two of these are cut by the image's border.
      {"udacity_carnd", publicData("udacity_carnd/images"), "checkerboard:9x6:25mm", 20, 18, 18},
  };
}

std::vector<CalibrationCase> calibrationCases() {
  return {
      {"opencv_left", 0.085, 533.5, 3},      {"opencv_right", 0.065, 537.5, 3},
      {"sony_chess", 0.140, 701.5, 10},      {"bumblebee2_left", 0.030, 525.5, 5},
      {"bumblebee2_right", 0.030, 525.5, 5}, {"gloworm_320", 0.065, 266, 25},
  };
}

bool isThere(const PhotoSet& set) {
  return fs::exists(fs::path(set.pattern).parent_path());
}

std::vector<PhotoSet> setsThatAreThere() {
  std::vector<PhotoSet> sets = photoSets();
  std::erase_if(sets, [](const PhotoSet& set) { return !isThere(set); });
  return sets;
}

TEST(Photographs, AreFoundOrNamed) {
  const bool is_promised = std::getenv("ALIDADE_REAL_DATA") != nullptr;
  for (const PhotoSet& set : photoSets()) {
    if (isThere(set)) continue;
    std::printf("not there, so not tested: %s\n", set.name.c_str());
    const bool is_public = set.pattern.find("opencv-doc") == std::string::npos;
    EXPECT_FALSE(is_promised && is_public) << "ALIDADE_REAL_DATA is set, but has no " << set.name;
  }
}

// ChArUco boards, whose layout is not told, and a wavy sheet of circles; the limits are a little above what
// is reached.
TEST(Photographs, OfMarkersAndCirclesCalibrateWell) {
  struct Case {
    std::string folder;
    std::string board;
    std::size_t min_corners;
    double max_rms_px;
  };
  const std::string lifecam = "photonvision_charuco/lifecam/";
  const std::string small = "charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000";
  const std::string sleap = "sleap_anipose_4cam_charuco/";
  const std::string large = "charuco:8x11:24mm:18.75mm:DICT_4X4_1000";
  const std::vector<Case> cases = {
      {lifecam + "2024-05-07_lifecam_1280", small, 740, 0.21},
      {lifecam + "2024-05-07_lifecam_480", small, 800, 0.17},
      {lifecam + "2024-06-19_lifecam_1280_Old_Pattern", small, 600, 0.27},
      {lifecam + "2024-06-19_lifecam_480_Old_Pattern", small, 760, 0.19},
      {sleap + "back/calibration_images", large, 1030, 0.03},
      {sleap + "mid/calibration_images", large, 1040, 0.02},
      {sleap + "side/calibration_images", large, 1000, 0.07},
      {sleap + "top/calibration_images", large, 1030, 0.02},
      {"sony_circles/regular", "circles:10x8:25mm:15mm", 480, 0.05},
  };
  std::size_t num_checked = 0;
  for (const Case& c : cases) {
    if (!fs::exists(publicData(c.folder))) continue;
    const Board board = parseBoardSpec(c.board);
    const BoardSurvey survey = surveyImages(listImages(std::vector{publicData(c.folder)}), board);
    const Calibration result = calibrate(board, survey.views(), {.model = "radtan"});
    std::printf("%s: %zu corners, RMS %.4f px\n", c.folder.c_str(), numCorners(result.fit), rms(result.fit));
    EXPECT_GE(numCorners(result.fit), c.min_corners) << c.folder;
    EXPECT_LE(rms(result.fit), c.max_rms_px) << c.folder;
    ++num_checked;
  }
  if (num_checked == 0 && std::getenv("ALIDADE_REAL_DATA") == nullptr)
    GTEST_SKIP() << "no photographs of markers and circles";
  EXPECT_EQ(num_checked, cases.size());
}

// The views of each camera of a rig, an input each.
std::vector<RigViews> rigViews(const std::vector<std::pair<std::string, std::string>>& inputs,
                               const Board& board) {
  std::vector<RigViews> cameras;
  for (const auto& [name, input] : inputs)
    cameras.push_back({.name = name, .views = surveyImages(listImages(std::vector{input}), board).views()});
  return cameras;
}

// Of all coordinates of the offsets that two cameras found for one board.
double offsetCorrelation(const BoardShape& a, const BoardShape& b) {
  expect(a.offsets_m.size() == b.offsets_m.size() && !a.offsets_m.empty(), "both cameras find offsets");
  double aa = 0;
  double ab = 0;
  double bb = 0;
  for (std::size_t i = 0; i < a.offsets_m.size(); ++i) {
    aa += a.offsets_m[i].squaredNorm();
    ab += a.offsets_m[i].dot(b.offsets_m[i]);
    bb += b.offsets_m[i].squaredNorm();
  }
  return ab / std::sqrt(aa * bb);
}

// The best peer reaches 0.2151 px with a flat board. The pairs of one half validate the rig of the other.
TEST(Photographs, OfAStereoPairGiveARig) {
  if (!fs::exists(kOpencvData + "left01.jpg")) GTEST_SKIP() << "no photographs of opencv-doc";
  const Board board = parseBoardSpec("checkerboard:9x6:25mm");
  const std::vector<RigViews> all = rigViews(
      {{"left", kOpencvData + "left[0-9][0-9].jpg"}, {"right", kOpencvData + "right[0-9][0-9].jpg"}}, board);
  RigOptions options;
  options.camera.model = "radtan";
  const RigCalibration bent = calibrate(std::span(&board, 1), all, options);
  options.camera.board_shape = BoardShapeMode::kFlat;
  const RigCalibration flat = calibrate(std::span(&board, 1), all, options);
  EXPECT_EQ(numCorners(flat.fit), 2u * 13 * 54);
  EXPECT_LE(rms(flat.fit), 0.18);
  EXPECT_LT(rms(bent.fit), 0.65 * rms(flat.fit));
  options.camera.board_shape = BoardShapeMode::kAuto;
  std::array<std::vector<RigViews>, 2> halves = {all, all};
  for (RigViews& camera : halves[0]) camera.views.resize(7);
  for (RigViews& camera : halves[1]) camera.views.erase(camera.views.begin(), camera.views.begin() + 7);
  const RigRecord rig = recordOf(calibrate(std::span(&board, 1), halves[0], options), "");
  const RigValidation held_out = validateRig(rig, std::span(&board, 1), halves[1], 1, options);
  std::printf("opencv-doc: RMS %.4f px, flat %.4f px; epipolar error of other pairs %.4f px\n", rms(bent.fit),
              rms(flat.fit), held_out.epipolar_px);
  EXPECT_EQ(held_out.num_points, 6u * 54);
  EXPECT_LE(held_out.epipolar_px, 0.15);  // the difference between rows after rectification
}

// Views of the ambiguous board are numbered differently in 6 of 11 pairs by OpenCV. The published baseline is
// 120.05 mm.
TEST(Photographs, OfABumblebeeGiveItsBaseline) {
  const std::string folder = publicData("bumblebee2_stereo_chess/");
  if (!fs::exists(folder)) GTEST_SKIP() << "no photographs of the stereo pair";
  const Board board = parseBoardSpec("checkerboard:4x6:30mm");
  const RigCalibration rig =
      calibrate(std::span(&board, 1),
                rigViews({{"left", folder + "left*.jpg"}, {"right", folder + "right*.jpg"}}, board),
                {.camera = {.model = "radtan"}});
  const double baseline_mm = 1000 * rig.fit.cameras[1].camera_from_rig.translation.norm();
  std::printf("bumblebee2: baseline %.2f mm, RMS %.4f px\n", baseline_mm, rms(rig.fit));
  EXPECT_EQ(rig.links.num_linked, 11u);
  EXPECT_TRUE(rig.links.unlinked.empty());
  EXPECT_NEAR(baseline_mm, 120.05, 0.3);
  EXPECT_LE(rms(rig.fit), 0.03);
}

// One camera sees the board at a grazing angle.
TEST(Photographs, OfFourCamerasGiveOneRig) {
  const std::string folder = publicData("sleap_anipose_4cam_charuco/");
  if (!fs::exists(folder)) GTEST_SKIP() << "no photographs of the four cameras";
  const Board board = parseBoardSpec("charuco:8x11:24mm:18.75mm:DICT_4X4_1000");
  std::vector<std::pair<std::string, std::string>> inputs;
  for (const char* name : {"back", "mid", "side", "top"})
    inputs.emplace_back(name, folder + name + "/calibration_images");
  const std::vector<RigViews> views = rigViews(inputs, board);
  const RigCalibration bent = calibrate(
      std::span(&board, 1), views, {.camera = {.model = "radtan", .board_shape = BoardShapeMode::kWarp}});
  const RigCalibration rig = calibrate(std::span(&board, 1), views, {.camera = {.model = "radtan"}});
  for (const RigCalibration* of : {&bent, &rig}) {
    EXPECT_GE(of->links.num_linked, 15u);
    EXPECT_TRUE(of->links.unlinked.empty());
  }
  ASSERT_TRUE(onlyBoard(rig.fit).isUneven());
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = bent.cameras[c];
    std::printf("%s: RMS %.4f px in the rig, %.4f px alone; with every point's place %.4f and %.4f px\n",
                camera.name.c_str(), camera.rms_px, camera.alone_rms_px, rig.cameras[c].rms_px,
                rig.cameras[c].alone_rms_px);
    EXPECT_GE(camera.link.num_views, 14u);
    EXPECT_LE(camera.rms_px, 1.11 * camera.alone_rms_px) << camera.name;
    EXPECT_LE(rig.cameras[c].rms_px, 0.35 * camera.alone_rms_px) << camera.name;
  }
}

// Five views of a fisheye, from a public report. The smallest model that predicts their corners makes the
// moving pupil count for more than five times the tolerance; another, which they cannot tell from it, for
// less.
TEST(Photographs, OfAFisheyeFromFiveViewsGiveAUsableCamera) {
  const std::string folder = publicData("reports/63_fisheye_corners");
  if (!fs::exists(folder)) GTEST_SKIP() << "not there: " << folder;
  std::vector<Board> boards;
  std::vector<View> views;
  for (int i = 1; i <= 5; ++i) {
    CornersFile file = readCornersFile(folder + "/view" + std::to_string(i) + ".csv");
    boards = file.boards;
    views.push_back(std::move(file.views.front()));
  }
  const Calibration result = calibrate(boards, views, {.num_pupil = 0});
  const auto isNamed = [&](std::string_view id) {
    return std::ranges::find(result.diagnoses, id, &Diagnosis::id) != result.diagnoses.end();
  };
  EXPECT_EQ(result.verdict(), Verdict::kReservations);
  EXPECT_TRUE(isNamed("model_rejected"));
  EXPECT_TRUE(isNamed("centre_moves"));
  const auto& candidates = result.choice.model->candidates;
  EXPECT_EQ(std::ranges::count(candidates, "rejected", &ModelCandidate::verdict), 1);
  EXPECT_EQ(std::ranges::count(candidates, "chosen", &ModelCandidate::verdict), 1);
  EXPECT_GT(result.uncertainty.accuracy->covered_px, 2);
  // Its entrance pupil moves, and the camera is twice as accurate if this is taken into account.
  const Calibration moving = calibrate(boards, views, {});
  EXPECT_EQ(moving.verdict(), Verdict::kReservations);
  ASSERT_EQ(moving.uncertainty.pupil_std_m.size(), 1U);
  EXPECT_NEAR(moving.camera().pupil().s1_m, 2.6e-3, 1e-3);
  EXPECT_LT(moving.uncertainty.holdout.rms_px, 0.6 * result.uncertainty.holdout.rms_px);
  EXPECT_LT(moving.uncertainty.accuracy->covered_px, 0.7 * result.uncertainty.accuracy->covered_px);
}

// Tags whose four corners are found; two boards in one image are told apart by their ids.
TEST(Photographs, OfAprilGridsGiveTheirTags) {
  struct Case {
    std::string image;
    std::vector<std::string> boards;
    int min_tags;
  };
  const std::vector<Case> cases = {
      {"EuRoC", {"aprilgrid:6x6:88mm:0.3"}, 27},
      {"iphone", {"aprilgrid:11x6:30mm:0.3"}, 66},
      {"two_boards", {"aprilgrid:6x6:88mm:0.3", "aprilgrid:6x6:88mm:0.3:36"}, 71}};
  std::size_t num_checked = 0;
  for (const Case& c : cases) {
    const std::string path = publicData("aprilgrid_singles/" + c.image + ".png");
    if (!fs::exists(path)) continue;
    int num_tags = 0;
    for (const std::string& spec : c.boards) {
      const Board board = parseBoardSpec(spec);
      std::map<int, int> corners_of;
      for (const Corner& corner : findBoard(readGrayImage(path).image, board).corners)
        ++corners_of[corner.id / board.columns() / 2 * board.columns() + corner.id % board.columns() / 2];
      for (const auto& [tag, count] : corners_of) num_tags += count == 4 ? 1 : 0;
    }
    std::printf("%s: %d tags\n", c.image.c_str(), num_tags);
    EXPECT_GE(num_tags, c.min_tags) << c.image;
    ++num_checked;
  }
  if (num_checked == 0 && std::getenv("ALIDADE_REAL_DATA") == nullptr)
    GTEST_SKIP() << "no photographs of AprilGrids";
  EXPECT_EQ(num_checked, cases.size());
}

class PhotoSetTest : public testing::TestWithParam<PhotoSet> {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(PhotoSetTest);
INSTANTIATE_TEST_SUITE_P(Photographs, PhotoSetTest, testing::ValuesIn(setsThatAreThere()),
                         [](const auto& set) { return set.param.name; });

std::vector<ImageOutcome> detectSet(const PhotoSet& set) {
  const std::vector<std::string> inputs = {set.pattern};
  const std::vector<std::string> images = listImages(inputs);
  EXPECT_EQ(static_cast<int>(images.size()), set.num_images);
  return detectInImages(images, std::vector{parseBoardSpec(set.board)}).front();
}

// Checks the order of a view's corners against the picture itself: rows clockwise of columns, squares of the
// colour that their place on the board has, no corner out of line. Returns how many squares were looked at.
int checkOrder(const ImageOutcome& outcome, const Board& board) {
  const GrayImage image = readGrayImage(outcome.image).image;
  std::vector<const Corner*> by_id(static_cast<std::size_t>(board.numCorners()), nullptr);
  for (const Corner& corner : outcome.detection.corners) by_id[static_cast<std::size_t>(corner.id)] = &corner;
  double sum[2] = {0, 0};
  int count[2] = {0, 0};
  for (int row = 0; row + 1 < board.rows(); ++row) {
    for (int column = 0; column + 1 < board.columns(); ++column) {
      const auto id = static_cast<std::size_t>(row * board.columns() + column);
      const Corner* corners[4] = {by_id[id], by_id[id + 1],
                                  by_id[id + static_cast<std::size_t>(board.columns())],
                                  by_id[id + static_cast<std::size_t>(board.columns()) + 1]};
      if (std::any_of(std::begin(corners), std::end(corners), [](const Corner* c) { return c == nullptr; }))
        continue;
      const Eigen::Vector2d u = corners[1]->pixel - corners[0]->pixel;
      const Eigen::Vector2d v = corners[2]->pixel - corners[0]->pixel;
      const Eigen::Vector2d across = corners[3]->pixel - corners[0]->pixel;
      EXPECT_GT(u.x() * v.y() - u.y() * v.x(), 0) << outcome.image;
      EXPECT_LT((across - u - v).norm(), 0.5 * std::min(u.norm(), v.norm()))
          << outcome.image << " corner " << id;
      const Eigen::Vector2d middle =
          0.25 * (corners[0]->pixel + corners[1]->pixel + corners[2]->pixel + corners[3]->pixel);
      sum[(row + column) % 2] +=
          image.at(static_cast<int>(std::lround(middle.x())), static_cast<int>(std::lround(middle.y())));
      ++count[(row + column) % 2];
    }
  }
  EXPECT_GT(count[0], 2) << outcome.image;
  EXPECT_GT(count[1], 2) << outcome.image;
  const double first = sum[0] / count[0];
  const double second = sum[1] / count[1];
  EXPECT_GT(std::abs(second - first), 15) << outcome.image << ": the squares do not alternate";
  if (std::get<Checkerboard>(board.kind()).coloursTellCorner0()) {
    EXPECT_LT(first, second) << outcome.image << ": corner 0 has no dark square";
  }
  return count[0] + count[1];
}

TEST_P(PhotoSetTest, IsFoundInTheRightOrder) {
  const PhotoSet& set = GetParam();
  int num_whole = 0;
  int num_with_corners = 0;
  int num_squares = 0;
  for (const ImageOutcome& outcome : detectSet(set)) {
    num_whole += outcome.detection.found() ? 1 : 0;
    if (outcome.detection.hasCorners()) {
      ++num_with_corners;
      num_squares += checkOrder(outcome, parseBoardSpec(set.board));
      for (const Corner& corner : outcome.detection.corners) {
        EXPECT_GT(corner.sigma_px, 0);
        EXPECT_LT(corner.sigma_px, 3);
      }
    } else {
      EXPECT_FALSE(outcome.detection.detail.empty());
    }
    if (!outcome.detection.found()) {
      std::printf("%s: %s: %s\n", outcome.image.c_str(),
                  std::string(reasonCode(outcome.detection.reason)).c_str(),
                  outcome.detection.detail.c_str());
    }
  }
  std::printf("%s: %d of %d whole, %d with corners, %d squares checked\n", set.name.c_str(), num_whole,
              set.num_images, num_with_corners, num_squares);
  EXPECT_GE(num_whole, set.min_whole);
  EXPECT_GE(num_with_corners, set.min_with_corners);
}

TEST(Photographs, CalibrateWithinTheirLimits) {
  const std::vector<PhotoSet> sets = setsThatAreThere();
  std::map<std::string, Calibration> by_set;
  for (const CalibrationCase& c : calibrationCases()) {
    const auto set =
        std::find_if(sets.begin(), sets.end(), [&](const PhotoSet& s) { return s.name == c.set; });
    if (set == sets.end()) continue;
    const Board board = parseBoardSpec(set->board);
    std::vector<View> views;
    for (const ImageOutcome& outcome : detectSet(*set)) {
      if (outcome.detection.hasCorners())
        views.push_back({outcome.image, outcome.size, outcome.detection.corners});
    }
    const Calibration result = calibrate(board, views, {.model = "radtan"});
    std::printf("%s: %zu views, RMS %.4f px, fx %.2f +- %.2f\n", c.set.c_str(), views.size(), rms(result.fit),
                onlyCamera(result.fit).params[0], result.uncertainty.parameterStdByNoise(0));
    EXPECT_EQ(result.fit.summary.termination, Termination::kConverged) << c.set;
    EXPECT_LE(rms(result.fit), c.max_rms_px) << c.set;
    EXPECT_NEAR(onlyCamera(result.fit).params[0], c.fx, c.fx_spread) << c.set;
    // The places of the board's points being known, corners are told from noise of a few hundredths of a
    // pixel.
    const std::size_t num_all = views.size() * static_cast<std::size_t>(board.numCorners());
    EXPECT_LE(result.dropped.outliers.size(), num_all / 500) << c.set;
    EXPECT_EQ(numCorners(result.fit) + result.dropped.outliers.size(), num_all) << c.set;
    by_set[c.set] = result;
  }
  // Two cameras looked at one board at the same moments, and agree on where its points are and how it is
  // bent.
  for (const std::string pair : {"opencv_", "bumblebee2_"}) {
    if (!by_set.contains(pair + "left") || !by_set.contains(pair + "right")) continue;
    const double correlation = offsetCorrelation(onlyBoard(by_set[pair + "left"].fit).shape,
                                                 onlyBoard(by_set[pair + "right"].fit).shape);
    std::printf("%s: the points of the board by two cameras correlate by %.3f\n", pair.c_str(), correlation);
    EXPECT_GT(correlation, 0.9) << pair;
  }
  if (!by_set.contains("opencv_left") || !by_set.contains("opencv_right")) return;
  const Calibration& left = by_set["opencv_left"];
  const Calibration& right = by_set["opencv_right"];
  ASSERT_TRUE(isShapeEstimated(left.fit) && isShapeEstimated(right.fit));
  const BoardShape& one = onlyBoard(left.fit).shape;
  const BoardShape& other = onlyBoard(right.fit).shape;
  const Eigen::Vector2d& std_m = left.uncertainty.bend_std_m.front();
  const Eigen::Vector2d& other_std_m = right.uncertainty.bend_std_m.front();
  EXPECT_LT(std::abs(one.bend_x_m - other.bend_x_m), 3 * std::hypot(std_m.x(), other_std_m.x()));
  EXPECT_LT(std::abs(one.bend_y_m - other.bend_y_m), 3 * std::hypot(std_m.y(), other_std_m.y()));
  // The views disagree by more than noise, so the sigma is that by the views.
  EXPECT_GT(std::abs(one.bend_y_m), 4 * std_m.y());
}

GrayImage cropOf(const GrayImage& image, int x0, int y0, int width, int height) {
  GrayImage out{.size = {.width = width, .height = height}, .pixels = {}};
  for (int y = 0; y < height; ++y) {
    const auto* row = image.pixels.data() + static_cast<std::ptrdiff_t>(y0 + y) * image.size.width + x0;
    out.pixels.insert(out.pixels.end(), row, row + width);
  }
  return out;
}

// Photographs, drawings and test patterns without a checkerboard, whole and in crops of all sizes; also grids
// that are none: circles, and tags with black squares at their corners.
TEST(Photographs, NoBoardIsFoundWhereThereIsNone) {
  std::vector<std::string> images;
  const auto add = [&](const std::string& folder) {
    if (!fs::exists(folder)) return;
    const std::vector<std::string> inputs = {folder};
    for (const std::string& path : listImages(inputs)) {
      const std::string name = fs::path(path).filename().string();
      const bool shows_board = name.starts_with("left") || name.starts_with("right") ||
                               name == "chessboard.png" || name == "tum_vi_with_chart.png";
      if (!shows_board) images.push_back(path);
    }
  };
  add(kOpencvData);
  add(publicData("aprilgrid_singles"));
  add(publicData("sony_circles/regular"));
  add(publicData("sony_circles/hexagonal"));
  if (images.empty()) GTEST_SKIP() << "no photographs on this machine";
  Random random(1);
  int num_crops = 0;
  int num_found = 0;
  // Where only some of the photographs are there, more is cut from each.
  constexpr int kMinCrops = 500;
  const int num_images = static_cast<int>(images.size());
  const int crops_per_image = std::max(10, (kMinCrops + num_images - 1) / num_images);
  for (const std::string& path : images) {
    const GrayImage image = readGrayImage(path).image;
    for (int k = 0; k < crops_per_image; ++k) {
      const auto part = [&](int side) {
        return std::max(16, static_cast<int>(side * random.uniform(0.2, 1.0)));
      };
      const int width = k == 0 ? image.size.width : std::min(image.size.width, part(image.size.width));
      const int height = k == 0 ? image.size.height : std::min(image.size.height, part(image.size.height));
      const int x0 = static_cast<int>(random.index(static_cast<std::uint64_t>(image.size.width - width + 1)));
      const int y0 =
          static_cast<int>(random.index(static_cast<std::uint64_t>(image.size.height - height + 1)));
      const GrayImage crop = cropOf(image, x0, y0, width, height);
      for (const auto& [columns, rows] : std::vector<std::pair<int, int>>{{9, 6}, {4, 6}, {5, 4}, {3, 3}}) {
        const Detection detection =
            findBoard(crop, Checkerboard{.columns = columns, .rows = rows, .square_m = 0.025});
        if (!detection.hasCorners()) continue;
        ++num_found;
        ADD_FAILURE() << path << " crop " << x0 << "," << y0 << " " << width << "x" << height << ": "
                      << columns << "x" << rows << " " << reasonCode(detection.reason);
      }
      ++num_crops;
    }
  }
  std::printf("%d crops of %zu images, %d false detections\n", num_crops, images.size(), num_found);
  EXPECT_GE(num_crops, kMinCrops);
}

// Left's camera by every other photograph, tested on the others and on those of the right camera.
TEST(Photographs, TellOneCameraFromAnother) {
  const auto viewsOf = [](const std::string& name) {
    std::vector<View> views;
    for (const PhotoSet& set : setsThatAreThere()) {
      if (set.name != name) continue;
      for (const ImageOutcome& outcome : detectSet(set))
        views.push_back({outcome.image, outcome.size, outcome.detection.corners});
    }
    return views;
  };
  const std::vector<View> left = viewsOf("opencv_left");
  const std::vector<View> right = viewsOf("opencv_right");
  if (left.empty() || right.empty()) GTEST_SKIP() << "no photographs of opencv-doc";
  const Board board = parseBoardSpec("checkerboard:9x6:25mm");
  int num_checked = 0;
  for (const std::size_t first : {0u, 1u}) {
    std::vector<View> halves[2];
    for (std::size_t i = 0; i < left.size(); ++i) halves[(i + first) % 2].push_back(left[i]);
    const Calibration half = calibrate(board, halves[0], {.model = "radtan"});
    const AnyCamera halves_camera = half.camera();
    const ComparedCamera camera{&halves_camera, half.imageSize(), half.uncertainty.statedCovariance()};
    const HeldOutOptions options{.is_covariance_by_views = half.uncertainty.isNoiseExceeded()};
    for (const Diagnosis& check :
         heldOutChecks(judgeOnImages(camera, board, halves[1], options), kDefaultTolerancePx))
      EXPECT_NE(check.severity, Severity::kFailure) << check.id << ": " << check.cause;
    const auto on_right = heldOutChecks(judgeOnImages(camera, board, right, options), kDefaultTolerancePx);
    EXPECT_EQ(on_right.at(1).id, "images_agree");
    EXPECT_EQ(on_right.at(1).severity, Severity::kFailure) << on_right.at(1).cause;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 2);
}

}  // namespace
}  // namespace alidade

// Without any photograph nothing was tested, and "skipped" says so.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const int result = RUN_ALL_TESTS();
  constexpr int kSkipped = 77;
  return result == 0 && alidade::setsThatAreThere().empty() ? kSkipped : result;
}
