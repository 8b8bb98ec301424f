// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

// The parts of module.cc; one file per concept.

namespace alidade::python {

/// The docstring of a name in the module such as "Camera.project", with its signature, from
/// alidade/_core.pyi.
/// @throws std::logic_error for an unknown name, so that the module cannot be loaded
[[nodiscard]] const char* doc(const char* name);

void bindErrors(pybind11::module_& module);
void bindCamera(pybind11::module_& module);
void bindFiles(pybind11::module_& module);
void bindDetection(pybind11::module_& module);
void bindCalibration(pybind11::module_& module);
void bindPoses(pybind11::module_& module);
void bindRig(pybind11::module_& module);
void bindHandEye(pybind11::module_& module);
void bindChecks(pybind11::module_& module);
void bindDifference(pybind11::module_& module);

}  // namespace alidade::python
