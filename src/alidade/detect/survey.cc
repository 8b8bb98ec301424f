// SPDX-License-Identifier: MIT
#include "alidade/detect/survey.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/error_text.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/detect/board_set.h"
#include "alidade/imagery/image_list.h"

namespace alidade {
namespace {

Diagnosis noteOf(DiagnosisId id, std::string cause) {
  return {.id = id, .severity = Severity::kNote, .cause = std::move(cause)};
}

void noteOrientations(BoardSurvey& survey) {
  std::map<int, int> counts;
  for (const ImageOutcome& outcome : survey.outcomes) ++counts[outcome.exif_orientation];
  counts.erase(1);
  for (const auto& [orientation, count] : counts) {
    survey.notes.push_back(noteOf(
        "exif_orientation",
        fmt::format("{} {} an Exif orientation ({}); it is ignored, and the camera file applies to the "
                    "pixels as stored",
                    count, count == 1 ? "image has" : "images have", describeExifOrientation(orientation))));
  }
}

bool hasCorners(const ImageOutcome& outcome) {
  return outcome.detection.hasCorners();
}

void refuseOtherSizes(std::span<BoardSurvey> surveys) {
  const bool any_corners = std::ranges::any_of(surveys, &BoardSurvey::numFound);
  // Images without a board do not decide the size, unless there are no others.
  std::vector<ImageSize> sizes;
  for (std::size_t i = 0; i < surveys.front().outcomes.size(); ++i) {
    const bool is_voter = std::ranges::any_of(surveys, [&](const BoardSurvey& survey) {
      return any_corners ? hasCorners(survey.outcomes[i]) : survey.outcomes[i].isReadable();
    });
    if (is_voter) sizes.push_back(surveys.front().outcomes[i].size);
  }
  const SizeGroups groups = groupBySize(sizes);
  for (BoardSurvey& survey : surveys) {
    for (ImageOutcome& outcome : survey.outcomes) {
      if (!outcome.isReadable() || outcome.size == groups.size) continue;
      outcome.detection.withdraw(
          DetectionReason::kOtherSize,
          "is " + sizeText(outcome.size) + ", while most images are " + sizeText(groups.size));
    }
  }
  if (groups.others.empty()) return;
  surveys.front().notes.push_back(noteOf(
      "several_sizes", fmt::format("images of {} different sizes were given; only the {} of {} are used",
                                   groups.others.size() == 1 ? "two" : "several", groups.in_group.size(),
                                   sizeText(groups.size))));
}

// @param most_px       between their corners, root mean square
// @param missing_share  of the corners that one of them may not have; two are allowed in any case
bool showSame(const std::vector<Corner>& a, const std::vector<Corner>& b, double most_px = 0.25,
              double missing_share = 0.01) {
  constexpr double kFewMissing = 2;
  std::size_t num_common = 0;
  double sum = 0;
  for (auto i = a.begin(), k = b.begin(); i != a.end() && k != b.end();) {
    if (i->id == k->id) {
      sum += (i->pixel - k->pixel).squaredNorm();
      ++num_common;
    }
    const int id = std::max(i->id, k->id);
    const bool are_both = i->id == k->id;
    if (i->id < id || are_both) ++i;
    if (k->id < id || are_both) ++k;
  }
  const auto count = static_cast<double>(num_common);
  const auto most = static_cast<double>(std::max(a.size(), b.size()));
  return num_common > 0 && most - count <= std::max(kFewMissing, missing_share * most) &&
         sum <= most_px * most_px * count;
}

void refuseDuplicates(std::span<ImageOutcome> outcomes) {
  for (auto outcome = outcomes.begin(); outcome != outcomes.end(); ++outcome) {
    const std::vector<Corner>& corners = outcome->detection.corners;
    // Unlike photographs, frames of a video repeat their errors if the board hardly moves.
    constexpr double kShare = 0.01;
    constexpr double kMissingShare = 0.2;
    const double frames_px = kShare * std::max(outcome->size.width, outcome->size.height);
    const auto original = std::find_if(outcomes.begin(), outcome, [&](const ImageOutcome& other) {
      const bool are_frames = outcome->sequence && outcome->sequence == other.sequence;
      return showSame(other.detection.corners, corners) ||
             (are_frames && showSame(other.detection.corners, corners, frames_px, kMissingShare));
    });
    if (original == outcome) continue;
    outcome->detection.withdraw(
        DetectionReason::kDuplicate,
        showSame(original->detection.corners, corners)
            ? "shows the same corners as " + original->image
            : fmt::format("shows the board within {:.0f} px of its place in {}", frames_px, original->image));
  }
}

void refuseUnclosed(std::span<ImageOutcome> outcomes, const std::string& detail) {
  for (ImageOutcome& outcome : outcomes) {
    Detection& detection = outcome.detection;
    const bool is_sure = detection.seen && detection.seen->is_closed;
    if (detection.hasCorners() && !is_sure) detection.withdraw(DetectionReason::kOtherBoard, detail);
  }
}

void refusePartsOfAnother(std::span<ImageOutcome> outcomes, const Board& board,
                          std::span<const Board> others) {
  int num_with_corners = 0;
  int num_all_lines = 0;
  std::map<std::pair<int, int>, int> counts;
  for (const ImageOutcome& outcome : outcomes) {
    const Detection& detection = outcome.detection;
    if (!detection.hasCorners() || !detection.seen) continue;
    ++num_with_corners;
    num_all_lines += detection.seen->hasCountsOf(board.columns(), board.rows()) ? 1 : 0;
    ++counts[{detection.seen->columns, detection.seen->rows}];
  }
  const auto hint = diagnoseBoard(outcomes, board, others);
  if (hint && hint->is_closed && hint->num_images > num_all_lines) {
    return refuseUnclosed(
        outcomes,
        fmt::format(
            "may show part of the board of {}x{} inner corners that is completely visible in other images",
            hint->columns, hint->rows));
  }
  constexpr int kEnoughImages = 3;
  if (num_all_lines > 0 || num_with_corners < kEnoughImages) return;
  const auto commonest = std::max_element(counts.begin(), counts.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
  if (2 * commonest->second <= num_with_corners) return;
  refuseUnclosed(
      outcomes,
      fmt::format("no image shows all rows and columns of a board with {}x{} inner corners; most show {}x{}",
                  board.columns(), board.rows(), commonest->first.first, commonest->first.second));
}

// Notes images whose edges are much wider than those of most; their corners are used, with their large
// sigmas.
void noteBlurred(BoardSurvey& survey) {
  constexpr double kFactor = 2.5;
  constexpr double kSharpPx = 1.5;  // smaller blur is harmless
  std::vector<double> blurs;
  for (const ImageOutcome& outcome : survey.outcomes) {
    if (hasCorners(outcome)) blurs.push_back(outcome.detection.measures.blur_px);
  }
  if (blurs.empty()) return;
  const double limit = std::max(kSharpPx, kFactor * medianOf(std::move(blurs)));
  std::vector<std::string> names;
  for (const ImageOutcome& outcome : survey.outcomes) {
    if (hasCorners(outcome) && outcome.detection.measures.blur_px > limit) names.push_back(outcome.image);
  }
  if (names.empty()) return;
  constexpr std::size_t kMaxNamed = 5;
  const std::size_t num_more = names.size() - std::min(names.size(), kMaxNamed);
  names.resize(names.size() - num_more);
  survey.notes.push_back(
      noteOf("blurred_images", "much more blurred than the others: " + join(names, ", ") +
                                   (num_more > 0 ? fmt::format(" and {} more", num_more) : "")));
}

void noteBoard(BoardSurvey& survey, std::span<const Board> others) {
  if (survey.numFound() == 0) return;
  if (survey.board.isAmbiguous()) survey.notes.push_back(ambiguityOf(survey.board));
  const auto hint = diagnoseBoard(survey.outcomes, survey.board, others);
  if (hint && hint->is_closed) survey.notes.push_back(noteOf("other_board", hintText(*hint, survey.board)));
}

// Reasons for which an image does not show the expected board.
bool isElsewhere(DetectionReason reason) {
  return reason == DetectionReason::kNoBoard || reason == DetectionReason::kUnplaced ||
         reason == DetectionReason::kLargerBoard || reason == DetectionReason::kOtherBoard;
}

}  // namespace

std::size_t BoardSurvey::numFound() const {
  return static_cast<std::size_t>(std::ranges::count_if(outcomes, hasCorners));
}

std::size_t BoardSurvey::numWhole() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(outcomes, &Detection::found, &ImageOutcome::detection));
}

std::vector<View> BoardSurvey::views() const {
  std::vector<View> views;
  for (const ImageOutcome& outcome : outcomes) {
    if (hasCorners(outcome)) views.push_back({outcome.image, outcome.size, outcome.detection.corners, index});
  }
  return views;
}

BoardSurvey surveyImages(const ImageSet& images, const Board& board, const DetectImagesOptions& options) {
  return std::move(surveyImages(images, std::span(&board, 1), options).front());
}

std::vector<BoardSurvey> surveyImages(const ImageSet& images, std::span<const Board> boards,
                                      const DetectImagesOptions& options) {
  expect(images.size() > 0 && !boards.empty(), "at least one image and one board");
  requireDistinguishable(boards);
  std::vector<std::vector<ImageOutcome>> of_boards = detectInImages(images, boards, options);
  const std::vector<std::string> paths = images.names();
  settleClaims(boards, of_boards);
  const std::vector<std::string> names = shortNames(paths);
  std::vector<BoardSurvey> surveys;
  for (std::size_t b = 0; b < boards.size(); ++b) {
    for (std::size_t i = 0; i < names.size(); ++i) of_boards[b][i].image = names[i];
    surveys.push_back(
        {.board = boards[b], .index = b, .paths = paths, .outcomes = std::move(of_boards[b]), .notes = {}});
  }
  triage(surveys);
  return surveys;
}

void triage(std::span<BoardSurvey> surveys) {
  const std::vector<Board> boards = mapped(surveys, &BoardSurvey::board);
  refuseOtherSizes(surveys);
  for (BoardSurvey& survey : surveys) {
    refusePartsOfAnother(survey.outcomes, survey.board, boards);
    refuseDuplicates(survey.outcomes);
    noteBlurred(survey);
  }
  noteOrientations(surveys.front());
  for (BoardSurvey& survey : surveys) noteBoard(survey, boards);
}

std::optional<Diagnosis> diagnosisOf(const ImageOutcome& outcome) {
  const Detection& detection = outcome.detection;
  if (detection.found()) return std::nullopt;
  return Diagnosis{.id = DiagnosisId::read(reasonCode(detection.reason)),
                   .severity = detection.hasCorners() ? Severity::kNote : Severity::kWarning,
                   .cause = outcome.image,
                   .evidence = detection.detail};
}

Diagnosis ambiguityOf(const Board& board) {
  return noteOf(
      "ambiguous_board",
      fmt::format("a board of {} looks the same after a rotation by {} degrees, so the first of them may "
                  "differ between images. Views are numbered alike only if the board's unevenness tells. "
                  "Alternative: {}",
                  board.countsText(), board.symmetryStep() == 1 ? "90, 180 or 270" : "180",
                  board.words().certain));
}

std::string hintText(const BoardHint& hint, const Board& asked) {
  // A hint has its longer side first; the text uses the order of the expected board.
  const bool is_upright = asked.columns() < asked.rows();
  const int columns = is_upright ? hint.rows : hint.columns;
  const int rows = is_upright ? hint.columns : hint.rows;
  std::string text = fmt::format("{} {} {}{}x{} inner corners", hint.num_images,
                                 hint.num_images == 1 ? "image shows" : "images show",
                                 hint.is_closed ? "" : "at least ", columns, rows);
  if (columns + 1 == asked.columns() && rows + 1 == asked.rows()) text += "; did you count squares?";
  if (columns - 1 == asked.columns() && rows - 1 == asked.rows())
    text += "; did you miss one line of corners in each direction?";
  text += (text.back() == '?' ? " Use " : "; use ") +
          Board(Checkerboard{.columns = columns, .rows = rows, .square_m = asked.spacing()}).spec() +
          (hint.is_closed ? " if that is your board" : " if that is the whole board");
  return text;
}

std::vector<std::string> reasonLines(std::span<const BoardSurvey> surveys) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < surveys.front().outcomes.size(); ++i) {
    const bool is_any_found = std::ranges::any_of(
        surveys, [&](const BoardSurvey& survey) { return survey.outcomes[i].detection.hasCorners(); });
    for (const BoardSurvey& survey : surveys) {
      const ImageOutcome& outcome = survey.outcomes[i];
      const auto why = diagnosisOf(outcome);
      if (!why || (is_any_found && isElsewhere(outcome.detection.reason))) continue;
      const std::string which = surveys.size() > 1 ? fmt::format(" ({})", survey.board.spec()) : "";
      lines.push_back(oneLine(fmt::format("{}: {}{}: {}", why->cause, why->id, which, why->evidence)));
    }
  }
  return lines;
}

std::optional<BoardHint> diagnoseBoard(std::span<const ImageOutcome> outcomes, const Board& asked,
                                       std::span<const Board> others) {
  // A board that was seen but rejected for its quality is not evidence of a different board.
  const auto speaks = [&](const Detection& detection) {
    return (detection.reason == DetectionReason::kUnplaced ||
            detection.reason == DetectionReason::kLargerBoard ||
            detection.reason == DetectionReason::kOtherBoard) &&
           detection.seen && !detection.seen->hasCountsOf(asked.columns(), asked.rows()) &&
           std::ranges::none_of(others, [&](const Board& other) {
             return detection.seen->hasCountsOf(other.columns(), other.rows());
           });
  };
  std::map<std::array<int, 3>, int> counts;  // complete boards first
  for (const ImageOutcome& outcome : outcomes) {
    const std::optional<SeenGrid>& seen = outcome.detection.seen;
    if (speaks(outcome.detection)) ++counts[{seen->is_closed ? 0 : 1, seen->columns, seen->rows}];
  }
  std::optional<BoardHint> best;
  for (const auto& [grid, count] : counts) {
    const bool is_closed = grid[0] == 0;
    if (best && (best->is_closed != is_closed || count <= best->num_images)) continue;
    best = {.columns = grid[1], .rows = grid[2], .num_images = count, .is_closed = is_closed};
  }
  return best;
}

}  // namespace alidade
