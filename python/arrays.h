// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/geometry/rotation_conversions.h"
#include "alidade/geometry/se3.h"

// Conversions of NumPy arrays and of small values (sizes, poses, paths) from Python and back.

namespace alidade::python {

namespace py = pybind11;

/// An array whose last axis holds one point, pixel or ray.
struct Rows {
  py::array array;                 ///< float64, C-contiguous: the caller's own array if possible
  std::vector<py::ssize_t> shape;  ///< of the axes before the last
  std::size_t count = 1;           ///< total number of rows

  [[nodiscard]] const double* data() const { return static_cast<const double*>(array.data()); }
  /// A new float64 array of the shape (..., inner), uninitialised.
  [[nodiscard]] py::array_t<double> results(const std::vector<py::ssize_t>& inner) const;
  /// A new array of one status per row, uninitialised.
  [[nodiscard]] py::array_t<std::uint8_t> statuses() const;
};

/// Output arrays of a call: one point or ray and one status per row.
struct RowOutputs {
  py::array_t<double> values;
  py::array_t<std::uint8_t> statuses;
};
/// New arrays, or those of the tuple `out` if it is not None.
/// @throws Error (kUsage) for arrays that are not C-contiguous and writeable, or have a different shape or
/// dtype
[[nodiscard]] RowOutputs outputsOf(const py::handle& out, const Rows& rows, py::ssize_t columns);

/// @param columns  length of the last axis
/// @param what     the argument, for messages
/// @throws Error (kUsage) for a different shape, or if it is not an array of real numbers
[[nodiscard]] Rows rowsOf(const py::handle& value, py::ssize_t columns, const std::string& what);

/// Calls `work(begin, count)` for blocks of rows, from up to `jobs` threads (0: one per processor), without
/// the interpreter lock.
void eachRun(std::size_t num_rows, int jobs, const std::function<void(std::size_t, std::size_t)>& work);

/// A 3x4 or 4x4 matrix as a pose; nothing for None. @throws Error for anything else, naming `what`
[[nodiscard]] std::optional<SE3> poseOf(const py::handle& value, const std::string& what,
                                        double tolerance = kRotationTolerance);
[[nodiscard]] py::array_t<double> poseArray(const SE3& pose);

/// (width, height). @throws Error (kUsage) for anything else
[[nodiscard]] ImageSize sizeOf(const py::handle& value, const std::string& what);
[[nodiscard]] py::tuple sizeTuple(ImageSize size);

/// A str, bytes or os.PathLike as a path.
[[nodiscard]] std::string pathOf(const py::handle& value);
/// A name that may contain bytes that are not UTF-8, encoded like file names in Python.
[[nodiscard]] py::str nameText(const std::string& name);

[[nodiscard]] py::array_t<double> vectorArray(const std::vector<double>& values);
[[nodiscard]] py::array_t<double> pixelsArray(const std::vector<Eigen::Vector2d>& pixels);
[[nodiscard]] py::array_t<double> matrixArray(const DenseMatrix& matrix);

}  // namespace alidade::python
