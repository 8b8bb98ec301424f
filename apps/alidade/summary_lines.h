// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/calibrate/calibrator.h"
#include "alidade/geometry/so3.h"

// Lines common to the summaries of cameras and of rigs, for people.

namespace alidade {

using Lines = std::vector<std::string>;

/// Largest numbers of lines and columns of a summary; text follows labels of kIndent columns.
inline constexpr std::size_t kMaxLines = 16;
inline constexpr std::size_t kMaxColumns = 100;
inline constexpr std::size_t kIndent = 10;
inline constexpr std::size_t kMaxBoardLines = 3;  ///< see boardLines()

/// Wraps words at kMaxColumns; the first line has the label, the others an indent.
[[nodiscard]] Lines wrapped(std::string_view label, const std::string& text);

/// Formats a text and adds its wrapped lines.
template <class... Args>
void addLines(Lines& lines, std::string_view label, fmt::format_string<Args...> format, Args&&... args) {
  const Lines more = wrapped(label, fmt::format(format, std::forward<Args>(args)...));
  lines.insert(lines.end(), more.begin(), more.end());
}

/// The number of decimals that shows two digits of a standard deviation.
[[nodiscard]] int decimalsFor(double std, int most);
/// An uncertain value with two digits, without an exponent: "0.12 px"; "unknown" if it is not finite.
[[nodiscard]] std::string pixels(double px);
/// "1.02 +- 0.01"
[[nodiscard]] std::string millimetresText(double value_m, double std_m);

/// "2.144 degrees (0.100 about z, 2.139 about the new y, 0.050 about the new x)".
[[nodiscard]] std::string turnText(const SO3& rotation);

/// "rejected: do not use this camera".
[[nodiscard]] std::string verdictText(Verdict verdict, std::string_view what, bool is_coloured);
/// "FAILED", "Warning" or "Note".
[[nodiscard]] std::string_view severityLabel(Severity severity);
/// The diagnosis with its next step, after its label.
[[nodiscard]] Lines diagnosisLines(const Diagnosis& diagnosis);
/// "3 more warnings, 2 notes: see --verbose"; empty if there are none.
[[nodiscard]] Lines moreLines(std::size_t num_warnings, std::size_t num_notes);

/// Appends to `lines` the diagnoses that fit in `room` lines.
/// @param lines_of  the lines for a diagnosis if this many remain; empty if it is only counted
/// @returns moreLines() of the others
[[nodiscard]] Lines addDiagnoses(Lines& lines, std::span<const Diagnosis> diagnoses, std::size_t room,
                                 const std::function<Lines(const Diagnosis&, std::size_t)>& lines_of);

/// The parameters with their standard deviations, four per line.
[[nodiscard]] Lines parameterLines(const Calibration& result);
/// How the entrance pupil moves; none if it is not estimated.
[[nodiscard]] Lines pupilLines(const Calibration& result);
/// The correction field and why it is used; none without it.
[[nodiscard]] Lines correctionLines(const Calibration& result);
/// One line per board; if there is not enough room, as many as fit and the number of the others.
[[nodiscard]] Lines boardLines(const Fit& fit, std::size_t room);

/// For --verbose: the outliers, and all diagnoses with their ids.
[[nodiscard]] std::string outliersText(const Calibration& result);
[[nodiscard]] std::string diagnosesText(std::span<const Diagnosis> diagnoses);

}  // namespace alidade
