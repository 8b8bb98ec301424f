// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kSamePx = 1e-9;

RunResult convert(const std::string& from, const std::string& to, std::vector<std::string> more) {
  std::vector<std::string> args = {"convert", from, "-o", to};
  args.insert(args.end(), more.begin(), more.end());
  return runAlidade(args);
}

CameraRecord cameraIn(const ScratchFolder& scratch, const std::string& name) {
  return onlyCamera(parseCameras(scratch.read(name), name));
}

// A nearly perspective camera, which pinhole fits well but not exactly.
std::string mildCamera() {
  return "alidade_camera: 1\nmodel: radtan\nimage_size: {width: 640, height: 480}\n"
         "parameters: {fx: 535, fy: 534, cx: 322.5, cy: 238.1, k1: -1e-3, k2: 0, p1: 0, p2: 0, k3: 0}\n";
}

TEST(Convert, CarriesTheKeysOfTheUserToAFileOfItsOwn) {
  const ScratchFolder scratch;
  const std::string from = scratch.write("camera.yaml", smallCamera() + "x_note: [anything, {at: all}]\n");
  int num_converted = 0;
  for (const std::vector<std::string>& how :
       std::vector<std::vector<std::string>>{{}, {"--resize", "320x240"}, {"--model", "rational"}}) {
    ASSERT_THAT(convert(from, scratch.path("to.yaml"), how), EndsWith(0));
    EXPECT_THAT(scratch.read("to.yaml"), HasSubstr("\nx_note: [anything, {at: all}]\n"));
    EXPECT_THAT(runAlidade({"validate", scratch.path("to.yaml")}), EndsWith(0));
    ++num_converted;
  }
  EXPECT_EQ(num_converted, 3);
  ASSERT_THAT(convert(from, scratch.path("ros.yaml"), {"--to", "ros"}), EndsWith(0));
  EXPECT_THAT(scratch.read("ros.yaml"), Not(HasSubstr("x_note")));
}

TEST(Convert, FourTurnsAreTheSameCamera) {
  const ScratchFolder scratch;
  std::string from = dataPath("camera.yaml");
  for (int i = 1; i <= 4; ++i) {
    const std::string to = scratch.path(fmt::format("turn_{}.yaml", i));
    const RunResult result = convert(from, to, {"--rotate", "90"});
    ASSERT_THAT(result, EndsWith(0));
    EXPECT_THAT(result.out, AllOf(HasSubstr("Rotate   90"), HasSubstr("x_new = -y, y_new = x")));
    EXPECT_THAT(runAlidade({"validate", to}), EndsWith(0));
    from = to;
  }
  EXPECT_EQ(cameraIn(scratch, "turn_1.yaml").image_size, (ImageSize{.width = 480, .height = 640}));
  EXPECT_EQ(cameraIn(scratch, "turn_4.yaml").image_size, (ImageSize{.width = 640, .height = 480}));
  const std::vector<double> before = parametersOf(readFile(dataPath("camera.yaml")));
  const std::vector<double> after = parametersOf(scratch.read("turn_4.yaml"));
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(after[i], before[i], 1e-12);
  EXPECT_THAT(cameraIn(scratch, "turn_2.yaml").created_by,
              AllOf(HasSubstr("convert rotate 90 of " + scratch.path("turn_1.yaml")),
                    HasSubstr("convert rotate 90 of " + dataPath("camera.yaml"))));
}

TEST(Convert, ThereAndBackIsTheSameCamera) {
  const ScratchFolder scratch;
  struct Case {
    std::vector<std::string> there;
    std::vector<std::string> back;
  };
  const std::vector<Case> cases = {
      {{"--resize", "321x111"}, {"--resize", "640x480"}},
      {{"--rotate", "270"}, {"--rotate", "90"}},
      {{"--rotate", "180"}, {"--rotate", "180"}},
      {{"--bin", "4"}, {"--resize", "640x480"}},
      {{"--model", "radtan"}, {}},
      {{}, {}},
  };
  const std::vector<double> before = parametersOf(readFile(dataPath("camera.yaml")));
  int num_cases = 0;
  for (const Case& c : cases) {
    ASSERT_THAT(convert(dataPath("camera.yaml"), scratch.path("there.yaml"), c.there), EndsWith(0));
    ASSERT_THAT(convert(scratch.path("there.yaml"), scratch.path("back.yaml"), c.back), EndsWith(0));
    const CameraRecord file = cameraIn(scratch, "back.yaml");
    EXPECT_EQ(file.image_size, (ImageSize{.width = 640, .height = 480}));
    for (std::size_t i = 0; i < before.size(); ++i)
      EXPECT_NEAR(file.camera.parameters()[i], before[i], 1e-10);
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 6);
}

TEST(Convert, CropsBinsResizesAndRotatesInThisOrder) {
  const ScratchFolder scratch;
  const RunResult result =
      convert(dataPath("camera.yaml"), scratch.path("out.yaml"),
              {"--rotate", "90", "--resize", "500x200", "--bin", "2", "--crop", "40,60,501,401"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, AllOf(HasSubstr("501x401 px"), HasSubstr("250x200 px"), HasSubstr("500x200 px"),
                                HasSubstr("200x500 px")));
  const AnyCamera old = loadCamera(dataPath("camera.yaml")).camera;
  const CameraRecord file = cameraIn(scratch, "out.yaml");
  EXPECT_EQ(file.image_size, (ImageSize{.width = 200, .height = 500}));
  int num_points = 0;
  for (double y = -0.3; y <= 0.3; y += 0.05) {
    for (double x = -0.4; x <= 0.4; x += 0.05) {
      const Eigen::Vector2d p = old.project({x, y, 1}).pixel;
      const double u = 2 * ((p.x() - 40 + 0.5) / 2) - 0.5;  // binned by 2, then twice as wide
      const double v = (p.y() - 60 + 0.5) / 2 - 0.5;
      const Projection projection = file.camera.project({-y, x, 1});
      ASSERT_TRUE(projection.ok());
      EXPECT_NEAR(projection.pixel.x(), 200 - 1 - v, kSamePx);
      EXPECT_NEAR(projection.pixel.y(), u, kSamePx);
      ++num_points;
    }
  }
  EXPECT_GE(num_points, 190);
}

TEST(Convert, CroppedCameraProjectsWhereTheCropShowsIt) {
  const ScratchFolder scratch;
  const std::string cropped = scratch.path("cropped.yaml");
  ASSERT_THAT(convert(dataPath("camera.yaml"), cropped, {"--crop", "100,50,400,300", "--quiet"}),
              EndsWith(0));
  const auto pixel = [](const std::string& camera) {
    const RunResult result = runAlidade({"project", camera, "--json"}, {.input = "0.1,-0.05,1\n"});
    return nlohmann::json::parse(result.out).at("points").at(0);
  };
  const auto before = pixel(dataPath("camera.yaml"));
  const auto after = pixel(cropped);
  EXPECT_NEAR(after.at("u").get<double>(), before.at("u").get<double>() - 100, kSamePx);
  EXPECT_NEAR(after.at("v").get<double>(), before.at("v").get<double>() - 50, kSamePx);
}

TEST(Convert, CarriesTheCalibrationAlong) {
  const ScratchFolder scratch;
  const std::string source = scratch.path("calibrated.yaml");
  ASSERT_THAT(runAlidade({"calibrate", dataPath("corners.csv"), "-o", source}), EndsWith(0));
  ASSERT_THAT(convert(source, scratch.path("out.yaml"), {"--resize", "320x240", "--rotate", "90"}),
              EndsWith(0));
  EXPECT_THAT(runAlidade({"validate", scratch.path("out.yaml"), "--verbose"}).out,
              AllOf(HasSubstr("PASS  covariance"), HasSubstr("1 passed")));
  const CalibrationRecord before = *cameraIn(scratch, "calibrated.yaml").calibration;
  const CameraRecord file = cameraIn(scratch, "out.yaml");
  const CalibrationRecord& after = *file.calibration;
  EXPECT_DOUBLE_EQ(after.rms_px, before.rms_px / 2);
  EXPECT_EQ(after.boards, before.boards);
  EXPECT_EQ(after.verdict, Verdict::kTrustworthy);
  // fx is now half of what was fy, p1 what was p2.
  ASSERT_EQ(after.parameter_std.size(), 9u);
  EXPECT_DOUBLE_EQ(after.parameter_std[0], before.parameter_std[1] / 2);
  EXPECT_DOUBLE_EQ(after.parameter_std[6], before.parameter_std[7]);
  EXPECT_NEAR(after.accuracy_px, before.accuracy_px / 2, 1e-9);
  EXPECT_EQ(before.view_centers.size(), static_cast<std::size_t>(kNumImages));
  EXPECT_TRUE(after.view_centers.empty()) << "the images are others";
}

TEST(Convert, SaysExactlyWhenTheLensIsTheSame) {
  const ScratchFolder scratch;
  const std::string small = scratch.write("small.yaml", smallCamera());
  const RunResult result =
      convert(small, scratch.path("out.yaml"), {"--model", "radtan", "--max-error", "0"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, HasSubstr("radtan: identical lens"));
  EXPECT_EQ(parametersOf(scratch.read("out.yaml")), (std::vector<double>{500, 501, 320, 240, 0, 0, 0, 0, 0}));
  ASSERT_THAT(convert(scratch.path("out.yaml"), scratch.path("back.yaml"), {"--model", "pinhole"}),
              EndsWith(0));
  EXPECT_EQ(parametersOf(scratch.read("back.yaml")), parametersOf(smallCamera()));
}

TEST(Convert, FitsWhatIsNearlyTheSameAndSaysHowNearly) {
  const ScratchFolder scratch;
  const std::string mild = scratch.write("mild.yaml", mildCamera());
  const RunResult result = convert(mild, scratch.path("out.yaml"), {"--model", "pinhole", "--json"});
  ASSERT_THAT(result, EndsWith(0));
  const auto document = nlohmann::json::parse(result.out);
  EXPECT_EQ(document.at("model"), "pinhole");
  EXPECT_EQ(document.at("written"), true);
  EXPECT_EQ(document.at("trustworthy"), true);
  const auto& fit = document.at("fit");
  EXPECT_EQ(fit.at("exact"), false);
  EXPECT_EQ(fit.at("num_unreached"), 0);
  EXPECT_GT(fit.at("rms_px"), 1e-3);
  EXPECT_LT(fit.at("rms_px"), 0.1);
  EXPECT_GT(fit.at("max_error_px"), fit.at("rms_px"));
  // The stated error is the one at the stated place.
  const Eigen::Vector2d worst(fit.at("worst_pixel")[0], fit.at("worst_pixel")[1]);
  const auto ray = loadCamera(mild).camera.unproject(worst);
  ASSERT_TRUE(ray);
  EXPECT_NEAR((cameraIn(scratch, "out.yaml").camera.project(*ray).pixel - worst).norm(),
              fit.at("max_error_px").get<double>(), kSamePx);
  EXPECT_THAT(convert(mild, scratch.path("text.yaml"), {"--model", "pinhole"}).out,
              AllOf(HasSubstr("best fit"), HasSubstr("Error    RMS "), HasSubstr("at pixel (")));
}

// RMS and largest distance over all pixels between a camera's pixels and those that another gives their rays.
std::pair<double, double> errorsOfAllPixels(const CameraRecord& from, const AnyCamera& to) {
  double sum = 0;
  double worst = 0;
  int num_pixels = 0;
  for (int y = 0; y < from.image_size.height; ++y) {
    for (int x = 0; x < from.image_size.width; ++x) {
      const auto ray = from.camera.unproject({x, y});
      const Projection projection = ray ? to.project(*ray) : Projection();
      if (!projection.ok()) continue;
      const double distance = (projection.pixel - Eigen::Vector2d(x, y)).norm();
      sum += distance * distance;
      worst = std::max(worst, distance);
      ++num_pixels;
    }
  }
  EXPECT_GE(num_pixels, from.image_size.width * from.image_size.height * 9 / 10);
  return {std::sqrt(sum / num_pixels), worst};
}

// A fisheye lens of 185 degrees as a double sphere and back: what is stated is what the files' cameras do.
TEST(Convert, StatesWhatAFisheyeLosesInAnotherModelAndBack) {
  const ScratchFolder scratch;
  scratch.write("0.yaml",
                "alidade_camera: 1\nmodel: kannala_brandt\nimage_size: {width: 1280, height: 960}\n"
                "parameters: {fx: 383.57, fy: 384.65, cx: 639.54, cy: 477.31,\n"
                "             k1: 0.04275, k2: -0.05002, k3: 0.01984, k4: -0.00294}\n");
  EXPECT_THAT(convert(scratch.path("0.yaml"), scratch.path("1.yaml"), {"--model", "double_sphere"}),
              EndsWith(3));
  EXPECT_FALSE(scratch.has("1.yaml"));
  const std::vector<std::string> models = {"double_sphere", "kannala_brandt"};
  for (std::size_t i = 0; i < models.size(); ++i) {
    SCOPED_TRACE(models[i]);
    const std::string from = fmt::format("{}.yaml", i);
    const std::string to = fmt::format("{}.yaml", i + 1);
    const RunResult result =
        convert(scratch.path(from), scratch.path(to), {"--model", models[i], "--max-error", "2", "--json"});
    ASSERT_THAT(result, EndsWith(0));
    const auto fit = nlohmann::json::parse(result.out).at("fit");
    const CameraRecord source = cameraIn(scratch, from);
    const AnyCamera target = cameraIn(scratch, to).camera;
    const auto [rms, worst] = errorsOfAllPixels(source, target);
    EXPECT_NEAR(fit.at("rms_px").get<double>(), rms, 0.03 * rms);
    const double stated = fit.at("max_error_px").get<double>();
    EXPECT_GE(stated, 0.995 * worst);
    EXPECT_LE(stated, 1.1 * worst);
    const Eigen::Vector2d place(fit.at("worst_pixel")[0], fit.at("worst_pixel")[1]);
    const auto ray = source.camera.unproject(place);
    ASSERT_TRUE(ray);
    EXPECT_NEAR((target.project(*ray).pixel - place).norm(), stated, 1e-6);
  }
}

TEST(Convert, WritesNothingWhenTheModelDoesNotFit) {
  const ScratchFolder scratch;
  const std::string out = scratch.path("out.yaml");
  const std::vector<std::string> poor = {"--model", "pinhole"};
  const RunResult result = convert(dataPath("camera.yaml"), out, poor);
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(HasSubstr("FAILED"), HasSubstr("[model_rms]"), HasSubstr("[model_error]")));
  EXPECT_THAT(result.err, AllOf(HasSubstr("must not be used"), HasSubstr("out.yaml was not written")));
  EXPECT_FALSE(scratch.has("out.yaml"));

  const RunResult kept =
      convert(dataPath("camera.yaml"), out, {"--model", "pinhole", "--keep-untrustworthy", "--json"});
  EXPECT_THAT(kept, EndsWith(3));
  const auto document = nlohmann::json::parse(kept.out);
  EXPECT_EQ(document.at("trustworthy"), false);
  EXPECT_EQ(document.at("written"), true);
  EXPECT_EQ(document.at("reasons").at(0).at("id"), "model_rms");
  const CameraRecord file = cameraIn(scratch, "out.yaml");
  ASSERT_TRUE(file.calibration);
  EXPECT_EQ(file.calibration->verdict, Verdict::kNo);
  EXPECT_EQ(file.calibration->findings, (std::vector<std::string>{"model_rms", "model_error"}));

  // What is not to be trusted does not become so by being converted.
  EXPECT_THAT(convert(out, scratch.path("half.yaml"), {"--resize", "320x240"}), EndsWith(3));
  EXPECT_FALSE(scratch.has("half.yaml"));
  EXPECT_THAT(
      convert(dataPath("camera.yaml"), scratch.path("lax.yaml"), {"--model", "pinhole", "--max-error", "10"}),
      EndsWith(0));
}

TEST(Convert, WritesNothingWhenTheModelDoesNotReachThePixels) {
  const ScratchFolder scratch;
  // 89.97 degrees at the edges, of which radtan leaves out the last.
  const std::string wide =
      scratch.write("wide.yaml", replaced(smallCamera(), "fx: 500, fy: 501", "fx: 0.1, fy: 0.1"));
  const RunResult result = convert(wide, scratch.path("out.yaml"), {"--model", "radtan"});
  EXPECT_THAT(result, EndsWith(3));
  EXPECT_THAT(result.out, AllOf(HasSubstr("[unreached_pixels]"), HasSubstr("limit 0.1 %")));
  EXPECT_FALSE(scratch.has("out.yaml"));

  // No pixel at all leaves no error to state, and still a file that can be read.
  const std::string wider =
      scratch.write("wider.yaml", replaced(smallCamera(), "fx: 500, fy: 501", "fx: 1e-4, fy: 1e-4"));
  const RunResult none =
      convert(wider, scratch.path("none.yaml"), {"--model", "radtan", "--keep-untrustworthy", "--json"});
  EXPECT_THAT(none, EndsWith(3));
  const auto fit = nlohmann::json::parse(none.out).at("fit");
  EXPECT_EQ(fit.at("unreached_share"), 1);
  EXPECT_TRUE(fit.at("rms_px").is_null() && fit.at("max_error_px").is_null());
  EXPECT_EQ(cameraIn(scratch, "none.yaml").calibration->findings,
            (std::vector<std::string>{"unreached_pixels"}));
}

// A pinhole camera reaches 90 degrees; the polynomial without coefficients, as OpenCV writes it, does not.
TEST(Convert, WritesNothingThatWouldBeReadAsAnotherLens) {
  const ScratchFolder scratch;
  const std::string wide = scratch.write("wide.yaml",
                                         "alidade_camera: 1\nmodel: pinhole\nimage_size: {width: 6400, "
                                         "height: 3}\nparameters: {fx: 4.25, fy: 300, cx: 320, cy: 240}\n");
  EXPECT_THAT(runAlidade({"convert", wide, "--to", "opencv", "-o", scratch.path("out.yaml")}),
              FailsWith(1, AllOf(HasSubstr("wide.yaml"), HasSubstr("project differently"),
                                 HasSubstr("--to alidade"))));
  EXPECT_FALSE(scratch.has("out.yaml"));
}

TEST(Convert, WritesToStandardOutput) {
  const RunResult result = convert(dataPath("camera.yaml"), "-", {"--bin", "2"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(onlyCamera(parseCameras(result.out, "standard output")).image_size,
            (ImageSize{.width = 320, .height = 240}));
  EXPECT_THAT(result.err, AllOf(HasSubstr("Bin      2: 320x240 px\n"), HasSubstr("\n  fx ")));
  EXPECT_EQ(convert(dataPath("camera.yaml"), "-", {"--bin", "2", "--quiet"}).err, "");
}

TEST(Convert, ReadsItsFlagsFromYaml) {
  const ScratchFolder scratch;
  const std::string config =
      scratch.write("settings.yaml", "crop: '0,60,640,360'\nresize: 320x180\nrotate: 180\nmodel: radtan\n");
  ASSERT_THAT(convert(dataPath("camera.yaml"), scratch.path("out.yaml"), {"--config", config}), EndsWith(0));
  EXPECT_EQ(cameraIn(scratch, "out.yaml").image_size, (ImageSize{.width = 320, .height = 180}));
}

TEST(Convert, RefusesToOverwriteItsInput) {
  const ScratchFolder scratch;
  const std::string camera = scratch.write("camera.yaml", smallCamera());
  EXPECT_THAT(convert(camera, camera, {"--bin", "2"}),
              FailsWith(2, AllOf(HasSubstr("this is also an input"), HasSubstr("would be overwritten"))));
  EXPECT_THAT(convert(scratch.path("./camera.yaml"), camera, {}), FailsWith(2, HasSubstr("overwritten")));
  EXPECT_EQ(scratch.read("camera.yaml"), smallCamera());
}

// Kalibr's radtan has no k3: the nearest lens without it is what --model asks for there.
TEST(Convert, FitsAroundACoefficientThatTheFormatDoesNotHave) {
  const ScratchFolder scratch;
  const std::string text =
      "alidade_camera: 1\nmodel: radtan\nimage_size: {width: 640, height: 480}\n"
      "parameters: {fx: 535, fy: 534, cx: 322, cy: 238, k1: -0.28, k2: 0.08, p1: 8e-4, p2: -4e-4, k3: "
      "-0.02}\n";
  const std::string given = scratch.write("radtan.yaml", text);
  const std::string rational = scratch.write(
      "rational.yaml",
      replaced(replaced(text, "radtan", "rational"), "k3: -0.02}", "k3: -0.02, k4: 0.01, k5: 0, k6: 0}"));
  const std::string chain = scratch.path("chain.yaml");
  EXPECT_THAT(convert(given, chain, {"--to", "kalibr"}),
              FailsWith(1, AllOf(HasSubstr("k3 = -0.02"), HasSubstr("add --model"))));
  int num_fitted = 0;
  for (const std::string& file : {given, rational}) {
    for (const char* format : {"kalibr", "camodocal"}) {
      const std::vector<std::string> args = {"--to", format, "--model", "radtan"};
      std::vector<std::string> strict = args;
      strict.insert(strict.end(), {"--max-error", "1e-6"});
      EXPECT_THAT(convert(file, chain, strict), EndsWith(3)) << format;
      EXPECT_FALSE(scratch.has("chain.yaml"));
      std::vector<std::string> lenient = args;
      lenient.insert(lenient.end(), {"--max-error", "1", "--json"});
      const RunResult result = convert(file, chain, lenient);
      ASSERT_THAT(result, EndsWith(0)) << format;
      const double rms_px = nlohmann::json::parse(result.out).at("fit").at("rms_px").get<double>();
      EXPECT_GT(rms_px, 1e-6);
      EXPECT_LT(rms_px, 0.1);
      // Over another grid, which reaches the image's border, where the error is largest.
      const RunResult diff = runAlidade({"diff", file, chain, "--same-frame", "--json"});
      const double apart_px = nlohmann::json::parse(diff.out).at("rms_px").get<double>();
      EXPECT_GT(apart_px, rms_px);
      EXPECT_LT(apart_px, 2 * rms_px);
      std::filesystem::remove(chain);
      ++num_fitted;
    }
  }
  EXPECT_EQ(num_fitted, 4);
  // Where k3 has a place it is kept.
  ASSERT_THAT(convert(given, chain, {"--to", "ros", "--model", "radtan"}), EndsWith(0));
  EXPECT_THAT(scratch.read("chain.yaml"), HasSubstr("-0.02"));
}

TEST(Convert, RefusesWhatItDoesNotUnderstand) {
  const ScratchFolder scratch;
  const std::string camera = scratch.write("camera.yaml", smallCamera());
  struct Case {
    std::vector<std::string> args;
    std::string found;
    std::string expected;
  };
  const std::vector<Case> cases = {
      {{"--crop", "1,2,3"}, "'1,2,3'", "X,Y,WIDTH,HEIGHT"},
      {{"--crop", "1,2,3,4,5"}, "'1,2,3,4,5'", "X,Y,WIDTH,HEIGHT"},
      {{"--crop", "1,2,3,four"}, "'1,2,3,four'", "X,Y,WIDTH,HEIGHT"},
      {{"--crop", "1,2,,3,4"}, "'1,2,,3,4'", "X,Y,WIDTH,HEIGHT"},
      {{"--crop", "600,0,100,100"}, "100x100 pixels from (600, 0)", "640x480"},
      {{"--crop", "-5,0,100,100"}, "100x100 pixels from (-5, 0)", "640x480"},
      {{"--resize", "320"}, "'320'", "WIDTHxHEIGHT"},
      {{"--resize", "320x"}, "'320x'", "WIDTHxHEIGHT"},
      {{"--resize", "0x240"}, "0x240", "1 to 1000000 pixels"},
      {{"--resize", "1000000x1000000"}, "1000000x1000000", "1073741824 in total"},
      {{"--bin", "0"}, "bin: 0", "1 to 480"},
      {{"--bin", "481"}, "bin: 481", "1 to 480"},
      {{"--bin", "two"}, "--bin", "alidade convert --help"},
      {{"--rotate", "45"}, "45", "90, 180, 270"},
      {{"--model", "radtn"}, "radtn", "radtan"},
      {{"--max-error", "-1"}, "--max-error", "0 or more"},
      {{"--crp", "1,2,3,4"}, "--crp", "did you mean '--crop'?"},
  };
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    EXPECT_THAT(convert(camera, scratch.path("out.yaml"), c.args),
                FailsWith(2, AllOf(HasSubstr(c.found), HasSubstr(c.expected))))
        << testing::PrintToString(c.args);
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 17u);
  EXPECT_THAT(convert(scratch.path("camra.yaml"), scratch.path("out.yaml"), {}),
              FailsWith(1, HasSubstr("did you mean '" + camera + "'?")));
  EXPECT_FALSE(scratch.has("out.yaml"));
}

}  // namespace
}  // namespace alidade
