// SPDX-License-Identifier: MIT
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "alidade/camera/triangulation.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/parallel.h"
#include "alidade/core/text.h"
#include "alidade/files/rig_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/table_lines.h"
#include "alidade/report/data/json_output.h"
#include "command.h"
#include "commands/rig/rig_inputs.h"
#include "console.h"
#include "outputs.h"

namespace alidade {
namespace {

using detail::TableLines;

// A point to triangulate: its name in the input, and its pixels.
using SeenPoint = std::pair<std::string, std::vector<RigPixel>>;

constexpr const char* kColumns = "id,camera,u,v";
constexpr std::array<const char*, 6> kEntries = {"xx", "xy", "xz", "yy", "yz", "zz"};

// Indices of the fields id, camera, u, v and, if the header has it, sigma_px.
std::vector<std::size_t> fieldsOf(const TableLines& lines) {
  std::vector<std::size_t> fields;
  for (const detail::TableColumn& column :
       {detail::TableColumn{"id"}, detail::TableColumn{"camera"}, detail::TableColumn{"u", "px"},
        detail::TableColumn{"v", "px"}, detail::TableColumn{"sigma_px"}}) {
    const detail::ColumnSearch search = detail::findColumn(lines.names(), column);
    if (search.index) {
      fields.push_back(*search.index);
    } else if (column.name != "sigma_px" || !search.complaint.empty()) {
      throw lines.error(
          search.complaint.empty() ? "the header " + join(lines.names(), ",") : search.complaint,
          std::string("columns ") + kColumns + " and optionally sigma_px");
    }
  }
  return fields;
}

// The pixel of a row.
RigPixel pixelOf(const TableLines& lines, const std::vector<std::size_t>& fields, const AnyRig& rig,
                 double default_sigma_px) {
  const std::string camera(lines.fields()[fields[1]]);
  const auto at = std::ranges::find(rig.cameras(), camera, &MountedCamera::name);
  if (at == rig.cameras().end()) {
    const std::vector<std::string> names = mapped(rig.cameras(), &MountedCamera::name);
    throw lines.error("camera '" + camera + "'", "one of the rig's: " + join(names, ", "),
                      didYouMean(camera, names));
  }
  RigPixel pixel{.camera = static_cast<std::size_t>(at - rig.cameras().begin()),
                 .pixel = {lines.number(fields[2], "u"), lines.number(fields[3], "v")},
                 .sigma_px = default_sigma_px};
  if (fields.size() <= 4 || lines.fields()[fields[4]].empty()) return pixel;
  const double sigma = lines.number(fields[4], "sigma_px");
  if (!std::isnan(sigma)) pixel.sigma_px = sigma;
  if (!(pixel.sigma_px > 0) || std::isinf(pixel.sigma_px))
    throw lines.error("sigma_px " + exactText(sigma), "a positive number of pixels");
  return pixel;
}

// Reads rows id,camera,u,v and optionally sigma_px, under a header that names them in any order. The rows of
// a point need not be adjacent.
// @returns the points in the order of their first rows. @throws Error (kInput) with the line
std::vector<SeenPoint> readPixels(const std::string& path, const AnyRig& rig, double default_sigma_px) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 30U;
  const bool is_standard = path.empty() || path == "-";
  const std::string text = readTextFile(is_standard ? "/dev/stdin" : path, kMaxBytes);
  TableLines lines(is_standard ? "standard input" : path);
  std::vector<std::size_t> fields;
  std::vector<SeenPoint> points;
  std::map<std::string, std::size_t> index_of;
  for (const std::string_view line : split(text, '\n')) {
    const TableLines::Kind kind = lines.take(line);
    if (kind == TableLines::Kind::kHeader) fields = fieldsOf(lines);
    if (kind != TableLines::Kind::kRow) continue;
    if (fields.empty())
      throw lines.error("a row before the header", std::string("the header ") + kColumns + "[,sigma_px]");
    const std::string id(lines.fields()[fields[0]]);
    const RigPixel pixel = pixelOf(lines, fields, rig, default_sigma_px);
    const auto [at, is_new] = index_of.emplace(id, points.size());
    if (is_new) points.emplace_back(id, std::vector<RigPixel>());
    std::vector<RigPixel>& pixels = points[at->second].second;
    if (std::ranges::find(pixels, pixel.camera, &RigPixel::camera) != pixels.end()) {
      throw lines.error(
          "a second pixel of point '" + id + "' in camera '" + rig.camera(pixel.camera).name + "'",
          "at most one per point and camera",
          "give points of other moments their own ids, such as 17_frame2");
    }
    pixels.push_back(pixel);
  }
  return points;
}

std::array<double, 6> entriesOf(const Eigen::Matrix3d& matrix) {
  return {matrix(0, 0), matrix(0, 1), matrix(0, 2), matrix(1, 1), matrix(1, 2), matrix(2, 2)};
}

// Numbers of a point by name, without its id and status.
using NamedNumbers = std::vector<std::pair<std::string, double>>;

NamedNumbers numbersOf(const Triangulation& point, bool is_rig_known, bool has_covariance) {
  const Eigen::Vector3d std = point.covariance().diagonal().cwiseSqrt();
  NamedNumbers numbers = {
      {"x", point.p_rig.x()},
      {"y", point.p_rig.y()},
      {"z", point.p_rig.z()},
      {"std_x", std.x()},
      {"std_y", std.y()},
      {"std_z", std.z()},
      {"std_by_pixels", std::sqrt(point.covariance_by_pixels.trace())},
      {"std_by_rig", is_rig_known ? std::sqrt(point.covariance_by_rig.trace()) : Triangulation::kNone},
      {"error_px", point.error_px}};
  if (!has_covariance) return numbers;
  for (const bool is_by_rig : {false, true}) {
    const auto entries = entriesOf(is_by_rig ? point.covariance_by_rig : point.covariance_by_pixels);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      numbers.emplace_back(std::string(is_by_rig ? "by_rig_" : "by_pixels_") + kEntries[i],
                           is_by_rig && !is_rig_known ? Triangulation::kNone : entries[i]);
    }
  }
  return numbers;
}

class RigTriangulateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade rig triangulate rig.yaml pixels.csv -o points.csv\nOutput: "
        "id,x,y,z,std_x,std_y,std_z,std_by_pixels,std_by_rig,error_px,num_cameras,status, in metres in the "
        "frame of\nthe rig. std_x to std_z are standard deviations from the noise of the pixels and the "
        "uncertainty of the rig\ntogether; std_by_pixels and std_by_rig are the lengths of the two parts. "
        "error_px is the RMS distance of the\nprojected point from its pixels. The status is ok, "
        "too_few_cameras, no_ray (of a pixel), at_infinity (parallel\nrays), behind (the rays meet behind a "
        "camera), undetermined (rays along the line through the cameras) or\nnot_converged; all numbers are "
        "nan unless it is ok.");
    flags.add("rig", &rig_path_, "Rig file, or another file with several cameras and their poses", kFilePath);
    flags.add("pixels", &pixels_path_,
              "Table with the header id,camera,u,v[,sigma_px] and one row per pixel; standard input if "
              "omitted or -",
              kFilePath);
    flags.add("-o,--output", &output_, "Table to write (CSV). Default: standard output", kFilePath);
    flags.add("--sigma", &sigma_,
              "Standard deviation of each coordinate of a pixel, for rows without sigma_px", kPixelText);
    flags.addSwitch("--covariance", has_covariance_,
                    "Append both parts of the covariance in m^2: by_pixels_xx to by_pixels_zz, by_rig_xx to "
                    "by_rig_zz");
    flags.addCommon(common_, true);
  }

  int run(const Flags&) override {
    if (rig_path_.empty()) throw missing("no rig file", "a rig file and a table of pixels");
    checkOutput(output_, {rig_path_, pixels_path_, common_.config}, common_);
    common_.cancel = catchInterrupts();
    const RigRecord record = loadRig(rig_path_);
    tellIfRejected(record, rig_path_, common_.quiet);
    const AnyRig rig = rigOf(record);
    if (rig.size() < 2) {
      throw inputError(
          {.where = rig_path_, .found = "one camera", .expected = "a rig of two or more cameras"});
    }
    Eigen::MatrixXd covariance;
    if (!record.covariance.empty()) covariance = fullMatrix(record.covariance, numRigUnknowns(rig));
    const std::vector<SeenPoint> points = readPixels(pixels_path_, rig, *parsePixels(sigma_));
    std::vector<Triangulation> answers(points.size());
    parallelFor(
        points.size(), resolveJobs(common_.jobs),
        [&](std::size_t i) { answers[i] = triangulate(rig, points[i].second, covariance); }, common_.cancel);
    write(points, answers, covariance.size() > 0);
    if (common_.quiet) return 0;
    if (covariance.size() == 0 && !points.empty())
      printMessage("note: " + rig_path_ +
                   " states no covariance; the standard deviations are those by the pixels alone");
    printMessage(countsText(answers));
    return 0;
  }

 private:
  void write(const std::vector<SeenPoint>& points, const std::vector<Triangulation>& answers,
             bool is_rig_known) const {
    std::string table = "id";
    for (const auto& [name, value] : numbersOf({}, is_rig_known, has_covariance_)) {
      if (name == "error_px")
        table += ",error_px,num_cameras,status";
      else
        table += "," + name;
    }
    table += "\n";
    json list = json::array();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const NamedNumbers numbers = numbersOf(answers[i], is_rig_known, has_covariance_);
      const auto& [id, pixels] = points[i];
      table += detail::csvField(id);
      json point = {{"id", id}, {"num_cameras", pixels.size()}, {"status", statusId(answers[i].status)}};
      for (const auto& [name, value] : numbers) {
        table += "," + exactText(value);
        if (common_.json) point[name] = value;
        if (name == "error_px") table += fmt::format(",{},{}", pixels.size(), statusId(answers[i].status));
      }
      table += "\n";
      if (common_.json) list.push_back(std::move(point));
    }
    const bool is_to_file = !output_.empty() && output_ != "-";
    if (is_to_file) writeFileAtomically(output_, table);
    if (common_.json) {
      printResult(jsonText({{"points", std::move(list)}, {"is_rig_covariance_known", is_rig_known}}));
    } else if (!is_to_file) {
      printResult(table);
    }
  }

  static std::string countsText(const std::vector<Triangulation>& answers) {
    std::map<TriangulationStatus, std::size_t> counts;
    for (const Triangulation& answer : answers) ++counts[answer.status];
    std::string text;
    for (const auto& [status, count] : counts)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, statusId(status));
    return text.empty() ? "no points" : text;
  }

  std::string rig_path_;
  std::string pixels_path_;
  std::string output_;
  std::string sigma_ = "1px";
  bool has_covariance_ = false;
};

}  // namespace

const CommandEntry kRigTriangulateCommand = {
    "rig triangulate", "Find 3D points from their pixels in several cameras", made<RigTriangulateCommand>};

}  // namespace alidade
