// SPDX-License-Identifier: MIT
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

struct BadFile {
  std::string text;
  std::string place;  ///< behind the file's name: line and key
  std::string found;
};

std::string repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

// Each list holds the one before nine times.
std::string aliasBomb() {
  std::string text = "x_a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (char c = 'b'; c <= 'k'; ++c) {
    const std::string name(1, c);
    const std::string before = std::string("*") + static_cast<char>(c - 1);
    text += "x_" + name + ": &" + name + " [" + before + repeated(", " + before, 8) + "]\n";
  }
  return text;
}

// Runs the program on every text as a file and wants it refused; returns how many were.
template <class Run>
std::size_t numRefused(const ScratchFolder& scratch, const std::vector<BadFile>& bad_files, const Run& run) {
  std::size_t num_refused = 0;
  for (const BadFile& bad : bad_files) {
    const std::string path = scratch.write("bad.yaml", bad.text);
    const RunResult result = run(path);
    EXPECT_THAT(result, FailsWith(1, AllOf(HasSubstr(path + bad.place), HasSubstr(bad.found))))
        << bad.text.substr(0, 400);
    num_refused += result.exit_code == 1 ? 1 : 0;
  }
  EXPECT_THAT(scratch.list(), ElementsAre("bad.yaml"));
  return num_refused;
}

TEST(CameraRecord, ThatIsWrongIsNamedWithLineAndKey) {
  const std::string good = smallCamera();
  const std::string calibration = "calibration:\n  rms_px: 0.1\n  num_views: 3\n  num_corners: 9\n";
  const std::vector<BadFile> bad_files = {
      {replaced(good, "fx: 500", "fx: .nan"), ":4: parameters.fx", "found '.nan'; expected a finite number"},
      {replaced(good, "fx: 500", "fx: nan"), ":4: parameters.fx", "a finite number"},
      {replaced(good, "fx: 500", "fx: inf"), ":4: parameters.fx", "a finite number"},
      {replaced(good, "fx: 500", "fx: 1e999"), ":4: parameters.fx", "a finite number"},
      {replaced(good, "fx: 500", "fx: -500"), ":4: parameters.fx", "a positive focal length"},
      {replaced(good, "fy: 501", "fy: 0"), ":4: parameters.fy", "a positive focal length"},
      {replaced(replaced(good, "model: pinhole", "model: double_sphere"), "cy: 240",
                "cy: 240, xi: 3, alpha: 0.5"),
       ":4: parameters.xi", "found 3; expected a number from -0.99 to 1"},
      {replaced(replaced(good, "model: pinhole", "model: double_sphere"), "cy: 240",
                "cy: 240, xi: 0.3, alpha: 2"),
       ":4: parameters.alpha", "found 2; expected a number from 0 to 1"},
      {replaced(good, "fx: 500", "fx: wide"), ":4: parameters.fx", "'wide'"},
      {replaced(good, "fx: 500", "fx: [500]"), ":4: parameters.fx", "found a list; expected a number"},
      {replaced(good, "fx: 500, ", ""), ":4: parameters", "no key 'fx'"},
      {replaced(good, "fx: 500", "fz: 500"), ":4: parameters", "did you mean 'fx'?"},
      {replaced(good, "cy: 240", "cy: 240, k1: 0"), ":4: parameters", "unknown key 'k1'"},
      {replaced(good, "cy: 240", "cy: 240, cy: 241"), ":4: parameters", "the key 'cy' twice"},
      {replaced(good, "{fx: 500, fy: 501, cx: 320, cy: 240}", "[500, 501, 320, 240]"), ":4: parameters",
       "found a list"},
      {replaced(good, "width: 640", "width: 640.5"), ":3: image_size.width", "a whole number"},
      {replaced(good, "width: 640", "width: 0"), ":3: image_size.width", "1 to 1000000 pixels"},
      {replaced(good, "width: 640", "width: 99999999999"), ":3: image_size.width", "a whole number"},
      {replaced(good, "{width: 640, height: 480}", "[640, 480]"), ":3: image_size", "found a list"},
      {replaced(good, "image_size: {width: 640, height: 480}\n", ""), "", "no key 'image_size'"},
      {replaced(good, "image_size", "imagesize"), ":3", "did you mean 'image_size'?"},
      {replaced(good, "model: pinhole", "model: pinhle"), ":2: model", "did you mean 'pinhole'?"},
      {replaced(good, "alidade_camera: 1", "alidade_camera: 2"), ":1: alidade_camera", "format version 2"},
      {good + "model: pinhole\n", ":5", "the key 'model' twice"},
      {good + "paramters: {}\n", ":5", "did you mean 'parameters'?"},
      {good + "conventions: {pixel_origin: corner}\n", ":5: conventions.pixel_origin",
       "top_left_pixel_center"},
      {good + "domain: {max_angle_rad: 1}\n", ":5: domain", "no key 'full_image'"},
      {good + "domain: {max_angle_rad: 1, full_image: yes}\n", ":5: domain.full_image", "true or false"},
      {good + "self_check:\n  - {point: [0, 0], pixel: [320, 240]}\n", ":6: self_check[0].point",
       "2 numbers; expected 3"},
      {good + "self_check: 7\n", ":5: self_check", "expected a list"},
      {good + calibration + "  covariance: [1, 2]\n", ":9: calibration.covariance",
       "2 rows; expected 4 rows"},
      {good + calibration + "  covariance: [[1], [2, 3]]\n", ":9: calibration.covariance",
       "2 rows; expected 4 rows"},
      {good + calibration + "  covariance: [[1], [2, 3], [4, 5], [6, 7, 8, 9]]\n",
       ":9: calibration.covariance[2]", "2 numbers; expected 3"},
      {good + calibration + "  covariance_by: noise\n", ":9: calibration.covariance_by", "expected 'views'"},
      {good + calibration + "  view_centers: [[1, 2], [3]]\n", ":9: calibration.view_centers[1]",
       "1 number; expected 2"},
      {good + calibration + "  accuracy_px: good\n", ":9: calibration.accuracy_px", "'good'"},
      {good + "camera: {nam: left}\n", ":5: camera", "did you mean 'name'?"},
      {replaced(good + calibration, "num_views: 3", "num_views: -3"), ":7: calibration.num_views", "a count"},
      {"", "", "an empty file"},
      {"# nothing but a comment\n", "", "expected"},
      {good + "---\n" + good, "", "2 YAML documents"},
      {std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16), "", "found a PNG image"},
      {"\x01\x02\x03\x04", "", "not a camera file"},
      {"just text\n", "", "not a camera file"},
      {"- 1\n- 2\n", "", "not a camera file"},
      {"", "", "an empty file"},
      {replaced(good, "alidade_camera", "alidade_camra"), ":1: alidade_camra",
       "did you mean 'alidade_camera'?"},
      {"distortion_model: plumb_bob\n", ":1: distortion_model", "the key 'camera_matrix'"},
      {"alidade_camera: 1\nmodel: [\n", "", "not valid YAML"},
      {"alidade_camera: 1\n\tmodel: pinhole\n", ":2", "not valid YAML"},
      {repeated("[", 100'000), ":1", "nested more than"},
      {repeated("{a: ", 100'000), ":1", "nested more than"},
      {repeated("- ", 100'000), ":1", "nested more than"},
      {replaced(good, "500", repeated("[", 400) + repeated("]", 400)), ":4: parameters.fx", "found a list"},
      {replaced(good + aliasBomb(), "fx: 500", "fx: *k"), ":4", "not valid YAML"},
      {aliasBomb() + replaced(good, "fx: 500", "fx: *k"), ":11: parameters.fx", "found a list"},
      {"alidade_camera: 1\nmodel: &m [*m]\n", ":2: model", "found a list"},
      {"&all\nalidade_camera: 1\nmodel: pinhole\nimage_size: {width: 1, height: 1}\nparameters: *all\n", "",
       "unknown key 'alidade_camera'"},
  };
  const ScratchFolder scratch;
  EXPECT_EQ(numRefused(scratch, bad_files,
                       [](const std::string& path) {
                         return runAlidade({"project", path});
                       }),
            58u);
  int num_commands = 0;
  scratch.write("bad.yaml", bad_files.front().text);
  for (const char* command : {"project", "unproject"}) {
    const RunResult result = runAlidade({command, scratch.path("bad.yaml")}, {.input = "0,0,1\n"});
    EXPECT_THAT(result, FailsWith(1, HasSubstr(":4: parameters.fx")));
    ++num_commands;
  }
  EXPECT_EQ(num_commands, 2);
}

TEST(CameraRecord, TakesWhatIsHarmless) {
  const ScratchFolder scratch;
  const std::vector<std::string> texts = {
      smallCamera(),
      "\xEF\xBB\xBF" + smallCamera(),
      "# mine\n" + smallCamera() + "x_note: [anything, {at: all}]\n",
      "---\n" + smallCamera() + "...\n",
      replaced(smallCamera(), "fx: 500", "fx: 5e2"),
      aliasBomb() + smallCamera(),
  };
  std::size_t num_read = 0;
  for (const std::string& text : texts) {
    EXPECT_THAT(runAlidade({"validate", scratch.write("camera.yaml", text)}), EndsWith(0)) << text;
    ++num_read;
  }
  EXPECT_EQ(num_read, 6u);
}

TEST(SceneFile, ThatIsWrongIsNamedWithLineAndKey) {
  const std::string good =
      "alidade_scene: 1\n"
      "camera: {model: pinhole, image_size: {width: 64, height: 48}, parameters: {fx: 50, fy: 50, cx: 32, "
      "cy: 24}}\n"
      "board: checkerboard:4x3:30mm\n"
      "views: {random: 2}\n";
  const ScratchFolder scratch;
  const std::vector<BadFile> bad_files = {
      {replaced(good, "checkerboard:4x3:30mm", "checkerboard:4x3"), ":3: board", "2 parts"},
      {replaced(good, "checkerboard:4x3:30mm", "chekerboard:4x3:30mm"), ":3: board",
       "did you mean 'checkerboard'?"},
      {replaced(good, "checkerboard:4x3:30mm", "checkerboard:4x3:30"), ":3: board", "did you mean 30mm?"},
      {replaced(good, "checkerboard:4x3:30mm", "none.yaml"), ":3: board",
       scratch.path("none.yaml") + ": no such file"},
      {replaced(good,
                "{model: pinhole, image_size: {width: 64, height: 48}, parameters: {fx: 50, fy: 50, cx: 32, "
                "cy: 24}}",
                "none.yaml"),
       ":2: camera", scratch.path("none.yaml") + ": no such file"},
      {replaced(good, "model: pinhole", "model: pinehole"), ":2: camera.model", "did you mean 'pinhole'?"},
      {replaced(good, "random: 2", "random: 0"), ":4: views.random", "1 to 100000 views"},
      {replaced(good, "random: 2", "random: many"), ":4: views.random", "a whole number"},
      {replaced(good, "{random: 2}", "{}"), ":4: views", "one of them"},
      {replaced(good, "{random: 2}", "{poses: []}"), ":4: views.poses", "at least one"},
      {replaced(good, "{random: 2}", "{poses: [{translation_m: [0, 0, 1]}]}"), ":4: views.poses[0]",
       "no rotation"},
      {good + "sead: 1\n", ":5", "did you mean 'seed'?"},
      {good + "seed: -1\n", ":5: seed", "0 or more"},
      {good + "random: {max_tilt_deg: 90}\n", ":5: random", "max_tilt_deg"},
      {good + "render: {blur_px: -1}\n", ":5: render", "blur_px"},
      {good + "render: {blur_px: nan}\n", ":5: render.blur_px", "a finite number"},
      {good + "corner_noise_px: -0.1\n", ":5: corner_noise_px", "0 or more"},
      {replaced(good, "alidade_scene: 1", "alidade_scene: 9"), ":1: alidade_scene", "format version 9"},
      {replaced(good, "board: checkerboard:4x3:30mm\n", ""), "", "no key 'board'"},
      {smallCamera(), ":1", "unknown key 'alidade_camera'"},
      {"", "", "an empty file"},
      {repeated("[", 100'000), ":1", "nested more than"},
  };
  EXPECT_EQ(numRefused(scratch, bad_files,
                       [&](const std::string& path) {
                         return runAlidade({"simulate", path, "--corners-only", "-o", scratch.path("out")});
                       }),
            22u);
}

TEST(Pose, ThatIsWrongIsNamedWithItsKey) {
  struct Case {
    std::string pose;
    std::string found;
  };
  const std::string t = "translation_m: [0, 0, 1]";
  const std::vector<Case> cases = {
      {"{" + t + "}", "no rotation; expected one of quaternion_xyzw"},
      {"{quaternion_xyzw: [0, 0, 0, 1]}", "no key 'translation_m'"},
      {"{quaternion_xyzw: [0, 0, 0, 0], " + t + "}", "quaternion_xyzw: "},
      {"{quaternion_xyzw: [0, 0, 1], " + t + "}", "quaternion_xyzw: found 3 numbers; expected 4"},
      {"{quaternion_xyzw: [0, 0, 0, nan], " + t + "}", "a finite number"},
      {"{quaternion_wxyz: [0, 0, 1], " + t + "}", "quaternion_wxyz: found 3 numbers; expected 4"},
      {"{quaternion_xyzw: [0, 0, 0, 1], quaternion_wxyz: [1, 0, 0, 0], " + t + "}",
       "both quaternion_xyzw and quaternion_wxyz"},
      {"[0, 0, 0, 1]", "a list, '[0, 0, 0, 1]'; expected a map"},
      {"{quaternion: [0, 0, 0, 1], " + t + "}", "unknown key 'quaternion'"},
      {"{rotation_vector_rad: [0, 0, 0], euler_zyx_deg: [0, 0, 0], " + t + "}",
       "both rotation_vector_rad and euler_zyx_deg"},
      {"{rotation_matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 2]], " + t + "}", "rotation_matrix: "},
      {"{rotation_matrix: [[1, 0, 0], [0, 1, 0], [0, 0, -1]], " + t + "}", "rotation_matrix: "},
      {"{rotation_matrix: [[1, 0, 0], [0, 1, 0]], " + t + "}", "rotation_matrix"},
      {"{matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 2]]}", "matrix: "},
      {"{matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], " + t + "}", "only 'matrix'"},
      {"{camera_from_world: 1}", "camera_from_world"},
      {"{camera_from_wrld: {}}", "unknown key 'camera_from_wrld'"},
      {"{quaternion_xyzw: [0, 0, 0, 1], ", "not valid YAML"},
      {"{}", "no rotation"},
  };
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    EXPECT_THAT(runAlidade({"project", dataPath("camera.yaml"), "--pose", c.pose}, {.input = "0,0,1\n"}),
                FailsWith(1, AllOf(HasSubstr("pose"), HasSubstr(c.found))))
        << c.pose;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 19u);
  const ScratchFolder scratch;
  const std::string file =
      scratch.write("pose.yaml", "rotation_vector_rad: [0, 0]\ntranslation_m: [0, 0, 1]\n");
  EXPECT_THAT(runAlidade({"project", dataPath("camera.yaml"), "--pose", file}),
              FailsWith(1, HasSubstr(file + ":1: rotation_vector_rad: found 2 numbers; expected 3")));
}

TEST(SettingsFile, ThatIsWrongIsNamedWithLineAndKey) {
  const std::vector<BadFile> bad_files = {
      {"modl: pinhole\n", ":1: modl", "did you mean 'model'?"},
      {"board: checkerboard:9x6:25mm\nmodel: pinhle\n", ":2: model", "pinhle"},
      {"jobs: many\n", ":1: jobs", "many"},
      {"jobs: [1, 2]\n", ":1: jobs", "jobs"},
      {"json: perhaps\n", ":1: json", "perhaps"},
      {"\nboard: chekerboard:9x6:25mm\n", ":2: board", "did you mean 'checkerboard'?"},
      {"model: {a: 1}\n", ":1: model", "a single value"},
      {"model: radtan\nmodel: pinhole\n", ":2", "the key 'model' twice"},
      {"config: other.yaml\n", ":1: config", "is not a flag of calibrate"},
      {"- model\n", ":1", "no map"},
      {"", "", "an empty file"},
      {repeated("[", 100'000), ":1", "nested more than"},
  };
  const ScratchFolder scratch;
  EXPECT_EQ(numRefused(scratch, bad_files,
                       [](const std::string& path) {
                         return runAlidade({"calibrate", dataPath("corners.csv"), "--config", path});
                       }),
            12u);
  EXPECT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "--config", scratch.path("bda.yaml")}),
              FailsWith(1, HasSubstr("did you mean '" + scratch.path("bad.yaml") + "'?")));
}

}  // namespace
}  // namespace alidade
