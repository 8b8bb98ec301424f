// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/io/board_file.h"
#include "alidade/io/corners_file.h"
#include "command.h"
#include "detection_stage.h"
#include "interrupt.h"
#include "settings.h"

namespace alidade {
namespace {

class DetectCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer("Example: alidade detect photos/ --board checkerboard:9x6:25mm -o corners.csv");
    app.add_option("input", inputs_, "Folders, image files or patterns");
    addBoardOption(app, board_);
    app.add_option("--camera", camera_, "Name of the camera, for the corners file")->capture_default_str();
    app.add_option("-o,--output", output_, "Corners file to write (CSV); - or none: standard output");
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App& app) override {
    if (inputs_.empty())
      throw usageError({.where = "detect",
                        .found = "no images",
                        .expected = "folders, files or patterns",
                        .next_step = "alidade detect --help"});
    if (board_.empty())
      throw usageError({.where = "detect",
                        .found = "no --board",
                        .expected = "for example --board checkerboard:9x6:25mm"});
    if (camera_.find_first_of("\r\n") != std::string::npos)
      throw usageError(
          {.where = "detect", .found = "a line break in --camera", .expected = "a name of one line"});
    std::vector<std::string> sources = withImages(inputs_);
    sources.insert(sources.end(), {board_, common_.config});
    checkOutput(output_, sources, common_);
    const DetectionStage stage = runDetection(inputs_, readBoard(board_), common_, catchInterrupts());

    CornersFile file;
    file.camera = camera_;
    file.board = stage.board;
    file.views = stage.views;
    file.comments.push_back(programName() + " detect; pixel (0, 0) is the centre of the top-left pixel");
    for (const auto& [key, values] : effectiveSettings(app))
      file.comments.push_back(fmt::format("{}: {}", key, fmt::join(values, " ")));
    for (const std::string& line : reasonLines(stage)) file.comments.push_back("without a board: " + line);
    const bool to_stdout = output_.empty() || output_ == "-";
    if (!to_stdout) writeCornersFile(output_, file);

    if (common_.json) {
      printResult(jsonText(json(stage)));
    } else if (to_stdout) {
      printResult(cornersFileText(file));
    }
    if (!common_.quiet) report(stage, to_stdout);
    return 0;
  }

 private:
  static nlohmann::json json(const DetectionStage& stage) {
    nlohmann::json images = nlohmann::json::array();
    for (const ImageOutcome& outcome : stage.outcomes) {
      nlohmann::json image = {{"image", outcome.image},
                              {"reason", reasonCode(outcome.detection.reason)},
                              {"width", outcome.size.width},
                              {"height", outcome.size.height}};
      if (!outcome.detection.detail.empty()) image["detail"] = outcome.detection.detail;
      nlohmann::json corners = nlohmann::json::array();
      for (const Corner& corner : outcome.detection.corners)
        corners.push_back({{"id", corner.id}, {"u", corner.pixel.x()}, {"v", corner.pixel.y()}});
      image["corners"] = corners;
      images.push_back(image);
    }
    return {{"board", specText(stage.board)}, {"images", images}, {"notes", stage.notes}};
  }

  void report(const DetectionStage& stage, bool to_stdout) const {
    printMessage(fmt::format("{} of {} images show the whole board ({} corners each){}", stage.numFound(),
                             stage.outcomes.size(), stage.board.numCorners(),
                             to_stdout ? "" : "; written to " + output_));
    for (const std::string& line : reasonLines(stage)) printMessage("  " + line);
    for (const std::string& note : stage.notes) printMessage("note: " + note);
  }

  std::vector<std::string> inputs_;
  std::string board_;
  std::string camera_ = "camera";
  std::string output_;
};

}  // namespace

std::unique_ptr<Command> makeDetectCommand() {
  return std::make_unique<DetectCommand>();
}

}  // namespace alidade
