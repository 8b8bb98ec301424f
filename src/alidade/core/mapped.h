// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <iterator>
#include <type_traits>
#include <vector>

namespace alidade {

/// `function` of each element, in order; it may be a pointer to a member.
template <class Range, class Function>
[[nodiscard]] auto mapped(const Range& range, Function function) {
  using Element = decltype(*std::begin(range));
  std::vector<std::decay_t<std::invoke_result_t<Function&, Element>>> result;
  for (Element element : range) result.push_back(std::invoke(function, element));
  return result;
}

}  // namespace alidade
