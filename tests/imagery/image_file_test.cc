// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_file.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>
#include <vector>

#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_container.h"
#include "alidade/imagery/image_damage.h"
#include "support/exif.h"
#include "support/message_of.h"
#include "support/scratch_test.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kWidth = 97;  // neither a multiple of 8 nor of 4
constexpr int kHeight = 60;

/// Smooth, so that JPEG keeps it; channels far apart, so that a mixed-up order shows.
cv::Mat makeColor() {
  cv::Mat image(kHeight, kWidth, CV_8UC3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x)
      image.at<cv::Vec3b>(y, x) =
          cv::Vec3b(20, cv::saturate_cast<uchar>(2 * x), cv::saturate_cast<uchar>(4 * y));
  }
  return image;
}

cv::Mat makeGray() {
  cv::Mat image(kHeight, kWidth, CV_8UC1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) image.at<uchar>(y, x) = cv::saturate_cast<uchar>(2 * x + y);
  }
  return image;
}

/// The luminance of ITU-R BT.601, as all of OpenCV's decoders take it, some of them with rounded weights.
double luminance(const cv::Vec3b& bgr) {
  return 0.114 * bgr[0] + 0.587 * bgr[1] + 0.299 * bgr[2];
}

constexpr double kRounding = 1.1;  // of the luminance and of its weights

Bytes encode(const std::string& extension, const cv::Mat& image, const std::vector<int>& options = {}) {
  Bytes bytes;
  EXPECT_TRUE(cv::imencode(extension, image, bytes, options));
  return bytes;
}

std::string_view view(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

class ImageFile : public ScratchTest {
 protected:
  [[nodiscard]] std::string write(const std::string& name, const Bytes& bytes) const {
    writeFileAtomically(path(name), view(bytes));
    return path(name);
  }
  [[nodiscard]] LoadedImage readBack(const std::string& name, const cv::Mat& image) const {
    EXPECT_TRUE(cv::imwrite(path(name), image));
    return readGrayImage(path(name));
  }
  [[nodiscard]] std::string errorFor(const std::string& name, const Bytes& bytes) const {
    const std::string file = write(name, bytes);
    std::string message = messageOf([&] { (void)readGrayImage(file); });
    EXPECT_THAT(message, AllOf(HasSubstr(file), HasSubstr("next: ")));
    return message;
  }
};

double worstDifference(const GrayImage& image, const std::function<double(int, int)>& expected) {
  EXPECT_EQ(image.size, (ImageSize{kWidth, kHeight}));
  double worst = 0.0;
  for (int y = 0; y < image.size.height; ++y) {
    for (int x = 0; x < image.size.width; ++x)
      worst = std::max(worst, std::abs(image.at(x, y) - expected(x, y)));
  }
  return worst;
}

TEST_F(ImageFile, ReadsGrayAndColorOfEveryFormat) {
  const cv::Mat gray = makeGray();
  const cv::Mat color = makeColor();
  constexpr double kLossy = 6.0;  // JPEG at quality 95, WebP
  int num_read = 0;
  for (const std::string extension : {"png", "bmp", "tiff", "ppm", "jpg", "webp"}) {
    const double tolerance = extension == "jpg" || extension == "webp" ? kLossy : kRounding;
    const LoadedImage from_color = readBack("color." + extension, color);
    EXPECT_LE(
        worstDifference(from_color.image, [&](int x, int y) { return luminance(color.at<cv::Vec3b>(y, x)); }),
        tolerance)
        << extension;
    EXPECT_EQ(from_color.exif_orientation, 1);
    const std::string gray_name = extension == "ppm" ? "gray.pgm" : "gray." + extension;
    const LoadedImage from_gray = readBack(gray_name, gray);
    EXPECT_LE(worstDifference(from_gray.image, [&](int x, int y) { return gray.at<uchar>(y, x); }),
              tolerance == kLossy ? kLossy : 0.0)
        << extension;
    ++num_read;
  }
  EXPECT_EQ(num_read, 6);
}

TEST_F(ImageFile, IgnoresAlpha) {
  const cv::Mat color = makeColor();
  cv::Mat with_alpha(kHeight, kWidth, CV_8UC4);
  cv::Mat with_alpha_16(kHeight, kWidth, CV_16UC4);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const cv::Vec3b& c = color.at<cv::Vec3b>(y, x);
      with_alpha.at<cv::Vec4b>(y, x) = cv::Vec4b(c[0], c[1], c[2], static_cast<uchar>(x));
      with_alpha_16.at<cv::Vec4w>(y, x) = cv::Vec4w(c[0], c[1], c[2], static_cast<ushort>(600 * x));
    }
  }
  EXPECT_LE(worstDifference(readBack("8.png", with_alpha).image,
                            [&](int x, int y) { return luminance(color.at<cv::Vec3b>(y, x)); }),
            kRounding);

  const LoadedImage deep = readBack("16.png", with_alpha_16);
  std::vector<double> sorted;
  for (int i = 0; i < kWidth * kHeight; ++i)
    sorted.push_back(luminance(color.at<cv::Vec3b>(i / kWidth, i % kWidth)));
  std::sort(sorted.begin(), sorted.end());
  constexpr std::size_t kTail = kWidth * kHeight / 1000;
  const double least = sorted[kTail];
  const double greatest = sorted[sorted.size() - 1 - kTail];
  constexpr double kTwoRoundings = 2.5;  // of the luminance, then scaled by 255 / (greatest - least) < 2
  EXPECT_LE(worstDifference(deep.image,
                            [&](int x, int y) {
                              const double share =
                                  (luminance(color.at<cv::Vec3b>(y, x)) - least) / (greatest - least);
                              return 255.0 * std::clamp(share, 0.0, 1.0);
                            }),
            kTwoRoundings);
}

TEST_F(ImageFile, KeepsTheContrastOf12BitData) {
  cv::Mat deep(kHeight, kWidth, CV_16UC1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x)
      deep.at<ushort>(y, x) = static_cast<ushort>(100 + 3995 * x / (kWidth - 1));
  }
  for (const char* name : {"deep.png", "deep.tiff", "deep.pgm"}) {
    const LoadedImage loaded = readBack(name, deep);
    EXPECT_LE(worstDifference(loaded.image, [](int x, int) { return 255.0 * x / (kWidth - 1); }), 1.0)
        << name;
  }
}

TEST_F(ImageFile, ScalesFloatsAndSurvivesThoseThatAreNoNumbers) {
  cv::Mat image(kHeight, kWidth, CV_32FC1, cv::Scalar(-2.0));
  image.at<float>(0, 1) = std::numeric_limits<float>::quiet_NaN();
  image.at<float>(0, 2) = std::numeric_limits<float>::infinity();
  image.at<float>(0, 3) = -std::numeric_limits<float>::infinity();
  image.rowRange(kHeight / 2, kHeight).setTo(3.0F);
  image.at<float>(0, 4) = 3.0F;
  image.at<float>(0, 5) = 0.5F;
  const LoadedImage loaded = readBack("float.tiff", image);
  const std::vector<std::uint8_t> start(loaded.image.pixels.begin(), loaded.image.pixels.begin() + 6);
  EXPECT_THAT(start, ElementsAre(0, 0, 255, 0, 255, 128));
}

TEST_F(ImageFile, KeepsTheContrastBesideHotAndDeadPixels) {
  cv::Mat deep(kHeight, kWidth, CV_16UC1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x)
      deep.at<ushort>(y, x) = static_cast<ushort>(1000 + 400 * x / (kWidth - 1));
  }
  deep.at<ushort>(20, 30) = 65535;
  deep.at<ushort>(40, 50) = 0;
  const auto expected = [](int x, int y) {
    if (x == 30 && y == 20) return 255.0;
    if (x == 50 && y == 40) return 0.0;
    return 255.0 * x / (kWidth - 1);
  };
  EXPECT_LE(worstDifference(readBack("hot.png", deep).image, expected), 1.5);
}

TEST_F(ImageFile, ScalesLargeDeepImagesByASampleOfTheirPixels) {
  constexpr int kSide = 1500;
  cv::Mat deep(kSide, kSide, CV_16UC1, cv::Scalar(1000));
  deep.rowRange(kSide / 2, kSide).setTo(1400);
  deep.at<ushort>(0, 0) = 65535;
  const GrayImage image = readBack("large.png", deep).image;
  EXPECT_EQ(image.at(0, 0), 255);
  EXPECT_EQ(image.at(1, 0), 0);
  EXPECT_EQ(image.at(kSide - 1, kSide - 1), 255);
}

TEST_F(ImageFile, TurnsConstantDeepImagesBlack) {
  const LoadedImage loaded = readBack("constant.png", cv::Mat(kHeight, kWidth, CV_16UC1, cv::Scalar(1234)));
  EXPECT_EQ(worstDifference(loaded.image, [](int, int) { return 0.0; }), 0.0);
}

TEST_F(ImageFile, ReportsTheOrientationAndLeavesThePixels) {
  const Bytes plain = encode(".jpg", makeGray());
  const GrayImage expected = readGrayImage(write("plain.jpg", plain)).image;
  int num_read = 0;
  for (int orientation = 0; orientation <= 9; ++orientation) {
    for (const bool big_endian : {false, true}) {
      const LoadedImage loaded =
          readGrayImage(write("turned.jpg", withExif(plain, makeExif(orientation, big_endian))));
      EXPECT_EQ(loaded.exif_orientation, orientation >= 1 && orientation <= 8 ? orientation : 1);
      EXPECT_EQ(loaded.image.size, expected.size);
      EXPECT_EQ(loaded.image.pixels, expected.pixels);
      ++num_read;
    }
  }
  EXPECT_EQ(num_read, 20);
}

TEST_F(ImageFile, DescribesOrientations) {
  EXPECT_EQ(describeExifOrientation(6), "rotated 90 degrees clockwise");
  EXPECT_EQ(describeExifOrientation(3), "rotated 180 degrees");
  EXPECT_EQ(describeExifOrientation(8), "rotated 90 degrees counter-clockwise");
  for (const int unknown : {0, 9, -1})
    EXPECT_EQ(describeExifOrientation(unknown), "with an unknown orientation");
}

TEST_F(ImageFile, RefusesTiffsThatAskToBeTurned) {
  Bytes tiff = encode(".tiff", makeGray());
  // OpenCV writes no orientation, so it takes the place of the samples a pixel, which are 1 without being
  // said.
  ASSERT_EQ(tiff[0], 'I');
  const std::size_t directory = tiff[4] | tiff[5] << 8 | tiff[6] << 16;
  const std::size_t num_entries = tiff[directory];
  int num_refused = 0;
  for (std::size_t i = 0; i < num_entries; ++i) {
    std::uint8_t* entry = &tiff[directory + 2 + 12 * i];
    const int tag = entry[0] | entry[1] << 8;
    if (tag != 0x0115) continue;
    // BYTE, SHORT, LONG and their signed forms.
    for (const std::uint8_t type : {1, 3, 4, 6, 8, 9}) {
      const Bytes orientation = {0x12, 0x01, type, 0, 1, 0, 0, 0, 6, 0, 0, 0};
      std::copy(orientation.begin(), orientation.end(), entry);
      EXPECT_THAT(errorFor("turned.tiff", tiff),
                  AllOf(HasSubstr("rotated 90 degrees clockwise"), HasSubstr("PNG")));
      ++num_refused;
    }
    break;
  }
  EXPECT_EQ(num_refused, 6);
}

TEST_F(ImageFile, RefusesTruncatedImagesOfEveryFormat) {
  const cv::Mat color = makeColor();
  const std::vector<std::pair<std::string, Bytes>> files = {
      {"baseline.jpg", encode(".jpg", color)},
      {"progressive.jpg", encode(".jpg", color, {cv::IMWRITE_JPEG_PROGRESSIVE, 1})},
      {"restart.jpg", encode(".jpg", color, {cv::IMWRITE_JPEG_RST_INTERVAL, 4})},
      {"thumbnail.jpg", withExif(encode(".jpg", color), makeExif(1, false), encode(".jpg", makeGray()))},
      {"a.png", encode(".png", color)},
      {"a.bmp", encode(".bmp", color)},
      {"a.tiff", encode(".tiff", color)},
      {"a.ppm", encode(".ppm", color)},
      {"a.webp", encode(".webp", color)},
  };
  int num_refused = 0;
  for (const auto& [name, bytes] : files) {
    EXPECT_FALSE(readGrayImage(write(name, bytes)).image.empty()) << name;
    for (std::size_t tenth = 1; tenth < 10; ++tenth) {
      const Bytes part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() * tenth / 10));
      const std::string message = errorFor(name, part);
      const bool has_end = name.ends_with(".jpg") || name.ends_with(".png") || name.ends_with(".webp");
      EXPECT_THAT(message, HasSubstr(has_end ? "truncated" : "cannot be decoded")) << name << " at " << tenth;
      ++num_refused;
    }
  }
  EXPECT_EQ(num_refused, 9 * 9);
}

TEST_F(ImageFile, AcceptsBytesBehindTheEnd) {
  for (const char* extension : {".jpg", ".png"}) {
    Bytes bytes = encode(extension, makeGray());
    bytes.insert(bytes.end(), 100, 0);
    EXPECT_FALSE(readGrayImage(write(std::string("tail") + extension, bytes)).image.empty());
  }
}

TEST_F(ImageFile, RefusesDamagedPngs) {
  Bytes bytes = encode(".png", makeGray());
  bytes[bytes.size() / 2] ^= 0x10;
  EXPECT_THAT(errorFor("damaged.png", bytes), HasSubstr("checksum"));
}

// One changed byte in the coded data displaces what follows it by whole blocks.
TEST_F(ImageFile, RefusesDamagedJpegs) {
  cv::Mat image(120, 160, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x)
      image.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(128 + 60 * std::sin(0.03 * x * y) + 60 * std::sin(0.9 * x - 0.2 * y));
  }
  const Bytes whole = encode(".jpg", image);
  EXPECT_EQ(jpegDamage(view(whole)), "");
  Random random(5);
  int num_wrong = 0;
  int num_missed = 0;
  for (int i = 0; i < 300; ++i) {
    Bytes damaged = whole;
    const auto at = damaged.size() / 2 + random.index(damaged.size() / 2 - 2);
    damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ (1U << random.index(8)));
    const cv::Mat decoded = cv::imdecode(damaged, cv::IMREAD_GRAYSCALE);
    double largest = 0;
    if (!decoded.empty())
      cv::minMaxLoc(cv::abs(decoded - cv::imdecode(whole, cv::IMREAD_GRAYSCALE)), nullptr, &largest);
    constexpr double kVisible = 40;
    if (decoded.empty() || largest < kVisible) continue;
    ++num_wrong;
    try {
      static_cast<void>(readGrayImage(write("damaged.jpg", damaged)));
      ++num_missed;
    } catch (const Error& error) {
      EXPECT_THAT(std::string(error.what()), AnyOf(HasSubstr("without errors"), HasSubstr("truncated")));
    }
  }
  EXPECT_GE(num_wrong, 100);
  // Damage that leaves a valid code of the same length cannot be known.
  EXPECT_LT(num_missed, num_wrong / 4);
}

// Deflate has a checksum; LZW has none, but not every code is valid.
TEST_F(ImageFile, RefusesDamagedTiffs) {
  constexpr int kLzw = 5;
  constexpr int kDeflate = 8;
  for (const int compression : {kLzw, kDeflate}) {
    Bytes whole;
    ASSERT_TRUE(cv::imencode(".tif", makeColor(), whole, {cv::IMWRITE_TIFF_COMPRESSION, compression}));
    EXPECT_FALSE(readGrayImage(write("whole.tif", whole)).image.empty());
    Random random(6);
    int num_refused = 0;
    constexpr int kTrials = 60;
    for (int i = 0; i < kTrials; ++i) {
      Bytes damaged = whole;
      constexpr std::size_t kHeader = 8;
      constexpr std::size_t kDirectory = 400;  // at the end
      const std::size_t at = kHeader + random.index(damaged.size() - kHeader - kDirectory);
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ (1U << random.index(8)));
      try {
        static_cast<void>(readGrayImage(write("damaged.tif", damaged)));
      } catch (const Error& error) {
        EXPECT_THAT(std::string(error.what()), HasSubstr("without errors"));
        ++num_refused;
      }
    }
    EXPECT_GE(num_refused, compression == kDeflate ? kTrials : 1);
  }
}

TEST_F(ImageFile, SaysWhatAFileHoldsInsteadOfAnImage) {
  const auto text = [](std::string_view t) { return Bytes(t.begin(), t.end()); };
  EXPECT_THAT(errorFor("text.jpg", text("hello\nworld")), HasSubstr("starts with 'hello', not an image"));
  EXPECT_THAT(errorFor("x.png", text("x")), HasSubstr("starts with 'x', not an image"));
  EXPECT_THAT(errorFor("page.png", text("<!DOCTYPE html><html lang=\"en\">")),
              HasSubstr("'<!DOCTYPE html><html"));
  EXPECT_THAT(errorFor("empty.png", {}), HasSubstr("0 bytes"));
  for (const std::string_view list : {"# filename x y level\n", "# found by a tool\n# filename x y\n",
                                      "camera,image,width,height,board,corner_id,col,row,u,v,sigma_px\n"})
    EXPECT_THAT(errorFor("corners.txt", text(list)), HasSubstr("ends in .csv, or .vnl")) << list;
  EXPECT_THAT(errorFor("notes.txt", text("# filenames of x and y\n")), testing::Not(HasSubstr(".csv")));
  EXPECT_THAT(errorFor("binary.png", {0, 1, 2, 3, 4, 5}), HasSubstr("not an image"));
  for (const std::string kind : {"heic", "mif1", "heix"}) {
    const Bytes heic = text(std::string("\0\0\0\x18", 4) + "ftyp" + kind + std::string(40, '\0'));
    EXPECT_THAT(errorFor("photo.HEIC", heic),
                AllOf(HasSubstr("a HEIC photograph"), HasSubstr("heif-convert"), HasSubstr("photo.jpg'")));
  }
  EXPECT_THAT(errorFor("video.png", text(std::string("\0\0\0\x18", 4) + "ftypisom" + std::string(40, '\0'))),
              HasSubstr("not an image"));
  EXPECT_THAT(errorFor("stub.jpg", {0xFF, 0xD8, 0xFF, 0xD9}), HasSubstr("cannot be decoded"));
}

TEST_F(ImageFile, GivesOpenCvOnlyTheKindsItNames) {
  Bytes dicom(4000, 0);  // GDCM, which OpenCV would ask, has brought the process down
  const std::string_view magic = "DICM";
  std::copy(magic.begin(), magic.end(), dicom.begin() + 128);
  EXPECT_THAT(errorFor("dicom.png", dicom), AllOf(HasSubstr("not an image"), HasSubstr("unknown format"),
                                                  HasSubstr("(JPEG, PNG, TIFF, BMP, PNM, WebP)")));
  // OpenCV reads these, but they are none of the kinds; of BigTIFF it turns the pixels.
  int num_refused = 0;
  for (const char* extension : {".ras", ".hdr", ".pam", ".jp2"}) {
    const Bytes bytes = encode(extension, makeColor());
    ASSERT_FALSE(cv::imdecode(bytes, cv::IMREAD_UNCHANGED).empty()) << extension;
    EXPECT_THAT(errorFor(std::string("other") + extension, bytes), HasSubstr("not an image")) << extension;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 4);
  EXPECT_THAT(errorFor("big.tif", {'I', 'I', 43, 0, 8, 0, 0, 0}), HasSubstr("a BigTIFF image"));
}

// With the first bytes of a kind that is read and, further on, those of one that is not.
TEST_F(ImageFile, GivesOpenCvNoFileOfTwoKinds) {
  int num_refused = 0;
  for (const std::string& start :
       {std::string("\xFF\xD8\xFF"), std::string("\x89PNG\r\n\x1A\n"), std::string("II*\0", 4),
        std::string("BM"), std::string("P5\n"), std::string("RIFF\0\0\0\0WEBP", 12),
        std::string("RIFF\0\0\0\0WEBPVP8L", 16)}) {
    Bytes bytes(4000, 0);
    std::copy(start.begin(), start.end(), bytes.begin());
    constexpr std::string_view kDicom = "DICM";
    constexpr std::string_view kDted = "DTED";
    std::copy(kDicom.begin(), kDicom.end(), bytes.begin() + 128);
    std::copy(kDted.begin(), kDted.end(), bytes.begin() + 140);
    EXPECT_THAT(errorFor("two_kinds.png", bytes),
                AnyOf(HasSubstr("starts with 'RIFF', not an image"), HasSubstr("cannot be decoded"),
                      HasSubstr("is truncated")));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 7);
}

TEST_F(ImageFile, NamesPathsThatAreNoFiles) {
  const auto read = [](const std::string& file) { return messageOf([&] { (void)readGrayImage(file); }); };
  const std::string file = write("left01.png", encode(".png", makeGray()));
  EXPECT_THAT(read(path("left1.png")), HasSubstr("did you mean '" + file + "'?"));
  EXPECT_THAT(read(folder_.string()), HasSubstr("this is a folder"));
  EXPECT_THAT(read(file + "/x.png"), HasSubstr("is a file, not a folder"));
  ASSERT_EQ(::mkfifo(path("fifo.png").c_str(), 0600), 0);
  EXPECT_THAT(read(path("fifo.png")), HasSubstr("device or pipe"));
  fs::permissions(file, fs::perms::none);
  if (::geteuid() == 0) {  // reads everything
    EXPECT_FALSE(readGrayImage(file).image.empty());
  } else {
    EXPECT_THAT(read(file), HasSubstr("Permission denied"));
  }
}

TEST_F(ImageFile, RefusesAbsurdSizes) {
  // The size in the frame header of a JPEG has no checksum.
  Bytes jpeg = encode(".jpg", makeGray());
  const Bytes marker = {0xFF, 0xC0};
  const auto frame = std::search(jpeg.begin(), jpeg.end(), marker.begin(), marker.end());
  ASSERT_NE(frame, jpeg.end());
  std::fill(frame + 5, frame + 9, 0xFF);
  EXPECT_THAT(errorFor("huge.jpg", jpeg), AllOf(HasSubstr("65535x65535"), HasSubstr("at most")));
  // A kind whose size only the decoder knows.
  const std::string pgm = "P5\n2000000 2000000\n255\n";
  EXPECT_THAT(errorFor("huge.pgm", Bytes(pgm.begin(), pgm.end())), HasSubstr("cannot be decoded"));
}

TEST_F(ImageFile, WritesWhatItReads) {
  RasterImage image{.size = {3, 2}, .bytes = {0, 50, 100, 150, 200, 255}};
  writeImage(path("a.png"), image);
  const LoadedImage loaded = readGrayImage(path("a.png"));
  EXPECT_EQ(loaded.image.size, image.size);
  EXPECT_EQ(loaded.image.pixels, image.bytes);
  EXPECT_THAT(messageOf([&] { writeImage("/dev/full", image); }), HasSubstr("No space left"));
  image.bytes.pop_back();
  EXPECT_THROW(writeImage(path("a.png"), image), std::logic_error);
  EXPECT_THROW(writeImage(path("a.png"), {}), std::logic_error);
}

TEST(ImageContainer, FindsTheSizeAndTheEnd) {
  const cv::Mat image = makeGray();
  for (const char* extension : {".jpg", ".png"}) {
    const Bytes bytes = encode(extension, image);
    const ContainerInfo info = parseImageContainer(bytes);
    EXPECT_TRUE(info.complete);
    EXPECT_TRUE(info.intact);
    EXPECT_EQ(info.size, (ImageSize{kWidth, kHeight}));
    int num_incomplete = 0;
    for (std::size_t length = 8; length < bytes.size(); ++length) {
      num_incomplete += parseImageContainer(std::span(bytes).first(length)).complete ? 0 : 1;
    }
    EXPECT_EQ(num_incomplete, static_cast<int>(bytes.size()) - 8);
  }
}

TEST(ImageContainer, ReadsTheOrientationOfPngs) {
  Bytes png = encode(".png", makeGray());
  const Bytes exif = makeExif(8, true);
  Bytes chunk = {0, 0, 0, static_cast<std::uint8_t>(exif.size()), 'e', 'X', 'I', 'f'};
  chunk.insert(chunk.end(), exif.begin(), exif.end());
  chunk.insert(chunk.end(), 4, 0);  // the checksum, which nobody needs in a chunk that may be left out
  constexpr std::ptrdiff_t kBehindHeader = 8 + 25;
  png.insert(png.begin() + kBehindHeader, chunk.begin(), chunk.end());
  const ContainerInfo info = parseImageContainer(png);
  EXPECT_EQ(info.exif_orientation, 8);
  EXPECT_TRUE(info.intact);
}

TEST(ImageContainer, SurvivesDamage) {
  constexpr int kNumRuns = 2000;
  constexpr int kMaxFlips = 8;
  const std::array<Bytes, 2> originals = {withExif(encode(".jpg", makeColor()), makeExif(6, false)),
                                          encode(".png", makeColor())};
  std::mt19937 random(1);
  int num_parsed = 0;
  for (const Bytes& original : originals) {
    for (int run = 0; run < kNumRuns; ++run) {
      Bytes bytes = original;
      // Half of the damage goes to the first bytes, where the lengths are.
      const std::size_t reach = run % 2 == 0 ? bytes.size() : 80;
      for (int i = 0; i <= run % kMaxFlips; ++i)
        bytes[random() % reach] = static_cast<std::uint8_t>(random());
      if (run % 3 == 0) bytes.resize(random() % bytes.size());
      bytes.shrink_to_fit();  // so that a sanitizer sees the first byte too many
      const ContainerInfo info = parseImageContainer(bytes);
      EXPECT_TRUE(info.exif_orientation >= 1 && info.exif_orientation <= 8);
      EXPECT_TRUE(!info.size || (info.size->width > 0 && info.size->height > 0));
      ++num_parsed;
    }
  }
  EXPECT_EQ(num_parsed, 2 * kNumRuns);
}

/// Every sample of an image by its own value, for lossless formats.
cv::Mat makeSamples(int type) {
  cv::Mat image(kHeight, kWidth, type);
  const int num_channels = image.channels();
  for (int y = 0; y < kHeight; ++y) {
    for (int i = 0; i < kWidth * num_channels; ++i) {
      const int value = 7 * i + 31 * y;
      if (image.depth() == CV_16U) {
        image.ptr<std::uint16_t>(y)[i] = static_cast<std::uint16_t>(97 * value);
      } else {
        image.ptr<std::uint8_t>(y)[i] = static_cast<std::uint8_t>(value);
      }
    }
  }
  return image;
}

TEST_F(ImageFile, KeepsColorsAlphaAndBits) {
  int num_kinds = 0;
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4}) {
    for (const std::string extension : {".png", ".tiff"}) {
      const cv::Mat expected = makeSamples(type);
      ASSERT_TRUE(cv::imwrite(path("in" + extension), expected));
      const Loaded<RasterImage> loaded = readImage(path("in" + extension));
      EXPECT_EQ(loaded.image.size, (ImageSize{kWidth, kHeight}));
      EXPECT_EQ(loaded.image.num_channels, expected.channels());
      EXPECT_EQ(loaded.image.bits_per_sample, expected.depth() == CV_8U ? 8 : 16);
      ASSERT_EQ(loaded.image.bytes.size(), expected.total() * expected.elemSize());
      writeImage(path("out.png"), loaded.image);
      const cv::Mat back = cv::imread(path("out.png"), cv::IMREAD_UNCHANGED);
      ASSERT_EQ(back.type(), type) << extension;
      EXPECT_EQ(cv::norm(back, expected, cv::NORM_INF), 0) << extension;
      ++num_kinds;
    }
  }
  EXPECT_EQ(num_kinds, 12);
}

TEST_F(ImageFile, HasRedFirst) {
  const cv::Mat bgr = makeColor();
  ASSERT_TRUE(cv::imwrite(path("color.png"), bgr));
  const RasterImage image = readImage(path("color.png")).image;
  const std::size_t at = 3 * (20 * kWidth + 30);
  const auto expected = bgr.at<cv::Vec3b>(20, 30);
  EXPECT_THAT(std::vector<int>(image.bytes.begin() + static_cast<std::ptrdiff_t>(at),
                               image.bytes.begin() + static_cast<std::ptrdiff_t>(at) + 3),
              ElementsAre(expected[2], expected[1], expected[0]));
}

TEST_F(ImageFile, WritesJpegUnderTheNameOfOne) {
  int num_names = 0;
  for (const std::string name : {"a.jpg", "b.JPEG"}) {
    ASSERT_TRUE(hasJpegName(name));
    const cv::Mat color = makeColor();
    ASSERT_TRUE(cv::imwrite(path("color.png"), color));
    writeImage(path(name), readImage(path("color.png")).image);
    const std::string content = readBinaryFile(path(name), 1 << 20);
    EXPECT_TRUE(content.starts_with("\xFF\xD8"));
    const cv::Mat back = cv::imread(path(name), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(back.type(), CV_8UC3);
    EXPECT_LT(cv::norm(back, color, cv::NORM_L1) / static_cast<double>(3 * color.total()), 2);
    ++num_names;
  }
  EXPECT_EQ(num_names, 2);
  EXPECT_FALSE(hasJpegName("jpg"));
  EXPECT_FALSE(hasJpegName("a.jpg.png"));
  const RasterImage deep{.size = {2, 1}, .num_channels = 1, .bits_per_sample = 16, .bytes = {1, 2, 3, 4}};
  EXPECT_THAT(messageOf([&] { writeImage(path("deep.jpg"), deep); }), HasSubstr("16-bit samples"));
  const RasterImage clear{.size = {1, 1}, .num_channels = 4, .bits_per_sample = 8, .bytes = {1, 2, 3, 4}};
  EXPECT_THAT(messageOf([&] { writeImage(path("clear.jpg"), clear); }), HasSubstr("alpha"));
  EXPECT_FALSE(fs::exists(path("deep.jpg")));
}

TEST_F(ImageFile, RefusesToKeepWhatIsNoSampleOf8Or16Bits) {
  ASSERT_TRUE(cv::imwrite(path("float.tiff"), cv::Mat(kHeight, kWidth, CV_32FC1, cv::Scalar(0.5))));
  EXPECT_THAT(messageOf([&] { (void)readImage(path("float.tiff")); }),
              AllOf(HasSubstr("float.tiff"), HasSubstr("8 or 16 bits")));
  EXPECT_THAT(messageOf([&] { (void)readImage(path("missing.png")); }), HasSubstr("no such file"));
}

TEST_F(ImageFile, KeepsThePixelsOfJpegFilesAsStored) {
  const Bytes jpeg = encode(".jpg", makeColor());
  const Loaded<RasterImage> plain = readImage(write("plain.jpg", jpeg));
  const Loaded<RasterImage> turned = readImage(write("turned.jpg", withExif(jpeg, makeExif(6, false))));
  EXPECT_EQ(plain.exif_orientation, 1);
  EXPECT_EQ(turned.exif_orientation, 6);
  EXPECT_EQ(turned.image.size, plain.image.size);
  EXPECT_EQ(turned.image.bytes, plain.image.bytes);
}

}  // namespace
}  // namespace alidade
