// SPDX-License-Identifier: MIT
#include "arrays.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

#include <pybind11/stl.h>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"

namespace alidade::python {
namespace {

// "(12, 2)"
std::string shapeText(const py::array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

std::vector<py::ssize_t> joined(std::vector<py::ssize_t> shape, const std::vector<py::ssize_t>& inner) {
  shape.insert(shape.end(), inner.begin(), inner.end());
  return shape;
}

// The value as a C-contiguous float64 array; the value itself if it already is one.
py::array realArray(const py::handle& value, const std::string& what) {
  const auto refusal = [&](const std::string& found) {
    return usageError({.where = what, .found = found, .expected = "an array of real numbers"});
  };
  const py::array given = py::array::ensure(value);
  if (!given) throw refusal("a " + py::str(py::type::of(value).attr("__name__")).cast<std::string>());
  const char kind = given.dtype().kind();
  if (std::string("fiu").find(kind) == std::string::npos)
    throw refusal("an array of dtype " + py::str(given.dtype()).cast<std::string>());
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(given);
}

}  // namespace

py::array_t<double> Rows::results(const std::vector<py::ssize_t>& inner) const {
  return py::array_t<double>(joined(shape, inner));
}

py::array_t<std::uint8_t> Rows::statuses() const {
  return py::array_t<std::uint8_t>(shape);
}

RowOutputs outputsOf(const py::handle& out, const Rows& rows, py::ssize_t columns) {
  if (out.is_none()) return {.values = rows.results({columns}), .statuses = rows.statuses()};
  const auto fits = [](const py::handle& array, const py::dtype& type,
                       const std::vector<py::ssize_t>& shape) {
    if (!py::isinstance<py::array>(array)) return false;
    const auto given = py::reinterpret_borrow<py::array>(array);
    return given.dtype().is(type) && given.writeable() && (given.flags() & py::array::c_style) != 0 &&
           std::ranges::equal(std::span(given.shape(), static_cast<std::size_t>(given.ndim())), shape);
  };
  const std::vector<py::ssize_t> shape = joined(rows.shape, {columns});
  if (py::isinstance<py::tuple>(out) && py::len(out) == 2) {
    const py::object values = out[py::int_(0)];
    const py::object statuses = out[py::int_(1)];
    if (fits(values, py::dtype::of<double>(), shape) &&
        fits(statuses, py::dtype::of<std::uint8_t>(), rows.shape))
      return {.values = values, .statuses = statuses};
  }
  throw usageError({.where = "out",
                    .found = "other arrays",
                    .expected = "a tuple of C-contiguous, writeable arrays: float64 of shape " +
                                py::str(py::tuple(py::cast(shape))).cast<std::string>() +
                                " and uint8 of shape " +
                                py::str(py::tuple(py::cast(rows.shape))).cast<std::string>(),
                    .next_step = "use what an earlier call with as many rows returned"});
}

Rows rowsOf(const py::handle& value, py::ssize_t columns, const std::string& what) {
  Rows rows{.array = realArray(value, what), .shape = {}};
  const py::ssize_t num_axes = rows.array.ndim();
  if (num_axes == 0 || rows.array.shape(num_axes - 1) != columns) {
    throw usageError({.where = what,
                      .found = "an array of shape " + shapeText(rows.array),
                      .expected = "(N, " + std::to_string(columns) +
                                  "), or any shape whose last axis has length " + std::to_string(columns)});
  }
  for (py::ssize_t axis = 0; axis + 1 < num_axes; ++axis) {
    rows.shape.push_back(rows.array.shape(axis));
    rows.count *= static_cast<std::size_t>(rows.array.shape(axis));
  }
  return rows;
}

void eachRun(std::size_t num_rows, int jobs, const std::function<void(std::size_t, std::size_t)>& work) {
  constexpr std::size_t kRun = 1 << 15;  // enough work to be worth passing to a thread
  if (jobs < 0)
    throw usageError(
        {.where = "jobs", .found = std::to_string(jobs), .expected = "0 (one per processor) or more"});
  const py::gil_scoped_release without_lock;
  parallelFor((num_rows + kRun - 1) / kRun, jobs,
              [&](std::size_t run) { work(run * kRun, std::min(kRun, num_rows - run * kRun)); });
}

std::optional<SE3> poseOf(const py::handle& value, const std::string& what, double tolerance) {
  if (value.is_none()) return std::nullopt;
  const py::array array = realArray(value, what);
  const bool is_matrix =
      array.ndim() == 2 && (array.shape(0) == 3 || array.shape(0) == 4) && array.shape(1) == 4;
  if (!is_matrix) {
    throw usageError({.where = what,
                      .found = "an array of shape " + shapeText(array),
                      .expected = "a 4x4 matrix [R t; 0 0 0 1], or its first three rows"});
  }
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  const auto* const numbers = static_cast<const double*>(array.data());
  for (py::ssize_t i = 0; i < array.size(); ++i) matrix(i / 4, i % 4) = numbers[i];
  try {
    return motionFromMatrix(matrix, tolerance);
  } catch (const Error& error) {
    throw usageError({.where = what, .found = error.what()});
  }
}

py::array_t<double> poseArray(const SE3& pose) {
  return matrixArray(pose.matrix());
}

ImageSize sizeOf(const py::handle& value, const std::string& what) {
  try {
    const auto [width, height] = value.cast<std::pair<int, int>>();
    if (width > 0 && height > 0) return {.width = width, .height = height};
  } catch (const py::cast_error&) {
    // Rejected below, like a size that is not positive.
  }
  throw usageError({.where = what,
                    .found = py::repr(value).cast<std::string>(),
                    .expected = "(width, height) in pixels",
                    .next_step = "for an image array use (image.shape[1], image.shape[0])"});
}

py::tuple sizeTuple(ImageSize size) {
  return py::make_tuple(size.width, size.height);
}

std::string pathOf(const py::handle& value) {
  return py::module_::import("os").attr("fsencode")(value).cast<std::string>();
}

py::str nameText(const std::string& name) {
  return py::module_::import("os").attr("fsdecode")(py::bytes(name));
}

py::array_t<double> vectorArray(const std::vector<double>& values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

py::array_t<double> pixelsArray(const std::vector<Eigen::Vector2d>& pixels) {
  py::array_t<double> array({static_cast<py::ssize_t>(pixels.size()), py::ssize_t{2}});
  double* out = array.mutable_data();
  for (const Eigen::Vector2d& pixel : pixels) {
    *out++ = pixel.x();
    *out++ = pixel.y();
  }
  return array;
}

py::array_t<double> matrixArray(const DenseMatrix& matrix) {
  py::array_t<double> array(
      {static_cast<py::ssize_t>(matrix.rows()), static_cast<py::ssize_t>(matrix.cols())});
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index col = 0; col < matrix.cols(); ++col) array.mutable_at(row, col) = matrix(row, col);
  }
  return array;
}

}  // namespace alidade::python
