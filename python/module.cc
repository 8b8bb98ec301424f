// SPDX-License-Identifier: MIT
#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

#include "bindings.h"
#include "docstrings.h"  // generated from alidade/_core.pyi

namespace alidade::python {

const char* doc(const char* name) {
  const auto* const found = std::ranges::find(kDocstrings, std::string_view(name), &Docstring::name);
  if (found == std::end(kDocstrings))
    throw std::logic_error("alidade/_core.pyi has no docstring of " + std::string(name));
  return found->text;
}

}  // namespace alidade::python

PYBIND11_MODULE(_core, module) {
  using namespace alidade::python;
  // The docstrings already contain the signatures from the stubs, with Python's types.
  pybind11::options options;
  options.disable_function_signatures();
  module.attr("__version__") = ALIDADE_VERSION;
  bindErrors(module);
  bindCamera(module);
  bindFiles(module);
  bindDetection(module);
  bindCalibration(module);
  bindPoses(module);
  bindRig(module);
  bindHandEye(module);
  bindDifference(module);
  bindChecks(module);
}
