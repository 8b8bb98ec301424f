// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/files/camera_file.h"
#include "alidade/files/table_lines.h"
#include "answer_writer.h"
#include "camera_options.h"
#include "command.h"

namespace alidade {

/// What project and unproject share: a camera file, rows in, rows out, counts by status at the end.
class StreamCommand : public Command {
 public:
  int run(const CLI::App& app) final;
  /// What was written but has not gone out is dropped by an error, which is the document then.
  [[nodiscard]] bool owesJson() const final { return common_.json && !(out_ && out_->hasSent()); }

 protected:
  /// What becomes of a row, in the order of the counts.
  enum class Status { kOk, kOutOfImage, kBehind, kOutside };

  /// The options of both; `points` describes the input.
  void setUpStream(CLI::App& app, const char* points);

  /// Reads what the command needs beside the camera.
  virtual void prepare(const CameraRecord&) {}
  [[nodiscard]] virtual std::vector<detail::TableColumn> inputColumns() const = 0;
  [[nodiscard]] virtual AnswerWriter::Format format(const CameraRecord& file) const = 0;
  /// Answers a block of rows, or keeps it until finish().
  virtual void take(const CameraRecord& file, const std::vector<Eigen::Vector3d>& rows,
                    AnswerWriter& out) = 0;
  virtual void finish(const CameraRecord&, AnswerWriter&) {}

  /// Writes one row and counts it.
  void answer(std::span<const double> values, Status status, std::span<const double> details,
              AnswerWriter& out);

  [[nodiscard]] static bool isInImage(const Eigen::Vector2d& pixel, ImageSize size);

  /// Whether a row with this status has a pixel or a ray.
  [[nodiscard]] bool hasNumbers(Status status) const {
    return status == Status::kOk || (status == Status::kOutOfImage && !is_clipped_);
  }

  bool is_clipped_ = false;
  bool has_jacobian_ = false;

 private:
  static constexpr std::size_t kNumStatuses = 4;
  [[nodiscard]] std::string countsText() const;

  std::optional<AnswerWriter> out_;
  std::string camera_path_;
  CameraOptions camera_;
  std::string points_path_;
  std::array<std::size_t, kNumStatuses> counts_{};
};

}  // namespace alidade
