// SPDX-License-Identifier: MIT
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <nlohmann/json.hpp>

#include "alidade/files/corners_file.h"
#include "alidade/files/formats/alidade_writer.h"
#include "apps/command_line.h"
#include "apps/rig_support.h"
#include "support/folder_content.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// What a camera sees of a sky that has a grey level for each direction.
cv::Mat skyOf(const MountedCamera& camera) {
  cv::Mat image(camera.image_size.height, camera.image_size.width, CV_8UC1, cv::Scalar(0));
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const auto ray = camera.camera.unproject(Eigen::Vector2d(x, y));
      if (!ray) continue;
      const Eigen::Vector3d d = camera.camera_from_rig.rotation.inverse() * *ray;
      image.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(std::lround(128 + 50 * std::sin(9 * d.x()) + 50 * std::sin(8 * d.y())));
    }
  }
  return image;
}

class RigRectify : public testing::Test {
 protected:
  RigRectify() {
    scratch_.write("rig.yaml", rigFileText(pairOfCameras()));
    for (const MountedCamera& camera : rig_.cameras()) {
      scratch_.makeFolder(camera.name);
      EXPECT_TRUE(cv::imwrite(scratch_.path(camera.name + "/sky.png"), skyOf(camera)));
    }
  }
  [[nodiscard]] RunResult rectify(std::vector<std::string> more, bool has_images = true) const {
    std::vector<std::string> args = {"rig", "rectify", scratch_.path("rig.yaml")};
    if (has_images) args.insert(args.end(), {scratch_.path("left"), scratch_.path("right")});
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  }
  // Corners of boards in front of the rig as both cameras see them, those of the right one with other numbers
  // where the board is turned.
  void writeCorners(double noise_px) const {
    const Board board = Checkerboard{.columns = 8, .rows = 6, .square_m = 0.03};
    std::array<CornersFile, 2> files;
    for (int k = 0; k < 4; ++k) {
      const SE3 rig_from_board{SO3::exp(Eigen::Vector3d(0.3 * k, 0.4 - 0.2 * k, 0.1)),
                               Eigen::Vector3d(-0.1 + 0.05 * k, -0.1, 0.7)};
      for (std::size_t i = 0; i < 2; ++i) {
        View view{.image = "frame" + std::to_string(k) + ".png", .size = {640, 480}};
        for (int id = 0; id < 48; ++id) {
          const int seen = i == 1 && k % 2 == 1 ? 47 - id : id;
          Eigen::Vector2d pixel = rig_.project(i, rig_from_board * board.corner(seen)).pixel;
          pixel.y() += noise_px * (id % 2 == 0 ? 1 : -1) * (i == 0 ? 1 : -1);
          view.corners.push_back({.id = id, .pixel = pixel});
        }
        files[i].boards = {board};
        files[i].views.push_back(std::move(view));
      }
    }
    writeCornersFile(scratch_.path("left.csv"), files[0]);
    writeCornersFile(scratch_.path("right.csv"), files[1]);
  }

  ScratchFolder scratch_;
  AnyRig rig_ = rigOf(pairOfCameras());
};

TEST_F(RigRectify, MakesBothImagesOfDistantThingsAlike) {
  int num_checked = 0;
  for (const std::string projection : {"rectilinear", "cylindrical", "equirectangular"}) {
    const RunResult run = rectify({"-o", scratch_.path("out"), "--projection", projection, "--overwrite"});
    ASSERT_THAT(run, EndsWith(0));
    EXPECT_THAT(run.out, AllOf(HasSubstr("1 of 1 and 1 of 1 images; " + projection + ", 640x480 px"),
                               HasSubstr("Baseline  120.")));
    const cv::Mat left = cv::imread(scratch_.path("out/left/sky.png"), cv::IMREAD_UNCHANGED);
    const cv::Mat right = cv::imread(scratch_.path("out/right/sky.png"), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(left.size(), cv::Size(640, 480));
    ASSERT_EQ(right.size(), left.size());
    cv::Mat shown;
    cv::min(left, right, shown);
    const cv::Mat both = shown > 0;
    cv::Mat difference;
    cv::absdiff(left, right, difference);
    EXPECT_GT(cv::countNonZero(both), 640 * 480 / 2) << projection;
    double largest = 0;
    cv::minMaxLoc(difference, nullptr, &largest, nullptr, nullptr, both);
    EXPECT_LE(largest, 3) << projection;
    // Without rectification they are not alike.
    cv::absdiff(left, skyOf(rig_.camera(0)), difference);
    EXPECT_GT(cv::mean(difference)[0], 1);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

TEST_F(RigRectify, WritesTheRectifiedRig) {
  ASSERT_THAT(rectify({"-o", scratch_.path("out"), "--keep", "valid", "--size", "400x300", "--maps"}),
              EndsWith(0));
  const RigRecord record = loadRig(scratch_.path("out/rig.yaml"));
  ASSERT_EQ(record.cameras.size(), 2u);
  for (const RigCameraRecord& camera : record.cameras) {
    EXPECT_EQ(camera.camera.camera.modelId(), "pinhole");
    EXPECT_EQ(camera.camera.image_size, (ImageSize{400, 300}));
    EXPECT_THAT(camera.camera.camera.parameters(),
                testing::ElementsAreArray(record.cameras[0].camera.camera.parameters()));
    EXPECT_EQ(camera.camera_from_rig.rotation.log().norm(), 0);
  }
  const double baseline = pairOfCameras().cameras[1].camera_from_rig.translation.norm();
  EXPECT_NEAR(record.cameras[1].camera_from_rig.translation.x(), -baseline, 1e-12);
  EXPECT_EQ(record.cameras[1].camera_from_rig.translation.tail<2>().norm(), 0);
  const auto content = contentOf(scratch_.path("out"));
  for (const char* name :
       {"rig.yaml", "rectification.yaml", "left/sky.png", "right/sky.png", "left_map_x.tiff",
        "left_map_y.tiff", "right_map_x.tiff", "right_map_y.tiff", ".alidade_result"})
    EXPECT_TRUE(content.contains(name)) << name;
  // The maps are those of the images.
  const auto map = [&](const char* name) {
    return cv::imread(scratch_.path("out/" + std::string(name)), cv::IMREAD_UNCHANGED);
  };
  cv::Mat remapped;
  cv::remap(cv::imread(scratch_.path("right/sky.png"), cv::IMREAD_UNCHANGED), remapped,
            map("right_map_x.tiff"), map("right_map_y.tiff"), cv::INTER_LINEAR);
  EXPECT_EQ(cv::norm(remapped, map("right/sky.png"), cv::NORM_INF), 0);
  // A rectified rig is a rig: points come back from rows.
  scratch_.write("pixels.csv", "id,camera,u,v\na,left,210,140\na,right,180,140\n");
  const RunResult points = runAlidade({"rig", "triangulate", scratch_.path("out/rig.yaml"),
                                       scratch_.path("pixels.csv"), "--json", "--quiet"});
  ASSERT_THAT(points, EndsWith(0));
  const double focal = record.cameras[0].camera.camera.parameter("fx");
  EXPECT_NEAR(nlohmann::json::parse(points.out).at("points").at(0).at("z").get<double>(),
              focal * baseline / 30, 1e-9);
}

TEST_F(RigRectify, WritesOneJsonDocument) {
  const RunResult run = rectify({"--camera-only", "-o", scratch_.path("out"), "--json"}, false);
  ASSERT_THAT(run, EndsWith(0));
  const auto document = nlohmann::json::parse(run.out);
  EXPECT_EQ(document.at("direction"), "horizontal");
  const double focal = document.at("scale_px").get<double>();
  const double baseline = document.at("baseline_m").get<double>();
  EXPECT_EQ(document.at("Q").at(3).at(2).get<double>(), 1 / baseline);
  EXPECT_EQ(document.at("cameras").at(1).at("P").at(0).at(3).get<double>(), -focal * baseline);
  EXPECT_EQ(document.at("cameras").at(0).at("R").size(), 3u);
  EXPECT_EQ(document.at("cameras").at(0).at("name"), "left");
  EXPECT_TRUE(document.at("epipolar_errors").is_null());
  EXPECT_TRUE(contentOf(scratch_.path("out")).contains("rig.yaml"));
  // The other way round.
  const RunResult back =
      rectify({"--camera-only", "-o", scratch_.path("back"), "--cameras", "right,left"}, false);
  EXPECT_THAT(back, EndsWith(0));
  EXPECT_THAT(back.err, HasSubstr("disparities are negative; --cameras left,right"));
}

TEST_F(RigRectify, MeasuresTheErrorsOfRows) {
  const std::vector<std::string> args = {
      "rig",   "rectify", scratch_.path("rig.yaml"), scratch_.path("left.csv"), scratch_.path("right.csv"),
      "--json"};
  writeCorners(0);
  const RunResult exact = runAlidade(args);
  ASSERT_THAT(exact, EndsWith(0));
  const auto none = nlohmann::json::parse(exact.out).at("epipolar_errors");
  EXPECT_EQ(none.at("num_boards"), 4);
  EXPECT_EQ(none.at("num_corners"), 4 * 48);
  EXPECT_EQ(none.at("num_shown"), 4 * 48);
  EXPECT_LT(none.at("row_max_px").get<double>(), 1e-6);
  EXPECT_LT(none.at("curve_rms_px").get<double>(), 1e-6);
  EXPECT_TRUE(nlohmann::json::parse(exact.out).at("folder").is_null());
  writeCorners(0.1);
  const RunResult noisy = runAlidade(args);
  ASSERT_THAT(noisy, EndsWith(0));
  const auto some = nlohmann::json::parse(noisy.out).at("epipolar_errors");
  // 0.1 px up in one and down in the other; the right camera's pixels are larger than those of its rows.
  EXPECT_GT(some.at("row_rms_px").get<double>(), 0.15);
  EXPECT_LT(some.at("row_rms_px").get<double>(), 0.35);
  EXPECT_GT(some.at("curve_rms_px").get<double>(), 0.1);
}

// Inputs with the names of the cameras are assigned by them; rows that differ are warned of.
TEST_F(RigRectify, WarnsOfRowsThatDiffer) {
  writeCorners(0);
  const auto measure = [&](const std::string& first, const std::string& second,
                           std::vector<std::string> more) {
    std::vector<std::string> args = {"rig", "rectify", scratch_.path("rig.yaml"), scratch_.path(first),
                                     scratch_.path(second)};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  };
  const RunResult sorted = measure("right.csv", "left.csv", {"--json"});
  EXPECT_THAT(sorted, EndsWith(0));
  EXPECT_THAT(sorted.err, HasSubstr("assigned to the cameras by their names"));
  const auto document = nlohmann::json::parse(sorted.out);
  EXPECT_LT(document.at("epipolar_errors").at("row_max_px").get<double>(), 1e-6);
  EXPECT_TRUE(document.at("warnings").empty());
  // The same under names that say nothing.
  scratch_.write("1.csv", scratch_.read("right.csv"));
  scratch_.write("2.csv", scratch_.read("left.csv"));
  const RunResult swapped = measure("1.csv", "2.csv", {});
  EXPECT_THAT(swapped.err, AllOf(HasSubstr("warning: rows differ by RMS "), HasSubstr("--tolerance 1 px")));
  writeCorners(0.1);
  EXPECT_THAT(measure("left.csv", "right.csv", {}).err, Not(HasSubstr("warning")));
  EXPECT_THAT(measure("left.csv", "right.csv", {"--tolerance", "0.1px"}).err,
              HasSubstr("warning: rows differ"));
}

TEST_F(RigRectify, MatchesImagesByATable) {
  writeCorners(0);
  std::string renamed = scratch_.read("right.csv");
  for (const char* number : {"0", "1", "2", "3"}) {
    const std::string from = "frame" + std::string(number);
    for (std::size_t at = renamed.find(from); at != std::string::npos; at = renamed.find(from, at + 1))
      renamed.replace(at, from.size(), "image" + std::string(number) + "7");
  }
  scratch_.write("right.csv", renamed);
  scratch_.write("frames.csv", "left,right\nframe0.png,image07.png\nframe2.png,image27.png\n");
  const std::vector<std::string> args = {"rig",
                                         "rectify",
                                         scratch_.path("rig.yaml"),
                                         scratch_.path("left.csv"),
                                         scratch_.path("right.csv"),
                                         "--match",
                                         scratch_.path("frames.csv"),
                                         "--json"};
  const RunResult run = runAlidade(args);
  ASSERT_THAT(run, EndsWith(0));
  const auto errors = nlohmann::json::parse(run.out).at("epipolar_errors");
  EXPECT_EQ(errors.at("num_boards"), 2);
  EXPECT_LT(errors.at("row_max_px").get<double>(), 1e-6);
  EXPECT_THAT(rectify({"-o", scratch_.path("out"), "--match", scratch_.path("frames.csv")}),
              FailsWith(2, HasSubstr("neither --board nor corners files")));
}

TEST_F(RigRectify, TellsThatARigWasRejected) {
  RigRecord rejected = pairOfCameras();
  rejected.verdict = Verdict::kNo;
  rejected.findings = {"camera_moved"};
  scratch_.write("rig.yaml", rigFileText(rejected));
  const std::string note =
      "rig.yaml says of itself that it must not be used (verdict: rejected; camera_moved)";
  const RunResult run = rectify({"--camera-only", "-o", scratch_.path("out")}, false);
  EXPECT_THAT(run, EndsWith(0));
  EXPECT_THAT(run.err, HasSubstr("note: " + scratch_.path() + "/" + note));
  scratch_.write("pixels.csv", "id,camera,u,v\np,left,320,240\np,right,250,238\n");
  const std::vector<std::string> args = {"rig", "triangulate", scratch_.path("rig.yaml"),
                                         scratch_.path("pixels.csv")};
  EXPECT_THAT(runAlidade(args).err, HasSubstr(note));
}

TEST_F(RigRectify, SaysWhatIsWrong) {
  const std::string out = scratch_.path("out");
  EXPECT_THAT(runAlidade({"rig", "rectify"}), FailsWith(2, HasSubstr("no rig file")));
  EXPECT_THAT(rectify({}), FailsWith(2, HasSubstr("-o FOLDER")));
  EXPECT_THAT(rectify({"-o", out}, false), FailsWith(2, HasSubstr("0 inputs")));
  EXPECT_THAT(rectify({"-o", out, "--cameras", "left"}), FailsWith(2, HasSubstr("two, given as --cameras")));
  EXPECT_THAT(rectify({"-o", out, "--cameras", "left,rigt"}),
              FailsWith(2, HasSubstr("did you mean 'right'?")));
  EXPECT_THAT(rectify({"-o", out, "--cameras", "left,left"}),
              FailsWith(2, HasSubstr("two different cameras")));
  EXPECT_THAT(rectify({"-o", out, "--fov", "160"}), FailsWith(2, HasSubstr("150 degrees")));
  EXPECT_THAT(rectify({"-o", out, "--fov", "60", "--keep", "all"}),
              FailsWith(2, HasSubstr("--fov and --keep")));
  EXPECT_THAT(rectify({"-o", scratch_.path("left")}), FailsWith(2, HasSubstr("the folder of the input")));
  writeCorners(0);
  EXPECT_THAT(runAlidade({"rig", "rectify", scratch_.path("rig.yaml"), scratch_.path("left.csv"),
                          scratch_.path("right"), "-o", out}),
              FailsWith(2, HasSubstr("a corners file beside images")));
  EXPECT_THAT(runAlidade({"rig", "rectify", dataPath("camera.yaml"), "--camera-only", "-o", out}),
              FailsWith(1, HasSubstr("rig calibrate")));
  EXPECT_FALSE(scratch_.has("out"));
  // Images of another size are skipped.
  ASSERT_TRUE(cv::imwrite(scratch_.path("right/small.png"), cv::Mat(10, 10, CV_8UC1, cv::Scalar(7))));
  const RunResult some = rectify({"-o", out});
  EXPECT_THAT(some, EndsWith(1));
  EXPECT_THAT(some.err, AllOf(HasSubstr("1 of 2 images were skipped"), HasSubstr("small.png")));
  EXPECT_THAT(rectify({"-o", out}), FailsWith(1, HasSubstr("out")));
  EXPECT_THAT(rectify({"-o", out, "--overwrite", "--quiet"}).err, Not(HasSubstr("note")));
}

}  // namespace
}  // namespace alidade
