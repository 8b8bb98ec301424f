// SPDX-License-Identifier: MIT
#include "given_views.h"

#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/files/board_file.h"
#include "alidade/files/corners_file.h"
#include "alidade/target/board_spec.h"
#include "detection_stage.h"

namespace alidade {
namespace {

GivenViews readCorners(const ViewsRequest& request) {
  if (request.inputs.size() > 1) {
    throw usageError(
        {.where = request.command,
         .found = fmt::format("{} inputs, of which the first is a corners file", request.inputs.size()),
         .expected = "one corners file, or images",
         .next_step = "concatenate corners files of one camera first: cat a.csv b.csv > all.csv"});
  }
  CornersFile file = readCornersFile(request.inputs.front());
  if (!request.board.empty() && !(readBoard(request.board) == file.board)) {
    throw inputError({.where = request.inputs.front(),
                      .found = "board " + specText(file.board),
                      .expected = specText(readBoard(request.board)) + " from --board",
                      .next_step = "remove --board: the corners file states its board"});
  }
  GivenViews given;
  given.input.board = file.board;
  given.input.num_images = given.input.num_found = file.views.size();
  std::vector<ImageSize> sizes;
  for (const View& view : file.views) sizes.push_back(view.size);
  const SizeGroups groups = groupBySize(sizes);
  for (const std::size_t i : groups.others) {
    given.input.reasons.push_back(fmt::format("{}: other_size: {}, while most images are {}",
                                              file.views[i].image, sizeText(sizes[i]),
                                              sizeText(groups.size)));
  }
  for (const std::size_t i : groups.in_group) given.views.push_back(std::move(file.views[i]));
  return given;
}

GivenViews findBoards(const ViewsRequest& request, const CommonOptions& options, const CancelFlag* cancel) {
  if (request.board.empty()) {
    throw usageError({.where = request.command,
                      .found = "no --board",
                      .expected = "for example --board checkerboard:9x6:25mm"});
  }
  DetectionStage stage = runDetection({.inputs = request.inputs,
                                       .board = readBoard(request.board),
                                       .debug_folder = request.debug_folder.value_or("")},
                                      options, cancel);
  requireBoards(stage.survey, options, request.debug_folder.has_value());
  const BoardSurvey& survey = stage.survey;
  return {.input = {.board = survey.board,
                    .num_images = survey.outcomes.size(),
                    .num_found = survey.numFound(),
                    .measures = measuresText(survey),
                    .reasons = reasonLines(survey),
                    .notes = std::move(stage.notes)},
          .views = survey.views()};
}

}  // namespace

bool isCornersFile(const std::string& path) {
  return path.ends_with(".csv") || path.ends_with(".CSV");
}

GivenViews readViews(const ViewsRequest& request, const CommonOptions& options, const CancelFlag* cancel) {
  return isCornersFile(request.inputs.front()) ? readCorners(request) : findBoards(request, options, cancel);
}

}  // namespace alidade
