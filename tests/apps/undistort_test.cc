// SPDX-License-Identifier: MIT
#include <cmath>
#include <csignal>
#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/files/camera_source.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A camera for images of 160x120, with barrel distortion.
constexpr const char* kLens =
    "alidade_camera: 1\n"
    "model: radtan\n"
    "image_size: {width: 160, height: 120}\n"
    "parameters: {fx: 130, fy: 131, cx: 80, cy: 59, k1: -0.28, k2: 0.08, p1: 0, p2: 0, k3: 0}\n";

// A smooth pattern with channels of their own.
cv::Mat pattern(int type, int width = 160, int height = 120) {
  cv::Mat image(height, width, type);
  const int num_channels = image.channels();
  for (int y = 0; y < height; ++y) {
    for (int i = 0; i < width * num_channels; ++i) {
      const int value = 20 + 40 * (i % num_channels) + i / num_channels / 2 + y / 4;
      if (image.depth() == CV_16U) {
        image.ptr<std::uint16_t>(y)[i] = static_cast<std::uint16_t>(200 * value + 17);
      } else {
        image.ptr<std::uint8_t>(y)[i] = static_cast<std::uint8_t>(value);
      }
    }
  }
  return image;
}

class Undistort : public testing::Test {
 protected:
  Undistort() {
    scratch.write("camera.yaml", kLens);
    scratch.makeFolder("photos");
  }

  void writePhoto(const std::string& name, const cv::Mat& image) const {
    ASSERT_TRUE(cv::imwrite(scratch.path("photos/" + name), image));
  }
  [[nodiscard]] RunResult undistort(const std::vector<std::string>& more, const std::string& input = "photos",
                                    const std::string& output = "out") const {
    std::vector<std::string> args = {"undistort", scratch.path("camera.yaml"), scratch.path(input), "-o",
                                     scratch.path(output)};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  }
  [[nodiscard]] cv::Mat result(const std::string& name) const {
    return cv::imread(scratch.path("out/" + name), cv::IMREAD_UNCHANGED);
  }

  ScratchFolder scratch;
};

// What a pixel shows of pattern(), by the camera alone.
double expectedLevel(const AnyCamera& source, const AnyCamera& view, int x, int y, int channel) {
  const Projection p = source.project(view.unproject({x, y}).value());
  EXPECT_TRUE(p.ok());
  // Halves and quarters of coordinates are rounded down in the pattern, by up to 1/2 and 3/4 level.
  return 20 + 40 * channel + p.pixel.x() / 2 - 0.25 + p.pixel.y() / 4 - 0.375;
}

TEST_F(Undistort, KeepsColorsBitsAndKindsOfFiles) {
  writePhoto("gray.png", pattern(CV_8UC1));
  writePhoto("color.bmp", pattern(CV_8UC3));
  writePhoto("alpha.png", pattern(CV_8UC4));
  writePhoto("deep.tiff", pattern(CV_16UC3));
  writePhoto("photo.JPG", pattern(CV_8UC3));
  const RunResult run = undistort({"--keep", "valid"});
  ASSERT_THAT(run, EndsWith(0));
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("5 of 5 images; rectilinear, 160x120 px"), HasSubstr(" 0 % of the pixels")));
  EXPECT_EQ(run.err, "");
  const CameraRecord file = loadCamera(scratch.path("out/camera.yaml"));
  EXPECT_EQ(file.camera.modelId(), "pinhole");
  EXPECT_EQ(file.self_check.size(), 9u);
  const AnyCamera source = onlyCamera(parseCameras(kLens, "lens")).camera;
  struct Case {
    std::string name;
    int type;
    double scale;
    double offset;
    double tolerance;
  };
  int num_files = 0;
  for (const Case& c : {Case{"gray.png", CV_8UC1, 1, 0, 1.3}, Case{"color.png", CV_8UC3, 1, 0, 1.3},
                        Case{"alpha.png", CV_8UC4, 1, 0, 1.3}, Case{"deep.png", CV_16UC3, 200, 17, 1.0},
                        Case{"photo.JPG", CV_8UC3, 1, 0, 5}}) {
    const cv::Mat image = result(c.name);
    ASSERT_EQ(image.type(), c.type) << c.name;
    ASSERT_EQ(image.size(), cv::Size(160, 120));
    double worst = 0;
    for (int y = 3; y < 120; y += 9) {
      for (int x = 3; x < 160; x += 11) {
        for (int channel = 0; channel < image.channels(); ++channel) {
          const int at = x * image.channels() + channel;
          const double value =
              image.depth() == CV_16U ? image.ptr<std::uint16_t>(y)[at] : image.ptr<std::uint8_t>(y)[at];
          worst = std::max(worst, std::abs((value - c.offset) / c.scale -
                                           expectedLevel(source, file.camera, x, y, channel)));
        }
      }
    }
    EXPECT_LT(worst, c.tolerance) << c.name;
    ++num_files;
  }
  EXPECT_EQ(num_files, 5);
  EXPECT_THAT(runAlidade({"validate", scratch.path("out/camera.yaml")}), EndsWith(0));
}

TEST_F(Undistort, MakesTheSameBytesForAnyNumberOfThreads) {
  writePhoto("a.png", pattern(CV_8UC3));
  writePhoto("b.png", pattern(CV_8UC1));
  ASSERT_THAT(undistort({"--jobs", "1", "--interpolation", "cubic"}, "photos", "one"), EndsWith(0));
  ASSERT_THAT(undistort({"--jobs", "3", "--interpolation", "cubic"}, "photos", "three"), EndsWith(0));
  int num_same = 0;
  for (const std::string name : {"a.png", "b.png", "camera.yaml"}) {
    ASSERT_TRUE(scratch.has("one/" + name));
    EXPECT_EQ(scratch.read("one/" + name), scratch.read("three/" + name)) << name;
    ++num_same;
  }
  EXPECT_EQ(num_same, 3);
}

TEST_F(Undistort, ReplacesOnlyWhatItMade) {
  writePhoto("a.png", pattern(CV_8UC1));
  ASSERT_THAT(undistort({}), EndsWith(0));
  const auto made = scratch.list();
  const std::string image = scratch.read("out/a.png");
  EXPECT_THAT(undistort({"--fov", "50"}),
              FailsWith(1, AllOf(HasSubstr("a new or empty folder"), HasSubstr("--overwrite"))));
  EXPECT_EQ(scratch.read("out/a.png"), image);
  ASSERT_THAT(undistort({"--fov", "50", "--overwrite"}), EndsWith(0));
  EXPECT_NE(scratch.read("out/a.png"), image);
  EXPECT_EQ(scratch.list(), made);
  ASSERT_THAT(undistort({"--projection", "cylindrical", "--overwrite"}), EndsWith(0));
  EXPECT_FALSE(scratch.has("out/camera.yaml")) << "of the earlier images";
  EXPECT_TRUE(scratch.has("out/projection.yaml"));

  scratch.write("out/notes.txt", "precious");
  const auto before = scratch.list();
  EXPECT_THAT(undistort({"--overwrite"}), FailsWith(1, HasSubstr("notes.txt")));
  EXPECT_EQ(scratch.list(), before);
}

// A folder with copies of the photographs looks like a result by its names.
TEST_F(Undistort, DoesNotReplaceCopiesOfItsInputs) {
  writePhoto("a.png", pattern(CV_8UC1));
  const std::string photo = scratch.read("photos/a.png");
  scratch.write("backup/a.png", photo);
  EXPECT_THAT(undistort({"--overwrite"}, "photos", "backup"), FailsWith(1, HasSubstr("a.png")));
  scratch.write("backup/camera.yaml", kLens);
  EXPECT_THAT(undistort({"--overwrite"}, "photos", "backup"), FailsWith(1, HasSubstr("choose another name")));
  EXPECT_EQ(scratch.read("backup/a.png"), photo);
}

TEST_F(Undistort, RefusesTheFolderOfItsInputs) {
  writePhoto("a.png", pattern(CV_8UC1));
  std::filesystem::create_symlink(scratch.path("photos"), scratch.path("link"));
  scratch.makeFolder("elsewhere");
  std::filesystem::create_symlink(scratch.path("photos/a.png"), scratch.path("elsewhere/linked.png"));
  const auto before = scratch.list();
  struct Case {
    std::string input;
    std::string output;
  };
  int num_refused = 0;
  for (const Case& c :
       {Case{"photos", "photos"}, Case{"photos/a.png", "photos/../photos/"}, Case{"photos", "link"},
        Case{"link", "photos"}, Case{"elsewhere/linked.png", "photos"}, Case{"elsewhere", "elsewhere"}}) {
    EXPECT_THAT(undistort({"--overwrite"}, c.input, c.output),
                FailsWith(2, AllOf(HasSubstr("--output"), HasSubstr("folder of the input"))))
        << c.input << " " << c.output;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 6);
  // The camera file is an input too.
  scratch.write("calibration/camera.yaml", kLens);
  EXPECT_THAT(runAlidade({"undistort", scratch.path("calibration/camera.yaml"), scratch.path("photos"), "-o",
                          scratch.path("calibration"), "--overwrite"}),
              FailsWith(2, HasSubstr("folder of the input")));
  EXPECT_EQ(scratch.read("calibration/camera.yaml"), kLens);
  EXPECT_EQ(scratch.list().size(), before.size() + 2);
  // Below the images' folder is no place of an image.
  EXPECT_THAT(undistort({}, "photos", "photos/undistorted"), EndsWith(0));
}

TEST_F(Undistort, LeavesOutImagesThatAreNotTheCameras) {
  writePhoto("a.png", pattern(CV_8UC1));
  writePhoto("turned.png", pattern(CV_8UC1, 120, 160));
  scratch.write("photos/text.png", "this is no image\n");
  const RunResult run = undistort({"--quiet"});
  EXPECT_THAT(run, EndsWith(1));
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, AllOf(HasSubstr("turned.png: the image size is 120x160 pixels; expected 160x120"),
                             HasSubstr("text.png"), HasSubstr("2 of 3 images were skipped")));
  EXPECT_TRUE(scratch.has("out/a.png"));
  EXPECT_TRUE(scratch.has("out/camera.yaml"));
  EXPECT_FALSE(scratch.has("out/turned.png"));

  EXPECT_THAT(undistort({}, "photos/turned.png", "none"), FailsWith(1, HasSubstr("120x160")));
  EXPECT_THAT(undistort({}, "photos/t*.png", "none"),
              FailsWith(1, AllOf(HasSubstr("2 images: none of them can be used; the first error: "),
                                 HasSubstr("\n  next: "))));
  EXPECT_FALSE(scratch.has("none"));
}

TEST_F(Undistort, TellsImagesOfOneNameApart) {
  writePhoto("a.png", pattern(CV_8UC1));
  writePhoto("a.bmp", pattern(CV_8UC1));
  writePhoto("a.jpg", pattern(CV_8UC1));
  scratch.makeFolder("photos/more");
  writePhoto("more/a.png", pattern(CV_8UC1));
  const RunResult run = runAlidade({"undistort", scratch.path("camera.yaml"), scratch.path("photos"),
                                    scratch.path("photos/more"), "-o", scratch.path("out")});
  ASSERT_THAT(run, EndsWith(0));
  std::vector<std::string> names;
  for (const std::string& name : scratch.list()) {
    if (name.starts_with("out/")) names.push_back(name.substr(4));
  }
  EXPECT_THAT(names,
              ElementsAre(".alidade_result", "a.bmp.png", "a.jpg", "a.png.png", "camera.yaml", "more_a.png"));
}

TEST_F(Undistort, WritesOneJsonDocument) {
  writePhoto("a.png", pattern(CV_8UC1));
  writePhoto("b.png", pattern(CV_8UC1, 10, 10));
  const RunResult run = undistort({"--json", "--keep", "all", "--size", "200x150"});
  EXPECT_THAT(run, EndsWith(1));
  const auto document = nlohmann::json::parse(run.out);
  EXPECT_EQ(document.at("projection"), "rectilinear");
  EXPECT_EQ(document.at("image_size").at("width"), 200);
  EXPECT_EQ(document.at("share_cut"), 0);
  EXPECT_GT(document.at("share_without_source").get<double>(), 0);
  ASSERT_EQ(document.at("images").size(), 2u);
  EXPECT_EQ(document.at("images")[0].at("output"), "a.png");
  EXPECT_EQ(document.at("images")[1].at("written"), false);
  EXPECT_THAT(document.at("images")[1].at("reason").get<std::string>(), HasSubstr("10x10"));
  const CameraRecord file = loadCamera(scratch.path("out/camera.yaml"));
  EXPECT_EQ(file.image_size, (ImageSize{200, 150}));
  EXPECT_EQ(document.at("focal_px")[0].get<double>(), file.camera.parameters()[0]);
  EXPECT_EQ(result("a.png").size(), cv::Size(200, 150));
}

TEST_F(Undistort, DescribesProjectionsThatNoCameraFileDoes) {
  writePhoto("a.png", pattern(CV_8UC3));
  int num_projections = 0;
  for (const std::string name : {"cylindrical", "equirectangular"}) {
    const RunResult run = undistort({"--projection", name, "--fov", "60"}, "photos", name);
    ASSERT_THAT(run, EndsWith(0));
    EXPECT_THAT(run.out, HasSubstr(name + ", 160x120 px, 60.0 degrees wide"));
    const std::string file = scratch.read(name + "/projection.yaml");
    EXPECT_THAT(file, HasSubstr("\nprojection: " + name + "\n"));
    const std::string key = "\nradians_per_pixel: ";
    ASSERT_THAT(file, HasSubstr(key));
    EXPECT_NEAR(std::stod(file.substr(file.find(key) + key.size())), (60 * M_PI / 180) / 160, 1e-15);
    EXPECT_FALSE(scratch.has(name + "/camera.yaml"));
    ++num_projections;
  }
  EXPECT_EQ(num_projections, 2);
}

TEST_F(Undistort, CanWriteTheCameraAlone) {
  const RunResult run = runAlidade({"undistort", scratch.path("camera.yaml"), "--camera-only", "--fov", "70",
                                    "--size", "1000x500", "-o", scratch.path("out")});
  ASSERT_THAT(run, EndsWith(0));
  EXPECT_THAT(run.out, HasSubstr("no images; rectilinear, 1000x500 px, 70.0 degrees wide"));
  const auto parameters = parametersOf(scratch.read("out/camera.yaml"));
  ASSERT_EQ(parameters.size(), 4u);
  EXPECT_NEAR(parameters[0], 500 / std::tan(35 * M_PI / 180), 1e-9);
  EXPECT_EQ(parameters[2], 499.5);
  EXPECT_EQ(scratch.list().size(), 5u);  // camera.yaml, photos, out, out/camera.yaml, its list
}

TEST_F(Undistort, RefusesWrongUsage) {
  writePhoto("a.png", pattern(CV_8UC1));
  struct Case {
    std::vector<std::string> flags;
    std::string message;
  };
  int num_refused = 0;
  for (const Case& c :
       {Case{{"--fov", "60", "--keep", "all"}, "--fov and --keep"},
        Case{{"--fov", "170"}, "at most 150 degrees"}, Case{{"--fov", "nan"}, "a finite number"},
        Case{{"--keep", "some"}, "some"}, Case{{"--projection", "fisheye"}, "rectilinear"},
        Case{{"--interpolation", "nearest"}, "cubic"}, Case{{"--size", "640"}, "WIDTHxHEIGHT"},
        Case{{"--size", "0x480"}, "WIDTHxHEIGHT"}, Case{{"--size", "1x480"}, "sides of 2 to"}}) {
    EXPECT_THAT(undistort(c.flags), FailsWith(2, HasSubstr(c.message))) << testing::PrintToString(c.flags);
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 9);
  EXPECT_FALSE(scratch.has("out"));
}

TEST_F(Undistort, LeavesNothingBehindWhenInterrupted) {
  const cv::Mat image = pattern(CV_8UC3);
  writePhoto("0.png", image);
  for (int i = 1; i <= 400; ++i)
    std::filesystem::create_hard_link(scratch.path("photos/0.png"),
                                      scratch.path(fmt::format("photos/{}.png", i)));
  const auto before = scratch.list();
  // Large outputs, so that it is at work for seconds.
  RunningProgram program(
      alidadeProgram(),
      {"undistort", scratch.path("camera.yaml"), scratch.path("photos"), "-o", scratch.path("out"), "--jobs",
       "1", "--size", "1600x1200", "--interpolation", "cubic"},
      {.time_limit = std::chrono::seconds(30)});
  ASSERT_TRUE(program.waitUntilItCatches(SIGINT));
  program.sendSignal(SIGINT);
  const RunResult run = program.wait();
  EXPECT_EQ(run.signal, SIGINT) << "exit code " << run.exit_code;
  EXPECT_EQ(run.err, "interrupted; no result was written\n");
  EXPECT_EQ(scratch.list(), before);
}

}  // namespace
}  // namespace alidade
