// SPDX-License-Identifier: MIT
#include "alidade/files/formats/ocam_numbers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

constexpr LensLayout kLens = {"", "ocam", "fx fy cx cy a2 a3 a4 a5 a6 skew shear"};
constexpr std::size_t kNumPowers = 5;  // a2 to a6

}  // namespace

StatedCamera stateOcam(const std::string& place, const OcamNumbers& numbers,
                       std::optional<ImageSize> image_size, std::vector<Remark> remarks) {
  std::vector<StatedNumber> a = numbers.polynomial;
  while (a.size() > 2 && a.back().value == 0) a.pop_back();
  if (a.empty() || a.front().value == 0 || (a.size() > 1 && a[1].value != 0)) {
    throw errorAt(place, "found a polynomial without constant term, or with a linear one",
                  "a0 other than 0, a1 = 0, a2, a3, ...", "export the calibration again");
  }
  if (a.size() > 2 + kNumPowers) {
    throw UnsupportedCamera(errorAt(place, "found a polynomial of degree " + std::to_string(a.size() - 1),
                                    "degree 2 to " + std::to_string(1 + kNumPowers),
                                    "calibrate with polynomial degree 4, the usual one"));
  }
  a.resize(2 + kNumPowers);
  const auto [c, d, e] = numbers.affine;
  if (!(c.value > 0)) throw errorAt(place, "found c = " + exactText(c.value), "a positive scale, near 1");
  // With R = r / |a0|, the ray is (X, Y, 1 + (a2 / a0) a0^2 R^2 + ...).
  const double focal = std::abs(a.front().value);
  std::vector<StatedNumber> listed = {{c.value * focal}, {focal}, numbers.centre[0], numbers.centre[1]};
  for (std::size_t i = 2; i < a.size(); ++i)
    listed.push_back({a[i].value / a.front().value * std::pow(focal, static_cast<double>(i))});
  StatedNumber skew = {d.value / c.value};  // of x by y
  StatedNumber shear = e;                   // of y by x
  if (numbers.is_row_first) {
    std::swap(listed[0], listed[1]);
    std::swap(listed[2], listed[3]);
    std::swap(skew, shear);
  }
  listed.push_back(skew);
  listed.push_back(shear);
  std::vector<StatedNumber> parameters = storageOrder(kLens, listed);
  takeOrigin(parameters, numbers.origin);
  return stateCamera(place, kLens.model, parameters, image_size, std::move(remarks));
}

OcamNumbers ocamNumbers(const AnyCamera& camera, bool is_row_first, double origin) {
  const std::vector<double> listed = listedOrder(kLens, camera, origin);
  // The toolbox has the unit of y (of x, if rows come first, as its y is then our x).
  const double focal = is_row_first ? listed[0] : listed[1];
  OcamNumbers numbers = {
      .polynomial = {{focal}, {0}}, .affine = {}, .centre = {}, .is_row_first = is_row_first};
  for (std::size_t i = 0; i < kNumPowers; ++i)
    numbers.polynomial.push_back({listed[4 + i] / std::pow(focal, static_cast<double>(i + 1))});
  const double c = (is_row_first ? listed[1] : listed[0]) / focal;
  const double skew = listed[4 + kNumPowers];
  const double shear = listed[5 + kNumPowers];
  numbers.affine = {{{c}, {c * (is_row_first ? shear : skew)}, {is_row_first ? skew : shear}}};
  numbers.centre = {{{listed[is_row_first ? 3 : 2]}, {listed[is_row_first ? 2 : 3]}}};
  return numbers;
}

}  // namespace alidade::detail
