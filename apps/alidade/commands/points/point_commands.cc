// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <istream>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <streambuf>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "alidade/camera/batch.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/pose_list.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/table_lines.h"
#include "alidade/report/data/json_output.h"
#include "camera_files.h"
#include "command.h"
#include "console.h"

// The commands project and unproject.

namespace alidade {
namespace {

using detail::TableColumn;
using detail::TableLines;

constexpr std::size_t kReadBytes = std::size_t{1} << 18U;
constexpr std::size_t kMaxLineBytes = std::size_t{1} << 16U;

bool isStandardInput(const std::string& path) {
  return path.empty() || path == "-";
}

int openInput(const std::string& path) {
  if (isStandardInput(path)) return STDIN_FILENO;
  struct stat info {};
  if (stat(path.c_str(), &info) != 0 && errno == ENOENT) throw missingPathError(path);
  if (S_ISDIR(info.st_mode))
    throw inputError({.where = path, .found = "a folder", .expected = "a file of points"});
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw inputError({.where = path, .found = std::strerror(errno), .expected = "a readable file"});
  return fd;
}

std::string namesOf(const std::vector<TableColumn>& columns) {
  return join(mapped(columns, &TableColumn::name), ",");
}

// Reads rows of two or three numbers from a file or standard input in constant memory, in the notations of
// TableLines. A header may name the columns in any order and have additional ones, which are ignored; without
// a header (or a comment that serves as one) the columns are in order and none is additional.
class PointReader final : private std::streambuf {
 public:
  // Rows per block.
  static constexpr std::size_t kMaxRows = 512;

  // @param path  a file; "-" or nothing for standard input
  // @param before_read  called before each read, which may block until the writer of the input continues; all
  // rows read so far have been passed on by then
  // @throws Error (kInput)
  PointReader(const std::string& path, std::vector<TableColumn> columns, std::function<void()> before_read)
      : lines_(isStandardInput(path) ? "standard input" : path),
        fd_(openInput(path)),
        columns_(std::move(columns)),
        before_read_(std::move(before_read)) {
    stream_.exceptions(std::ios::badbit);  // passes on what underflow() throws
  }
  ~PointReader() override {
    if (fd_ != STDIN_FILENO) ::close(fd_);
  }
  PointReader(const PointReader&) = delete;
  PointReader& operator=(const PointReader&) = delete;

  // The next rows' numbers in the order of `columns` (NaN and infinities are numbers here), with zero as a
  // third column if there are two. False at the end.
  // @throws Error (kInput) naming file, line and field
  bool next(std::vector<Eigen::Vector3d>& rows) {
    rows.clear();
    while (rows.empty() || (rows.size() < kMaxRows && std::find(gptr(), egptr(), '\n') != egptr())) {
      stream_.getline(line_.data(), static_cast<std::streamsize>(line_.size()));
      if (stream_.fail() && stream_.eof()) break;
      if (stream_.fail()) {
        lines_.countLine();
        throw lines_.error("a line longer than 64 KiB", "one row of numbers per line");
      }
      takeLine({line_.data(), static_cast<std::size_t>(stream_.gcount()) - (stream_.eof() ? 0 : 1)}, rows);
    }
    return !rows.empty();
  }

 private:
  int_type underflow() override {
    before_read_();
    ssize_t got = 0;
    do {
      got = ::read(fd_, buffer_.data(), buffer_.size());
    } while (got < 0 && errno == EINTR);
    if (got < 0) throw lines_.error(std::strerror(errno), "readable data");
    setg(buffer_.data(), buffer_.data(), buffer_.data() + got);
    return got == 0 ? traits_type::eof() : traits_type::to_int_type(buffer_.front());
  }

  void takeLine(std::string_view line, std::vector<Eigen::Vector3d>& rows) {
    const TableLines::Kind kind = lines_.take(line);
    if (kind == TableLines::Kind::kNothing) return;
    if (kind == TableLines::Kind::kHeader) {
      if (const std::string complaint = findColumns(lines_.names()); !complaint.empty())
        throw lines_.error(complaint, "columns " + namesOf(columns_) + " in " + columns_.front().unit);
      return;
    }
    // Without a header: a comment may name the columns, otherwise they come in order.
    if (field_of_column_.empty() && !findColumns(lines_.commentNames()).empty()) {
      if (lines_.numFields() != columns_.size()) {
        throw lines_.error(std::to_string(lines_.numFields()) + " columns without a header",
                           std::to_string(columns_.size()) + ": " + namesOf(columns_),
                           columns_.size() == 3 ? "pixels u,v are for alidade unproject"
                                                : "points x,y,z are for alidade project");
      }
      for (std::size_t i = 0; i < columns_.size(); ++i) field_of_column_.push_back(i);
    }
    Eigen::Vector3d row = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < columns_.size(); ++i)
      row[static_cast<Eigen::Index>(i)] = lines_.number(field_of_column_[i], columns_[i].name);
    rows.push_back(row);
  }

  // Looks each column up among the names of a header. @returns why one is missing; empty otherwise
  std::string findColumns(const std::vector<std::string>& names) {
    std::vector<std::size_t> fields;
    for (const TableColumn& column : columns_) {
      const detail::ColumnSearch search = detail::findColumn(names, column);
      if (!search.index)
        return search.complaint.empty() ? "the header " + join(names, ",") : search.complaint;
      fields.push_back(*search.index);
    }
    field_of_column_ = std::move(fields);
    return {};
  }

  TableLines lines_;
  int fd_;
  std::vector<TableColumn> columns_;
  std::function<void()> before_read_;
  std::vector<std::size_t> field_of_column_;  // empty until known
  std::vector<char> buffer_ = std::vector<char>(kReadBytes);
  std::vector<char> line_ = std::vector<char>(kMaxLineBytes + 1);
  std::istream stream_{this};
};

// Writes rows of numbers with a status to standard output, as CSV or as one JSON document, in large pieces.
// Numbers have the fewest digits that read back as the same value; NaN is "nan", in JSON null. The JSON is
// written in pieces and not as a document of nlohmann-json, which would need memory for all rows.
// @throws Error (kInput), from any method, if writing fails
class AnswerWriter {
 public:
  // @param names  of the columns: "pose" if rows start with the id of one, then numbers, "status", numbers
  AnswerWriter(bool is_json, std::vector<std::string> names)
      : is_json_(is_json),
        names_(std::move(names)),
        buffer_(is_json_ ? "{\"points\": [" : join(names_, ",") + "\n") {}

  // Sets the pose of the following rows.
  void setPose(const std::string& id) {
    pose_ = is_json_ ? "\"pose\": " + json(id).dump(-1, ' ', false, json::error_handler_t::replace) + ", "
                     : detail::csvField(id) + ",";
  }

  void row(std::span<const double> values, std::string_view status, std::span<const double> details) {
    constexpr std::size_t kBufferBytes = std::size_t{1} << 17U;
    const std::string_view separator = is_json_ ? ", " : ",";
    if (is_json_) buffer_ += has_rows_ ? ",\n{" : "\n{";
    buffer_ += pose_;
    std::size_t column = pose_.empty() ? 0 : 1;
    for (const double value : values) {
      addNumber(names_[column++], value);
      buffer_ += separator;
    }
    const std::string_view quote = is_json_ ? "\"" : "";
    if (is_json_) buffer_ += "\"status\": ";
    buffer_.append(quote).append(status).append(quote);
    for (const double value : details) {
      buffer_ += separator;
      addNumber(names_[++column], value);
    }
    buffer_ += is_json_ ? '}' : '\n';
    has_rows_ = true;
    if (buffer_.size() >= kBufferBytes) flush();
  }

  void end() {
    if (is_json_) buffer_ += "\n]}\n";
    flush();
  }
  void flush() {
    has_sent_ = has_sent_ || !buffer_.empty();  // even if only a part arrives
    printResult(buffer_);
    buffer_.clear();
  }

  // Does not write a header without rows.
  void flushRows() {
    if (has_rows_) flush();
  }
  // True if standard output already has a part of the document, which must then be completed.
  [[nodiscard]] bool hasSent() const { return has_sent_; }

 private:
  // In JSON, the name comes first.
  void addNumber(const std::string& name, double value) {
    if (is_json_) buffer_.append("\"").append(name).append("\": ");
    if (std::isnan(value) || (is_json_ && std::isinf(value))) {
      buffer_ += is_json_ ? "null" : "nan";
      return;
    }
    std::array<char, 32> digits{};  // the shortest exact form has at most 24 characters
    char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    buffer_.append(digits.data(), end);
  }

  bool is_json_;
  std::vector<std::string> names_;
  std::string pose_;
  std::string buffer_;
  bool has_rows_ = false;
  bool has_sent_ = false;
};

constexpr std::string_view kOutOfImage = "out_of_image";

// Rows of numbers, one array per column, for the batch functions; memory is reused between blocks.
using Columns = Eigen::MatrixX3d;

std::span<double> column(Columns& columns, Eigen::Index c) {
  return {columns.col(c).data(), static_cast<std::size_t>(columns.rows())};
}

void assign(std::span<const Eigen::Vector3d> rows, Columns& columns) {
  columns.resize(static_cast<Eigen::Index>(rows.size()), Eigen::NoChange);
  for (std::size_t i = 0; i < rows.size(); ++i)
    columns.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
}

// The common part of project and unproject: a camera file, rows in, rows out, counts by status at the end.
class StreamCommand : public Command {
 public:
  int run(const Flags&) final {
    if (camera_path_.empty()) throw missing("no camera file", "a camera file");
    const CameraRecord file = readCameraTelling(camera_path_, camera_, common_.quiet);
    prepare(file);
    AnswerWriter& out = out_.emplace(common_.json, columns(file));
    // The writer of the points may wait for these rows before writing more.
    PointReader reader(points_path_, columns_, [&] { out.flushRows(); });
    std::vector<Eigen::Vector3d> rows;
    while (reader.next(rows)) take(file, rows, out);
    finish(file, out);
    out.end();
    if (!common_.quiet) printMessage(countsText());
    return 0;
  }
  // An error drops rows that have not gone out yet, and becomes the document.
  [[nodiscard]] bool owesJson() const final { return common_.json && !(out_ && out_->hasSent()); }

 protected:
  // The options of both; `points` describes the input, which has these columns.
  void setUpStream(Flags& flags, const char* points, std::vector<TableColumn> columns) {
    columns_ = std::move(columns);
    flags.add("camera", &camera_path_, "Camera file of any format (docs/formats.md)", kFilePath);
    flags.add("points", &points_path_, points, kFilePath);
    flags.redirect({"-o", "--output"}, "results go to standard output: add > FILE");
    flags.redirect({"--camera"}, "FILE#NAME selects one camera of a file with several");
    addReadOptions(flags, camera_);
    flags.addCommon(common_, false);
    flags.under(nullptr);
  }

  // Reads the command's inputs besides the camera.
  virtual void prepare(const CameraRecord&) {}
  // The names of the columns of the answer, see AnswerWriter.
  [[nodiscard]] virtual std::vector<std::string> columns(const CameraRecord& file) const = 0;
  // Answers a block of rows, or stores it until finish().
  virtual void take(const CameraRecord& file, const std::vector<Eigen::Vector3d>& rows,
                    AnswerWriter& out) = 0;
  virtual void finish(const CameraRecord&, AnswerWriter&) {}

  // Writes one row and counts it.
  void answer(std::span<const double> values, std::string_view status, std::span<const double> details,
              AnswerWriter& out) {
    ++counts_[status];
    out.row(values, status, details);
  }

  [[nodiscard]] static std::string_view statusOf(ProjectStatus status, const Eigen::Vector2d& pixel,
                                                 ImageSize size) {
    const bool is_in_image = pixel.x() >= -0.5 && pixel.x() < size.width - 0.5 && pixel.y() >= -0.5 &&
                             pixel.y() < size.height - 0.5;
    return status == ProjectStatus::kOk && !is_in_image ? kOutOfImage : statusId(status);
  }

  // True if a row with this status has a pixel or a ray.
  [[nodiscard]] bool hasNumbers(std::string_view status) const {
    return status == statusId(ProjectStatus::kOk) || (status == kOutOfImage && !is_clipped_);
  }

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  bool is_clipped_ = false;
  bool has_jacobian_ = false;

 private:
  [[nodiscard]] std::string countsText() const {
    std::vector<std::string> parts;
    for (const std::string_view status :
         {statusId(ProjectStatus::kOk), kOutOfImage, statusId(ProjectStatus::kBehind),
          statusId(ProjectStatus::kOutsideDomain)}) {
      if (const auto found = counts_.find(status); found != counts_.end())
        parts.push_back(fmt::format("{} {}", found->second, status));
    }
    return parts.empty() ? "no points" : join(parts, ", ");
  }

  std::vector<TableColumn> columns_;
  std::optional<AnswerWriter> out_;
  std::string camera_path_;
  ReadOptions camera_;
  std::string points_path_;
  std::map<std::string_view, std::size_t> counts_;  // by status
};

class ProjectCommand final : public StreamCommand {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: echo 0.1,-0.05,1.0 | alidade project camera.yaml\nExample: alidade project camera.yaml "
        "points.csv --pose '{rotation_vector_rad: [0, 0.1, 0], translation_m: [0, 0, 2]}'\nExample: alidade "
        "project camera.yaml points.csv --poses trajectory.txt\nOutput: u,v,status. The status is ok (a "
        "pixel of the image), out_of_image (a pixel outside the image),\nbehind or outside (no pixel; u and "
        "v are nan).\nPixel (0, 0) is the centre of the top-left pixel. With --poses, the first column is "
        "the id of the pose.\n--poses reads one of: a YAML list of poses; a TUM trajectory (timestamp tx ty "
        "tz qx qy qz qw, world_from_camera);\nor a table with a header that names tx,ty,tz, a rotation "
        "qx,qy,qz,qw or rx,ry,rz (rotation vector), and optionally id\nor timestamp.\nPoints are processed "
        "as they arrive, in constant memory. With --poses all points are kept in memory, at 24 bytes "
        "each.\n--jacobian appends the derivatives of u, then those of v: du_dx,du_dy,du_dz with respect to "
        "the point as given,\ndu_dtx,du_dty,du_dtz,du_drx,du_dry,du_drz with respect to the pose, "
        "camera_from_points * Exp([t, r]) at t = r = 0\n(metres, radians), and du_dfx and so on with respect "
        "to the camera parameters.");
    setUpStream(
        flags,
        "Rows x,y,z in metres, separated by commas, semicolons or blanks, header optional; standard input if "
        "omitted or -",
        {{"x", "m"}, {"y", "m"}, {"z", "m"}});
    flags.add("--pose", &pose_,
              "Pose camera_from_points: a YAML file, or YAML text in braces. Default: identity", kFilePath);
    flags.add("--poses", &poses_path_, "File of poses; all points are projected for each pose", kFilePath);
    flags.add("--poses-are", &direction_,
              "Direction of the poses, unless the input states it: camera_from_world (also called "
              "world_to_camera) or world_from_camera (camera_to_world)",
              oneOf(kPoseDirections));
    flags.addSwitch("--jacobian", has_jacobian_, "Append the derivatives of the pixel");
    flags.addSwitch("--clip", is_clipped_, "Leave out the coordinates of pixels outside the image");
  }

 private:
  void prepare(const CameraRecord& file) override {
    if (!pose_.empty() && !poses_path_.empty()) {
      throw misuse("both --pose and --poses", "one of them",
                   "remove one; --poses also accepts a file with one pose");
    }
    if (!direction_.empty() && poses_path_.empty()) {
      throw misuse("--poses-are without --poses", "--poses FILE",
                   "a --pose states its direction by a key such as world_from_camera");
    }
    if (!pose_.empty()) camera_from_points_ = readPoseSource(pose_);
    if (!poses_path_.empty()) {
      list_ = readPoseList(poses_path_, direction_);
      if (!common_.quiet) printNotes(list_.remarks);
    }
    if (has_jacobian_) jacobian_.resize(2 * (9 + file.camera.parameters().size()));
  }

  [[nodiscard]] std::vector<std::string> columns(const CameraRecord& file) const override {
    std::vector<std::string> names = {"u", "v", "status"};
    if (!list_.poses.empty()) names.insert(names.begin(), "pose");
    if (!has_jacobian_) return names;
    std::vector<std::string> inputs = {"x", "y", "z", "tx", "ty", "tz", "rx", "ry", "rz"};
    for (const std::string_view name : file.camera.parameterNames()) inputs.emplace_back(name);
    for (const char* output : {"du_d", "dv_d"}) {
      for (const std::string& input : inputs) names.push_back(output + input);
    }
    return names;
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
    assign(rows, points_);
    pixels_.resizeLike(points_);
    statuses_.resize(rows.size());
    const PointColumns points{column(points_, 0), column(points_, 1), column(points_, 2)};
    const PixelResults pixels{column(pixels_, 0), column(pixels_, 1), statuses_};
    if (has_jacobian_) {
      // Computed first, so that the pixels have the same digits with and without Jacobians.
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
      Eigen::Vector2d pixel = pixels_.row(static_cast<Eigen::Index>(i)).head<2>().transpose();
      const std::string_view status = statusOf(statuses_[i], pixel, file.image_size);
      const bool has_pixel = hasNumbers(status);
      if (!has_pixel) pixel.setConstant(kNone);
      if (has_jacobian_) gatherJacobian(i, has_pixel);
      answer({pixel.data(), 2}, status, jacobian_, out);
    }
  }

  // Jacobian of u by the point, the pose and the parameters, then of v.
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
  // Memory for the current block.
  Columns points_;
  Columns pixels_;
  std::vector<ProjectStatus> statuses_;
  std::vector<double> by_point_;
  std::vector<double> by_pose_;
  std::vector<double> by_params_;
  std::vector<double> jacobian_;  // of the current point
};

class UnprojectCommand final : public StreamCommand {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: echo 320,240 | alidade unproject camera.yaml\nOutput: x,y,z,status: a unit ray in the "
        "camera frame. The status is ok (a pixel of the image), out_of_image (a pixel\noutside the image) or "
        "outside (no ray projects to the pixel; x, y and z are nan).\n--jacobian appends "
        "dx_du,dx_dv,dy_du,dy_dv,dz_du,dz_dv.");
    setUpStream(flags,
                "Rows u,v in pixels, separated by commas, semicolons or blanks, header optional; standard "
                "input if omitted or -",
                {{"u", "px"}, {"v", "px"}});
    flags.addSwitch("--jacobian", has_jacobian_, "Append the derivatives of the ray");
    flags.addSwitch("--clip", is_clipped_, "Leave out the rays of pixels outside the image");
  }

 private:
  [[nodiscard]] std::vector<std::string> columns(const CameraRecord&) const override {
    std::vector<std::string> names = {"x", "y", "z", "status"};
    if (has_jacobian_) append(names, {"dx_du", "dx_dv", "dy_du", "dy_dv", "dz_du", "dz_dv"});
    return names;
  }

  void take(const CameraRecord& file, const std::vector<Eigen::Vector3d>& rows, AnswerWriter& out) override {
    assign(rows, pixels_);
    rays_.resizeLike(pixels_);
    statuses_.resize(rows.size());
    J_ray_pixel_.resize(has_jacobian_ ? 6 * rows.size() : 0);
    unprojectBatch(file.camera, {column(pixels_, 0), column(pixels_, 1)},
                   {column(rays_, 0), column(rays_, 1), column(rays_, 2), statuses_},
                   has_jacobian_ ? J_ray_pixel_.data() : nullptr);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::string_view status = statusOf(statuses_[i], rows[i].head<2>(), file.image_size);
      Eigen::Vector3d ray = rays_.row(static_cast<Eigen::Index>(i)).transpose();
      const auto J =
          std::span<double>(J_ray_pixel_).subspan(has_jacobian_ ? 6 * i : 0, has_jacobian_ ? 6 : 0);
      if (!hasNumbers(status)) {
        ray.setConstant(kNone);
        std::fill(J.begin(), J.end(), kNone);
      }
      answer({ray.data(), 3}, status, J, out);
    }
  }

  // Memory for the current block.
  Columns pixels_;
  Columns rays_;
  std::vector<ProjectStatus> statuses_;
  std::vector<double> J_ray_pixel_;
};

}  // namespace

const CommandEntry kProjectCommand = {"project", "Project 3D points to pixels", made<ProjectCommand>};

const CommandEntry kUnprojectCommand = {"unproject", "Convert pixels to rays", made<UnprojectCommand>};

}  // namespace alidade
