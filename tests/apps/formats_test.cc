// SPDX-License-Identifier: MIT
// Camera files of other tools on the command line: every command takes them, and convert hands them on.
#include <map>
#include <sstream>
#include <tuple>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

constexpr const char* kChain = R"(cam0:
  camera_model: pinhole
  distortion_coeffs: [-0.1, 0.02, 0.001, 0.002]
  distortion_model: radtan
  intrinsics: [500.0, 501.0, 320.0, 240.0]
  resolution: [640, 480]
cam1:
  camera_model: pinhole
  distortion_coeffs: [-0.01, 0.02, -0.03, 0.004]
  distortion_model: equidistant
  intrinsics: [300.0, 301.0, 320.0, 240.0]
  resolution: [640, 480]
  T_cn_cnm1: [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
)";

std::string project(const std::string& camera) {
  const RunResult run = runAlidade({"project", camera, "-"}, {.input = "x,y,z\n0.3,-0.2,1\n"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.out;
}

// From Kalibr through all formats that hold the lens, and back to Kalibr.
TEST(Formats, HandACameraOn) {
  const ScratchFolder folder;
  const std::string chain = folder.write("camchain.yaml", kChain);
  const std::string start = project(chain + "#cam1");
  std::string last = chain + "#cam1";
  int num_formats = 0;
  for (const char* format :
       {"alidade", "opencv", "ros", "colmap", "basalt", "nerfstudio", "camodocal", "orbslam", "kalibr"}) {
    const std::string next = folder.path(std::string("camera.") + format);
    const RunResult run = runAlidade({"convert", last, "-o", next, "--to", format});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, testing::HasSubstr("written to"));
    EXPECT_EQ(run.err.find("the pose of the camera is not written") != std::string::npos, num_formats == 0)
        << run.err;
    EXPECT_EQ(project(next), start) << format;
    last = next;
    ++num_formats;
  }
  EXPECT_EQ(num_formats, 9);
}

TEST(Formats, HoldAllCamerasOfAChain) {
  const ScratchFolder folder;
  const std::string chain = folder.write("camchain.yaml", kChain);
  const std::string cameras = folder.path("cameras.txt");
  ASSERT_EQ(runAlidade({"convert", chain, "-o", cameras, "--to", "colmap"}).exit_code, 0);
  EXPECT_EQ(project(cameras + "#1"), project(chain + "#cam0"));
  EXPECT_EQ(project(cameras + "#2"), project(chain + "#cam1"));
  const RunResult which = runAlidade({"project", cameras, "-"});
  EXPECT_EQ(which.exit_code, 1);
  EXPECT_THAT(which.err,
              testing::AllOf(testing::HasSubstr("2 cameras: 1, 2"), testing::HasSubstr("cameras.txt#1")));
}

TEST(Formats, RefuseWhatTheyCannotHold) {
  const ScratchFolder folder;
  const std::string chain = folder.write("camchain.yaml", kChain);
  const std::string output = folder.path("camera.cameramodel");
  const RunResult refused = runAlidade({"convert", chain + "#cam1", "-o", output, "--to", "mrcal"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err,
              testing::AllOf(testing::HasSubstr("kannala_brandt"), testing::HasSubstr("--model")));
  EXPECT_FALSE(folder.has("camera.cameramodel"));
}

// What leaves a wrong camera without a word is worse than any refusal.
TEST(Formats, RefuseWhatContradictsItself) {
  const ScratchFolder scratch;
  const std::string matrix = "camera_matrix: [[532.8, 0, 342.5], [0, 532.9, 233.9], [0, 0, 1]]\n";
  const std::string size = "image_width: 640\nimage_height: 480\n";
  const std::string five = "[-0.281, 0.025, 0.0012, -0.0001, 0.063]\n";
  struct Case {
    std::string text;
    std::vector<std::string> flags;
    std::string complaint;
  };
  const std::vector<Case> cases = {
      {size + matrix + "distortion_coeffs: " + five, {}, "'distortion_coeffs'"},
      {size + matrix + "D1: " + five, {}, "'D1'"},
      {size + matrix + "distortion_coefficients: " + five + "D: " + five, {}, "'D' and"},
      {size + matrix + "K: [1, 0, 0, 0, 1, 0, 0, 0, 1]\ndistortion_coefficients: " + five, {}, "'K' and"},
      {size + "image_size: [320, 240]\n" + matrix + "D: " + five, {}, "an image size that differs"},
      {size + "camera_matrix: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n  data: [5, 0, 3, 0, 5, 2, 0, "
              "0, 1]\n"
              "fisheye_model: 0\ndistortion_model: fisheye\nD: [0, 0, 0, 0]\n",
       {},
       "values that agree"},
      {size + matrix + "fisheye_model: 1\nD: [0, 0, 0, 0]\n", {"--read-as", "radtan"}, "from --read-as"},
      {"1 PINHOLE 640 480 500 500 320 240\n1 PINHOLE 640 480 600 600 320 240\n", {}, "two cameras named '1'"},
  };
  const std::string points = scratch.write("points.csv", "x,y,z\n0.1,0.2,1\n");
  int num_refused = 0;
  for (const Case& c : cases) {
    std::vector<std::string> args = {"project", scratch.write("camera.txt", c.text), points};
    args.insert(args.end(), c.flags.begin(), c.flags.end());
    const RunResult result = runAlidade(args);
    EXPECT_THAT(result, FailsWith(1, testing::HasSubstr(c.complaint))) << c.text;
    num_refused += result.exit_code == 1 ? 1 : 0;
  }
  EXPECT_EQ(num_refused, 8);
  // COLMAP's names are numbers: one that is missing is no place in the list.
  const std::string several =
      scratch.write("cameras.txt", "1 PINHOLE 640 480 500 500 320 240\n3 PINHOLE 640 480 600 600 320 240\n");
  EXPECT_THAT(runAlidade({"project", several + "#0", points}),
              FailsWith(1, testing::HasSubstr("no camera '0'")));
  EXPECT_THAT(runAlidade({"project", several + "#3", points}), EndsWith(0));
  // What was assumed is told.
  const RunResult bare = runAlidade({"project", scratch.write("bare.yml", size + matrix), points});
  EXPECT_THAT(bare, EndsWith(0));
  EXPECT_THAT(bare.err, testing::HasSubstr("note: "));
  // `rostopic echo` ends a message with a line of its own.
  EXPECT_THAT(runAlidade({"project",
                          scratch.write("echo.yaml",
                                        "height: 480\nwidth: 640\ndistortion_model: plumb_bob\n"
                                        "D: " +
                                            five + "K: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n---\n"),
                          points}),
              EndsWith(0));
}

// One camera of a model that is not supported is no reason against the others, and never taken for them.
TEST(Formats, SetCamerasAsideThatAreNotSupported) {
  const ScratchFolder scratch;
  const std::string points = scratch.write("points.csv", "x,y,z\n0.1,0.2,1\n");
  const std::string kalibr_tail =
      "\n  intrinsics: [500, 500, 320, 240]\n  distortion_model: none\n  distortion_coeffs: []\n"
      "  resolution: [640, 480]\n";
  const std::string nerf_tail = R"(","fl_x":500,"fl_y":500,"cx":320,"cy":240,"w":640,"h":480})";
  const std::string basalt_tail = R"(","intrinsics":{"fx":500,"fy":500,"cx":320,"cy":240}})";
  struct Case {
    std::string text;
    std::string bad;
    std::string good;
    std::string bad_by_number;  // empty where names are numbers
  };
  const std::vector<Case> cases = {
      {"1 EQUIRECTANGULAR 640 480 0\n2 PINHOLE 640 480 500 500 320 240\n", "1", "2", ""},
      {"cam0:\n  camera_model: sphere" + kalibr_tail + "cam1:\n  camera_model: pinhole" + kalibr_tail, "cam0",
       "cam1", "0"},
      {R"({"value0":{"intrinsics":[{"camera_type":"sphere)" + basalt_tail + R"(,{"camera_type":"pinhole)" +
           basalt_tail + R"(],"resolution":[[640,480],[640,480]]}})",
       "cam0", "cam1", "0"},
      {R"({"frames":[{"file_path":"a","camera_model":"EQUIRECTANGULAR)" + nerf_tail +
           R"(,{"file_path":"b","camera_model":"PINHOLE)" + nerf_tail + "]}",
       "a", "b", "0"},
      {"K1: [500, 0.5, 320, 0, 500, 240, 0, 0, 1]\nK2: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n"
       "image_size: [640, 480]\n",
       "1", "2", ""},
  };
  int num_files = 0;
  for (const Case& c : cases) {
    const std::string file = scratch.write("cameras.txt", c.text);
    EXPECT_THAT(runAlidade({"project", file + "#" + c.good, points}), EndsWith(0)) << c.text;
    std::vector<std::string> names = {c.bad};
    if (!c.bad_by_number.empty()) {
      names.push_back(c.bad_by_number);
      EXPECT_THAT(runAlidade({"project", file + "#1", points}), EndsWith(0)) << c.text;
    }
    const RunResult one = runAlidade({"project", file + "#" + c.bad, points});
    for (const std::string& name : names) {
      const RunResult refused = runAlidade({"project", file + "#" + name, points});
      EXPECT_THAT(refused, FailsWith(1, testing::HasSubstr("cameras.txt:"))) << c.text;
      EXPECT_EQ(refused.err, one.err);
    }
    EXPECT_THAT(runAlidade({"project", file, points}),
                FailsWith(1, testing::HasSubstr("2 cameras: " + c.good + " (not supported: " + c.bad + ")")));
    const std::string output = scratch.path("out.yaml");
    EXPECT_THAT(runAlidade({"convert", file, "-o", output, "--to", "kalibr"}),
                FailsWith(1, testing::HasSubstr("1 of 2 cameras are not supported: " + c.bad)));
    EXPECT_FALSE(scratch.has("out.yaml"));
    const RunResult judged = runAlidade({"validate", file, "--json"});
    EXPECT_THAT(judged, EndsWith(3)) << c.text;
    const auto files = nlohmann::json::parse(judged.out).at("files");
    ASSERT_EQ(files.size(), 1u);
    EXPECT_EQ(files[0].at("file"), file);
    const auto cameras = files[0].at("cameras");
    ASSERT_EQ(cameras.size(), 2u);
    EXPECT_EQ(cameras[0].at("name"), c.good);
    EXPECT_TRUE(cameras[0].at("model").is_string());
    EXPECT_EQ(cameras[1].at("name"), c.bad);
    EXPECT_TRUE(cameras[1].at("model").is_null());
    ASSERT_EQ(cameras[1].at("checks").size(), 1u);
    EXPECT_EQ(cameras[1].at("checks")[0].at("id"), "model");
    EXPECT_EQ(cameras[1].at("checks")[0].at("status"), "failure");
    ++num_files;
  }
  EXPECT_EQ(num_files, 5);
  // A file without a camera that is supported is not readable.
  const RunResult none =
      runAlidade({"validate", scratch.write("none.txt", "1 EQUIRECTANGULAR 640 480 5 5 320 240 0\n")});
  EXPECT_THAT(none, EndsWith(3));
  EXPECT_THAT(none.out, testing::HasSubstr("EQUIRECTANGULAR"));
}

TEST(Formats, LimitsAreNumbers) {
  const std::string camera = dataPath("camera.yaml");
  int num_refused = 0;
  for (const auto& args : std::vector<std::vector<std::string>>{
           {"convert", camera, "-o", "-", "--model", "pinhole", "--max-error", "nan"},
           {"validate", camera, "--against", camera, "--tolerance", "nan"},
           {"diff", camera, camera, "--tolerance", "nan"},
           {"diff", camera, camera, "--distance", "nan"}}) {
    EXPECT_THAT(runAlidade(args),
                FailsWith(2, testing::AnyOf(testing::HasSubstr("a finite number"),
                                            testing::HasSubstr("a positive number of pixels"))));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 4);
}

TEST(Formats, ADamagedFileOfAFolderIsNoOtherFile) {
  const ScratchFolder scratch;
  scratch.write("good.yaml", readFile(dataPath("camera.yaml")));
  scratch.write("cut.yaml", readFile(dataPath("camera.yaml")).substr(0, 200));
  scratch.write("empty.yaml", "");
  scratch.write("zeros.json", std::string(100, '\0'));
  scratch.write("notes.yaml", "nothing: of a camera\n");
  scratch.write("latin.txt", "gr\xfc\xdf\n");
  const RunResult result = runAlidade({"validate", scratch.path(""), "--json", "--quiet"});
  EXPECT_THAT(result, EndsWith(3));
  const auto document = nlohmann::json::parse(result.out);
  EXPECT_EQ(document.at("files").size(), 4u);
  EXPECT_EQ(document.at("totals").at("failed"), 3);
  EXPECT_EQ(document.at("other_files").size(), 2u);
}

// What every other command tells as a note is in the rows of `validate` too.
TEST(Formats, HaveEveryNoteOfOtherCommandsInARowOfValidate) {
  const ScratchFolder scratch;
  const std::string ros =
      "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [532.8, 0, 342.5, 0, "
      "532.9, 233.9, 0, 0, 1]}\ndistortion_model: plumb_bob\n"
      "distortion_coefficients: {rows: 1, cols: 5, data: [-0.281, 0.025, 0.0012, -0.0001, 0.163]}\n"
      "binning_x: 2\nbinning_y: 2\n";
  const std::string size = "image_width: 640\nimage_height: 480\n";
  const std::string opencv =
      size + "camera_matrix: {rows: 3, cols: 3, data: [532.8, 0, 342.5, 0, 532.9, 233.9, 0, 0, 1]}\n";
  int num_notes = 0;
  for (const std::string& text :
       {ros, ros + "roi:\n  x_offset: 8\n  width: 320\n  height: 240\n",
        ros + "rectification_matrix: [1, 0, 0, 0, 0.9, 0, 0, 0, 1]\n", ros + "serial: 7\n",
        opencv + "R: [1, 0, 0, 0, 0.9, 0, 0, 0, 1]\n", opencv}) {
    const std::string path = scratch.write("noted.yaml", text);
    const RunResult converted = runAlidade({"convert", path, "--to", "alidade", "-o",
                                            scratch.path("out" + std::to_string(num_notes) + ".yaml")});
    ASSERT_THAT(converted, EndsWith(0));
    const auto checks = nlohmann::json::parse(runAlidade({"validate", path, "--json"}).out)
                            .at("files")[0]
                            .at("cameras")[0]
                            .at("checks");
    std::string warned;
    for (const auto& check : checks) {
      if (check.at("status") == "note" || check.at("status") == "warning")
        warned += check.at("message").get<std::string>() + "\n";
    }
    std::istringstream notes(converted.err);
    for (std::string line; std::getline(notes, line);) {
      const std::string start = "note: " + path + ":";
      if (!line.starts_with(start)) continue;
      EXPECT_THAT(warned, testing::HasSubstr("line " + line.substr(start.size())));
      ++num_notes;
    }
  }
  EXPECT_EQ(num_notes, 9);
}

TEST(Formats, AreListedWithTheModelsThatTheyHold) {
  const RunResult list = runAlidade({"formats"});
  ASSERT_THAT(list, EndsWith(0));
  std::istringstream lines(list.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
  const auto formats = nlohmann::json::parse(runAlidade({"formats", "--json"}).out).at("formats");
  std::map<std::string, std::string> held;  // of each format: "pinhole radtan(k3 = 0) ucm=omni"
  for (const auto& format : formats) {
    const std::string id = format.at("format");
    EXPECT_THAT(list.out, testing::ContainsRegex("(^|\n)" + id + " "));
    for (const auto& one : format.at("models")) {
      const std::string as = one.at("as") == one.at("model") ? "" : "=" + one.at("as").get<std::string>();
      held[id] += one.at("model").get<std::string>() + as +
                  (one.at("zero").empty() ? "" : "(" + one.at("zero").at(0).get<std::string>() + " = 0)") +
                  " ";
    }
  }
  // The documents of Kalibr and of COLMAP's camera models.
  EXPECT_THAT(held.at("kalibr"),
              testing::AllOf(testing::HasSubstr("radtan(k3 = 0) "), testing::HasSubstr("ucm=omni "),
                             testing::Not(testing::HasSubstr("rational"))));
  EXPECT_THAT(held.at("colmap"),
              testing::AllOf(testing::HasSubstr("radtan=rational "), testing::HasSubstr("eucm "),
                             testing::Not(testing::HasSubstr("double_sphere"))));
  EXPECT_EQ(held.size(), formats.size());
}

TEST(Formats, SayWhatTheyMakeOfAModel) {
  const RunResult text = runAlidade({"formats", "fisheye"});
  ASSERT_THAT(text, EndsWith(0));
  EXPECT_THAT(
      text.out,
      testing::AllOf(testing::HasSubstr("\nopencv    exactly\n"),
                     testing::ContainsRegex("\nmrcal +fitted by [a-z_]+, typically [0-9.e-]+ px RMS")));
  const auto formats = nlohmann::json::parse(runAlidade({"formats", "radtan", "--json"}).out).at("formats");
  int num_exact = 0;
  for (const auto& one : formats) {
    if (one.at("format") == "kalibr") {
      EXPECT_EQ(one.at("zero"), nlohmann::json::array({"k3"}));
      EXPECT_GT(one.at("typical_rms_px"), 0);
    }
    num_exact += one.at("zero").empty() && !one.at("as").is_null() ? 1 : 0;
  }
  EXPECT_GE(num_exact, 8);
  EXPECT_THAT(runAlidade({"formats", "radtn"}), FailsWith(2, testing::HasSubstr("did you mean 'radtan'?")));
}

// The format is forced for the input alone, and --format is answered where it could mean either.
TEST(Formats, AreReadAsStated) {
  const ScratchFolder folder;
  const std::string chain = folder.write("camchain.yaml", kChain);
  const std::string out = folder.path("out.yaml");
  EXPECT_THAT(runAlidade({"convert", chain + "#cam0", "-o", out, "--from", "camchain", "--to", "ros"}),
              EndsWith(0));
  EXPECT_THAT(runAlidade({"convert", chain, "-o", out, "--from", "mrcal"}),
              FailsWith(1, testing::HasSubstr("camchain.yaml")));
  EXPECT_THAT(
      runAlidade({"convert", out, "-o", chain, "--format", "kalibr"}),
      FailsWith(2, testing::AllOf(testing::HasSubstr("--to with one of"), testing::HasSubstr("--from"))));
  EXPECT_THAT(runAlidade({"validate", out, "--format", "ros"}), EndsWith(0));
}

// Files on disk that cannot be read as text: other kinds are named, damage to text stays damage.
TEST(Formats, NameBinaryFilesByTheirKind) {
  const ScratchFolder folder;
  const std::string heic =
      folder.write("IMG_1.HEIC", std::string("\0\0\0\x18", 4) + "ftypheic" + std::string(40, '\0'));
  EXPECT_THAT(runAlidade({"project", heic, "-"}, {.input = "x,y,z\n0,0,1\n"}),
              FailsWith(1, testing::AllOf(testing::HasSubstr("a HEIC photograph"),
                                          testing::HasSubstr("heif-convert"))));
  const std::string zeros = std::string(100, '\0');
  for (const auto& [name, content, found] :
       {std::tuple("calib.npz", "PK\x03\x04" + zeros, "NumPy arrays (npz)"),
        std::tuple("k.npy", "\x93NUMPY\x01" + zeros, "a NumPy array"),
        std::tuple("a.bin", "\x01" + zeros, "a binary file of unknown kind"),
        std::tuple("a.yaml", "a: 1\n" + zeros, "zero byte at offset 5")}) {
    EXPECT_THAT(runAlidade({"validate", folder.write(name, content)}).out, testing::HasSubstr(found)) << name;
  }
}

TEST(Formats, OfRosReadAPartOfTheImageOnRequest) {
  const ScratchFolder folder;
  const std::string path = folder.write(
      "info.yaml",
      "width: 1280\nheight: 800\ndistortion_model: plumb_bob\nD: []\nK: [600, 0, 640, 0, 600, 400, 0, 0, 1]\n"
      "roi: {x_offset: 320, y_offset: 200, width: 640, height: 400}\n");
  const RunResult whole = runAlidade({"project", path, "-"}, {.input = "x,y,z\n0,0,1\n"});
  EXPECT_THAT(whole.out, testing::HasSubstr("640"));
  EXPECT_THAT(whole.err,
              testing::HasSubstr("K is of 1280x800; this image is its part at x 320, y 200 of 640x400"));
  const RunResult part =
      runAlidade({"project", path, "-", "--apply-roi", "--json"}, {.input = "x,y,z\n0,0,1\n"});
  EXPECT_THAT(part.out, testing::AllOf(testing::HasSubstr("320"), testing::HasSubstr("200"),
                                       testing::Not(testing::HasSubstr("640"))));
}

// theta (1 + k1 theta^2) folds at theta = 1 / sqrt(-3 k1); its radius there is 2/3 of that.
TEST(Formats, OfFoldingLensesAreCountedInAFolder) {
  const ScratchFolder folder;
  const auto fisheye = [](double k1) {
    return "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\nfisheye_model: 1\nK: [320, 0, 319.5, 0, 320, 239.5, 0, 0, "
           "1]\nD: [" +
           std::to_string(k1) + ", 0, 0, 0]\n";
  };
  folder.write("all/none.yaml", fisheye(-0.05));    // 1.72 beyond the corner's 1.25
  folder.write("all/corner.yaml", fisheye(-0.12));  // 1.11
  folder.write("all/edge.yaml", fisheye(-0.16));    // 0.96, before the edge's 1
  const RunResult run = runAlidade({"validate", folder.path("all")});
  EXPECT_THAT(run.out, testing::AllOf(testing::HasSubstr(
                                          "2 files have a lens that folds over before the image corner, 1 of "
                                          "them before the edge"),
                                      testing::ContainsRegex("corner.yaml.*before the image corner"),
                                      testing::ContainsRegex("edge.yaml.*before the image edge")));
}

}  // namespace
}  // namespace alidade
