// SPDX-License-Identifier: MIT
// The signatures of binary files are those of the table of file(1).
#include "alidade/files/foreign_file.h"

#include <algorithm>
#include <array>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kAsPhotograph =
    "a camera file is text; photographs are inputs of alidade calibrate, or of validate --images";
constexpr std::string_view kFromArrays =
    "write the camera matrix and the coefficients with cv2.FileStorage, or as JSON: docs/formats.md";
constexpr std::string_view kCalibrate = "calibrate the images of the camera with alidade calibrate";
constexpr std::string_view kUnpack = "unpack it, and give the camera file in it";
constexpr std::string_view kFromBag =
    "print one message: rostopic echo -b FILE -n 1 /CAMERA/camera_info > camera_info.yaml, or in ROS 2, while the "
    "bag is played, ros2 topic echo --once /CAMERA/camera_info > camera_info.yaml";
constexpr std::string_view kByHand =
    "if it has a camera's numbers, write them as one: alidade_camera: 1, model, image_size, parameters "
    "(docs/formats.md)";

constexpr std::string_view kInMatlab = "in MATLAB, write jsonencode(toStruct(params)) to a .json file";
constexpr std::string_view kAsVideo = "videos are inputs of alidade calibrate";

// Bytes at a fixed place.
struct Signature {
  std::size_t at;
  std::string_view bytes;
  std::string_view what;
  std::string_view next_step;
};
constexpr std::array kSignatures = {
    Signature{4, "ftypavif", "an AVIF image", kAsPhotograph},
    Signature{4, "ftyp", "a video (MP4, QuickTime)", kAsVideo},
    Signature{0, "\x1A\x45\xDF\xA3", "a video (Matroska, WebM)", kAsVideo},
    Signature{8, "AVI ", "a video (AVI)", kAsVideo},
    Signature{0, "\xFF\xD8\xFF", "a JPEG image", kAsPhotograph},
    Signature{0, "\x89PNG", "a PNG image", kAsPhotograph},
    Signature{0, "II*\0"sv, "a TIFF image or raw photograph", kAsPhotograph},
    Signature{0, "MM\0*"sv, "a TIFF image or raw photograph", kAsPhotograph},
    Signature{8, "WEBP", "a WebP image", kAsPhotograph},
    Signature{0, "#ROSBAG V", "a ROS bag", kFromBag},
    Signature{0, "\x89MCAP0", "a ROS 2 bag (MCAP)", kFromBag},
    Signature{0, "SQLite format 3", "a SQLite database, as of a ROS 2 bag (db3)", kFromBag},
    Signature{0, "\x93NUMPY", "a NumPy array (npy)", kFromArrays},
    Signature{0, "MATLAB 5.0 MAT-file", "a MATLAB file (mat)", kInMatlab},
    Signature{0, "\x89HDF", "an HDF5 file, as MATLAB writes it (mat, version 7.3)", kInMatlab},
    Signature{0, "PK\x03\x04", "a ZIP archive", kUnpack},
    Signature{0, "\x1F\x8B", "a gzip archive", kUnpack},
    Signature{0, "%PDF", "a PDF document", kByHand},
    Signature{0, "version https://git-lfs", "a pointer of Git LFS, which stands for the file",
              "git lfs pull"}};

// Text that only one kind of file has.
struct Mark {
  std::string_view text;
  std::string_view what;
  std::string_view next_step;
};
constexpr std::array kMarks = {
    Mark{"# oST version", "the INI file (ost.txt) of the ROS calibrator, without the distortion model",
         "use ost.yaml, which the calibrator writes to the same folder"},
    Mark{"Camera-system parameters:", "Kalibr's report (results-cam.txt)",
         "use camchain.yaml, which Kalibr writes beside it and which has all digits"},
    Mark{"<lensdatabase", "lensfun's database (XML), which has many lenses and no focal length in pixels",
         "calibrate the lens with alidade calibrate"},
    Mark{"xcr:DistortionModel", "the camera of one image from RealityCapture (XMP)",
         "export the cameras in the format of COLMAP or OpenCV"},
    Mark{"camera calibration matrix K", "Pix4D's calibrated camera parameters",
         "write one camera as an OpenCV file: docs/formats.md"},
    Mark{
        "Model = CAHV", "a camera in the CAHV model of planetary rovers (CAHV, CAHVOR, CAHVORE)",
        "write a CAHV without O and R as a pinhole: fx = Hs, fy = Vs, cx = Hc, cy = Vc; see docs/formats.md"},
    Mark{"qtm-version", "a calibration of Qualisys Track Manager (XML)", kCalibrate},
    Mark{"<fov_marker", "a calibration of Qualisys Track Manager (XML)", kCalibrate},
    Mark{"<robot", "a robot description (URDF)", "give the camera file of the driver: camera_info"},
    Mark{"<!DOCTYPE html", "a web page", "download the file itself, such as the raw view of a repository"},
    Mark{"<html", "a web page", "download the file itself, such as the raw view of a repository"},
    Mark{"array([", "NumPy arrays as Python prints them", kFromArrays}};

struct Token {
  std::string_view text;
  std::size_t at;  // in the text
  std::ptrdiff_t line;
  std::optional<double> number;
};

std::vector<Token> tokensOf(std::string_view text) {
  constexpr std::size_t kMaxBytes = 1U << 16U;
  constexpr std::string_view kOfToken = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.+-";
  text = text.substr(0, kMaxBytes);
  std::vector<Token> tokens;
  std::ptrdiff_t line = 1;
  std::size_t end = 0;
  for (std::size_t at = 0; (at = text.find_first_of(kOfToken, end)) != std::string_view::npos;) {
    line += std::count(text.begin() + static_cast<std::ptrdiff_t>(end),
                       text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    end = std::min(text.find_first_not_of(kOfToken, at), text.size());
    const std::string_view token = text.substr(at, end - at);
    tokens.push_back({token, at, line, parseDouble(token)});
  }
  return tokens;
}

}  // namespace

std::optional<ForeignFile> knownForeignFile(std::string_view content, std::string_view file) {
  const auto made = [](std::string_view what, std::string_view next_step) {
    return ForeignFile{.what = std::string(what), .next_step = std::string(next_step)};
  };
  constexpr std::array kHeic = {"heic", "heix", "hevc", "mif1", "msf1"};  // kinds of "ftyp"
  const std::string_view kind = content.substr(std::min<std::size_t>(content.size(), 8), 4);
  if (content.find("ftyp") == 4 && std::ranges::find(kHeic, kind) != kHeic.end()) {
    return made(
        "a HEIC photograph",
        "photographs of a board are inputs of alidade calibrate, as JPEG of full size: heif-convert FILE "
        "photo.jpg");
  }
  if (content.starts_with("PK") && file.ends_with(".npz")) return made("NumPy arrays (npz)", kFromArrays);
  const bool is_pickle = content.size() > 1 && content[0] == '\x80' && content[1] >= 2 && content[1] <= 5;
  if (is_pickle) return made("a Python pickle", kFromArrays);
  for (const Signature& signature : kSignatures) {
    if (content.size() > signature.at && content.substr(signature.at).starts_with(signature.bytes))
      return made(signature.what, signature.next_step);
  }
  for (const Mark& mark : kMarks) {
    if (content.find(mark.text) != std::string_view::npos) return made(mark.what, mark.next_step);
  }
  // Where the name promises text, zero bytes are damage.
  constexpr std::array kTextNames = {".yaml", ".yml", ".json", ".xml", ".txt", ".cameramodel", ".cam"};
  if (std::ranges::any_of(kTextNames, [&](const char* end) { return file.ends_with(end); }))
    return std::nullopt;
  constexpr std::size_t kHead = 4096;
  if (content.substr(0, kHead).find('\0') == std::string_view::npos) return std::nullopt;
  return made("a binary file of unknown kind", "export the camera as text from the program that wrote it");
}

std::optional<ForeignFile> foreignText(std::string_view text) {
  std::size_t num_sections = 0;
  std::size_t num_values = 0;
  std::size_t num_toml = 0;
  std::size_t num_lines = 0;
  std::size_t num_rows = 0;
  std::ptrdiff_t num_columns = 0;
  for (const std::string_view whole : split(text, '\n')) {
    const std::string_view line = trim(whole);
    if (line.empty() || line.front() == '#' || line.front() == ';') continue;
    if (line.front() == '<') return std::nullopt;  // XML
    ++num_lines;
    const std::size_t equals = line.find('=');
    num_sections += line.front() == '[' && line.back() == ']' ? 1U : 0U;
    const std::string_view value = equals == std::string_view::npos ? "" : trim(line.substr(equals + 1));
    num_values += value.empty() ? 0U : 1U;
    num_toml += !value.empty() && (value.front() == '[' || value.front() == '"') ? 1U : 0U;
    const std::ptrdiff_t num_commas = std::count(line.begin(), line.end(), ',');
    const bool has_key = line.find(':') != std::string_view::npos;
    num_rows += num_commas > 0 && !has_key && (num_lines == 1 || num_commas == num_columns) ? 1U : 0U;
    num_columns = num_commas;
  }
  const std::string next(kByHand);
  if (num_lines > 1 && num_sections + num_values == num_lines)
    return ForeignFile{.what = num_toml > 0 ? "a TOML file" : "an INI file", .next_step = next};
  if (num_lines > 1 && num_rows == num_lines) return ForeignFile{.what = "a table (CSV)", .next_step = next};
  return std::nullopt;
}

std::string cameraNumbersIn(std::string_view text) {
  constexpr std::string_view kNames = " fx fy cx cy k1 k2 k3 k4 k5 k6 p1 p2 ppx ppy xi alpha beta f ";
  constexpr std::size_t kMaxNamed = 9;
  const std::vector<Token> tokens = tokensOf(text);
  std::vector<std::string> found;
  std::ptrdiff_t line = 0;
  for (std::size_t i = 0; i < tokens.size() && found.size() < kMaxNamed; ++i) {
    const std::string_view last = tokens[i].text.substr(tokens[i].text.find_last_of("._") + 1);
    const bool is_named = i + 1 < tokens.size() && tokens[i + 1].number && !last.empty() &&
                          kNames.find(fmt::format(" {} ", last)) != std::string_view::npos;
    const std::size_t after = tokens[i].at + tokens[i].text.size();
    if (is_named && text.substr(after, tokens[i + 1].at - after).find_first_not_of(" \t\"':=>") ==
                        std::string_view::npos) {
      found.push_back(fmt::format("{} {}", tokens[i].text, tokens[i + 1].text));
      if (line == 0) line = tokens[i].line;
    }
    const auto value = [&](std::size_t k) { return tokens[i + k].number.value_or(-1); };
    const bool is_matrix = found.empty() && i + 9 <= tokens.size() && value(0) > 1 && value(1) == 0 &&
                           value(2) > 1 && value(3) == 0 && value(4) > 1 && value(5) > 1 && value(6) == 0 &&
                           value(7) == 0 && value(8) == 1;
    if (!is_matrix) continue;
    return fmt::format("a camera matrix with fx {}, fy {}, cx {}, cy {} (line {})", tokens[i].text,
                       tokens[i + 4].text, tokens[i + 2].text, tokens[i + 5].text, tokens[i].line);
  }
  constexpr std::size_t kFew = 2;  // of one letter and a digit
  return found.size() < kFew ? "" : fmt::format("{} (from line {})", join(found, ", "), line);
}

}  // namespace alidade::detail
