// SPDX-License-Identifier: MIT
#include <map>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/io/camera_file.h"
#include "alidade/io/pose_file.h"
#include "command.h"
#include "point_stream.h"

namespace alidade {
namespace {

const char* statusName(ProjectStatus status) {
  switch (status) {
    case ProjectStatus::kOk:
      return "ok";
    case ProjectStatus::kBehind:
      return "behind";
    case ProjectStatus::kOutside:
      return "outside";
  }
  return "unknown";
}

/// What project and unproject share: a camera file, rows in, rows out, counts by status at the end.
class StreamCommand : public Command {
 public:
  int run(const CLI::App& app) override {
    if (camera_path_.empty())
      throw usageError({.where = app.get_name(),
                        .found = "no camera file",
                        .expected = "a camera file (YAML)",
                        .next_step = "alidade " + app.get_name() + " --help"});
    const CameraFile file = readCameraFile(camera_path_);
    prepare();
    OutputStream out;
    bool is_first = true;
    // Whoever writes the points may wait for these rows before writing more. A header alone is no answer.
    PointReader reader(points_path_, inputColumns(), [&] {
      if (!is_first) out.flush();
    });
    if (common_.json) {
      out.write("{\"points\": [");
    } else {
      out.write(header());
    }
    std::array<double, 3> row{};
    while (reader.next(row)) {
      if (common_.json) out.write(is_first ? "\n" : ",\n");
      is_first = false;
      writeRow(file.camera, row, out);
    }
    if (common_.json) out.write("\n]}\n");
    out.flush();
    if (!common_.quiet) {
      std::string text;
      for (const auto& [status, count] : counts_)
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, status);
      printMessage(text.empty() ? "no points" : text);
    }
    return 0;
  }

 protected:
  virtual void prepare() {}
  [[nodiscard]] virtual std::vector<std::string> inputColumns() const = 0;
  [[nodiscard]] virtual std::string_view header() const = 0;
  virtual void writeRow(const AnyCamera& camera, const std::array<double, 3>& row, OutputStream& out) = 0;

  void setUpStream(CLI::App& app, const char* points) {
    app.add_option("camera", camera_path_, "Camera file (YAML)");
    app.add_option("points", points_path_, points);
    addCommonOptions(app, common_, false);
  }

  // One row with `names` as JSON keys; JSON has no NaN, so missing numbers are null.
  template <class Values>
  void writeFields(const Values& values, std::initializer_list<const char*> names, const char* status,
                   OutputStream& out) {
    ++counts_[status];
    std::size_t i = 0;
    for (const char* name : names) {
      const double value = values[static_cast<Eigen::Index>(i++)];
      if (common_.json) {
        out.write(i == 1 ? "{\"" : ", \"");
        out.write(name);
        out.write("\": ");
        if (value != value) {
          out.write("null");
          continue;
        }
      }
      out.writeNumber(value);
      if (!common_.json) out.write(",");
    }
    if (common_.json) {
      out.write(", \"status\": \"");
      out.write(status);
      out.write("\"}");
    } else {
      out.write(status);
      out.write("\n");
    }
  }

 private:
  std::string camera_path_;
  std::string points_path_;
  std::map<std::string, std::size_t> counts_;
};

class ProjectCommand final : public StreamCommand {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: echo 0.1,-0.05,1.0 | alidade project camera.yaml\n"
        "Example: alidade project camera.yaml points.csv --pose '{rotation_vector_rad: [0, 0.1, 0], "
        "translation_m: [0, 0, 2]}'\n"
        "Output: u,v,status with status ok, behind or outside; only ok has a pixel. Pixel (0, 0) is the "
        "centre of the\n"
        "top-left pixel.");
    setUpStream(app,
                "Rows x,y,z (metres), comma or blank separated, header optional; - or none: standard input");
    app.add_option("--pose", pose_,
                   "camera_from_points: YAML file, or YAML text in braces; the identity if not given");
  }

 private:
  void prepare() override {
    if (!pose_.empty()) camera_from_points_ = readPoseSource(pose_);
  }
  [[nodiscard]] std::vector<std::string> inputColumns() const override { return {"x", "y", "z"}; }
  [[nodiscard]] std::string_view header() const override { return "u,v,status\n"; }

  void writeRow(const AnyCamera& camera, const std::array<double, 3>& row, OutputStream& out) override {
    const Projection projection =
        camera.project(camera_from_points_ * Eigen::Vector3d(row[0], row[1], row[2]));
    writeFields(projection.pixel, {"u", "v"}, statusName(projection.status), out);
  }

  std::string pose_;
  SE3 camera_from_points_;
};

class UnprojectCommand final : public StreamCommand {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: echo 320,240 | alidade unproject camera.yaml\n"
        "Output: x,y,z,status; a unit ray in the camera frame with status ok, or outside where no ray leads "
        "to the pixel.");
    setUpStream(app,
                "Rows u,v (pixels), comma or blank separated, header optional; - or none: standard input");
  }

 private:
  [[nodiscard]] std::vector<std::string> inputColumns() const override { return {"u", "v"}; }
  [[nodiscard]] std::string_view header() const override { return "x,y,z,status\n"; }

  void writeRow(const AnyCamera& camera, const std::array<double, 3>& row, OutputStream& out) override {
    const auto ray = camera.unproject({row[0], row[1]});
    const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    writeFields(ray.value_or(none), {"x", "y", "z"}, ray ? "ok" : "outside", out);
  }
};

}  // namespace

std::unique_ptr<Command> makeProjectCommand() {
  return std::make_unique<ProjectCommand>();
}
std::unique_ptr<Command> makeUnprojectCommand() {
  return std::make_unique<UnprojectCommand>();
}

}  // namespace alidade
