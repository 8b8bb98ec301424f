// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade::python {

/// The keyword arguments of a call that has many of them and shares some with other calls.
class Keywords {
 public:
  Keywords(std::string function, pybind11::dict given)
      : function_(std::move(function)), given_(std::move(given)) {}

  /// The value given for `name`, or `otherwise`. @throws Error (kUsage) for a value of the wrong type
  template <class T>
  [[nodiscard]] T take(const char* name, T otherwise) {
    names_.emplace_back(name);
    if (!given_.contains(name)) return otherwise;
    const pybind11::object value = given_.attr("pop")(name);
    try {
      return value.cast<T>();
    } catch (const pybind11::cast_error&) {
      throw usageError({.where = function_ + "(" + name + "=)",
                        .found = pybind11::repr(value).cast<std::string>(),
                        .expected = "a value as help(alidade." + function_ + ") says"});
    }
  }

  /// @throws Error (kUsage) if there are unused arguments
  void finish() const {
    if (given_.empty()) return;
    const auto name = pybind11::str(given_.begin()->first).cast<std::string>();
    throw usageError({.where = function_ + "()",
                      .found = "the unknown argument " + name,
                      .expected = join(names_, ", "),
                      .next_step = didYouMean(name, names_)});
  }

 private:
  std::string function_;
  pybind11::dict given_;
  std::vector<std::string> names_;
};

}  // namespace alidade::python
