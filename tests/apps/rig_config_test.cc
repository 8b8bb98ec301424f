// SPDX-License-Identifier: MIT
// Each flag of the rig commands in a settings file does what it does on the command line.
#include <regex>
#include <set>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "apps/command_line.h"
#include "apps/rig_support.h"
#include "support/folder_content.h"

namespace alidade {
namespace {

// A flag's long name and its values: none for a switch.
struct Flag {
  std::string name;
  std::vector<std::string> values = {};
};

struct TwinCase {
  std::string command;
  std::vector<std::string> inputs;
  std::vector<Flag> flags;
  int exit_code = 0;
};

std::vector<std::string> argumentsOf(const std::vector<Flag>& flags) {
  std::vector<std::string> args;
  for (const Flag& flag : flags) {
    if (flag.values.empty()) args.push_back("--" + flag.name);
    for (const std::string& value : flag.values)
      args.insert(args.end(), {"--" + flag.name, value});  // lists may be given value by value
  }
  return args;
}

std::string settingsOf(const std::vector<Flag>& flags) {
  std::string text;
  for (const Flag& flag : flags) {
    std::string value = flag.values.empty() ? "true" : "'" + flag.values.front() + "'";
    for (std::size_t i = 1; i < flag.values.size(); ++i) value += ", '" + flag.values[i] + "'";
    text += flag.name + ": " + (flag.values.size() > 1 ? "[" + value + "]" : value) + "\n";
  }
  return text;
}

struct Outcome {
  RunResult run;
  FolderContent made;
};

class RigConfig : public testing::Test {
 protected:
  RigConfig() {
    writeCornersOfPair(scratch_);
    for (const std::string name : {"left", "right"}) linkImages(scratch_, name, 4);
    scratch_.write("rig.yaml", rigFileText(pairOfCameras()));
    CameraRecord left = pairOfCameras().cameras[0].camera;
    scratch_.write("camera.yaml", cameraText(left, "alidade"));
    scratch_.write("pixels.csv", "id,camera,u,v\np,left,320,240\np,right,250,238\n");
    std::string frames = "left,right\n";
    for (int i = 1; i <= 8; ++i) {
      const std::string image = "view_00" + std::to_string(i) + ".png";
      frames.append(image).append(",").append(image).append("\n");
    }
    scratch_.write("frames.csv", frames);
  }

  // All that a command makes goes into the folder "made".
  [[nodiscard]] Outcome outcomeOf(const TwinCase& c, const std::vector<std::string>& flags) const {
    std::filesystem::remove_all(scratch_.path("made"));
    scratch_.makeFolder("made");
    std::vector<std::string> args = {"rig", c.command};
    args.insert(args.end(), c.inputs.begin(), c.inputs.end());
    args.insert(args.end(), flags.begin(), flags.end());
    RunResult run = runAlidade(args, {.folder = scratch_.path()});
    return {.run = std::move(run), .made = contentOf(scratch_.path("made"))};
  }

  ScratchFolder scratch_;
};

std::vector<TwinCase> twinCases() {
  const std::vector<std::string> corners = {"left.csv", "right.csv"};
  const std::vector<std::string> rig_corners = {"rig.yaml", "left.csv", "right.csv"};
  const std::vector<std::string> rig_images = {"rig.yaml", "left", "right"};
  const Flag board = {"board", {kBoardSpec}};
  const Flag cache = {"cache", {"made/cache"}};
  return {{"calibrate",
           corners,
           {{"model", {"radtan", "pinhole"}},
            {"names", {"left", "right"}},
            {"match", {"frames.csv"}},
            {"board-shape", {"flat"}},
            {"tolerance", {"0.5px"}},
            {"verbose"},
            {"keep-untrustworthy"},
            {"offsets", {"none"}},
            {"pupil", {"0"}},
            {"output", {"made/rig.yaml"}},
            {"evidence", {"made/rig.json"}},
            {"report", {"made/rig.html"}},
            {"date", {"May 2026"}},
            {"json"}},
           3},
          {"calibrate", corners, {{"fixed", {"camera.yaml", "-"}}, {"model", {"kannala_brandt"}}, {"quiet"}}},
          {"calibrate",
           {"left", "right"},
           {board,
            {"frames", {"3"}},
            {"mirrored", {"back", "-"}},
            cache,
            {"model", {"pinhole"}},
            {"jobs", {"1"}},
            {"board-shape", {"flat"}}},
           3},
          {"validate",
           rig_corners,
           {{"names", {"right", "left"}},
            {"match", {"frames.csv"}},
            {"tolerance", {"0.25"}},
            {"strict"},
            {"junit", {"made/rig.xml"}},
            {"report", {"made/rig.html"}},
            {"date", {"May"}},
            {"json"}},
           3},
          {"validate",
           rig_images,
           {board, {"frames", {"3"}}, {"mirrored", {"back"}}, cache, {"quiet"}, {"jobs", {"1"}}},
           3},
          {"validate", rig_images, {{"footage"}, {"tolerance", {"0.25"}}, {"json"}, {"jobs", {"1"}}}},
          {"triangulate",
           {"rig.yaml", "pixels.csv"},
           {{"sigma", {"2px"}}, {"covariance"}, {"output", {"made/points.csv"}}}},
          {"triangulate", {"rig.yaml", "pixels.csv"}, {{"json"}, {"quiet"}, {"jobs", {"1"}}}},
          {"rectify",
           {"rig.yaml"},
           {{"camera-only"},
            {"maps"},
            {"cameras", {"right", "left"}},
            {"projection", {"cylindrical"}},
            {"fov", {"60"}},
            {"size", {"160x120"}},
            {"own-centres"},
            {"overwrite"},
            {"output", {"made/views"}}}},
          {"rectify", rig_corners, {{"match", {"frames.csv"}}, {"tolerance", {"0.01"}}}},
          {"rectify",
           rig_images,
           {{"keep", {"valid"}},
            {"interpolation", {"cubic"}},
            board,
            {"frames", {"3"}},
            cache,
            {"json"},
            {"quiet"},
            {"jobs", {"1"}},
            {"output", {"made/views"}}}}};
}

TEST_F(RigConfig, DoesWhatTheCommandLineDoes) {
  int num_checked = 0;
  for (const TwinCase& c : twinCases()) {
    const std::string what = c.command + " with " + c.flags.front().name;
    const Outcome by_hand = outcomeOf(c, argumentsOf(c.flags));
    EXPECT_THAT(by_hand.run, EndsWith(c.exit_code)) << what;
    scratch_.write("settings.yaml", settingsOf(c.flags));
    const Outcome by_file = outcomeOf(c, {"--config", "settings.yaml"});
    EXPECT_THAT(by_file.run, EndsWith(c.exit_code)) << what;
    EXPECT_EQ(by_file.run.out, by_hand.run.out) << what;
    EXPECT_EQ(by_file.run.err, by_hand.run.err) << what;
    EXPECT_TRUE(by_file.made == by_hand.made) << what;
    // The flags do something.
    const Outcome without = outcomeOf(c, {});
    EXPECT_FALSE(without.run.exit_code == by_hand.run.exit_code && without.run.out == by_hand.run.out &&
                 without.made == by_hand.made)
        << what;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 11);
}

// A new flag has to be added above.
TEST_F(RigConfig, IsTestedForEveryFlag) {
  std::size_t num_flags = 0;
  for (const std::string command : {"calibrate", "validate", "triangulate", "rectify"}) {
    std::set<std::string> tested = {"help", "config"};
    for (const TwinCase& c : twinCases()) {
      if (c.command != command) continue;
      for (const Flag& flag : c.flags) tested.insert(flag.name);
    }
    std::set<std::string> known;
    const std::string help = runAlidade({"rig", command, "--help"}).out;
    const std::regex pattern("\n +(?:-[a-z],)?--([a-z-]+)");
    for (std::sregex_iterator at(help.begin(), help.end(), pattern), end; at != end; ++at)
      known.insert((*at)[1].str());
    EXPECT_EQ(tested, known) << command;
    num_flags += known.size();
  }
  EXPECT_EQ(num_flags, 23U + 17U + 8U + 21U);
}

}  // namespace
}  // namespace alidade
