// SPDX-License-Identifier: MIT
// Videos and image sequences as inputs.
#include <regex>
#include <set>

#include <opencv2/imgcodecs.hpp>

#include "alidade/files/corners_file.h"
#include "apps/command_line.h"
#include "apps/report_page.h"
#include "imagery/video_files.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The images of testdata/, each shown for a while, with a frame of motion blur before the next one.
std::vector<cv::Mat> boardFrames(int num_images, int num_each) {
  std::vector<cv::Mat> frames;
  for (int i = 1; i <= num_images; ++i) {
    const cv::Mat image = cv::imread(imagePath(i), cv::IMREAD_GRAYSCALE);
    for (int k = 0; k < num_each; ++k) frames.push_back(image);
    cv::Mat blurred;
    cv::blur(image, blurred, {40, 1});
    frames.push_back(blurred);
  }
  return frames;
}

TEST(Video, GivesTheCornersOfItsImages) {
  const ScratchFolder scratch;
  const std::string clip = writeVideo(scratch.path("clip.avi"), boardFrames(12, 5));
  const RunResult result = runAlidade({"detect", clip, "--board", kBoardSpec, "--frames", "20"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.err, HasSubstr("of 72 frames are searched"));
  const CornersFile found = parseCornersFile(result.out, "found");
  const CornersFile truth = readCornersFile(dataPath("corners.csv"));
  constexpr double kWorstPx = 0.5;  // the video is compressed
  std::set<std::size_t> images;
  for (const View& view : found.views) {
    const std::size_t number = std::stoul(view.image.substr(view.image.find('@') + 1));
    const View& expected = truth.views.at(number / 6);
    EXPECT_TRUE(images.insert(number / 6).second) << view.image;  // once each
    ASSERT_EQ(view.corners.size(), 54u);
    for (std::size_t i = 0; i < view.corners.size(); ++i)
      EXPECT_LT((view.corners[i].pixel - expected.corners[i].pixel).norm(), kWorstPx);
  }
  EXPECT_EQ(images.size(), 12u);
  EXPECT_EQ(runAlidade({"detect", clip, "--board", kBoardSpec, "--frames", "20", "--jobs", "2"}).out,
            result.out);
}

TEST(Video, IsCalibratedFrom) {
  const ScratchFolder scratch;
  const std::string clip = writeVideo(scratch.path("clip.avi"), boardFrames(12, 2));
  const RunResult result = runAlidade(
      {"calibrate", clip, "--board", kBoardSpec, "--model", "radtan", "-o", scratch.path("camera.yaml")});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, HasSubstr("corners in 12 of "));
  EXPECT_NEAR(parametersOf(scratch.read("camera.yaml")).front(),
              parametersOf(readFile(dataPath("camera.yaml"))).front(), 2.0);
}

// The pictures are made while frames are searched, or read again by their numbers: it must be the same ones.
TEST(Video, HasPicturesInItsReport) {
  const ScratchFolder scratch;
  const std::string clip = writeVideo(scratch.path("clip.avi"), boardFrames(12, 2));
  const std::string page = scratch.path("page.html");
  const std::string again = scratch.path("again.html");
  const std::string evidence = scratch.path("evidence.json");
  ASSERT_THAT(runAlidade({"calibrate", clip, "--board", kBoardSpec, "--model", "radtan", "--report", page,
                          "--evidence", evidence}),
              EndsWith(0));
  const std::string html = readFile(page);
  const std::string sheet = figureOf(html, "view-sheet");
  std::set<std::string> pictures;
  const std::regex pattern("src=\"(data:image/jpeg[^\"]+)\"");
  for (std::sregex_iterator i(sheet.begin(), sheet.end(), pattern), end; i != end; ++i)
    pictures.insert((*i)[1]);
  EXPECT_EQ(pictures.size(), 12u);  // all different
  EXPECT_THAT(figureOf(html, "undistorted"), HasSubstr("data:image/jpeg"));
  for (const char* jobs : {"1", "2"}) {
    ASSERT_THAT(runAlidade({"report", evidence, "-o", again, "--images", clip, "--jobs", jobs}), EndsWith(0));
    EXPECT_TRUE(readFile(again) == html) << jobs;
  }
}

TEST(Video, HasItsBoardGuessed) {
  const ScratchFolder scratch;
  const std::string clip = writeVideo(scratch.path("clip.avi"), boardFrames(6, 2));
  EXPECT_THAT(runAlidade({"detect", clip}), FailsWith(2, HasSubstr("--board checkerboard:9x6:SQUARE")));
}

TEST(Video, SaysWhatIsWrong) {
  const ScratchFolder scratch;
  const auto detect = [&](const std::string& name, std::vector<std::string> more = {}) {
    std::vector<std::string> args = {"detect", scratch.path(name), "--board", kBoardSpec};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  };
  const std::string whole =
      scratch.read(writeVideo(scratch.path("clip.avi"), boardFrames(3, 3)).substr(scratch.path().size() + 1));
  scratch.write("cut.avi", whole.substr(0, whole.size() / 2));
  scratch.write("text.mp4", "no video");
  scratch.write("empty.mov", "");
  writeVideo(scratch.path("other.avi"), movingSquares(30));
  EXPECT_THAT(detect("cut.avi"),
              FailsWith(1, AllOf(HasSubstr("cut.avi"), HasSubstr("of 12 frames can be read"))));
  EXPECT_THAT(detect("text.mp4"), FailsWith(1, AllOf(HasSubstr("text.mp4"), HasSubstr("cannot be opened"))));
  EXPECT_THAT(detect("empty.mov"), FailsWith(1, HasSubstr("the file is empty")));
  EXPECT_THAT(detect("missing.mp4"), FailsWith(1, HasSubstr("no such file")));
  EXPECT_THAT(detect("other.avi"), FailsWith(1, AllOf(HasSubstr("no board"), HasSubstr("next: "))));
  EXPECT_THAT(detect("clip.avi", {"--frames", "0"}), FailsWith(2, HasSubstr("--frames")));
  // A folder of videos alone, and a command without a use for them.
  EXPECT_THAT(detect(""), FailsWith(1, HasSubstr("give videos by their names")));
  EXPECT_THAT(
      runAlidade({"undistort", dataPath("camera.yaml"), scratch.path("clip.avi"), "-o", scratch.path("out")}),
      FailsWith(1, AllOf(HasSubstr("a video"), HasSubstr("ffmpeg -i"))));
}

TEST(ImageSequence, IsReadByItsPattern) {
  const ScratchFolder scratch;
  for (int i = 1; i <= 5; ++i)
    std::filesystem::copy_file(imagePath(i), scratch.path("img_" + std::to_string(i) + ".png"));
  const RunResult result =
      runAlidade({"detect", scratch.path("img_%d.png"), "--board", kBoardSpec, "--quiet"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(parseCornersFile(result.out, "found").views.size(), 5u);
}

}  // namespace
}  // namespace alidade
