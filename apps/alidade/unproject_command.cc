// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include <CLI/CLI.hpp>

#include "alidade/camera/batch.h"
#include "columns.h"
#include "stream_command.h"

namespace alidade {
namespace {

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
        "Rows u,v in pixels, separated by commas or blanks, header optional; standard input if omitted or -");
    app.add_flag("--jacobian", has_jacobian_, "Append the derivatives of the ray");
    app.add_flag("--clip", is_clipped_, "Leave out the rays of pixels outside the image");
  }

 private:
  [[nodiscard]] std::vector<detail::TableColumn> inputColumns() const override {
    return {{"u", "px"}, {"v", "px"}};
  }

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
      const Eigen::Vector2d pixel = rows[i].head<2>();
      const Status status = statuses_[i] != ProjectStatus::kOk  ? Status::kOutside
                            : isInImage(pixel, file.image_size) ? Status::kOk
                                                                : Status::kOutOfImage;
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

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  // Of the block at hand.
  Columns pixels_;
  Columns rays_;
  std::vector<ProjectStatus> statuses_;
  std::vector<double> J_ray_pixel_;
};

}  // namespace

std::unique_ptr<Command> makeUnprojectCommand() {
  return std::make_unique<UnprojectCommand>();
}

}  // namespace alidade
