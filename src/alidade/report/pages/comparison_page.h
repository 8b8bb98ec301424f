// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/compare/projection_difference.h"
#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

/// The answer about a camera or a rig in two files.
struct ComparedPair {
  std::string name = {};  ///< of the camera or rig
  std::string a = {};     ///< files; empty: there is none
  std::string b = {};
  Agreement agreement = Agreement::kNotComparable;
  std::string reason = {};             ///< the numbers, see agreementText()
  std::string next_step = {};          ///< may be empty
  std::optional<Figure> drawing = {};  ///< of the difference
};

/// The answer about all pairs: "changed: 1 of 30 cameras", or that of the only pair with its numbers.
[[nodiscard]] std::string answerText(std::span<const ComparedPair> pairs);
/// The agreement that decides it: kBeyond before kNotComparable, kUncertain and kWithin.
[[nodiscard]] Agreement agreementOf(std::span<const ComparedPair> pairs);

/// The page of `alidade diff`. @param document  that of --json
[[nodiscard]] std::string comparisonPage(std::span<const ComparedPair> pairs, const RunOrigin& origin,
                                         const nlohmann::json& document);

}  // namespace alidade
