// SPDX-License-Identifier: MIT
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/rig_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/imagery/rectification.h"
#include "alidade/report/data/json_output.h"
#include "alidade/rig/rig_frames.h"
#include "alidade/rig/rig_start.h"
#include "command.h"
#include "commands/images/remapped_images.h"
#include "commands/rig/rectified_pair.h"
#include "commands/rig/rig_inputs.h"
#include "console.h"
#include "pending_folder.h"
#include "view_options.h"

namespace alidade {
namespace {

constexpr const char* kRigName = "rig.yaml";
constexpr const char* kRectificationName = "rectification.yaml";

// A camera of the pair, its images and their results.
struct Side {
  MountedCamera camera;
  std::vector<RemappedImage> images = {};
  double dark_share = 0;  // share of the rectified pixels without a source

  [[nodiscard]] std::size_t numWritten() const { return images.size() - numSkipped(images); }
};

// The corners of one board that both cameras saw at the same time, in the first and the second camera.
using SharedBoard = std::pair<const View*, const View*>;

std::vector<SharedBoard> sharedBoards(const std::vector<RigViews>& cameras, const FrameTable& table) {
  const RigFrames frames = table.empty() ? matchFrames(cameras) : framesOf(table, cameras);
  std::map<std::pair<std::size_t, std::size_t>, const View*> seen;  // by frame and board
  for (std::size_t i = 0; i < cameras[0].views.size(); ++i) {
    const View& view = cameras[0].views[i];
    seen[{frames.frame_of[0][i], view.board}] = &view;
  }
  std::vector<SharedBoard> shared;
  for (std::size_t i = 0; i < cameras[1].views.size(); ++i) {
    const View& view = cameras[1].views[i];
    const auto at = seen.find({frames.frame_of[1][i], view.board});
    if (at != seen.end()) shared.emplace_back(at->second, &view);
  }
  return shared;
}

// Pixels of the same corners, with the second view's numbering turned by a symmetry of the board.
std::vector<EpipolarPair> pairsOf(const SharedBoard& board, const BoardTurn& turn) {
  std::map<int, Eigen::Vector2d> first;
  for (const Corner& corner : board.first->corners) first[corner.id] = corner.pixel;
  std::vector<EpipolarPair> pairs;
  for (const Corner& corner : board.second->corners) {
    const auto at = first.find(turn.id_of.at(static_cast<std::size_t>(corner.id)));
    if (at != first.end()) pairs.push_back({at->second, corner.pixel});
  }
  return pairs;
}

// The number of boards that both cameras saw, and the errors of their corners.
using MeasuredErrors = std::pair<std::size_t, EpipolarErrors>;

// The cameras may number a board that looks the same after a turn differently. The numbering with the
// smallest errors is right; others are off by whole squares.
MeasuredErrors measured(const Rectification& r, const std::vector<Side>& sides, const RigInputViews& given) {
  std::size_t num_boards = 0;
  std::vector<EpipolarPair> all;
  const auto turns = mapped(given.boards, boardTurns);
  for (const SharedBoard& shared : sharedBoards(given.cameras, given.frames)) {
    std::vector<EpipolarPair> best;
    double least = std::numeric_limits<double>::infinity();
    for (const BoardTurn& turn : turns.at(shared.first->board)) {
      std::vector<EpipolarPair> pairs = pairsOf(shared, turn);
      const EpipolarErrors errors = epipolarErrors(r, sides[0].camera, sides[1].camera, pairs);
      if (errors.num_pairs == 0 || errors.curve_rms_px >= least) continue;
      least = errors.curve_rms_px;
      best = std::move(pairs);
    }
    all.insert(all.end(), best.begin(), best.end());
    num_boards += best.empty() ? 0 : 1;
  }
  return {num_boards, epipolarErrors(r, sides[0].camera, sides[1].camera, all)};
}

json matrixJson(const Eigen::MatrixXd& matrix) {
  return rowsJson(static_cast<int>(matrix.cols()), static_cast<int>(matrix.rows()), [&](std::size_t i) {
    const auto at = static_cast<Eigen::Index>(i);
    return matrix(at / matrix.cols(), at % matrix.cols());
  });
}

class RigRectifyCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade rig rectify rig.yaml left/ right/ -o rectified\nExample: alidade rig rectify "
        "rig.yaml --camera-only --maps -o rectified --overwrite\nWrites one folder of images per camera, "
        "rig.yaml with the rectified pinhole cameras, and rectification.yaml with\nR1, R2, P1, P2 and Q for "
        "cv::FileStorage. A point has the same row in both images. If the cameras are one above\nthe other, "
        "it has the same column. Around the baseline, cylindrical and equirectangular views show more "
        "than\nhalf of all directions. Corners files in place of the folders only measure the errors of the "
        "rows.");
    flags.add("rig", &rig_path_, "Rig file, or another file with several cameras and their poses", kFilePath);
    flags.add(
        "input", &views_.inputs,
        "For the first and the second camera: a folder of images, a pattern in quotes, or a corners file "
        "(.csv)",
        kFilePath);
    flags.add("-o,--output", &output_, "Folder to create", kFolder);
    flags.add("--cameras", &names_,
              "Names of the two cameras, separated by a comma. Default: those of a rig of two",
              {.separator = ','});
    view_.addOptions(flags, ", with the baseline as its axis", "image size of the first camera");
    flags.addSwitch("--own-centres", has_own_centres_,
                    "Centre each view on its own camera, for cameras that look towards each other; infinity "
                    "then has a disparity");
    views_.addBoards(flags);
    views_.addMatch(flags);
    views_.addDetection(flags, false);
    flags.add("--tolerance", &tolerance_, "RMS difference of rows that you accept", kPixelText);
    flags.addSwitch("--maps", has_maps_, "Write the tables for cv::remap() as TIFF files of 32-bit floats");
    flags.addSwitch("--camera-only", camera_only_, "Write no images; do not read inputs");
    flags.addCommon(common_, true);
  }

  int run(const Flags& flags) override {
    checkUsage(flags);
    common_.cancel = catchInterrupts();
    const RigRecord record = loadRig(rig_path_);
    tellIfRejected(record, rig_path_, common_.quiet);
    const AnyRig rig = rigOf(record);
    const auto [first, second] = chosenCameras(rig);
    if (!camera_only_) views_.sortLike({rig.camera(first).name, rig.camera(second).name}, common_);
    r_ = rectify(rig, first, second, request(flags));
    sides_ = {Side{rig.camera(first)}, Side{rig.camera(second)}};
    listImages();
    if (hasBoards()) errors_ = measure();
    if (!output_.empty()) write(record);
    print();
    const bool is_incomplete = reportSkipped(sides_[0].images);
    return reportSkipped(sides_[1].images) || is_incomplete ? static_cast<int>(ErrorCode::kInput) : 0;
  }

 private:
  [[nodiscard]] bool hasCornersFiles() const {
    return !camera_only_ && !views_.inputs.empty() && isCornersFile(views_.inputs.front());
  }
  // True if errors can be measured.
  [[nodiscard]] bool hasBoards() const { return hasCornersFiles() || !views_.boards.empty(); }

  void checkUsage(const Flags& flags) const {
    if (rig_path_.empty()) throw missing("no rig file", "a rig file and two folders of images");
    if (views_.inputs.size() != 2 && !camera_only_) {
      throw missing(fmt::format("{} inputs", views_.inputs.size()),
                    "two, for the first and the second camera, or --camera-only");
    }
    if (!camera_only_ && isCornersFile(views_.inputs[0]) != isCornersFile(views_.inputs[1]))
      throw misuse("a corners file beside images", "two corners files or two folders of images");
    if (output_.empty() && !hasCornersFiles()) throw missing("no --output", "-o FOLDER");
    if (camera_only_ && !views_.boards.empty())
      throw misuse("--board with --camera-only", "one of them: boards are searched for in images");
    if (!views_.match.empty() && !hasBoards()) {
      throw flagError("--match", "neither --board nor corners files",
                      "one of them: only corners are compared between images");
    }
    view_.checkUsage(flags);
  }

  [[nodiscard]] std::pair<std::size_t, std::size_t> chosenCameras(const AnyRig& rig) const {
    const std::vector<std::string> known = mapped(rig.cameras(), &MountedCamera::name);
    if (names_.empty() && rig.size() == 2) return {0, 1};
    if (names_.size() == 2) return {rig.index(names_[0]), rig.index(names_[1])};
    const auto count = names_.empty() ? rig.size() : names_.size();
    throw flagError(names_.empty() ? rig_path_ : "--cameras", fmt::format("{} cameras", count),
                    "two, given as --cameras FIRST,SECOND", "the rig has " + join(known, ", "));
  }

  [[nodiscard]] ViewRequest request(const Flags& flags) const {
    ViewRequest request = view_.request(flags);
    request.has_own_centres = has_own_centres_;
    return request;
  }

  // Lists the images; refuses an output that is among them.
  void listImages() {
    std::vector<std::string> sources = {cameraFilePath(rig_path_), common_.config, views_.match};
    for (std::size_t i = 0; i < 2 && !camera_only_ && !hasCornersFiles(); ++i) {
      const std::vector<std::string> paths = alidade::listImages(std::span(&views_.inputs[i], 1));
      append(sources, paths);
      sides_[i].images = namedImages(paths);
    }
    if (hasCornersFiles()) append(sources, views_.inputs);
    if (!output_.empty()) refuseFolderOfInputs(output_, sources);
  }

  MeasuredErrors measure() const {
    const RigInputViews given = readRigViews(views_, {sides_[0].camera.name, sides_[1].camera.name}, common_);
    for (std::size_t i = 0; i < 2; ++i) {
      const std::vector<View>& views = given.cameras[i].views;
      const MountedCamera& camera = sides_[i].camera;
      if (views.empty() || views.front().size == camera.image_size) continue;
      throw inputError(
          {.where = views_.inputs[i],
           .found = "images of " + sizeText(views.front().size) + " pixels",
           .expected = sizeText(camera.image_size) + ", the image size of camera '" + camera.name + "'"});
    }
    return measured(r_, sides_, given);
  }

  void write(const RigRecord& record) {
    PendingFolder folder(output_, common_.command, view_.may_overwrite, common_.quiet);
    for (std::size_t i = 0; i < 2; ++i) {
      Side& side = sides_[i];
      const std::string name = fileNameOf(side.camera.name);
      const RemapTable table = makeRemapTable(r_, i, side.camera, common_.jobs, common_.cancel);
      side.dark_share = darkShare(table);
      if (has_maps_) {
        folder.write([&] {
          writeRemapTable(table, folder.path(name + "_map_x.tiff"), folder.path(name + "_map_y.tiff"));
        });
      }
      if (side.images.empty()) continue;
      folder.write([&] {
        folder.makeSubfolder(name);
        remapAll(side.images, table, folder,
                 {.label = "rectifying " + side.camera.name,
                  .subfolder = name,
                  .interpolation = view_.interpolationKind(),
                  .common = common_});
      });
      requireAnImage(side.images);
    }
    folder.write([&] {
      writeFileAtomically(folder.path(kRectificationName), rectificationFileText(r_));
      if (r_.projection == ViewProjection::kRectilinear)
        writeFileAtomically(folder.path(kRigName), rigFileText(rectifiedRecord(record)));
    });
    folder.commit();
  }

  // The rectified cameras, with the rig's statements about itself.
  RigRecord rectifiedRecord(const RigRecord& source) const {
    RigRecord record = source;
    record.cameras.clear();
    record.covariance.clear();
    record.created_by = maker();
    for (std::size_t i = 0; i < 2; ++i) {
      CameraRecord camera = bareRecord(r_.pinhole(i), r_.size, record.created_by);
      camera.name.name = sides_[i].camera.name;
      SE3 camera_from_rig;
      if (i == 1) camera_from_rig.translation[r_.alongIndex()] = -r_.baseline_m;
      record.cameras.push_back({.camera = std::move(camera), .camera_from_rig = camera_from_rig});
    }
    return record;
  }

  void print() {
    const std::vector<std::string> warnings = this->warnings();
    answer(
        [&] {
          json document = wholeDocument();
          document["notes"] = notes();
          document["warnings"] = warnings;
          return jsonText(document);
        },
        [&] { return summary(); });
    if (common_.quiet) return;
    printNotes(notes());
    for (const std::string& warning : warnings) printMessage("warning: " + warning);
  }

  [[nodiscard]] std::vector<std::string> notes() const {
    const std::string& first = sides_[0].camera.name;
    const std::string& second = sides_[1].camera.name;
    std::vector<std::string> notes;
    if (r_.baseline_m < 0) {
      notes.push_back(fmt::format(
          "camera '{}' is {} '{}', so disparities are negative; --cameras {},{} makes them positive", first,
          r_.is_vertical ? "below" : "on the right of", second, second, first));
    }
    if (r_.is_vertical)
      notes.emplace_back(
          "the cameras are one above the other: a point has the same column in both images, not the same "
          "row");
    if (r_.cut_share > 0) {
      notes.push_back(fmt::format(
          "{:.2g} % of the input pixels are too far from the axis of the views and were cut off; {}",
          100 * r_.cut_share, "--projection equirectangular shows them all"));
    }
    const std::size_t num_second = sides_[1].images.size();
    if (sides_[0].images.size() != num_second && num_second > 0)
      notes.push_back(fmt::format("{} images for the first camera, {} for the second",
                                  sides_[0].images.size(), num_second));
    for (const Side& side : sides_) append(notes, orientationNotes(side.images));
    return notes;
  }

  [[nodiscard]] std::vector<std::string> warnings() const {
    const double tolerance_px = *parsePixels(tolerance_);
    if (!errors_) return {};
    if (errors_->second.num_pairs == 0) return {"no board was seen by both cameras at one time"};
    if (!(errors_->second.row_rms_px > tolerance_px)) return {};
    return {
        fmt::format("{} differ by RMS {:.3g} px, more than --tolerance {:g} px; check that the inputs are in "
                    "the order of the cameras, and that the cameras stand where the rig file says",
                    r_.is_vertical ? "columns" : "rows", errors_->second.row_rms_px, tolerance_px)};
  }

  [[nodiscard]] std::string summary() const {
    constexpr double kMillimetres = 1000;
    const char* row = r_.is_vertical ? "columns" : "rows";
    std::string text;
    if (!output_.empty()) {
      const Side& first = sides_[0];
      const Side& second = sides_[1];
      const std::string what =
          first.images.empty() ? "no images"
                               : fmt::format("{} of {} and {} of {} images", first.numWritten(),
                                             first.images.size(), second.numWritten(), second.images.size());
      text += fmt::format("{}: {}; {}, {} px, {:.2g} % and {:.2g} % of the pixels are black (no source)\n",
                          printable(output_), what, projectionName(r_.projection), sizeText(r_.size),
                          100 * first.dark_share, 100 * second.dark_share);
    }
    text += fmt::format("Baseline  {:.2f} mm, {}\n", r_.baseline_m * kMillimetres,
                        r_.is_vertical ? "vertical" : "horizontal");
    if (r_.projection == ViewProjection::kEquirectangular) {
      text += fmt::format("Views     {:.4g} px per degree; {} are planes through the baseline\n",
                          r_.scale_px / kDegPerRad, row);
    } else {
      const std::string offset = r_.disparityAtInfinity() == 0
                                     ? "disparity"
                                     : fmt::format("(disparity - {:.3f})", r_.disparityAtInfinity());
      text +=
          fmt::format("Views     focal length {:.2f} px; {} = {:.4f} m px / {}\n", r_.scale_px,
                      r_.projection == ViewProjection::kRectilinear ? "depth" : "distance from the baseline",
                      r_.scale_px * r_.baseline_m, offset);
    }
    if (errors_) {
      const auto& [num_boards, e] = *errors_;
      text += fmt::format(
          "Errors    {} corners of {} boards: RMS {:.3f} px from the epipolar curves before\n          {} "
          "differ by RMS {:.3f} px, mean {:.3f} px, at most {:.2f} px; {} corners in both views\n",
          e.num_pairs, num_boards, e.curve_rms_px, row, e.row_rms_px, e.row_mean_px, e.row_max_px,
          e.num_shown);
    }
    return text;
  }

  [[nodiscard]] json wholeDocument() const {
    const bool is_flat = r_.projection == ViewProjection::kRectilinear;
    json cameras = json::array();
    for (std::size_t i = 0; i < 2; ++i) {
      cameras.push_back(
          {{"name", sides_[i].camera.name},
           {"folder", fileNameOf(sides_[i].camera.name)},
           {"axis_pixel", vectorJson(r_.views[i].axis_px)},
           {"R", matrixJson(r_.views[i].rectified_from_camera.matrix())},
           {"P", is_flat ? matrixJson(r_.projectionMatrix(i)) : json(nullptr)},
           {"share_without_source", output_.empty() ? json(nullptr) : json(sides_[i].dark_share)},
           {"images", imagesJson(sides_[i].images)}});
    }
    json epipolar = nullptr;
    if (errors_) {
      const auto& [num_boards, e] = *errors_;
      epipolar = {{"num_boards", num_boards},  {"num_corners", e.num_pairs}, {"curve_rms_px", e.curve_rms_px},
                  {"num_shown", e.num_shown},  {"row_rms_px", e.row_rms_px}, {"row_mean_px", e.row_mean_px},
                  {"row_max_px", e.row_max_px}};
    }
    return {{"folder", output_.empty() ? json(nullptr) : json(output_)},
            {"projection", projectionName(r_.projection)},
            {"direction", r_.is_vertical ? "vertical" : "horizontal"},
            {"image_size", r_.size},
            {"scale_px", r_.scale_px},
            {"baseline_m", r_.baseline_m},
            {"disparity_at_infinity_px", r_.disparityAtInfinity()},
            {"Q", is_flat ? matrixJson(r_.disparityToDepth()) : json(nullptr)},
            {"share_cut", r_.cut_share},
            {"cameras", std::move(cameras)},
            {"epipolar_errors", std::move(epipolar)}};
  }

  std::string rig_path_;
  RigInputs views_;
  std::string output_;
  std::vector<std::string> names_;
  std::string tolerance_ = "1px";
  ViewOptions view_;
  bool has_own_centres_ = false;
  bool has_maps_ = false;
  bool camera_only_ = false;
  Rectification r_;
  std::vector<Side> sides_;  // two
  std::optional<MeasuredErrors> errors_;
};

}  // namespace

const CommandEntry kRigRectifyCommand = {
    "rig rectify", "Rectify the images of two cameras, so that a point has one row in both",
    made<RigRectifyCommand>};

}  // namespace alidade
