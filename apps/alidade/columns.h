// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/batch.h"

namespace alidade {

/// Rows of up to three numbers as one array a column, for the batch functions; memory is kept between blocks.
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

}  // namespace alidade
