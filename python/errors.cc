// SPDX-License-Identifier: MIT
#include <exception>

#include "alidade/core/error.h"
#include "bindings.h"

namespace alidade::python {
namespace {

namespace py = pybind11;

// Never released, because a module cannot be unloaded.
PyObject* any_error = nullptr;
PyObject* input_error = nullptr;
PyObject* usage_error = nullptr;

PyObject* typeOf(ErrorCode code) {
  if (code == ErrorCode::kInput) return input_error;
  return code == ErrorCode::kUsage ? usage_error : any_error;
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const Error& error) {
    // Messages may name files whose names are not UTF-8.
    PyObject* const message = PyUnicode_DecodeUTF8(
        error.what(), static_cast<Py_ssize_t>(std::char_traits<char>::length(error.what())),
        "backslashreplace");
    PyErr_SetObject(typeOf(error.code()), message);
    Py_XDECREF(message);
  }
}

PyObject* newType(py::module_& module, const char* name, PyObject* bases) {
  PyObject* const type =
      PyErr_NewExceptionWithDoc(("alidade." + std::string(name)).c_str(), doc(name), bases, nullptr);
  if (type == nullptr) throw py::error_already_set();
  module.add_object(name, type);
  return type;
}

}  // namespace

void bindErrors(py::module_& module) {
  any_error = newType(module, "Error", PyExc_RuntimeError);
  input_error = newType(module, "InputError", any_error);
  usage_error = newType(module, "UsageError",
                        py::make_tuple(py::handle(any_error), py::handle(PyExc_ValueError)).ptr());
  py::register_exception_translator(&translate);
}

}  // namespace alidade::python
