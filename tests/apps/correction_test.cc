// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/correction_field.h"
#include "alidade/files/camera_source.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Two by one cells over the image; u of the control points rises and falls by some pixels.
std::string fieldText(double px) {
  std::string text =
      "correction:\n  grid: {columns: 2, rows: 1, x: -0.5, y: -0.5, cell_width: 320, cell_height: 480}\n"
      "  coefficients:\n";
  for (int row = 0; row < 4; ++row) {
    text += "    - [";
    for (int column = 0; column < 5; ++column)
      text += fmt::format("{}{}, {}", column > 0 ? ", " : "", (column + row) % 2 == 0 ? px : -px, 0.5 * px);
    text += "]\n";
  }
  return text;
}

std::string cameraWithField(const std::string& field) {
  return "alidade_camera: 1\nmodel: radtan\nimage_size: {width: 640, height: 480}\n"
         "parameters: {fx: 560, fy: 560.4, cx: 322, cy: 238, k1: -0.2, k2: 0.05, p1: 0, p2: 0, k3: 0}\n" +
         field;
}

// Corners of a board by a lens with a field, and by the lens alone.
void simulateField(const ScratchFolder& scratch, const std::string& field, int num_views) {
  scratch.write("camera.yaml", cameraWithField(field));
  const std::string scene = scratch.write(
      "scene.yaml", "alidade_scene: 1\ncamera: camera.yaml\nboard: checkerboard:11x8:20mm\nviews: {random: " +
                        std::to_string(num_views) +
                        "}\nseed: 4\nrandom: {max_tilt_deg: 40, min_fill: 0.3, max_fill: 0.8}\n"
                        "corner_noise_px: 0.05\n");
  ASSERT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("set"), "--corners-only"}), EndsWith(0));
}

TEST(Correction, IsCheckedInFiles) {
  const ScratchFolder scratch;
  EXPECT_THAT(runAlidade({"validate", scratch.write("camera.yaml", cameraWithField(fieldText(0.5)))}),
              EndsWith(0));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = fieldText(0.5);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  int num_refused = 0;
  for (const auto& [field, complaint] :
       {std::pair(changed("columns: 2", "columns: 3"), "12"),
        std::pair(changed("columns: 2", "columns: 100000000"), "1 to 200"),
        std::pair(changed("rows: 1", "rows: -1"), "1 to 200"),
        std::pair(changed("rows", "row"), "did you mean"),
        std::pair(changed("cell_width: 320", "cell_width: 0"), "without a place"),
        std::pair(changed("[0.5", "[.nan"), "line 8"), std::pair(changed("[0.5", "[text"), "line 8"),
        std::pair(changed("- [0.5", "- [1000, 0.5"), "11 numbers"),
        std::pair(fieldText(900), "may change places"), std::pair(fieldText(1e9), "1e6"),
        std::pair(changed("rows: 1", "rows: 2"), "40 numbers"),
        std::pair(std::string("correction: 3\n"), "line 5")}) {
    const RunResult result = runAlidade({"validate", scratch.write("camera.yaml", cameraWithField(field))});
    EXPECT_THAT(result, EndsWith(3)) << field;
    EXPECT_THAT(result.out + result.err, HasSubstr(complaint)) << field;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 12);
}

TEST(Correction, IsKeptByConversionsOrRefused) {
  const ScratchFolder scratch;
  const std::string from = scratch.write("camera.yaml", cameraWithField(fieldText(3)));
  const std::string to = scratch.path("to.yaml");
  const auto pixelOf = [&](const std::string& camera) {
    const RunResult result = runAlidade({"project", camera}, {.input = "0.1,0.07,0.5\n"});
    EXPECT_THAT(result, EndsWith(0));
    return result.out;
  };
  const std::string pixel = pixelOf(from);
  EXPECT_NE(pixel, pixelOf(scratch.write("plain.yaml", cameraWithField(""))));
  ASSERT_THAT(runAlidade({"convert", from, "-o", to, "--rotate", "90"}), EndsWith(0));
  EXPECT_THAT(runAlidade({"validate", to}), EndsWith(0));
  ASSERT_THAT(runAlidade({"convert", to, "-o", scratch.path("back.yaml"), "--rotate", "270"}), EndsWith(0));
  EXPECT_EQ(pixelOf(scratch.path("back.yaml")).substr(0, 14), pixel.substr(0, 14));
  const std::string ros = scratch.path("ros.yaml");
  const RunResult refused = runAlidade({"convert", from, "-o", ros, "--to", "ros"});
  EXPECT_THAT(refused, EndsWith(1));
  EXPECT_THAT(refused.err, AllOf(HasSubstr("px (RMS)"), HasSubstr("--drop-correction")));
  ASSERT_THAT(
      runAlidade({"convert", from, "-o", ros, "--to", "ros", "--drop-correction", "--max-error", "9"}),
      EndsWith(0));
  ASSERT_THAT(runAlidade({"convert", from, "-o", to, "--drop-correction"}), EndsWith(3));
  const RunResult dropped = runAlidade({"convert", from, "-o", to, "--drop-correction", "--max-error", "9"});
  ASSERT_THAT(dropped, EndsWith(0));
  EXPECT_THAT(dropped.out, AllOf(HasSubstr("Drop     correction"), HasSubstr("Error    RMS")));
  EXPECT_THAT(scratch.read("to.yaml"), Not(HasSubstr("\ncorrection")));
}

TEST(Correction, IsCalibratedValidatedAndReported) {
  const ScratchFolder scratch;
  simulateField(scratch, fieldText(8), 30);
  const std::string corners = scratch.path("set/corners.csv");
  const std::string found = scratch.path("found.yaml");
  const RunResult result =
      runAlidade({"calibrate", corners, "-o", found, "--report", scratch.path("page.html"), "--evidence",
                  scratch.path("evidence.json"), "--json"});
  ASSERT_THAT(result, EndsWith(0));
  const nlohmann::json document = nlohmann::json::parse(result.out);
  ASSERT_FALSE(document["correction"].is_null());
  const CameraRecord record = onlyCamera(parseCameras(scratch.read("found.yaml"), "found.yaml"));
  ASSERT_NE(record.camera.correction(), nullptr);
  EXPECT_EQ(record.camera.correction()->points(),
            document["correction"]["coefficients"].get<std::vector<double>>());
  EXPECT_THAT(scratch.read("page.html"), HasSubstr("Correction field"));
  ASSERT_THAT(runAlidade({"report", scratch.path("evidence.json"), "-o", scratch.path("again.html")}),
              EndsWith(0));
  EXPECT_THAT(scratch.read("again.html"), HasSubstr("Correction field"));
  EXPECT_THAT(runAlidade({"calibrate", corners, "-o", found}).out, HasSubstr("Field     "));
  const std::string plain = scratch.path("plain.yaml");
  EXPECT_THAT(runAlidade({"calibrate", corners, "-o", plain, "--correction", "none"}).out,
              Not(HasSubstr("Field  ")));
  // The true camera passes on these images, and so does what is found; one without the field does not.
  const RunResult tested = runAlidade({"validate", scratch.path("camera.yaml"), "--images", corners});
  EXPECT_THAT(tested, EndsWith(0));
  EXPECT_THAT(tested.out, Not(HasSubstr("WARN")));
  EXPECT_THAT(runAlidade({"validate", found, "--images", corners}), EndsWith(0));
  const RunResult difference = runAlidade({"diff", found, scratch.path("camera.yaml"), "--tolerance", "0.5"});
  EXPECT_THAT(difference, EndsWith(0)) << difference.out;
  const std::string central = scratch.write("central.yaml", cameraWithField(""));
  EXPECT_THAT(runAlidade({"validate", central, "--images", corners}).out, HasSubstr("WARN"));
}

TEST(Correction, IsAskedForRight) {
  const ScratchFolder scratch;
  simulateField(scratch, "", 8);
  const std::string corners = scratch.path("set/corners.csv");
  int num_refused = 0;
  for (const char* const value : {"8", "8x", "0x0", "25x3", "-4x3", "yes", ""}) {
    const RunResult result =
        runAlidade({"calibrate", corners, "-o", scratch.path("c.yaml"), "--correction", value});
    EXPECT_THAT(result, EndsWith(2)) << value;
    EXPECT_THAT(result.err, HasSubstr("--correction")) << value;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 7);
  EXPECT_THAT(
      runAlidade({"calibrate", corners, "-o", scratch.path("r.yaml"), "--to", "ros", "--correction", "4x3"}),
      EndsWith(2));
  EXPECT_THAT(runAlidade({"calibrate", corners, "-o", scratch.path("r.yaml"), "--to", "ros"}), EndsWith(0));
  // A lens that is given whole gets none by itself, and may be asked for one.
  for (const char* const value : {"auto", "4x3"}) {
    EXPECT_THAT(
        runAlidade({"calibrate", corners, "-o", scratch.path("g.yaml"), "--init", scratch.path("camera.yaml"),
                    "--fix", "fx,fy,cx,cy,k1,k2,p1,p2,k3", "--correction", value}),
        EndsWith(0))
        << value;
  }
}

// A stereographic lens, and a spline of its plane that is the same shift at each control point.
TEST(Correction, IsReadFromSplinesOfMrcal) {
  const ScratchFolder scratch;
  const auto model = [&](const std::string& name, int num_points) {
    std::string intrinsics = "400, 410, 320, 240";
    for (int i = 0; i < num_points; ++i) intrinsics += ", 0.01, -0.02";
    return scratch.write("s.cameramodel", "{'lensmodel': '" + name + "', 'intrinsics': [" + intrinsics +
                                              "], 'extrinsics': [0,0,0,0,0,0], 'imagersize': [640, 480]}\n");
  };
  const std::string name = "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=9_fov_x_deg=120";
  const std::string file = model(name, 99);
  EXPECT_THAT(runAlidade({"validate", file}), EndsWith(0));
  const RunResult projected = runAlidade({"project", file}, {.input = "0.3,0.4,1.2\n"});
  ASSERT_THAT(projected, EndsWith(0));
  const std::string row = projected.out.substr(projected.out.find('\n') + 1);
  // 2 tan(theta / 2) = 2 rho / (|p| + z), with |p| = 1.3.
  EXPECT_NEAR(std::stod(row), 320 + 400 * (2 * 0.3 / 2.5 + 0.01), 1e-9) << projected.out;
  EXPECT_NEAR(std::stod(row.substr(row.find(',') + 1)), 240 + 410 * (2 * 0.4 / 2.5 - 0.02), 1e-9);
  ASSERT_THAT(runAlidade({"convert", file, "-o", scratch.path("own.yaml")}), EndsWith(0));
  EXPECT_THAT(runAlidade({"validate", scratch.path("own.yaml")}), EndsWith(0));
  int num_refused = 0;
  for (const auto& [wrong, num_points] :
       {std::pair(std::string("LENSMODEL_SPLINED_STEREOGRAPHIC_order=2_Nx=11_Ny=9_fov_x_deg=120"), 99),
        std::pair(name, 98), std::pair(name + "x", 99),
        std::pair(std::string("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=3_Ny=9_fov_x_deg=120"), 27),
        std::pair(std::string("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=99999_Ny=99999_fov_x_deg=120"), 9),
        std::pair(std::string("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=9_fov_x_deg=400"), 99)}) {
    EXPECT_THAT(runAlidade({"validate", model(wrong, num_points)}), EndsWith(3)) << wrong;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 6);
}

}  // namespace
}  // namespace alidade
