// SPDX-License-Identifier: MIT
#include <limits>
#include <optional>

#include <CLI/CLI.hpp>

#include "alidade/camera/point_jacobian.h"
#include "stream_command.h"

namespace alidade {
namespace {

class UnprojectCommand final : public StreamCommand {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: echo 320,240 | alidade unproject camera.yaml\n"
        "Output: x,y,z,status; a unit ray in the camera frame with status ok, or outside where no ray leads "
        "to the pixel,\n"
        "or (--clip) out_of_image.\n"
        "--jacobian appends dx_du,dx_dv,dy_du,dy_dv,dz_du,dz_dv.");
    setUpStream(app,
                "Rows u,v (pixels), comma or blank separated, header optional; - or none: standard input");
    app.add_flag("--jacobian", has_jacobian_, "Append the derivatives of the ray");
    app.add_flag("--clip", is_clipped_, "Give pixels beyond the image the status out_of_image and no ray");
  }

 private:
  [[nodiscard]] std::vector<detail::TableColumn> inputColumns() const override {
    return {{"u", "px"}, {"v", "px"}};
  }

  [[nodiscard]] AnswerWriter::Format format(const CameraFile&) const override {
    AnswerWriter::Format format{
        .is_json = common_.json, .has_pose = false, .values = {"x", "y", "z"}, .details = {}};
    if (has_jacobian_) format.details = {"dx_du", "dx_dv", "dy_du", "dy_dv", "dz_du", "dz_dv"};
    return format;
  }

  void take(const CameraFile& file, const std::vector<Eigen::Vector3d>& rows, AnswerWriter& out) override {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    for (const Eigen::Vector3d& row : rows) {
      const Eigen::Vector2d pixel = row.head<2>();
      const bool is_clipped = is_clipped_ && pixel.allFinite() && !isInImage(pixel, file.image_size);
      const auto ray = is_clipped ? std::nullopt : file.camera.unproject(pixel);
      const Status status = is_clipped ? Status::kOutOfImage : ray ? Status::kOk : Status::kOutside;
      const Eigen::Vector3d values = ray.value_or(Eigen::Vector3d::Constant(kNone));
      RayJacobian J = RayJacobian::Constant(kNone);
      if (has_jacobian_ && ray) J = rayJacobian(file.camera, *ray).value_or(J);
      answer({values.data(), 3}, status, {J.data(), has_jacobian_ ? std::size_t{6} : 0}, out);
    }
  }
};

}  // namespace

std::unique_ptr<Command> makeUnprojectCommand() {
  return std::make_unique<UnprojectCommand>();
}

}  // namespace alidade
