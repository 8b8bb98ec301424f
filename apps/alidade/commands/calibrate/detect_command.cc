// SPDX-License-Identifier: MIT
#include <cmath>

#include <fmt/format.h>

#include "alidade/core/error_text.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/board_file.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/text/table_lines.h"
#include "alidade/imagery/image_list.h"
#include "alidade/report/data/json_output.h"
#include "board_views.h"
#include "command.h"
#include "console.h"
#include "outputs.h"

namespace alidade {
namespace {

// One CSV line per image with its reason and measures, after a header line.
std::vector<std::string> imageTable(const BoardSurvey& survey) {
  std::vector<std::string> lines = {
      "image,reason,corners,blur_px,spacing_px,area_share,tilt_deg,columns_seen,rows_seen,detail"};
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : ""; };
  for (const ImageOutcome& outcome : survey.outcomes) {
    const Detection& detection = outcome.detection;
    const ViewMeasures& measures = detection.measures;
    const bool is_measured = std::isfinite(measures.spacing_px);
    lines.push_back(oneLine(
        fmt::format("{},{},{},{},{},{},{},{},{},{}", detail::csvField(outcome.image),
                    reasonCode(detection.reason), detection.corners.size(), number(measures.blur_px),
                    number(measures.spacing_px), is_measured ? number(measures.area_share) : "",
                    number(measures.tilt_deg), detection.seen ? std::to_string(detection.seen->columns) : "",
                    detection.seen ? std::to_string(detection.seen->rows) : "",
                    detail::csvField(oneLine(detection.detail)))));
  }
  return lines;
}

json imageJson(const ImageOutcome& outcome) {
  const Detection& detection = outcome.detection;
  json corners = mapped(detection.corners, [](const Corner& c) -> json {
    return {{"id", c.id}, {"u", c.pixel.x()}, {"v", c.pixel.y()}, {"sigma_px", c.sigma_px}};
  });
  json image = {{"image", outcome.image},
                {"reason", reasonCode(detection.reason)},
                {"width", outcome.size.width},
                {"height", outcome.size.height},
                {"corners", std::move(corners)}};
  if (!detection.detail.empty()) image["detail"] = detection.detail;
  if (std::isfinite(detection.measures.spacing_px)) {
    image["measures"] = {{"blur_px", detection.measures.blur_px},
                         {"spacing_px", detection.measures.spacing_px},
                         {"area_share", detection.measures.area_share},
                         {"tilt_deg", detection.measures.tilt_deg}};
  }
  if (detection.seen) {
    image["seen"] = {{"columns", detection.seen->columns},
                     {"rows", detection.seen->rows},
                     {"num_corners", detection.seen->num_corners},
                     {"whole", detection.seen->is_closed}};
  }
  return image;
}

// Documents of one board keep their original form.
std::string detectionJson(const GivenViews& found) {
  json boards = mapped(found.surveys, [](const BoardSurvey& survey) -> json {
    return {{"board", survey.board.spec()}, {"images", mapped(survey.outcomes, imageJson)}};
  });
  json document = boards.size() == 1 ? std::move(boards[0]) : json{{"boards", std::move(boards)}};
  document["notes"] = found.notes;
  return jsonText(document);
}

class DetectCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain("Example: alidade detect photos/ --board checkerboard:9x6:25mm -o corners.csv");
    flags.add("input", &given_.inputs, "Folders, image files, patterns (*.jpg, frame%04d.png) or videos",
              kFilePath);
    given_.addBoards(flags);
    flags.add("--camera", &camera_, "Camera name to write into the corners file");
    given_.addDetection(flags, true);
    given_.addMirrored(flags);
    flags.add("-o,--output", &output_,
              "Corners file to write: .csv, or .vnl for mrcal; CSV to standard output if omitted or -",
              aside(kFilePath));
    flags.addCommon(common_, true);
  }

  int run(const Flags& flags) override {
    checkUsage();
    common_.cancel = catchInterrupts();
    const GivenViews found = runDetection(given_, common_);
    if (found.num_found == 0) printJson(found);
    requireBoards(found, given_, common_);
    const CornersFile file = cornersOf(found, flags);
    const bool to_stdout = output_.empty() || output_ == "-";
    if (!to_stdout) (isVnlFile(output_) ? writeVnlFile : writeCornersFile)(output_, file);
    printJson(found);
    if (to_stdout && !common_.json) printResult(cornersFileText(file));
    if (!common_.quiet) report(found, to_stdout);
    return 0;
  }

 private:
  void checkUsage() const {
    if (given_.inputs.empty()) throw missing("no images", "folders, files or patterns");
    if (camera_.find_first_of("\r\n") != std::string::npos)
      throw misuse("a line break in --camera", "a name without line breaks");
    std::vector<std::string> sources = withImages(given_.inputs);
    append(sources, given_.boards);
    sources.push_back(common_.config);
    given_.checkDebugFolder(output_);
    checkOutput(output_, sources, common_);
    if (isVnlFile(output_) && !given_.boards.empty())
      checkVnl(mapped(given_.boards, readBoard), shortNames(listInputs(given_.inputs).all()));
  }

  // Prints the JSON once, if requested. A later error then has its reasons on standard output.
  void printJson(const GivenViews& found) {
    if (owesJson()) answer([&] { return detectionJson(found); }, {});
  }

  [[nodiscard]] CornersFile cornersOf(const GivenViews& found, const Flags& flags) const {
    CornersFile file;
    file.camera = camera_;
    file.boards = found.boards;
    file.views = found.views;
    file.comments.push_back(maker() + "; pixel (0, 0) is the centre of the top-left pixel");
    for (const auto& [key, values] : flags.settings())
      file.comments.push_back(fmt::format("{}: {}", key, join(values, " ")));
    for (const std::string& note : found.notes) file.comments.push_back("note: " + note);
    for (const BoardSurvey& survey : found.surveys) {
      if (found.surveys.size() > 1) file.comments.push_back("images of " + survey.board.spec());
      append(file.comments, imageTable(survey));
    }
    return file;
  }

  void report(const GivenViews& found, bool to_stdout) const {
    const bool is_one = found.surveys.size() == 1;
    const std::string written = to_stdout ? "" : "; written to " + output_;
    if (!is_one)
      printMessage(fmt::format("{} of {} images show a board{}", found.num_found, found.num_images, written));
    for (const BoardSurvey& survey : found.surveys) {
      const std::size_t num_partial = survey.numFound() - survey.numWhole();
      printMessage(fmt::format(
          "{}{} of {} images show the whole board ({} {} each){}{}", is_one ? "" : survey.board.spec() + ": ",
          survey.numWhole(), survey.outcomes.size(), survey.board.numCorners(), survey.board.words().points,
          num_partial > 0 ? fmt::format(", {} show a part of it", num_partial) : "", is_one ? written : ""));
      if (survey.numFound() > 0) printMessage("  " + measuresText(survey));
    }
    for (const std::string& line : found.reasons) printMessage("  " + line);
    printNotes(found.notes);
  }

  BoardInputs given_;
  std::string camera_ = "camera";
  std::string output_;
};

}  // namespace

const CommandEntry kDetectCommand = {"detect", "Detect the corners of a board in images",
                                     made<DetectCommand>};

}  // namespace alidade
