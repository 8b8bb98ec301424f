// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_scores.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// Numbers by name. Corrections of numbers that the model does not have are lost.
using Numbers = std::map<std::string_view, double>;

struct SlipKind {
  std::string_view id;
  std::string_view text;
  void (*mend)(Numbers&) = nullptr;
  // Groups of numbers, each wrong by one factor that the images determine.
  std::array<std::string_view, 2> open = {};
  double least_change = 0;  // of the first factor; a smaller change is not this slip

  [[nodiscard]] int numOpen() const { return (open[0].empty() ? 0 : 1) + (open[1].empty() ? 0 : 1); }
};

// Moves the principal point.
template <int kHalves>
void shiftCenter(Numbers& n) {
  n["cx"] += 0.5 * kHalves;
  n["cy"] += 0.5 * kHalves;
}

// THE list. If two have the same correction, the first is named.
constexpr std::array kSlips = {
    SlipKind{"k1_sign", "k1 has the wrong sign", [](Numbers& n) { n["k1"] *= -1; }},
    SlipKind{"radial_sign", "the radial terms have the wrong sign",
             [](Numbers& n) {
               for (const char* name : {"k1", "k2", "k3", "k4", "k5", "k6"}) n[name] *= -1;
             }},
    SlipKind{"tangential_swapped", "p1 and p2 are swapped", [](Numbers& n) { std::swap(n["p1"], n["p2"]); }},
    SlipKind{"tangential_sign", "p1 and p2 have the wrong sign",
             [](Numbers& n) {
               n["p1"] *= -1;
               n["p2"] *= -1;
             }},
    SlipKind{"p1_sign", "p1 has the wrong sign", [](Numbers& n) { n["p1"] *= -1; }},
    SlipKind{"p2_sign", "p2 has the wrong sign", [](Numbers& n) { n["p2"] *= -1; }},
    SlipKind{"tangential_order", "the coefficients are in the order k1 k2 k3 p1 p2",
             [](Numbers& n) {
               if (!n.contains("p1") || !n.contains("k3")) return;
               std::swap(n["p1"], n["p2"]);
               std::swap(n["p2"], n["k3"]);
             }},
    SlipKind{"center_swapped", "cx and cy are swapped", [](Numbers& n) { std::swap(n["cx"], n["cy"]); }},
    SlipKind{"focal_swapped", "fx and fy are swapped", [](Numbers& n) { std::swap(n["fx"], n["fy"]); }},
    SlipKind{"pixel_origin", "the pixel origin is half a pixel off", shiftCenter<-1>},
    SlipKind{"pixel_origin", "the pixel origin is half a pixel off", shiftCenter<1>},
    SlipKind{"fx", "fx alone is wrong", nullptr, {"fx"}},
    SlipKind{"fy", "fy alone is wrong", nullptr, {"fy"}},
    // In practice images are not resized by less than 5 %.
    SlipKind{"scaled", "the numbers are those of images of another size", nullptr, {"fx fy cx cy"}, 0.05},
    SlipKind{"cropped", "cx and cy alone are wrong, as of another part of the image", nullptr, {"cx", "cy"}}};

// The camera without the slip; nothing if it does not have it or the corrected numbers make no valid camera.
std::optional<AnyCamera> mended(const SlipKind& kind, const AnyCamera& tested, const PosedViews& freed) {
  const auto names = tested.parameterNames();
  const auto given = tested.parameters();
  Numbers numbers;
  for (std::size_t i = 0; i < names.size(); ++i) numbers[names[i]] = given[i];
  if (kind.mend != nullptr) kind.mend(numbers);
  std::vector<double> params;
  Eigen::MatrixXd open = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(names.size()), kind.numOpen());
  for (const std::string_view name : names) {
    const auto i = static_cast<Eigen::Index>(params.size());
    params.push_back(numbers.at(name));
    for (int group = 0; group < kind.numOpen(); ++group) {
      const bool is_in_group = kind.open.at(group).find(name) != std::string_view::npos;
      // Images are resized about their corner, half a pixel before the origin.
      if (is_in_group) open(i, group) = params.back() + (name.front() == 'c' ? 0.5 : 0.0);
    }
  }
  if (kind.numOpen() > 0) {
    const Eigen::VectorXd amounts = amountsToFreed(tested, open, freed);
    if (!(std::abs(amounts(0)) > kind.least_change)) return std::nullopt;
    Eigen::Map<Eigen::VectorXd>(params.data(), open.rows()) += open * amounts;
  }
  if (std::equal(params.begin(), params.end(), given.begin())) return std::nullopt;
  try {
    return tested.withParameters(params);
  } catch (const Error&) {
    return std::nullopt;
  }
}

// "k1 has the wrong sign: k1 -0.28 instead of 0.28".
std::string textOf(const SlipKind& kind, const AnyCamera& mended, const AnyCamera& tested) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < tested.parameters().size(); ++i) {
    const double was = tested.parameters()[i];
    const double is = mended.parameters()[i];
    if (is == was) continue;
    const std::string number = kind.numOpen() > 0 ? fmt::format("{:.1f}", is) : fmt::format("{:.6g}", is);
    texts.push_back(fmt::format("{} {} instead of {:.6g}", tested.parameterNames()[i], number, was));
  }
  return fmt::format("{}: {}", kind.text, join(texts, ", "));
}

}  // namespace

std::vector<Slip> mendedSlips(const AnyCamera& tested, const PosedViews& freed) {
  std::vector<Slip> slips;
  for (const SlipKind& kind : kSlips) {
    const auto camera = mended(kind, tested, freed);
    const auto posed = camera ? posedFor(*camera, freed) : std::nullopt;
    if (!posed) continue;
    slips.push_back({.id = kind.id,
                     .text = textOf(kind, *camera, tested),
                     .mended = *camera,
                     .num_free = kind.numOpen(),
                     .rms_px = rms(posed->fit)});
  }
  return slips;
}

}  // namespace alidade
