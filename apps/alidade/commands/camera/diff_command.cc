// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "alidade/compare/projection_difference.h"
#include "alidade/compare/ray_alignment.h"
#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/record/camera_record.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/figures/difference_svg.h"
#include "alidade/report/pages/comparison_page.h"
#include "camera_files.h"
#include "command.h"
#include "commands/camera/folder_diff.h"
#include "commands/rig/rig_diff.h"
#include "console.h"
#include "junit.h"
#include "outputs.h"
#include "page_file.h"

namespace alidade {
namespace {

// Up to `most` of `count` positions, from the first to the last.
std::vector<int> spread(int count, int most) {
  std::vector<int> places;
  const int n = std::min(count, most);
  for (int i = 0; i < n; ++i)
    places.push_back(n == 1 ? 0
                            : static_cast<int>(std::lround(static_cast<double>(i) * (count - 1) / (n - 1))));
  return places;
}

std::string motionText(const ProjectionDifference& difference) {
  const Eigen::Vector3d w = difference.b_from_a.rotation.log();
  constexpr double kRoundingDeg = 1e-9;
  const double angle_deg = kDegPerRad * w.norm();
  std::string text = "by a rotation of 0 degrees";
  if (angle_deg >= kRoundingDeg) {
    text = fmt::format("by a rotation of {:.6g} degrees", angle_deg);
    const Eigen::Vector3d axis = w.normalized();
    text += fmt::format(" about ({:.4f}, {:.4f}, {:.4f}), from A's camera frame to B's", axis.x(), axis.y(),
                        axis.z());
  }
  const Eigen::Vector3d& t = difference.b_from_a.translation;
  if (t.norm() > 0)
    text += fmt::format("\n         and by a translation of ({:.6g}, {:.6g}, {:.6g}) m", t.x(), t.y(), t.z());
  return text;
}

// The motion that was removed and the numbers, for people; or a sentence if no motion was found.
std::string differenceText(const ProjectionDifference& difference) {
  if (!difference.is_converged)
    return "Aligned  no: the best alignment was not found, so no difference can be stated\n";
  std::string text = "Aligned  " + motionText(difference) + "\n";
  if (difference.match.quarter_turns != 0) {
    text += fmt::format("         B's image is A's image rotated clockwise by {} degrees\n",
                        90 * difference.match.quarter_turns);
  }
  const auto num_pixels = difference.pixels.size();
  text += fmt::format("Compared {} of {} pixels", difference.num_compared, num_pixels);
  if (difference.num_seen_by_one > 0)
    text += fmt::format("; {} are seen by only one camera", difference.num_seen_by_one);
  if (difference.num_seen_by_neither > 0)
    text += fmt::format("; {} are seen by neither", difference.num_seen_by_neither);
  text += "\n";
  if (difference.num_compared == 0) return text;
  if (difference.max_px < kEqualPx)
    return text + "Diff     none: the cameras are identical to within rounding\n";
  text += fmt::format(
      "Diff     mean {:.4g} px, RMS {:.4g} px, 95 % within {:.4g} px, at most {:.4g} px at pixel ({:.0f}, "
      "{:.0f}) of A; in pixels of the {} image\n",
      difference.mean_px, difference.rms_px, difference.p95_px, difference.max_px, difference.worst_pixel.x(),
      difference.worst_pixel.y(), sizeText(difference.match.unit_size));
  return text;
}

// A note for images whose sizes do not differ by one exact factor, for instance with a rounded side (213x160
// from 640x480): the resulting error in pixels of the finer one. Empty for identical aspect ratios.
std::string unevenSizeText(ImageSize a, ImageSize b, int quarter_turns) {
  if (quarter_turns % 2 != 0) std::swap(b.width, b.height);
  if (std::int64_t{a.width} * b.height == std::int64_t{a.height} * b.width) return "";
  // The finer image shrinks by different factors along x and y. Using their mean causes this error at the
  // border.
  const bool is_a_finer = std::int64_t{a.width} * a.height >= std::int64_t{b.width} * b.height;
  const ImageSize fine = is_a_finer ? a : b;
  const ImageSize coarse = is_a_finer ? b : a;
  const double by_width = static_cast<double>(coarse.width) / fine.width;
  const double by_height = static_cast<double>(coarse.height) / fine.height;
  const double mean = std::sqrt(by_width * by_height);
  const double off_px = 0.5 * std::max(std::abs(by_width / mean - 1) * fine.width,
                                       std::abs(by_height / mean - 1) * fine.height);
  return fmt::format(
      "note: {} px is not {} px resized by one factor: the factor would be {:.5g} along x and {:.5g} along "
      "y. If the sides were only rounded after resizing or binning, this causes differences of up to {:.2g} "
      "px (of the {} image) at the border",
      sizeText(coarse), sizeText(fine), by_width, by_height, off_px, sizeText(fine));
}

// A table of the grid's lengths, for people.
std::string differenceTable(const ProjectionDifference& difference) {
  constexpr int kMostColumns = 9;
  constexpr int kMostRows = 7;
  const auto columns = spread(difference.columns, kMostColumns);
  const auto rows = spread(difference.rows, kMostRows);
  const auto at = [&](int row, int column) {
    return static_cast<std::size_t>(row * difference.columns + column);
  };
  std::string text = "Grid     differences in px; columns and rows are pixels of A\n            ";
  for (const int column : columns) text += fmt::format(" {:>8.0f}", difference.pixels[at(0, column)].x());
  text += "\n";
  for (const int row : rows) {
    text += fmt::format("    {:>8.0f}", difference.pixels[at(row, 0)].y());
    for (const int column : columns) {
      const double length = difference.lengthAt(at(row, column));
      text += std::isfinite(length) ? fmt::format(" {:>8.3g}", length < kEqualPx ? 0.0 : length)
                                    : fmt::format(" {:>8}", "-");
    }
    text += "\n";
  }
  return text;
}

// Converts rows of text for people ("Aligned  by a rotation", continued on lines that begin with blanks) to
// lines for a figure: "Aligned: by a rotation".
std::vector<std::string> figureLines(const std::string& text) {
  constexpr std::size_t kLabelColumns = 9;
  std::vector<std::string> lines;
  for (const std::string_view row : split(trim(text), '\n')) {
    if (row.starts_with(' ') && !lines.empty()) {
      lines.back() += "; " + std::string(trim(row));
      continue;
    }
    const std::string label(trim(row.substr(0, kLabelColumns)));
    lines.push_back(label + ": " + std::string(trim(row.substr(std::min(row.size(), kLabelColumns)))));
  }
  for (std::string& line : lines) line = printable(line);
  return lines;
}

// "Test     the difference of 0.4 px (RMS) is 1.2 sigma: not significant; ...", or why it is unknown.
std::string testText(const LensComparison& lens) {
  const auto& [a, b, difference, significance] = lens;
  if (!significance) {
    return "Test     unknown: neither file states a covariance, so the difference cannot be compared with the "
           "uncertainty\n";
  }
  std::string text = fmt::format("Test     the difference of {:.2g} px (RMS) is {}: {}",
                                 difference.rms_px < kEqualPx ? 0.0 : difference.rms_px,
                                 significance->sigmas > 0 ? fmt::format("{:.1f} sigma", significance->sigmas)
                                                          : std::string("within chance"),
                                 significance->isSignificant() ? "significant" : "not significant");
  text += fmt::format(
      "; the covariances predict {0:.2g} px. At least {2:.3g} px of the {1:.3g} px (95 %) are real; {3:.0f} "
      "% of the pixels differ by more than their 95 % ellipse",
      significance->expected_rms_px, difference.p95_px, significance->sure_p95_px,
      100 * significance->share_beyond);
  if (!a.covariance || !b.covariance)
    text += fmt::format("; {} states no covariance and is assumed to be exact", a.covariance ? "B" : "A");
  return text + "\n";
}

// All results; values that are not finite are null, and so are all numbers if no motion was found.
json differenceJson(const LensComparison& lens) {
  const ProjectionDifference& difference = lens.difference;
  const auto& significance = lens.significance;
  const auto gridJson = [&](const auto& valueAt) {
    return rowsJson(difference.columns, difference.rows, valueAt);
  };
  const auto finiteJson = [](const Eigen::Vector2d& v) {
    return v.allFinite() ? vectorJson(v) : json(nullptr);
  };
  const bool is_known = difference.is_converged;
  const auto known = [is_known](const auto& value) { return is_known ? json(value) : json(nullptr); };
  json motion = difference.b_from_a;
  motion["angle_deg"] = kDegPerRad * difference.b_from_a.rotation.log().norm();
  json document = {{"b_from_a", known(motion)},
                   {"image_turn_deg", known(90 * difference.match.quarter_turns)},
                   {"converged", difference.is_converged},
                   {"pixels_of", difference.match.unit_size},
                   {"num_compared", known(difference.num_compared)},
                   {"num_seen_by_one", known(difference.num_seen_by_one)},
                   {"num_seen_by_neither", known(difference.num_seen_by_neither)},
                   {"mean_px", known(difference.mean_px)},
                   {"rms_px", known(difference.rms_px)},
                   {"p95_px", known(difference.p95_px)},
                   {"max_px", known(difference.max_px)},
                   {"worst_pixel", known(finiteJson(difference.worst_pixel))},
                   {"grid",
                    {{"columns", difference.columns},
                     {"rows", difference.rows},
                     {"pixels", gridJson([&](std::size_t i) { return finiteJson(difference.pixels[i]); })},
                     {"difference_px", gridJson([&](std::size_t i) {
                        return known(finiteJson(difference.difference_px[i]));
                      })}}},
                   {"significance", nullptr}};
  if (significance && is_known) {
    document["grid"]["std_px"] = gridJson([&](std::size_t i) { return significance->std_px[i]; });
    document["significance"] = {{"sigmas", significance->sigmas},
                                {"significant", significance->isSignificant()},
                                {"expected_rms_px", significance->expected_rms_px},
                                {"sure_p95_px", significance->sure_p95_px},
                                {"share_beyond", significance->share_beyond}};
  }
  return document;
}

class DiffCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade diff left.yaml right.yaml --tolerance 0.5px -o difference.svg\nExample: alidade diff "
        "before/ now/ --junit report.xml --report changes.html\nThe first line answers: same, changed, "
        "or cannot tell, because the stated uncertainty exceeds the tolerance.\nA and B may have different "
        "formats, models and resolutions. Differences are in pixels of the image with the higher\nresolution. "
        "Swapping A and B gives the inverse rotation and the same differences.\nIn two folders, cameras are "
        "paired by serial number, name or file name.\nTwo rigs are compared camera by camera, then the poses "
        "from the first camera, then what both together do: a pixel of\none camera, as a point at --distance "
        "(default: 10 times the largest baseline), projected into another.\nExit code 3: changed, or cannot "
        "tell.");
    flags.add(
        "files", &files_,
        "Two camera files or rigs of any format, or two folders, A and B; FILE#NAME selects one camera of "
        "a file with several",
        kFilePath);
    flags.add("--distance", &distance_m_,
              "Compare points at this distance, for example 2m, and align by the best pose "
              "instead of the best rotation",
              {.complaint = positiveNumber, .limits = "above 0", .number = metresOrNan});
    flags.addSwitch("--same-frame", same_frame_,
                    "Do not align: assume that both cameras have the same frame");
    flags.addQuarterTurns("--rotate", rotate_,
                          "Clockwise rotation of B's image relative to A's, in degrees. Default: 0, or 90 or "
                          "270 if the image sizes require it");
    flags.add("--grid", &grid_, "Grid of pixels to compare: COLUMNSxROWS. Default: 40 along the longer side",
              {.complaint = gridComplaint});
    flags.add("--tolerance", &tolerance_px_, "Largest accepted difference in pixels (95th percentile)",
              {.complaint = nonNegativeNumber, .limits = "0 or more", .number = pixelsOrNan});
    flags.addSwitch("--allow-unknown", allows_unknown_,
                    "Exit code 0 if the uncertainty that the files state is too large to tell");
    flags.add("-o,--output", &figure_,
              "SVG file to write: the difference over the image of A, as colours and arrows",
              {.word = kFilePath.word, .complaint = figureComplaint});
    addReportFlag(flags, report_, "the answers, with figures");
    addDateFlag(flags, date_);
    addJunitFlag(flags, common_);
    flags.addSwitch("--verbose", is_verbose_, "Print the differences over the image", true);
    addReadOptions(flags, camera_);
    flags.addCommon(common_, false);
  }

  int run(const Flags&) override {
    checkUsage();
    are_folders_ = isFolder(files_[0]);
    std::vector<DiffResult> results;
    if (are_folders_) {
      results = diffFolders(files_[0], files_[1], camera_,
                            [&](const std::string& a, const std::string& b) { return diffFiles(a, b); });
    } else {
      results.push_back(diffFiles(files_[0], files_[1]));
    }
    const std::vector<ComparedPair> pairs = mapped(results, &DiffResult::pair);
    const json document = are_folders_ ? documentOf(results, answerText(pairs)) : withAnswer(results.front());
    const bool has_figure = !figure_.empty() && pairs.front().drawing;
    if (has_figure) writeFileAtomically(figure_, standaloneSvg(pairs.front().drawing->svg));
    if (!common_.junit.empty())
      writeFileAtomically(common_.junit, junitText("alidade diff", casesOf(results)));
    if (!report_.empty())
      writeFileAtomically(report_, comparisonPage(pairs, originOf(files_, date_), document));
    answer(
        [&] { return jsonText(document); },
        [&] { return answerText(pairs) + "\n" + (are_folders_ ? rowsText(pairs) : results.front().text); });
    if (!common_.quiet) {
      for (const auto& path : {has_figure ? figure_ : "", report_})
        if (!path.empty()) printMessage("written to " + path);
    }
    const Agreement agreement = agreementOf(pairs);
    if (isAccepted(agreement)) return 0;
    printMessage(
        "error: " + answerText(pairs) +
        (pairs.size() > 1 || pairs.front().next_step.empty() ? "" : "\n  next: " + pairs.front().next_step));
    if (!figure_.empty() && !has_figure) printMessage(notWritten(figure_) + " (there is nothing to draw)");
    return kUntrustworthyExit;
  }

 private:
  static bool isFolder(const std::string& path) {
    std::error_code ignored;
    return std::filesystem::is_directory(path, ignored);
  }

  void checkUsage() const {
    if (files_.size() != 2) throw missing(counted(files_.size(), "file"), "two camera files, or two folders");
    if (same_frame_ && distance_m_) {
      throw flagError("--same-frame and --distance", "both", "one of them",
                      "remove --distance: without alignment the distance has no effect");
    }
    const bool is_one = isFolder(files_[0]);
    if (is_one != isFolder(files_[1])) {
      const std::string& other = files_[is_one ? 1 : 0];
      std::error_code ignored;
      if (!std::filesystem::exists(cameraFilePath(other), ignored)) throw missingPathError(other);
      throw misuse(files_[is_one ? 0 : 1] + " is a folder and " + files_[is_one ? 1 : 0] + " is not",
                   "two camera files, or two folders",
                   "name the file in the folder: alidade diff " + files_[0] + (is_one ? "/FILE " : " ") +
                       files_[1] + (is_one ? "" : "/FILE"));
    }
    if (is_one && !figure_.empty())
      throw flagError("--output " + figure_, "two folders", "two cameras",
                      "draw all with --report page.html");
    checkOutputs(std::vector<Output>{{"--output", figure_},
                                     {"--report", report_, "page.html"},
                                     {"--junit", common_.junit, "report.xml"}},
                 {cameraFilePath(files_[0]), cameraFilePath(files_[1]), common_.config}, common_);
    checkJunitPath(common_.junit);
  }

  [[nodiscard]] bool isAccepted(Agreement agreement) const {
    return agreement == Agreement::kWithin || (allows_unknown_ && agreement == Agreement::kUncertain);
  }

  [[nodiscard]] DiffResult diffFiles(const std::string& file_a, const std::string& file_b) const {
    const bool is_quiet = common_.quiet || are_folders_;
    const CameraSource source_a = loadCameras(file_a, camera_);
    const CameraSource source_b = loadCameras(file_b, camera_);
    if (isRigSource(source_a) || isRigSource(source_b)) return diffTwoRigs(source_a, source_b);
    const CameraRecord a = onlyCameraTelling(source_a, is_quiet);
    const CameraRecord b = onlyCameraTelling(source_b, is_quiet);
    const LensComparison lens = compareLenses(a, b, differenceOptions());
    DiffResult result{.pair = {.name = a.name.name, .a = file_a, .b = file_b}};
    result.pair.agreement = agreementOf(lens.difference, lens.significance, tolerance_px_);
    result.pair.reason = agreementText(lens.difference, lens.significance, tolerance_px_);
    result.pair.reason += placeText(source_a.cameras.front(), source_b.cameras.front());
    if (!isComparable(lens.difference))
      result.pair.next_step =
          "check both files with alidade validate, and that both cameras belong to the same image";
    if (!is_quiet) tellOfSizes(lens);
    if (lens.isKnown()) result.pair.drawing = drawingOf(result.pair, lens);
    result.text = textOf(result.pair, lens);
    result.document = differenceJson(lens);
    result.document["a"] = fileJson(file_a, lens.a);
    result.document["b"] = fileJson(file_b, lens.b);
    result.document["distance_m"] = orNull(distance_m_);
    return result;
  }

  [[nodiscard]] json withAnswer(const DiffResult& result) const {
    json document = result.document;
    document["answer"] = std::string(answerOf(result.pair.agreement));
    document["tolerance_px"] = tolerance_px_;
    const Agreement agreement = result.pair.agreement;
    const bool is_known = agreement == Agreement::kWithin || agreement == Agreement::kBeyond;
    document["agrees"] = is_known ? json(agreement == Agreement::kWithin) : json(nullptr);
    document["reason"] = result.pair.reason;
    document["created_by"] = programName();
    return document;
  }

  [[nodiscard]] json documentOf(const std::vector<DiffResult>& results, const std::string& answer) const {
    const json pairs = mapped(results, [&](const DiffResult& result) {
      json document = withAnswer(result);
      document["name"] = result.pair.name;
      return document;
    });
    return {{"a", files_[0]},
            {"b", files_[1]},
            {"answer", answer.substr(0, answer.find(':'))},
            {"created_by", programName()},
            {"pairs", pairs}};
  }

  static std::string rowsText(const std::vector<ComparedPair>& pairs) {
    std::string text;
    for (const ComparedPair& pair : pairs)
      text += fmt::format("{:<12} {:<20} {}\n", answerOf(pair.agreement), printable(pair.name), pair.reason);
    return text;
  }

  [[nodiscard]] std::vector<TestCase> casesOf(const std::vector<DiffResult>& results) const {
    return mapped(results, [&](const DiffResult& result) {
      const ComparedPair& pair = result.pair;
      TestCase test{.kind = "camera", .name = pair.name.empty() ? pair.a : pair.name, .text = result.text};
      const std::string reason = fmt::format("{}: {}", answerOf(pair.agreement), pair.reason);
      if (!isAccepted(pair.agreement)) test.failure = reason;
      if (pair.agreement == Agreement::kUncertain && allows_unknown_) test.skipped = reason;
      return test;
    });
  }

  void tellOfSizes(const LensComparison& lens) const {
    const ImageMatch& match = lens.difference.match;
    if (const auto crop = suspectCrop(lens.a, lens.b, match)) printMessage(cropText(*crop));
    const std::string uneven = unevenSizeText(lens.a.size, lens.b.size, match.quarter_turns);
    if (!uneven.empty()) printMessage(uneven);
  }

  // The cameras and the motion removed from their difference.
  [[nodiscard]] static std::string headText(const ComparedPair& pair, const LensComparison& lens) {
    return fileText("A", pair.a, lens.a) + fileText("B", pair.b, lens.b) + differenceText(lens.difference) +
           pupilText(lens);
  }

  // What is no part of a camera, but of a file: its pose in a rig, as ROS states it.
  static std::string placeText(const StatedCamera& a, const StatedCamera& b) {
    constexpr double kMillimetres = 1000;
    if (!a.camera_from_rig || !b.camera_from_rig) return "";
    const SE3 change = *a.camera_from_rig * b.camera_from_rig->inverse();
    const double angle_deg = kDegPerRad * change.rotation.log().norm();
    const double distance_mm = kMillimetres * change.translation.norm();
    if (angle_deg < 1e-6 && distance_mm < 1e-6) return "";
    return fmt::format(
        "; their poses in a rig differ by {:.3g} degrees and {:.3g} mm, which only two rigs show", angle_deg,
        distance_mm);
  }

  // Far points, which are compared, do not see the entrance pupils.
  [[nodiscard]] static std::string pupilText(const LensComparison& lens) {
    const EntrancePupil& a = lens.a.camera->pupil();
    const EntrancePupil& b = lens.b.camera->pupil();
    if (a == b) return "";
    return fmt::format(
        "Pupil    moves by {:.3g} mm in A and {:.3g} mm in B at 57 degrees, which near points see\n",
        1e3 * a.at(1), 1e3 * b.at(1));
  }

  [[nodiscard]] static Figure drawingOf(const ComparedPair& pair, const LensComparison& lens) {
    return differenceDrawing(lens.a, lens.b, lens.difference,
                             figureLines(headText(pair, lens) + testText(lens)));
  }

  [[nodiscard]] std::string textOf(const ComparedPair& pair, const LensComparison& lens) const {
    return headText(pair, lens) +
           (lens.isKnown() ? (is_verbose_ ? differenceTable(lens.difference) : "") + testText(lens) : "") +
           upsideDownText(lens);
  }

  static std::string gridComplaint(const std::string& text) {
    constexpr int kMostPixels = 1'000'000;
    const auto grid = parseSize(text);
    if (grid && grid->width <= kMostPixels / grid->height) return {};
    return "found '" + text + "', expected COLUMNSxROWS such as 20x15, with at most a million pixels";
  }

  [[nodiscard]] DiffResult diffTwoRigs(const CameraSource& a, const CameraSource& b) const {
    if (!figure_.empty() || rotate_) {
      throw usageError(
          {.where = figure_.empty() ? "--rotate" : "--output",
           .found = "two rigs",
           .expected = "two cameras",
           .next_step = "select a camera of each: " + a.path + "#" + cameraLabel(a.cameras.front())});
    }
    DifferenceOptions options = differenceOptions();
    // A distance applies only to the poses; each lens is compared for distant points.
    if (options.freed == Freed::kPose) options.freed = Freed::kRotation;
    return diffRigs(a, b, options, distance_m_, tolerance_px_, common_);
  }

  [[nodiscard]] DifferenceOptions differenceOptions() const {
    DifferenceOptions options;
    if (same_frame_) options.freed.reset();
    if (distance_m_) {
      options.freed = Freed::kPose;
      options.distance_m = *distance_m_;
    }
    if (rotate_) options.quarter_turns = *rotate_ / 90;
    if (grid_.empty()) return options;
    const ImageSize grid = *parseSize(grid_);
    options.columns = grid.width;
    options.rows = grid.height;
    const int num_pixels = options.columns * options.rows;
    if (options.freed && num_pixels < fewestPairs(*options.freed)) {
      throw flagError("--grid " + grid_, fmt::format("{} pixels", num_pixels),
                      fmt::format("at least {} pixels to estimate the best {}", fewestPairs(*options.freed),
                                  distance_m_ ? "pose" : "rotation"),
                      "use a finer grid, or --same-frame to compare without alignment");
    }
    return options;
  }

  // Images that are upside down have the same size, so a note states it.
  [[nodiscard]] std::string upsideDownText(const LensComparison& lens) const {
    const auto& [a, b, difference, significance] = lens;
    constexpr double kFarLess = 0.1;
    constexpr double kWorthWhilePx = 0.1;
    if (rotate_ || !difference.is_converged || difference.match.quarter_turns != 0 ||
        !(difference.rms_px > kWorthWhilePx))
      return "";
    DifferenceOptions options = differenceOptions();
    options.quarter_turns = 2;
    const ProjectionDifference turned = projectionDifference(a, b, options);
    // A few pixels that match by chance do not show a turned image.
    if (!turned.is_converged || turned.num_compared < difference.num_compared ||
        !(turned.rms_px < kFarLess * difference.rms_px))
      return "";
    return fmt::format(
        "Note     with B's image upside down relative to A's (--rotate 180), the RMS would be {:.4g} px "
        "instead of {:.4g} px\n",
        turned.rms_px, difference.rms_px);
  }

  static std::string figureComplaint(const std::string& text) {
    if (text.ends_with(".svg")) return {};
    return "found '" + text + "', expected a file name that ends in .svg";
  }

  [[nodiscard]] std::string cropText(const CropSuspicion& crop) const {
    const std::string& larger = files_[crop.is_a_larger ? 0 : 1];
    const std::string corner = crop.corner ? fmt::format("{},{}", crop.corner->x(), crop.corner->y()) : "X,Y";
    return fmt::format(
        "note: the image sizes differ, but the focal lengths agree ({:.6g} and {:.6g} px), as if one image "
        "were a crop of the other; this comparison assumes a resized image\n  next: if {}'s image is a crop "
        "of {}'s, run alidade convert {} -o cropped.yaml --crop {},{},{} and compare with its output",
        crop.focal_a_px, crop.focal_b_px, crop.is_a_larger ? "B" : "A", crop.is_a_larger ? "A" : "B", larger,
        corner, crop.part.width, crop.part.height);
  }

  static std::string fileText(const char* name, const std::string& path, const ComparedCamera& camera) {
    return fmt::format("{:<8} {}: {}, {} px\n", name, path, camera.camera->modelId(), sizeText(camera.size));
  }

  static json fileJson(const std::string& path, const ComparedCamera& camera) {
    return {{"file", path},
            {"model", camera.camera->modelId()},
            {"image_size", camera.size},
            {"has_covariance", camera.covariance.has_value()}};
  }

  std::vector<std::string> files_;
  ReadOptions camera_;
  std::optional<double> distance_m_;
  bool same_frame_ = false;
  std::optional<int> rotate_;
  std::string grid_;
  std::string figure_;
  double tolerance_px_ = kDefaultTolerancePx;
  bool allows_unknown_ = false;
  std::string report_;
  std::string date_;
  bool is_verbose_ = false;
  bool are_folders_ = false;
};

}  // namespace

const CommandEntry kDiffCommand = {"diff", "Tell whether two cameras, rigs or folders of them are the same",
                                   made<DiffCommand>};

}  // namespace alidade
