// SPDX-License-Identifier: MIT
#include "board_views.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/error_text.h"
#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/detect/board_guess.h"
#include "alidade/detect/board_set.h"
#include "alidade/detect/draw_detection.h"
#include "alidade/files/board_file.h"
#include "alidade/files/content_cache.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/text/table_lines.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/imagery/image_set.h"
#include "alidade/report/data/utf8.h"
#include "alidade/target/board_spec.h"
#include "command.h"
#include "console.h"

namespace alidade {
namespace {

// Paths of the debug images, by path of the input. Names that differ only in folders stay distinct, and long
// ones leave room for suffixes.
std::map<std::string, std::string> debugPaths(const std::string& folder,
                                              const std::vector<std::string>& paths,
                                              const std::vector<std::string>& names) {
  constexpr std::size_t kMaxLength = 180;
  std::map<std::string, std::string> result;
  std::map<std::string, int> num_taken;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    std::string name = names[i].substr(names[i].size() - std::min(names[i].size(), kMaxLength));
    std::replace(name.begin(), name.end(), '/', '_');
    const int number = ++num_taken[name];
    if (number > 1) name += fmt::format("-{}", number);
    result[paths[i]] = (std::filesystem::path(folder) / (name + ".detection.png")).string();
  }
  return result;
}

void prepareDebugFolder(const std::string& folder, const std::vector<std::string>& images) {
  std::error_code error;
  for (const std::string& image : images) {
    const std::filesystem::path parent = std::filesystem::path(image).parent_path();
    if (!std::filesystem::equivalent(parent.empty() ? "." : parent, folder, error)) continue;
    throw flagError("--debug " + folder, "this is the folder of the input " + image, "a different folder",
                    "choose another folder, otherwise the next run would read the debug images as inputs");
  }
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw inputError({.where = "--debug " + folder,
                      .found = error ? error.message() : "a file with this name exists",
                      .expected = "a writable folder, or a new one"});
  }
}

// "A", or "A and B".
std::string specsText(std::span<const Board> boards) {
  return join(mapped(boards, &Board::spec), " and ");
}

// Corners of one board; the command line supplies what the files do not state.
CornersFile readVnl(const BoardInputs& inputs, const CommonOptions& options) {
  if (inputs.boards.size() != 1) {
    throw flagError(options.command, inputs.boards.empty() ? "no --board" : "several boards",
                    "one, for example --board checkerboard:9x6:25mm",
                    inputs.inputs.front() + " has the corners of one board and does not state it");
  }
  if (!inputs.image_size) {
    throw flagError(options.command, "no --image-size", "for example --image-size 640x480",
                    inputs.inputs.front() + " does not state it; give width and height in pixels");
  }
  return readVnlFiles(inputs.inputs, readBoard(inputs.boards.front()), *inputs.image_size);
}

// Number of corners that two boards have at the same pixel.
std::size_t numShared(const View& a, const View& b) {
  constexpr double kSamePx = 0.5;
  return static_cast<std::size_t>(std::ranges::count_if(a.corners, [&](const Corner& corner) {
    const auto other = std::ranges::find(b.corners, corner.id, &Corner::id);
    return other != b.corners.end() && (other->pixel - corner.pixel).norm() < kSamePx;
  }));
}

// Warns of boards that may be one board with its lengths given in two ways, and refuses views if this is
// certain.
void checkLengths(const CornersFile& file, bool is_quiet, std::vector<std::string>& notes) {
  constexpr std::size_t kCertain = 4;
  for (std::size_t i = 0; i + 1 < file.views.size(); ++i) {
    for (std::size_t k = i + 1; k < file.views.size() && file.views[k].image == file.views[i].image; ++k) {
      const Board& first = file.boards[file.views[i].board];
      const Board& second = file.boards[file.views[k].board];
      if (!first.differsInLengthsFrom(second) || numShared(file.views[i], file.views[k]) < kCertain) continue;
      throw inputError({.where = "image " + file.views[i].image,
                        .found = fmt::format("the same {} of {} and of {}", first.words().points,
                                             first.spec(), second.spec()),
                        .expected = "one board at one place",
                        .next_step = "give one of the files only, that with the measured lengths"});
    }
  }
  for (std::size_t b = 0; b < file.boards.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      if (!file.boards[a].differsInLengthsFrom(file.boards[b])) continue;
      notes.push_back(
          fmt::format("{} and {} differ in lengths alone; if they are one board, give it the measured "
                      "lengths in all files: distances now have two scales",
                      file.boards[a].spec(), file.boards[b].spec()));
      if (!is_quiet) printMessage("warning: " + notes.back());
    }
  }
}

GivenViews readCorners(const BoardInputs& inputs, const CommonOptions& options) {
  if (inputs.areFlipped()) {
    throw flagError("--mirrored image", "the corners file " + inputs.inputs.front(), "images",
                    "run alidade detect --mirrored image on the images, and give its corners file");
  }
  const auto other = std::ranges::find_if_not(inputs.inputs, isCornersFile);
  if (other != inputs.inputs.end()) {
    throw flagError(*other, "an input that is no corners file, beside " + inputs.inputs.front(),
                    "corners files alone, or images alone",
                    "write the corners of the images with alidade detect first");
  }
  const bool is_vnl = isVnlFile(inputs.inputs.front());
  const auto mixed = std::ranges::find(inputs.inputs, !is_vnl, isVnlFile);
  if (mixed != inputs.inputs.end()) {
    throw flagError(*mixed, "a corners file of another format than " + inputs.inputs.front(),
                    "only .csv files, or only .vnl files");
  }
  CornersFile file = is_vnl ? readVnl(inputs, options) : readCornersFiles(inputs.inputs);
  const std::vector<Board> asked = mapped(inputs.boards, readBoard);
  const auto isAsked = [&](const Board& board) { return std::ranges::find(asked, board) != asked.end(); };
  const bool are_same = asked.size() == file.boards.size() && std::ranges::all_of(file.boards, isAsked);
  if (!asked.empty() && !are_same) {
    throw inputError({.where = inputs.inputs.front(),
                      .found = "board " + specsText(file.boards),
                      .expected = specsText(asked) + " from --board",
                      .next_step = "remove --board: the corners file states its board"});
  }
  GivenViews given;
  checkLengths(file, options.quiet, given.notes);
  given.boards = std::move(file.boards);
  std::set<std::string> images;
  for (const View& view : file.views) images.insert(view.image);
  given.num_images = given.num_found = images.size();
  const std::vector<ImageSize> sizes = mapped(file.views, &View::size);
  const SizeGroups groups = groupBySize(sizes);
  for (const std::size_t i : groups.others) {
    given.reasons.push_back(fmt::format("{}: other_size: {}, while most images are {}", file.views[i].image,
                                        sizeText(sizes[i]), sizeText(groups.size)));
  }
  for (const std::size_t i : groups.in_group) given.views.push_back(std::move(file.views[i]));
  return given;
}

// Opens all input images; a terminal shows progress while videos are read.
ImageSet openInputs(const BoardInputs& inputs, const CommonOptions& options, const ContentCache* cache) {
  ProgressBar bar("choosing frames", options.quiet);
  ImageSet images = openImages(inputs.inputs, {.num_frames = inputs.num_frames,
                                               .even_from = inputs.even_from,
                                               .num_jobs = options.jobs,
                                               .progress = bar.reporter(),
                                               .cancel = options.cancel,
                                               .cache = cache});
  return inputs.areFlipped() ? images.mirrored() : images;
}

// The results of one survey per board.
GivenViews foundIn(std::vector<BoardSurvey> surveys) {
  GivenViews given;
  for (const BoardSurvey& survey : surveys) {
    std::vector<View> views = survey.views();
    std::ranges::move(views, std::back_inserter(given.views));
    const std::string measures = measuresText(survey);
    if (!measures.empty())
      given.measures.push_back(surveys.size() == 1 ? measures : survey.board.spec() + ": " + measures);
  }
  const std::vector<ImageOutcome>& outcomes = surveys.front().outcomes;
  given.images = mapped(outcomes, &ImageOutcome::image);
  given.paths = surveys.front().paths;
  given.num_images = outcomes.size();
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const auto isFound = [i](const BoardSurvey& survey) { return survey.outcomes[i].detection.hasCorners(); };
    given.num_found += std::ranges::any_of(surveys, isFound) ? 1 : 0;
  }
  given.reasons = reasonLines(surveys);
  given.surveys = std::move(surveys);
  return given;
}

// A guess of the board; errors in the inputs are reported once there is a board.
std::string boardOfInputs(const BoardInputs& inputs, const CommonOptions& options) {
  try {
    return guessedBoard(openInputs(inputs, options, nullptr), options.cancel);
  } catch (const Error&) {
    return {};
  }
}

}  // namespace

GivenViews runDetection(const BoardInputs& inputs, const CommonOptions& options) {
  if (inputs.boards.empty()) {
    throw flagError(options.command, "no --board", "for example --board checkerboard:9x6:25mm",
                    boardOfInputs(inputs, options));
  }
  const std::vector<Board> boards = mapped(inputs.boards, readBoard);
  requireDistinguishable(boards);  // before reading any image
  std::optional<ContentCache> cache;
  if (!inputs.cache.empty()) cache.emplace(inputs.cache);
  DetectImagesOptions detect_options;
  detect_options.num_jobs = options.jobs;
  detect_options.cancel = options.cancel;
  detect_options.cache = cache ? &*cache : nullptr;
  const ImageSet images = openInputs(inputs, options, detect_options.cache);
  std::map<std::string, std::string> debug_paths;
  std::mutex mutex;
  std::string debug_complaint;  // failing to write a drawing must not lose the corners
  if (!inputs.debug_folder.empty()) {
    const std::vector<std::string> paths = images.names();
    prepareDebugFolder(inputs.debug_folder, paths);
    debug_paths = debugPaths(inputs.debug_folder, paths, shortNames(paths));
    detect_options.inspect = [&](const GrayImage& image, std::span<const ImageOutcome> outcomes) {
      try {
        writeImage(debug_paths.at(outcomes.front().image), drawDetections(image, outcomes, boards));
      } catch (const Error& error) {
        const std::lock_guard lock(mutex);
        debug_complaint = oneLine(error.what());
      }
    };
  }
  // Images with cached corners are not decoded here, except those of views, for the page.
  if (inputs.pictures != nullptr && !cache) {
    inputs.pictures->expectImages(images.size());
    detect_options.inspect = [pictures = inputs.pictures, drawn = detect_options.inspect](
                                 const GrayImage& image, std::span<const ImageOutcome> outcomes) {
      if (drawn) drawn(image, outcomes);
      Eigen::AlignedBox2d box;
      for (const ImageOutcome& outcome : outcomes)
        for (const Corner& corner : outcome.detection.corners) box.extend(corner.pixel);
      if (!box.isEmpty()) pictures->add(outcomes.front().image, image, box.volume());
    };
  }
  GivenViews given;
  {
    ProgressBar bar("detecting boards", options.quiet);
    detect_options.progress = bar.reporter();
    given = foundIn(surveyImages(images, boards, detect_options));
  }
  given.boards = boards;
  given.notes = images.notes();
  if (inputs.areFlipped())
    given.notes.push_back(
        "the images were flipped left to right; all results are those of the flipped images, and other "
        "commands need them flipped, too");
  given.image_set = images;
  for (const BoardSurvey& survey : given.surveys) {
    for (const Diagnosis& note : survey.notes) given.notes.push_back(note.message());
  }
  if (!debug_complaint.empty())
    given.notes.push_back("some debug images could not be written: " + debug_complaint);
  // Not part of the notes, which corners files store and which must not depend on the cache.
  if (cache && !options.quiet) {
    for (const std::string& complaint : cache->complaints()) printMessage("note: " + oneLine(complaint));
  }
  return given;
}

void requireBoards(const GivenViews& found, const BoardInputs& given, const CommonOptions& options) {
  const std::vector<BoardSurvey>& surveys = found.surveys;
  if (found.num_found > 0) {
    for (const BoardSurvey& survey : surveys) {
      if (!options.quiet && survey.numFound() == 0)
        printMessage("warning: no image shows the board " + survey.board.spec());
    }
    return;
  }
  if (!options.quiet && found.num_images > 1) printListed(found.reasons);
  const std::vector<std::string>& paths = found.paths;
  std::map<DetectionReason, int> counts;
  for (const BoardSurvey& survey : surveys) {
    for (const ImageOutcome& outcome : survey.outcomes) ++counts[outcome.detection.reason];
  }
  if (counts.contains(DetectionReason::kUnreadable) && counts.size() == 1) {
    const std::string& why = surveys.front().outcomes.front().detection.detail;
    if (paths.size() == 1) throw inputError({.found = why});
    throw noneUsableError(paths.size(), "none of them can be read", why);
  }
  std::vector<std::string> reasons;
  for (const auto& [reason, count] : counts)
    reasons.push_back(fmt::format("{} {}", count, reasonCode(reason)));
  std::optional<BoardHint> hint;
  const BoardSurvey* hinted = nullptr;
  for (auto survey = surveys.begin(); survey != surveys.end() && !hint; ++survey) {
    hint = diagnoseBoard(survey->outcomes, survey->board, found.boards);
    hinted = &*survey;
  }
  const bool has_markers =
      std::ranges::any_of(found.boards, [](const Board& board) { return board.markers().has_value(); });
  const std::string guess = !hint && has_markers && found.image_set
                                ? guessedBoard(*found.image_set, options.cancel)
                                : std::string();
  throw inputError(
      {.where = paths.size() == 1 ? paths.front() : fmt::format("{} images", paths.size()),
       .found = fmt::format("no board ({})", join(reasons, ", ")),
       .expected = join(mapped(found.boards,
                               [](const Board& board) {
                                 return fmt::format("{} ({}, columns x rows)", board.spec(),
                                                    board.countsText());
                               }),
                        " or "),
       .next_step = hint ? hintText(*hint, hinted->board)
                    : !guess.empty()
                        ? guess
                        : "check that the board is in the image, is sharp and has a white margin; " +
                              std::string(given.has_debug_flag ? "" : "alidade detect ") +
                              "--debug FOLDER saves copies of the images with the detections drawn in"});
}

std::string boardsHelp() {
  std::string text =
      "A board SPEC is KIND:COLUMNSxROWS:LENGTH and so on. Lengths have a unit (25mm, 2.5cm, 0.025m, 1in); a bare\n"
      "number is metres. A YAML file may state the same with the keys kind, columns, rows and those of the lengths.\n";
  for (const BoardKindName& kind : boardKinds())
    text += fmt::format("\n{}\n  also read: {}\n", kind.example, kind.aliases);
  return text +
         "\nalidade board SPEC -o board.pdf draws it to print. OpenCV, ROS and Kalibr count checkerboards like this; MATLAB\ncounts their squares, one more in each direction. docs/boards.md has more.\n";
}

void BoardInputs::addBoards(Flags& flags) {
  Values board = kSpec;
  board.is_single = true;  // a word after a SPEC is an input
  board.complaint = [](const std::string& source) -> std::string {
    try {
      (void)readBoard(source);
    } catch (const Error& e) {
      if (e.code() == ErrorCode::kUsage) return e.what();  // an error in a board file is not a usage error
    }
    return {};
  };
  flags.under(kBoardGroup);
  flags.add("--board", &boards, std::string(kBoardText) + ". Repeat it for several boards", board);
  flags.redirect({"--square", "--square-size", "--square_size", "--pattern", "--target"},
                 "--board checkerboard:9x6:25mm (inner corners, side of a square); see alidade help boards");
  flags.under(nullptr);
}

void BoardInputs::addDetection(Flags& flags, bool has_debug) {
  flags.under(kBoardGroup);
  // The default is not an effective setting, because it means nothing for photographs.
  flags.add(
      "--frames", &num_frames,
      fmt::format("How many frames of each video or image sequence to search for boards: {} (default: {})",
                  even_from ? "of videos, 6 to 12 a second" : "sharp ones that differ from each other",
                  num_frames),
      {.complaint = [](const std::string& text) { return wholeComplaint(text, 1, 10000); }});
  flags.add("--cache", &cache,
            "Folder for the results of detection. Images that it knows are not searched again",
            aside(kFolder));
  has_debug_flag = has_debug;
  if (has_debug) {
    flags.add("--debug", &debug_folder,
              "Folder for copies of the images with the corners, their ids and the board's axes drawn in",
              kFolder);
  }
  flags.under(nullptr);
}

void BoardInputs::addMirrored(Flags& flags) {
  flags.under(kBoardGroup);
  flags.add("--mirrored", &mirrored, kMirroredText, oneOf({"image"}));
  flags.under(nullptr);
}

void BoardInputs::checkDebugFolder(const std::string& output) const {
  const auto normal = [](const std::string& path) {
    std::error_code ignored;
    const std::filesystem::path whole = std::filesystem::absolute(path, ignored).lexically_normal();
    return whole.has_filename() ? whole : whole.parent_path();
  };
  if (debug_folder.empty() || output.empty() || normal(debug_folder) != normal(output)) return;
  throw flagError("--debug " + debug_folder, "this is also the output", "a different folder");
}

std::string measuresText(const BoardSurvey& survey) {
  const auto range = [&](const auto& measure) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const ImageOutcome& outcome : survey.outcomes) {
      if (!outcome.detection.hasCorners()) continue;
      low = std::min(low, measure(outcome.detection.measures));
      high = std::max(high, measure(outcome.detection.measures));
    }
    return fmt::format("{:.3g} to {:.3g}", low, high);
  };
  if (survey.numFound() == 0) return {};
  return fmt::format("edge blur {} px, spacing {} px, tilt {} degrees, board area {} % of the image",
                     range([](const ViewMeasures& m) { return m.blur_px; }),
                     range([](const ViewMeasures& m) { return m.spacing_px; }),
                     range([](const ViewMeasures& m) { return m.tilt_deg; }),
                     range([](const ViewMeasures& m) { return 100 * m.area_share; }));
}

void explainMirrors(const std::string& mirrored, const std::string& camera,
                    std::vector<Diagnosis>& diagnoses) {
  for (Diagnosis& diagnosis : diagnoses) {
    const bool is_asked =
        diagnosis.id == DiagnosisId("mirrored_view") && diagnosis.severity != Severity::kNote;
    if (!is_asked || !diagnosis.cause.starts_with(camera)) continue;
    if (mirrored == "back") diagnosis.severity = Severity::kNote;
    if (mirrored == "image") {
      diagnosis.evidence = "they are, after the images were flipped";
      diagnosis.next_step = "leave out --mirrored image";
    }
  }
}

bool isCornersFile(const std::string& path) {
  return path.ends_with(".csv") || path.ends_with(".CSV") || isVnlFile(path);
}

GivenViews readViews(const BoardInputs& inputs, const CommonOptions& options) {
  if (isCornersFile(inputs.inputs.front())) return readCorners(inputs, options);
  GivenViews given = runDetection(inputs, options);
  requireBoards(given, inputs, options);
  return given;
}

PictureSource picturesOf(const std::vector<std::string>& names, const std::optional<ImageSet>& set,
                         const PassingPictures* passing) {
  if (!set) return {};
  std::map<std::string, std::size_t> index_of;
  for (std::size_t i = 0; i < names.size(); ++i) index_of[validUtf8(names[i])] = i;
  PictureSource source;
  source.image_of = [=](const std::string& name) -> std::optional<GrayImage> {
    const auto found = index_of.find(name);
    if (found == index_of.end()) return std::nullopt;
    if (passing != nullptr) {
      if (std::optional<GrayImage> kept = passing->imageOf(set->name(found->second))) return kept;
    }
    try {
      return set->read(found->second).decode().image;
    } catch (const Error&) {
      return std::nullopt;  // the page shows the corners instead
    }
  };
  if (passing == nullptr) return source;
  source.picture_of = [=](const std::string& name) {
    const auto found = index_of.find(name);
    return found == index_of.end() ? std::nullopt : passing->pictureOf(set->name(found->second));
  };
  return source;
}

void addPupilFlag(Flags& flags, std::string& value) {
  flags.add(
      "--pupil", &value,
      "How many numbers describe how the entrance pupil of a wide lens moves with the angle; auto: as many "
      "as the views show",
      oneOf({"auto", "0", "1", "2"}));
}

std::optional<std::size_t> pupilNumbers(const std::string& value) {
  if (value == "auto") return std::nullopt;
  return static_cast<std::size_t>(value.front() - '0');
}

std::optional<std::array<int, 2>> correctionCells(const std::string& value) {
  if (value == "auto") return std::nullopt;
  if (value == "none") return std::array{0, 0};
  const auto cells = parseSize(value);
  if (!cells || std::max(cells->width, cells->height) > kMaxCorrectionCells) {
    throw flagError(
        "--correction", value,
        fmt::format("auto, none or COLUMNSxROWS with 1 to {} cells each, such as 8x6", kMaxCorrectionCells));
  }
  return std::array{cells->width, cells->height};
}

}  // namespace alidade
