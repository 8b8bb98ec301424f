// SPDX-License-Identifier: MIT
#include <filesystem>
#include <functional>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/command_line.h"
#include "support/exif.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kNumViews = 4;

using Change = std::function<cv::Mat(const cv::Mat&)>;

// The first images of testdata/ in another form.
std::string writeImages(const ScratchFolder& scratch, const std::string& folder, const std::string& extension,
                        const Change& change, int count = kNumViews) {
  const std::string path = scratch.makeFolder(folder);
  for (int i = 1; i <= count; ++i) {
    const cv::Mat gray = cv::imread(imagePath(i), cv::IMREAD_GRAYSCALE);
    EXPECT_FALSE(gray.empty());
    EXPECT_TRUE(cv::imwrite(fmt::format("{}/view_{:03}.{}", path, i, extension), change(gray)));
  }
  return path;
}

// The parameters that come of a folder of images.
std::vector<double> calibrated(const std::string& folder) {
  const RunResult result = runAlidade({"calibrate", folder, "--board", kBoardSpec, "-o", "-", "--verbose"});
  EXPECT_THAT(result, EndsWith(0)) << folder;
  EXPECT_THAT(result.err, HasSubstr(fmt::format("{0} given, {0} with the board, {0} used", kNumViews)));
  return result.exit_code == 0 ? parametersOf(result.out) : std::vector<double>();
}

cv::Mat toColor(const cv::Mat& gray) {
  cv::Mat color;
  cv::cvtColor(gray, color, cv::COLOR_GRAY2BGR);
  return color;
}

TEST(ImageKinds, GiveTheSameParametersWhereTheyHoldTheSamePixels) {
  const ScratchFolder scratch;
  const auto same = [](const cv::Mat& gray) { return gray; };
  const auto with_alpha = [](const cv::Mat& gray) {
    const cv::Mat alpha = gray / 2;  // would change the image if it were applied
    cv::Mat image;
    cv::merge(std::vector<cv::Mat>{gray, gray, gray, alpha}, image);
    return image;
  };
  const std::vector<double> expected = calibrated(writeImages(scratch, "gray", "png", same));
  ASSERT_EQ(expected.size(), 9u);
  EXPECT_EQ(calibrated(writeImages(scratch, "color", "png", toColor)), expected);
  EXPECT_EQ(calibrated(writeImages(scratch, "bmp", "bmp", same)), expected);
  EXPECT_EQ(calibrated(writeImages(scratch, "tiff", "tiff", toColor)), expected);
  EXPECT_EQ(calibrated(writeImages(scratch, "pgm", "pgm", same)), expected);
  EXPECT_EQ(calibrated(writeImages(scratch, "alpha", "png", with_alpha)), expected);
}

TEST(ImageKinds, GiveNearlyTheSameParametersWhereThePixelsDifferALittle) {
  const ScratchFolder scratch;
  const std::vector<double> truth = parametersOf(readFile(dataPath("camera.yaml")));
  const std::vector<std::string> folders = {writeImages(scratch, "jpeg", "jpg", toColor),
                                            // 12 bits in 16, as industrial cameras give.
                                            writeImages(scratch, "deep", "png", [](const cv::Mat& gray) {
                                              cv::Mat deep;
                                              gray.convertTo(deep, CV_16U, 16);
                                              return deep;
                                            })};
  int num_kinds = 0;
  for (const std::string& folder : folders) {
    const std::vector<double> found = calibrated(folder);
    ASSERT_EQ(found.size(), truth.size());
    constexpr double kFourViewsPx =
        3;  // four views of a board know the focal length and centre to about 1 px
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(found[i], truth[i], kFourViewsPx) << folder;
    ++num_kinds;
  }
  EXPECT_EQ(num_kinds, 2);
}

TEST(ImageKinds, LeavesOutImagesOfAnotherSize) {
  const ScratchFolder scratch;
  const auto pad = [](const cv::Mat& gray) {
    cv::Mat padded;
    cv::copyMakeBorder(gray, padded, 0, 1, 0, 1, cv::BORDER_REPLICATE);
    return padded;
  };
  const std::string folder = writeImages(scratch, "photos", "png", pad, 2);
  for (int i = 3; i <= kNumImages; ++i)
    std::filesystem::create_symlink(imagePath(i), fmt::format("{}/view_{:03}.png", folder, i));
  const RunResult result = runAlidade({"calibrate", folder, "--board", kBoardSpec, "--verbose"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("640x480 px"), HasSubstr("12 given"), HasSubstr("10 used"),
                    HasSubstr("view_001.png: other_size: is 641x481, while most images are 640x480"),
                    HasSubstr("view_002.png: other_size"),
                    HasSubstr("images of several different sizes were given")));
}

TEST(ImageKinds, UsesPixelsAsStoredWhateverExifSays) {
  const ScratchFolder scratch;
  const std::string plain = writeImages(scratch, "plain", "jpg", [](const cv::Mat& gray) { return gray; });
  int num_turned = 0;
  for (int i = 1; i <= kNumViews; ++i) {
    const std::string name = fmt::format("view_{:03}.jpg", i);
    const std::string jpeg = scratch.read("plain/" + name);
    const Bytes turned = withExif(Bytes(jpeg.begin(), jpeg.end()), makeExif(6, false));
    scratch.write("turned/" + name, {reinterpret_cast<const char*>(turned.data()), turned.size()});
    ++num_turned;
  }
  ASSERT_EQ(num_turned, kNumViews);
  const RunResult result =
      runAlidade({"calibrate", scratch.path("turned"), "--board", kBoardSpec, "-o", "-", "--verbose"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(parametersOf(result.out), calibrated(plain));
  EXPECT_THAT(
      result.err,
      AllOf(HasSubstr("4 images have an Exif orientation (rotated 90 degrees clockwise); it is ignored"),
            HasSubstr("as stored")));
}

}  // namespace
}  // namespace alidade
