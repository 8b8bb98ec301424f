// SPDX-License-Identifier: MIT
// Whole runs of the program, with arguments from a grammar: a byte is a word, a flag with its value in one
// word, or the start of text of any kind.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "apps/alidade/console.h"
#include "apps/alidade/program.h"
#include "fuzz.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

constexpr std::array kWords = {
    "calibrate", "detect", "project", "unproject", "undistort", "validate", "diff", "convert", "simulate",
    "fleet", "track",
    // Flags.
    "--help", "--version", "--against", "--bin", "--board", "--board-shape", "--camera", "--camera-only",
    "--clip", "--config", "--corners-only", "--crop", "--debug", "--distance", "--evidence", "--fix",
    "--footage", "--fov", "--front-end", "--grid", "--image-size", "--images", "--init", "--interpolation",
    "--jacobian", "--jobs", "--json", "--junit", "--keep", "--keep-untrustworthy", "--max-error", "--model",
    "--name", "--next-view", "-o", "--overwrite", "--pose", "--poses", "--poses-are", "--projection",
    "--quiet", "--read-as", "--resize", "--rotate", "--same-focal", "--same-frame", "--serial", "--size",
    "--strict", "--target-sigma", "--to", "--tolerance", "--verbose", "--",
    // Files and folders that are there, and names for new ones.
    "camera.yaml", "lens.yaml", "corners.csv", "points.csv", "pixels.csv", "poses.csv", "scene.yaml",
    "board.yaml", "settings.yaml", "images", "images/view_001.png", "sim", ".", "-", "new", "new.yaml",
    "new.csv", "new.svg", "", "*.png", "images/*.png",
    // Values.
    "checkerboard:4x3:30mm", "4x3", "96x72", "48x36", "0,0,48,36", "0", "1", "2", "90", "-90", "0.5", "-1",
    "1e9", "nan", "inf", "1e-320", "10px", "1m", "30mm", "1:2", "auto", "pinhole", "radtan", "kannala_brandt",
    "ucm", "off", "flat", "all", "fx", "fx=80", "[0,0,1]", "{position: [0, 0, 1], orientation: [0, 0, 0, 1]}",
    "opencv", "kalibr", "alidade", "ros", "valid", "cylindrical", "equirectangular", "cubic", "nearest",
    "camera_from_world", "all: pixels"};

class Arguments {
 public:
  Arguments(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {
    constexpr std::size_t kMax = 24;
    while (at_ < size_ && words_.size() < kMax) words_.push_back(word());
  }
  [[nodiscard]] const std::vector<std::string>& words() const { return words_; }

 private:
  std::uint8_t next() { return at_ < size_ ? data_[at_++] : std::uint8_t{0}; }
  std::string word() {
    const std::uint8_t byte = next();
    constexpr std::uint8_t kJoined = 250;
    if (byte == kJoined)
      return std::string(kWords[next() % kWords.size()]) + "=" + kWords[next() % kWords.size()];
    return byte < kJoined ? kWords[byte % kWords.size()] : text();
  }
  // Without the characters that lead out of the folder or end an argument.
  std::string text() {
    constexpr std::size_t kMaxBytes = 32;
    const std::size_t size = next() % kMaxBytes;
    std::string text;
    for (std::size_t i = 0; i < size && at_ < size_; ++i) {
      const char c = static_cast<char>(next());
      text += c == '/' || c == '\0' ? '_' : c;
    }
    return text;
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
  std::vector<std::string> words_;
};

struct Run {
  int exit_code = 0;
  std::string messages;
};

Run run(std::vector<std::string> words) {
  words.insert(words.begin(), "alidade");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const stream = ::open_memstream(&text, &size);
  sendMessagesTo(stream);
  Run run;
  run.exit_code = runProgram(static_cast<int>(words.size()), argv.data());
  sendMessagesTo(nullptr);
  std::fclose(stream);
  run.messages.assign(text, size);
  std::free(text);
  return run;
}

// A folder with a small input of every kind. Each run gets it anew.
class Desk {
 public:
  Desk() {
    std::filesystem::current_path(scratch_.path());
    writeTexts();
    expect(run({"simulate", "scene.yaml", "-o", "sim"}).exit_code == 0, "the desk's own images");
    for (const char* name : {"corners.csv", "images/view_001.png", "images/view_002.png"})
      files_.emplace_back(name, scratch_.read(std::string("sim/") + name));
  }
  void clear() const {
    for (const std::string& name : scratch_.list()) std::filesystem::remove_all(scratch_.path(name));
    writeTexts();
    for (const auto& [name, text] : files_) scratch_.write(name, text);
  }
  [[nodiscard]] std::vector<std::string> list() const { return scratch_.list(); }

 private:
  void writeTexts() const {
    constexpr const char* kStart = "image_size: {width: 96, height: 72}";
    scratch_.write("camera.yaml", "alidade_camera: 1\nmodel: pinhole\n" + std::string(kStart) +
                                      "\nparameters: {fx: 80, fy: 80, cx: 47.5, cy: 35.5}\n");
    scratch_.write("lens.yaml",
                   "alidade_camera: 1\nmodel: radtan\n" + std::string(kStart) +
                       "\nparameters: {fx: 80, fy: 81, cx: 47, cy: 36, k1: -0.1, k2: 0.01, p1: 0, "
                       "p2: 0, k3: 0}\n");
    scratch_.write("scene.yaml",
                   "alidade_scene: 1\ncamera: camera.yaml\nboard: checkerboard:4x3:30mm\n"
                   "views: {random: 4}\nrender: {samples: 4}\n");
    scratch_.write("board.yaml", "alidade_board: 1\ntype: checkerboard\ncolumns: 4\nrows: 3\nsquare: 30mm\n");
    scratch_.write("points.csv", "x,y,z\n0.1,0.2,1\n0,0,-1\n");
    scratch_.write("pixels.csv", "u,v\n10,20\n900,0\n");
    scratch_.write("poses.csv", "image,tx,ty,tz,qx,qy,qz,qw\na,0,0,1,0,0,0,1\n");
    scratch_.write("settings.yaml", "json: true\n");
  }

  ScratchFolder scratch_;
  std::vector<std::pair<std::string, std::string>> files_;
};

}  // namespace
}  // namespace alidade

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  static const Desk desk;
  desk.clear();
  const Run result = run(Arguments(data, size).words());
  constexpr int kMaxCode = 3;
  expect(result.exit_code >= 0 && result.exit_code <= kMaxCode, "an exit code as documented");
  expect(result.messages.find("error: internal") == std::string::npos, "complaints are about the input");
  const bool has_failed = result.exit_code == 1 || result.exit_code == 2;
  expect(!has_failed || !result.messages.empty(), "a failure is explained");
  for (const std::string& name : desk.list())
    expect(name.find(".tmp") == std::string::npos && name.find(".old") == std::string::npos,
           "nothing is left over");
  return 0;
}
