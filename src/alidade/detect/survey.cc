// SPDX-License-Identifier: MIT
#include "alidade/detect/survey.h"

#include <algorithm>
#include <map>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/detect/triage.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

SourceImage loadImage(const std::string& path) {
  if (path.find_first_of("\r\n") != std::string::npos) {
    throw inputError(
        {.where = path,
         .found = "a line break in the name",
         .expected = "a name without line breaks, because corners files have one line per corner",
         .next_step = "rename it"});
  }
  LoadedImage loaded = readGrayImage(path);
  return {.image = std::move(loaded.image), .exif_orientation = loaded.exif_orientation};
}

void noteOrientations(BoardSurvey& survey) {
  std::map<int, std::vector<std::size_t>> images;
  for (std::size_t i = 0; i < survey.outcomes.size(); ++i)
    images[survey.outcomes[i].exif_orientation].push_back(i);
  images.erase(1);
  for (auto& [orientation, turned] : images) {
    survey.notes.push_back({.kind = SurveyNote::Kind::kExifOrientation,
                            .images = std::move(turned),
                            .exif_orientation = orientation});
  }
}

std::string sizesText(const SurveyNote& note) {
  return "images of " + std::string(note.images.size() == 1 ? "two" : "several") +
         " different sizes were given; only the " + std::to_string(note.num_used) + " of " +
         sizeText(note.size) + " are used";
}

std::string blurText(const SurveyNote& note, const BoardSurvey& survey) {
  constexpr std::size_t kMaxNamed = 5;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(note.images.size(), kMaxNamed); ++i)
    names.push_back(survey.outcomes[note.images[i]].image);
  const std::size_t num_more = note.images.size() - names.size();
  return "much more blurred than the others: " + join(names, ", ") +
         (num_more > 0 ? " and " + std::to_string(num_more) + " more" : "");
}

std::string orientationText(const SurveyNote& note) {
  const bool is_one = note.images.size() == 1;
  return std::to_string(note.images.size()) + (is_one ? " image has" : " images have") +
         " an Exif orientation (" + describeExifOrientation(note.exif_orientation) +
         "); it is ignored, and the camera file applies to the pixels as stored";
}

std::string ambiguityText(const Checkerboard& board) {
  const std::string turned = board.symmetryStep() == 1 ? "90, 180 or 270" : "180";
  return "a board of " + std::to_string(board.columns) + "x" + std::to_string(board.rows) +
         " inner corners looks the same after a rotation by " + turned +
         " degrees, so the first corner may differ between images. This is harmless for one camera, but not "
         "for several. A board with one even and one odd count avoids it";
}

}  // namespace

std::size_t BoardSurvey::numFound() const {
  return static_cast<std::size_t>(std::count_if(
      outcomes.begin(), outcomes.end(), [](const ImageOutcome& o) { return o.detection.hasCorners(); }));
}

std::size_t BoardSurvey::numWhole() const {
  return static_cast<std::size_t>(std::count_if(outcomes.begin(), outcomes.end(),
                                                [](const ImageOutcome& o) { return o.detection.found(); }));
}

std::vector<View> BoardSurvey::views() const {
  std::vector<View> views;
  for (const ImageOutcome& outcome : outcomes) {
    if (outcome.detection.hasCorners())
      views.push_back({outcome.image, outcome.size, outcome.detection.corners});
  }
  return views;
}

BoardSurvey surveyImages(const std::vector<std::string>& paths, const Checkerboard& board,
                         const DetectImagesOptions& options) {
  expect(!paths.empty(), "at least one image");
  BoardSurvey survey{.board = board, .paths = paths, .outcomes = {}, .notes = {}};
  survey.outcomes = detectInImages(paths, loadImage, board, options);
  const std::vector<std::string> names = shortNames(paths);
  for (std::size_t i = 0; i < names.size(); ++i) survey.outcomes[i].image = names[i];
  survey.notes = triage(survey.outcomes, board);
  noteOrientations(survey);
  if (survey.numFound() == 0) return survey;
  if (board.isAmbiguous()) survey.notes.push_back({.kind = SurveyNote::Kind::kAmbiguousBoard});
  const auto hint = diagnoseBoard(survey.outcomes, board);
  if (hint && hint->is_closed) survey.notes.push_back({.kind = SurveyNote::Kind::kOtherBoard, .hint = hint});
  return survey;
}

std::optional<Diagnosis> diagnosisOf(const ImageOutcome& outcome) {
  const Detection& detection = outcome.detection;
  if (detection.found()) return std::nullopt;
  return Diagnosis{.severity = detection.hasCorners() ? Severity::kNote : Severity::kWarning,
                   .id = std::string(reasonCode(detection.reason)),
                   .cause = outcome.image,
                   .evidence = detection.detail};
}

Diagnosis diagnosisOf(const SurveyNote& note, const BoardSurvey& survey) {
  const auto told = [](std::string id, std::string cause) {
    return Diagnosis{.severity = Severity::kNote, .id = std::move(id), .cause = std::move(cause)};
  };
  switch (note.kind) {
    case SurveyNote::Kind::kSeveralSizes:
      return told("several_sizes", sizesText(note));
    case SurveyNote::Kind::kBlurred:
      return told("blurred_images", blurText(note, survey));
    case SurveyNote::Kind::kExifOrientation:
      return told("exif_orientation", orientationText(note));
    case SurveyNote::Kind::kAmbiguousBoard:
      return told("ambiguous_board", ambiguityText(survey.board));
    case SurveyNote::Kind::kOtherBoard:
      return told("other_board", hintText(note.hint.value(), survey.board));
  }
  return {};
}

std::string hintText(const BoardHint& hint, const Checkerboard& asked) {
  // A hint has its longer side first; it is told in the order of the board that was asked for.
  const bool is_upright = asked.columns < asked.rows;
  const int columns = is_upright ? hint.rows : hint.columns;
  const int rows = is_upright ? hint.columns : hint.rows;
  std::string text = std::to_string(hint.num_images) +
                     (hint.num_images == 1 ? " image shows " : " images show ") +
                     (hint.is_closed ? "" : "at least ") + std::to_string(columns) + "x" +
                     std::to_string(rows) + " inner corners";
  if (columns + 1 == asked.columns && rows + 1 == asked.rows) text += "; did you count squares?";
  if (columns - 1 == asked.columns && rows - 1 == asked.rows)
    text += "; did you leave out one line of corners in each direction?";
  text += (text.back() == '?' ? " Use " : "; use ") +
          specText({.columns = columns, .rows = rows, .square_m = asked.square_m}) +
          (hint.is_closed ? " if that is your board" : " if that is the whole board");
  return text;
}

}  // namespace alidade
