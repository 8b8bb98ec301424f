// SPDX-License-Identifier: MIT
// `rig validate --footage`: a rig tested on ordinary synchronous pictures.
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/rig_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kDeg = 3.14159265358979 / 180;

// Two cameras one behind the other: frames of a camera that drives straight ahead, three frames apart.
struct Drive {
  ScratchFolder scratch;
  std::string back = scratch.path("back");
  std::string front = scratch.path("front");

  Drive() {
    const std::string scene = scratch.write("scene.yaml",
                                            "alidade_scene: 1\n"
                                            "camera: {model: radtan, image_size: {width: 320, height: 240},\n"
                                            "         parameters: {fx: 250, fy: 250, cx: 160, cy: 119, k1: "
                                            "-0.2, k2: 0.03, p1: 0, p2: 0, k3: 0}}\n"
                                            "footage: {frames: 24, flow_px: 4, path: straight}\n"
                                            "seed: 5\nrender: {blur_px: 0.6, read_noise: 1.5}\n");
    EXPECT_THAT(runAlidade({"simulate", scene, "-o", scratch.path("footage")}), EndsWith(0));
    int number = 0;
    for (const int k : {0, 7, 14, 20}) {
      link(back, k, number);
      link(front, k + 3, number++);
    }
    scratch.write("rig.yaml", rigFileText(rig()));
    RigRecord turned = rig();
    turned.cameras[1].camera_from_rig.rotation = SO3::exp(Eigen::Vector3d(kDeg, 0, 0));
    scratch.write("turned.yaml", rigFileText(turned));
  }

  // Links frame `k` of the drive as image `number` of a folder.
  void link(const std::string& folder, int k, int number) const {
    std::filesystem::create_directories(folder);
    std::filesystem::create_symlink(scratch.path(fmt::format("footage/images/frame_{:05}.png", k)),
                                    fmt::format("{}/{}.png", folder, number));
  }

  static RigRecord rig() {
    RigRecord rig;
    for (const char* name : {"back", "front"}) {
      CameraRecord record =
          bareRecord(AnyCamera::make("radtan", std::vector<double>{250, 250, 160, 119, -0.2, 0.03, 0, 0, 0}),
                     {320, 240}, "a test");
      record.name.name = name;
      const bool is_front = !rig.cameras.empty();
      rig.cameras.push_back(
          {.camera = record, .camera_from_rig = {SO3(), Eigen::Vector3d(0, 0, is_front ? -0.3 : 0)}});
    }
    return rig;
  }
};

const Drive& drive() {
  static const Drive made;
  return made;
}

RunResult validate(const std::string& file, const std::vector<std::string>& inputs,
                   const std::vector<std::string>& more = {}) {
  std::vector<std::string> args = {"rig", "validate", drive().scratch.path(file)};
  args.insert(args.end(), inputs.begin(), inputs.end());
  args.push_back("--footage");
  args.insert(args.end(), more.begin(), more.end());
  return runAlidade(args);
}

TEST(RigFootageCommand, TellsARightRigFromATurnedOne) {
  const RunResult right = validate("rig.yaml", {drive().back, drive().front});
  EXPECT_THAT(right, EndsWith(0));
  EXPECT_THAT(right.out,
              AllOf(HasSubstr("Verdict   consistent: the images agree with the rig\n"),
                    HasSubstr("Pair      back, front: consistent: no "), HasSubstr("4 instants, ")));
  EXPECT_THAT(right.err, Not(HasSubstr("note")));

  const RunResult text = validate("turned.yaml", {drive().back, drive().front});
  EXPECT_THAT(text, EndsWith(3));
  EXPECT_THAT(text.out, AllOf(HasSubstr("Verdict   inconsistent: the images contradict the rig\n"),
                              HasSubstr("turned by"), HasSubstr("next: ")));
  EXPECT_THAT(text.err, HasSubstr("error: the images contradict the rig: "));

  const RunResult structured = validate("turned.yaml", {drive().back, drive().front}, {"--json"});
  EXPECT_THAT(structured, EndsWith(3));
  const json document = json::parse(structured.out);
  EXPECT_EQ(document.at("verdict"), "inconsistent");
  EXPECT_EQ(document.at("tolerance_px"), 0.2);
  ASSERT_EQ(document.at("pairs").size(), 1U);
  const json& pair = document.at("pairs").at(0);
  EXPECT_EQ(pair.at("first"), "back");
  EXPECT_GT(pair.at("num_used").get<int>(), 500);
  const json& change = pair.at("changes").at(pair.at("explanation").get<std::size_t>());
  EXPECT_THAT(change.at("id").get<std::string>(), testing::AnyOf("rotation", "pose"));
  EXPECT_NEAR(change.at("amounts").at(0).get<double>(), kDeg, 0.1 * kDeg);
  // Nothing fails below five times the tolerance.
  EXPECT_THAT(validate("turned.yaml", {drive().back, drive().front}, {"--tolerance", "10px", "--quiet"}),
              EndsWith(0));
}

TEST(RigFootageCommand, CannotTellFromImagesThatDoNotBelongTogether) {
  const Drive& made = drive();
  const ScratchFolder other;
  // Noise has no points in common with anything.
  cv::theRNG().state = 7;
  std::filesystem::create_directories(other.path("noise"));
  for (int k = 0; k < 4; ++k) {
    cv::Mat noise(240, 320, CV_8U);
    cv::randu(noise, 0, 255);
    cv::imwrite(fmt::format("{}/{}.png", other.path("noise"), k), noise);
  }
  const RunResult result = validate("rig.yaml", {made.back, other.path("noise")}, {"--json"});
  EXPECT_THAT(result, EndsWith(0));
  const json document = json::parse(result.out);
  EXPECT_EQ(document.at("verdict"), "cannot_tell");
  EXPECT_THAT(document.at("pairs").at(0).at("gap").get<std::string>(),
              testing::AnyOf("too_few_points", "moving_scene"));
}

TEST(RigFootageCommand, SaysWhatIsWrong) {
  const Drive& made = drive();
  const ScratchFolder other;
  // One image more, and one instant less than is enough.
  made.link(other.path("more"), 3, 0);
  made.link(other.path("more"), 10, 1);
  made.link(other.path("more"), 20, 9);
  const RunResult few = validate("rig.yaml", {made.back, other.path("more")});
  EXPECT_THAT(few, EndsWith(0));
  EXPECT_THAT(few.err, HasSubstr("note: 3 images without one of the same instant by another camera"));
  EXPECT_THAT(few.out, HasSubstr("cannot tell: 2 instants with enough matches; take three or more"));

  std::filesystem::create_directories(other.path("small"));
  for (int k = 0; k < 4; ++k) {
    cv::Mat half;
    cv::resize(cv::imread(fmt::format("{}/{}.png", made.front, k), cv::IMREAD_GRAYSCALE), half, {}, 0.5, 0.5);
    cv::imwrite(fmt::format("{}/{}.png", other.path("small"), k), half);
  }
  EXPECT_THAT(validate("rig.yaml", {made.back, other.path("small")}),
              FailsWith(1, AllOf(HasSubstr("small/"), HasSubstr("160x120 pixels"), HasSubstr("320x240"),
                                 HasSubstr("camera front"))));

  RigRecord one = Drive::rig();
  one.cameras.pop_back();
  made.scratch.write("one.yaml", rigFileText(one));
  EXPECT_THAT(validate("one.yaml", {made.back}), FailsWith(1, HasSubstr("a rig with one camera")));
  EXPECT_THAT(validate("rig.yaml", {made.back}),
              FailsWith(2, AllOf(HasSubstr("1 input"), HasSubstr("back, front"))));
  EXPECT_THAT(validate("rig.yaml", {made.back, made.front}, {"--board", "checkerboard:9x6:25mm"}),
              FailsWith(2, HasSubstr("--board with --footage")));
  other.write("corners.csv", "");
  EXPECT_THAT(validate("rig.yaml", {made.back, other.path("corners.csv")}),
              FailsWith(2, HasSubstr("a corners file")));
  other.write("frames.csv", "back,front\n0.png,1.png\n1.png,2.png\n2.png,3.png\n");
  const RunResult shifted =
      validate("rig.yaml", {made.back, made.front}, {"--match", other.path("frames.csv"), "--json"});
  EXPECT_EQ(json::parse(shifted.out).at("num_instants"), 3);
}

}  // namespace
}  // namespace alidade
