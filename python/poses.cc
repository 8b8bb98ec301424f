// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <pybind11/numpy.h>

#include "alidade/core/error.h"
#include "alidade/files/text/pose_forms.h"
#include "arrays.h"
#include "bindings.h"

namespace alidade::python {
namespace {

// The form of this name. @throws Error (kUsage)
PoseForm formOf(const std::string& name) {
  if (const auto form = findPoseForm(name)) return *form;
  throw usageError({.where = "form",
                    .found = "'" + name + "'",
                    .expected = "the name of a form of a pose",
                    .next_step = poseFormAdvice(name)});
}

// (..., N) numbers in a form as (..., 4, 4) matrices.
py::array_t<double> posesFromNumbers(const std::string& name, const py::object& numbers) {
  const PoseForm form = formOf(name);
  const std::size_t count = form.places.size();
  const Rows rows = rowsOf(numbers, static_cast<py::ssize_t>(count), name);
  py::array_t<double> matrices = rows.results({4, 4});
  double* out = matrices.mutable_data();
  for (std::size_t i = 0; i < rows.count; ++i) {
    try {
      for (std::size_t k = 0; k < count; ++k) {
        if (!std::isfinite(rows.data()[count * i + k]))
          throw usageError({.found = "numbers that are not finite"});
      }
      const Eigen::Matrix4d matrix = form.read({rows.data() + count * i, count}).stated.matrix();
      for (const double entry : matrix.transpose().reshaped()) *out++ = entry;
    } catch (const Error& error) {
      throw usageError(
          {.where = name + (rows.count > 1 ? ", row " + std::to_string(i) : ""), .found = error.what()});
    }
  }
  return matrices;
}

// (..., 16) numbers of 4x4 matrices as (..., N) numbers in a form, and whether any is in gimbal lock.
py::tuple numbersFromPoses(const std::string& name, const py::object& matrices) {
  const PoseForm form = formOf(name);
  const Rows rows = rowsOf(matrices, 16, "matrix");
  const PoseForm matrix_form = formOf("matrix");
  py::array_t<double> numbers = rows.results({static_cast<py::ssize_t>(form.places.size())});
  double* out = numbers.mutable_data();
  bool gimbal_lock = false;
  for (std::size_t i = 0; i < rows.count; ++i) {
    const SE3 pose = matrix_form.read({rows.data() + 16 * i, 16}).stated;
    for (const double number : form.write(pose, gimbal_lock)) *out++ = number;
  }
  return py::make_tuple(std::move(numbers), gimbal_lock);
}

}  // namespace

void bindPoses(py::module_& module) {
  using namespace pybind11::literals;
  module.def("_poses_from_numbers", posesFromNumbers, "form"_a, "numbers"_a);
  module.def("_numbers_from_poses", numbersFromPoses, "form"_a, "matrices"_a);
}

}  // namespace alidade::python
