// SPDX-License-Identifier: MIT
#include "commands/rig/rig_inputs.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/distinct_names.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/files/frame_table_file.h"
#include "alidade/imagery/video_reader.h"
#include "command.h"
#include "console.h"
#include "outputs.h"

namespace alidade {
namespace {

// "left" for photos/left/, photos/left*.png and left.csv; names of folders are not cut.
std::string nameOf(const std::string& input) {
  std::filesystem::path path = std::filesystem::absolute(input).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  std::string name = path.filename().string();
  std::error_code ignored;  // of missing inputs, which are reported later
  if (std::filesystem::is_directory(path, ignored)) return name;
  const std::size_t pattern = name.find_first_of("*?[%");
  name = pattern == std::string::npos ? path.stem().string() : name.substr(0, pattern);
  while (!name.empty() && (name.back() == '_' || name.back() == '-' || name.back() == '.')) name.pop_back();
  return name;
}

std::vector<std::string> namesOf(const std::vector<std::string>& inputs) {
  return distinctNames(mapped(inputs, nameOf), inputs);
}

// Resolves links and detours. An input without a path, such as a pipe, stays unchanged.
std::filesystem::path withoutLinks(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(path, error);
  if (error || whole.empty()) return std::filesystem::absolute(path).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

// An image that is a link keeps its own name.
std::string placeOf(const std::filesystem::path& image) {
  return (withoutLinks(image.has_parent_path() ? image.parent_path() : ".") / image.filename()).string();
}

void requireDifferentInputs(const std::string& command, const std::vector<std::string>& inputs) {
  const std::string expected = "images of its own for each camera";
  std::map<std::string, std::size_t> input_of;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const auto [at, is_new] = input_of.emplace(withoutLinks(inputs[i]).string(), i);
    if (is_new) continue;
    throw flagError(command,
                    "the same input for two cameras: " + inputs[at->second] +
                        (inputs[at->second] == inputs[i] ? "" : " and " + inputs[i]),
                    expected, "give another folder for the second, for example left/ right/");
  }
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (isCornersFile(inputs[i])) continue;
    for (const std::string& image : withImages({inputs[i]})) {
      if (image == inputs[i]) continue;
      const auto [at, is_new] = input_of.emplace(placeOf(image), i);
      if (is_new || at->second == i) continue;
      throw flagError(
          command,
          "an image of two cameras: " + image + ", in " + inputs[at->second] + " and in " + inputs[i],
          expected);
    }
  }
}

void tellNamedWithoutViews(const FrameTable& frames, const std::vector<RigViews>& cameras) {
  if (frames.empty()) return;
  const std::vector<RigImage> named = namedWithoutViews(frames, cameras);
  if (named.empty()) return;
  const RigImage& first = named.front();
  printMessage(fmt::format("note: {} of {} {} in no corners file, for example '{}' of {} ({}): {}",
                           counted(named.size(), "image"), frames.path, named.size() == 1 ? "is" : "are",
                           first.image, cameras[first.camera].name, first.frame,
                           "no board was found there, or the name is misspelt"));
}

// Adds the boards of a camera to those before; its views then refer to these. Corners files name only the
// boards that were found.
void addBoards(const std::vector<std::string>& inputs, std::size_t camera, GivenViews& given,
               std::vector<Board>& boards) {
  std::vector<std::size_t> index;
  for (const Board& board : given.boards) {
    const auto at = std::ranges::find(boards, board);
    index.push_back(static_cast<std::size_t>(at - boards.begin()));
    if (at != boards.end()) continue;
    for (const Board& other : boards) {
      if (!board.differsInLengthsFrom(other)) continue;
      throw inputError(
          {.where = inputs[camera],
           .found = "the board " + board.spec() + ", which is " + other.spec() + " in inputs before",
           .expected = "the same lengths of a board for all cameras"});
    }
    boards.push_back(board);
  }
  for (View& view : given.views) view.board = index[view.board];
}

}  // namespace

void RigInputs::addOptions(Flags& flags) {
  constexpr std::size_t kMostFrames = 300;  // at eight a second, to follow the boards' motion
  even_from = 0;
  num_frames = kMostFrames;
  flags.add("input", &inputs,
            "One for each camera: a folder of images, a pattern in quotes, a video, or a corners file (.csv)",
            kFilePath);
  addBoards(flags);
  flags.under(kBoardGroup);
  flags.add("--names", &names, "Names of the cameras, separated by commas. Default: from the inputs",
            {.separator = ','});
  addMatch(flags);
  addDetection(flags, false);
  flags.under(kBoardGroup);
  flags.add("--mirrored", &mirrored_of,
            std::string(
                "Why boards look mirrored; for all cameras, or one value for each, separated by commas ('-': "
                "they do not). ") +
                kMirroredText + "; back: they show the back of a board that is printed through",
            oneOf({"image", "back", "-"}, ','));
}

void RigInputs::addMatch(Flags& flags) {
  flags.under(kBoardGroup);
  flags.add("--match", &match,
            "CSV file that says which images were taken together: a column for each camera, a row for "
            "each frame. Default: images whose names match",
            kFilePath);
}

double RigInputs::rateOfVideos(const CommonOptions& common) const {
  constexpr double kSame = 0.01;
  double first = 0;
  for (const std::string& input : inputs) {
    if (!hasVideoName(input)) return 0;
    const double rate = VideoReader(input, {.cancel = common.cancel}).frameRate();
    if (!(rate > 0)) return 0;
    if (first == 0) first = rate;
    if (!match.empty() || std::abs(rate - first) < kSame * first) continue;
    throw inputError(
        {.where = input,
         .found = fmt::format("{:.4g} frames a second; {} has {:.4g}", rate, inputs.front(), first),
         .expected = "videos with one rate, because frames with one number belong together",
         .next_step =
             "say which frames belong together with --match FRAMES.csv, or convert the videos: ffmpeg -i "
             "IN -r 30 OUT.mp4"});
  }
  return first;
}

bool RigInputs::shiftTo(const RigCalibration& rig, const CommonOptions& common) {
  if (!std::ranges::all_of(inputs, hasVideoName) || !rig.frames.areShifted()) return false;
  leads.clear();
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    leads.push_back(std::round(rig.frames.leads[c] - rig.fit.cameras[c].delay * rig.frames.step));
  const double least = std::ranges::min(leads);
  for (double& lead : leads) lead -= least;
  if (std::ranges::all_of(leads, [&](double lead) { return std::fmod(lead, rig.frames.step) == 0; }))
    return false;
  if (!common.quiet)
    printMessage("note: the videos start at different times; frames that were taken together are read");
  return true;
}

std::string RigInputs::mirroredOf(std::size_t camera) const {
  if (mirrored_of.empty()) return "";
  return mirrored_of.size() == 1 ? mirrored_of.front() : mirrored_of[camera];
}

std::vector<std::string> RigInputs::sources() const {
  std::vector<std::string> sources = {match};
  for (const std::string& input : inputs)
    append(sources, isCornersFile(input) ? std::vector{input} : withImages({input}));
  return sources;
}

std::vector<std::string> RigInputs::cameraNames(const CommonOptions& common) const {
  requireDifferentInputs(common.command, inputs);
  requireMirroredCount();
  std::vector<std::string> result = names.empty() ? namesOf(inputs) : names;
  const std::set<std::string> unique(result.begin(), result.end());
  if (result.size() != inputs.size() || unique.size() != result.size() || unique.contains("")) {
    throw flagError(names.empty() ? common.command : "--names",
                    (result.empty() ? "no names in the inputs" : "the names " + join(result, ", ")) +
                        fmt::format(" for {} cameras", inputs.size()),
                    "a different name for each camera", "give --names, for example --names left,right");
  }
  return result;
}

void RigInputs::sortLike(const std::vector<std::string>& cameras, const CommonOptions& common) {
  requireDifferentInputs(common.command, inputs);
  requireMirroredCount();
  expect(inputs.size() == cameras.size(), "an input for each camera");
  const auto places = placesByName(namesOf(inputs), cameras);
  if (!places || places->empty() || std::ranges::is_sorted(*places)) return;
  placeAt(*places);
  if (common.quiet) return;
  std::vector<std::string> assigned;
  for (std::size_t c = 0; c < cameras.size(); ++c) assigned.push_back(inputs[c] + " to " + cameras[c]);
  printMessage("note: the inputs were assigned to the cameras by their names: " + join(assigned, ", "));
}

void RigInputs::requireMirroredCount() const {
  if (mirrored_of.size() < 2 || mirrored_of.size() == inputs.size()) return;
  throw flagError("--mirrored", fmt::format("{} values for {} cameras", mirrored_of.size(), inputs.size()),
                  "one value, or one for each camera");
}

void RigInputs::placeAt(const std::vector<std::size_t>& places) {
  for (std::vector<std::string>* values : {&inputs, &mirrored_of}) {
    if (values->size() < 2) continue;
    const std::vector<std::string> given = *values;
    for (std::size_t i = 0; i < given.size(); ++i) (*values)[places[i]] = given[i];
  }
}

std::optional<std::vector<std::size_t>> placesByName(const std::vector<std::string>& names,
                                                     const std::vector<std::string>& cameras) {
  std::vector<std::size_t> places;
  for (const std::string& name : names) {
    const auto at = std::ranges::find(cameras, name);
    const auto place = static_cast<std::size_t>(at - cameras.begin());
    if (at == cameras.end() || std::ranges::find(places, place) != places.end()) return std::nullopt;
    places.push_back(place);
  }
  return places;
}

void tellIfRejected(const RigRecord& rig, const std::string& path, bool is_quiet) {
  if (is_quiet || !rig.isCalibrated() || rig.verdict != Verdict::kNo) return;
  printMessage("note: " + path + " says of itself that it must not be used (verdict: rejected" +
               (rig.findings.empty() ? "" : "; " + join(rig.findings, ", ")) + ")");
}

RigInputViews readRigViews(const RigInputs& inputs, const std::vector<std::string>& names,
                           const CommonOptions& common) {
  RigInputViews result;
  if (!inputs.match.empty()) result.frames = readFrameTable(inputs.match);
  for (std::size_t c = 0; c < inputs.inputs.size(); ++c) {
    BoardInputs of_camera = inputs;
    of_camera.inputs = {inputs.inputs[c]};
    of_camera.mirrored = inputs.mirroredOf(c);
    const double lead = inputs.leads.empty() ? 0 : inputs.leads[c];
    if (lead != 0) of_camera.even_from = static_cast<std::size_t>(lead);
    GivenViews given = readViews(of_camera, common);
    addBoards(inputs.inputs, c, given, result.boards);
    if (!common.quiet && !common.json) {
      printMessage(
          fmt::format("{}: a board in {} of {} images", names[c], given.num_found, given.num_images));
      printListed(given.reasons);
    }
    result.cameras.push_back({.name = names[c],
                              .views = std::move(given.views),
                              .images = given.images,
                              .paths = given.paths,
                              .lead = lead});
    given.views.clear();
    result.given.push_back(std::move(given));
  }
  if (!common.quiet) tellNamedWithoutViews(result.frames, result.cameras);
  return result;
}

}  // namespace alidade
