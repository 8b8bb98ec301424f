// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>

#include <CLI/CLI.hpp>

#include "alidade/camera/batch.h"
#include "alidade/core/error.h"
#include "alidade/files/pose_list.h"
#include "console.h"
#include "options.h"
#include "row_streams.h"

// The commands project and unproject.

namespace alidade {
namespace {

const std::array<std::string_view, 4> kStatusNames = {statusId(ProjectStatus::kOk), "out_of_image",
                                                      statusId(ProjectStatus::kBehind),
                                                      statusId(ProjectStatus::kOutsideDomain)};

// Rows of up to three numbers as one array a column, for the batch functions; memory is kept between blocks.
class Columns {
 public:
  void resize(std::size_t count) {
    for (auto& column : columns_) column.resize(count);
  }
  void assign(std::span<const Eigen::Vector3d> rows) {
    resize(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) columns_[c][i] = rows[i][static_cast<Eigen::Index>(c)];
    }
  }
  [[nodiscard]] std::vector<double>& operator[](std::size_t c) { return columns_[c]; }
  [[nodiscard]] Eigen::Vector3d row(std::size_t i) const {
    return {columns_[0][i], columns_[1][i], columns_[2][i]};
  }

 private:
  std::array<std::vector<double>, 3> columns_;
};

// What project and unproject share: a camera file, rows in, rows out, counts by status at the end.
class StreamCommand : public Command {
 public:
  int run(const CLI::App& app) final {
    if (camera_path_.empty()) throw missingError(app.get_name(), "no camera file", "a camera file");
    const CameraRecord file = readCameraTelling(camera_path_, camera_.readOptions(), common_.quiet);
    prepare(file);
    AnswerWriter& out = out_.emplace(format(file));
    // Whoever writes the points may wait for these rows before writing more. A header alone is no answer.
    PointReader reader(points_path_, columns_, [&] {
      if (out.hasRows()) out.flush();
    });
    out.begin();
    std::vector<Eigen::Vector3d> rows;
    while (reader.next(rows)) take(file, rows, out);
    finish(file, out);
    out.end();
    if (!common_.quiet) printMessage(countsText());
    return 0;
  }
  // What was written but has not gone out is dropped by an error, which is the document then.
  [[nodiscard]] bool owesJson() const final { return common_.json && !(out_ && out_->hasSent()); }

 protected:
  // What becomes of a row, in the order of the counts.
  enum class Status { kOk, kOutOfImage, kBehind, kOutside };

  // The options of both; `points` describes the input, which has these columns.
  void setUpStream(CLI::App& app, const char* points, std::vector<detail::TableColumn> columns) {
    columns_ = std::move(columns);
    app.add_option("camera", camera_path_, "Camera file of any format (docs/formats.md)");
    app.add_option("points", points_path_, points);
    addCameraOptions(app, camera_);
    addCommonOptions(app, common_, false);
  }

  // Reads what the command needs beside the camera.
  virtual void prepare(const CameraRecord&) {}
  [[nodiscard]] virtual AnswerWriter::Format format(const CameraRecord& file) const = 0;
  // Answers a block of rows, or keeps it until finish().
  virtual void take(const CameraRecord& file, const std::vector<Eigen::Vector3d>& rows,
                    AnswerWriter& out) = 0;
  virtual void finish(const CameraRecord&, AnswerWriter&) {}

  // Writes one row and counts it.
  void answer(std::span<const double> values, Status status, std::span<const double> details,
              AnswerWriter& out) {
    const auto index = static_cast<std::size_t>(status);
    ++counts_[index];
    out.row(values, kStatusNames[index], details);
  }

  [[nodiscard]] static Status statusOf(ProjectStatus status, const Eigen::Vector2d& pixel, ImageSize size) {
    if (status == ProjectStatus::kBehind) return Status::kBehind;
    if (status == ProjectStatus::kOutsideDomain) return Status::kOutside;
    const bool is_in_image = pixel.x() >= -0.5 && pixel.x() < size.width - 0.5 && pixel.y() >= -0.5 &&
                             pixel.y() < size.height - 0.5;
    return is_in_image ? Status::kOk : Status::kOutOfImage;
  }

  // Whether a row with this status has a pixel or a ray.
  [[nodiscard]] bool hasNumbers(Status status) const {
    return status == Status::kOk || (status == Status::kOutOfImage && !is_clipped_);
  }

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  bool is_clipped_ = false;
  bool has_jacobian_ = false;

 private:
  [[nodiscard]] std::string countsText() const {
    std::string text;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      if (counts_[i] == 0) continue;
      text += (text.empty() ? "" : ", ") + std::to_string(counts_[i]) + " " + std::string(kStatusNames[i]);
    }
    return text.empty() ? "no points" : text;
  }

  std::vector<detail::TableColumn> columns_;
  std::optional<AnswerWriter> out_;
  std::string camera_path_;
  CameraOptions camera_;
  std::string points_path_;
  std::array<std::size_t, kStatusNames.size()> counts_{};
};

class ProjectCommand final : public StreamCommand {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: echo 0.1,-0.05,1.0 | alidade project camera.yaml\nExample: alidade project camera.yaml "
        "points.csv --pose '{rotation_vector_rad: [0, 0.1, 0], translation_m: [0, 0, 2]}'\nExample: alidade "
        "project camera.yaml points.csv --poses trajectory.txt\nOutput: u,v,status. The status is ok "
        "(a pixel of the image), out_of_image (a pixel outside the image),\nbehind or outside (no pixel; u "
        "and v are nan).\nPixel (0, 0) is the centre of "
        "the top-left pixel. With --poses, the first column is the id of the pose.\n--poses reads one of: a "
        "YAML list of poses; a TUM trajectory (timestamp tx ty tz qx qy qz qw, world_from_camera);\nor a "
        "table with a header that names tx,ty,tz, a rotation qx,qy,qz,qw or rx,ry,rz (rotation vector), and "
        "optionally id\nor timestamp.\nPoints are processed as they arrive, in constant memory. With --poses "
        "all points are kept in memory, at 24 bytes each.\n--jacobian appends the derivatives of u, then "
        "those of v: "
        "du_dx,du_dy,du_dz with respect to the point as given,\ndu_dtx,du_dty,du_dtz,du_drx,du_dry,du_drz "
        "with respect to the pose, camera_from_points * Exp([t, r]) at t = r = 0\n(metres, radians), and "
        "du_dfx and so on with respect to the camera parameters.");
    setUpStream(app,
                "Rows x,y,z in metres, separated by commas or blanks, header optional; standard input if "
                "omitted or -",
                {{"x", "m"}, {"y", "m"}, {"z", "m"}});
    app.add_option("--pose", pose_,
                   "Pose camera_from_points: a YAML file, or YAML text in braces. Default: identity");
    app.add_option("--poses", poses_path_, "File of poses; all points are projected for each pose");
    app.add_option(
           "--poses-are", direction_,
           "Direction of the poses if their file does not state it: camera_from_world or world_from_camera")
        ->check(CLI::IsMember({"camera_from_world", "world_from_camera"}));
    app.add_flag("--jacobian", has_jacobian_, "Append the derivatives of the pixel");
    app.add_flag("--clip", is_clipped_, "Leave out the numbers of pixels outside the image");
  }

 private:
  void prepare(const CameraRecord& file) override {
    if (!pose_.empty() && !poses_path_.empty()) {
      throw usageError({.where = "project",
                        .found = "both --pose and --poses",
                        .expected = "one of them",
                        .next_step = "remove one; --poses also accepts a file with one pose"});
    }
    if (!direction_.empty() && poses_path_.empty()) {
      throw usageError({.where = "project",
                        .found = "--poses-are without --poses",
                        .expected = "--poses FILE",
                        .next_step = "a --pose states its direction by a key such as world_from_camera"});
    }
    if (!pose_.empty()) camera_from_points_ = readPoseSource(pose_);
    if (!poses_path_.empty()) {
      std::optional<PoseDirection> direction;
      if (!direction_.empty())
        direction = direction_ == "camera_from_world" ? PoseDirection::kCameraFromWorld
                                                      : PoseDirection::kWorldFromCamera;
      list_ = readPoseList(poses_path_, direction);
      if (list_.is_assumed_tum && !common_.quiet) {
        printMessage("note: " + poses_path_ +
                     " is read as a TUM trajectory (timestamp tx ty tz qx qy qz qw, world_from_camera)");
      }
    }
    if (has_jacobian_) jacobian_.resize(2 * (9 + file.camera.parameters().size()));
  }

  [[nodiscard]] AnswerWriter::Format format(const CameraRecord& file) const override {
    AnswerWriter::Format format{
        .is_json = common_.json, .has_pose = !list_.poses.empty(), .values = {"u", "v"}, .details = {}};
    if (!has_jacobian_) return format;
    std::vector<std::string> inputs = {"x", "y", "z", "tx", "ty", "tz", "rx", "ry", "rz"};
    for (const std::string_view name : file.camera.parameterNames()) inputs.emplace_back(name);
    for (const char* output : {"du_d", "dv_d"}) {
      for (const std::string& input : inputs) format.details.push_back(output + input);
    }
    return format;
  }

  void take(const CameraRecord& file, const std::vector<Eigen::Vector3d>& rows, AnswerWriter& out) override {
    if (list_.poses.empty()) return project(file, camera_from_points_, rows, out);
    kept_.insert(kept_.end(), rows.begin(), rows.end());
  }

  void finish(const CameraRecord& file, AnswerWriter& out) override {
    const std::span<const Eigen::Vector3d> all(kept_);
    for (const NamedPose& pose : list_.poses) {
      out.setPose(pose.id);
      for (std::size_t i = 0; i < all.size(); i += PointReader::kMaxRows)
        project(file, pose.camera_from_x, all.subspan(i, std::min(PointReader::kMaxRows, all.size() - i)),
                out);
    }
  }

  void project(const CameraRecord& file, const std::optional<SE3>& camera_from_points,
               std::span<const Eigen::Vector3d> rows, AnswerWriter& out) {
    points_.assign(rows);
    pixels_.resize(rows.size());
    statuses_.resize(rows.size());
    const PointColumns points{points_[0], points_[1], points_[2]};
    const PixelResults pixels{pixels_[0], pixels_[1], statuses_};
    if (has_jacobian_) {
      // First, as the pixels are to have the same digits with and without.
      by_point_.resize(6 * rows.size());
      by_pose_.resize(12 * rows.size());
      by_params_.resize(2 * file.camera.parameters().size() * rows.size());
      projectBatch(file.camera, camera_from_points.value_or(SE3()), points, pixels,
                   {by_point_.data(), by_pose_.data(), by_params_.data()});
    }
    if (camera_from_points) {
      projectBatch(file.camera, *camera_from_points, points, pixels);
    } else {
      projectBatch(file.camera, points, pixels);
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      Eigen::Vector2d pixel(pixels_[0][i], pixels_[1][i]);
      const Status status = statusOf(statuses_[i], pixel, file.image_size);
      const bool has_pixel = hasNumbers(status);
      if (!has_pixel) pixel.setConstant(kNone);
      if (has_jacobian_) gatherJacobian(i, has_pixel);
      answer({pixel.data(), 2}, status, jacobian_, out);
    }
  }

  // du by the point, the pose and the parameters, then dv.
  void gatherJacobian(std::size_t i, bool has_pixel) {
    if (!has_pixel) return std::fill(jacobian_.begin(), jacobian_.end(), kNone);
    const std::size_t num_inputs = jacobian_.size() / 2;
    const std::size_t num_params = num_inputs - 9;
    for (std::size_t r = 0; r < 2; ++r) {
      const auto to = jacobian_.begin() + static_cast<std::ptrdiff_t>(r * num_inputs);
      std::copy_n(by_point_.data() + 6 * i + 3 * r, 3, to);
      std::copy_n(by_pose_.data() + 12 * i + 6 * r, 6, to + 3);
      std::copy_n(by_params_.data() + (2 * i + r) * num_params, num_params, to + 9);
    }
  }

  std::string pose_;
  std::string poses_path_;
  std::string direction_;
  std::optional<SE3> camera_from_points_;
  PoseList list_;
  std::vector<Eigen::Vector3d> kept_;  // only for many poses
  // Of the block at hand.
  Columns points_;
  Columns pixels_;
  std::vector<ProjectStatus> statuses_;
  std::vector<double> by_point_;
  std::vector<double> by_pose_;
  std::vector<double> by_params_;
  std::vector<double> jacobian_;  // of the point at hand
};

class UnprojectCommand final : public StreamCommand {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: echo 320,240 | alidade unproject camera.yaml\nOutput: x,y,z,status: a unit ray in the "
        "camera frame. The status is ok (a pixel of the image), out_of_image (a pixel\noutside the image) or "
        "outside (no ray projects to the pixel; x, y and z are nan).\n--jacobian appends "
        "dx_du,dx_dv,dy_du,dy_dv,dz_du,dz_dv.");
    setUpStream(
        app,
        "Rows u,v in pixels, separated by commas or blanks, header optional; standard input if omitted or -",
        {{"u", "px"}, {"v", "px"}});
    app.add_flag("--jacobian", has_jacobian_, "Append the derivatives of the ray");
    app.add_flag("--clip", is_clipped_, "Leave out the rays of pixels outside the image");
  }

 private:
  [[nodiscard]] AnswerWriter::Format format(const CameraRecord&) const override {
    AnswerWriter::Format format{
        .is_json = common_.json, .has_pose = false, .values = {"x", "y", "z"}, .details = {}};
    if (has_jacobian_) format.details = {"dx_du", "dx_dv", "dy_du", "dy_dv", "dz_du", "dz_dv"};
    return format;
  }

  void take(const CameraRecord& file, const std::vector<Eigen::Vector3d>& rows, AnswerWriter& out) override {
    pixels_.assign(rows);
    rays_.resize(rows.size());
    statuses_.resize(rows.size());
    J_ray_pixel_.resize(has_jacobian_ ? 6 * rows.size() : 0);
    unprojectBatch(file.camera, {pixels_[0], pixels_[1]}, {rays_[0], rays_[1], rays_[2], statuses_},
                   has_jacobian_ ? J_ray_pixel_.data() : nullptr);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Status status = statusOf(statuses_[i], rows[i].head<2>(), file.image_size);
      Eigen::Vector3d ray = rays_.row(i);
      const auto J =
          std::span<double>(J_ray_pixel_).subspan(has_jacobian_ ? 6 * i : 0, has_jacobian_ ? 6 : 0);
      if (!hasNumbers(status)) {
        ray.setConstant(kNone);
        std::fill(J.begin(), J.end(), kNone);
      }
      answer({ray.data(), 3}, status, J, out);
    }
  }

  // Of the block at hand.
  Columns pixels_;
  Columns rays_;
  std::vector<ProjectStatus> statuses_;
  std::vector<double> J_ray_pixel_;
};

}  // namespace

std::unique_ptr<Command> makeProjectCommand() {
  return std::make_unique<ProjectCommand>();
}

std::unique_ptr<Command> makeUnprojectCommand() {
  return std::make_unique<UnprojectCommand>();
}

}  // namespace alidade
