// SPDX-License-Identifier: MIT
#include "alidade/core/decimal.h"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace alidade {
namespace {

__extension__ using Wide = unsigned __int128;  // of g++ and clang

constexpr int kMantissaBits = 53;
constexpr int kMaxPlaces = 19;

template <std::uint64_t kBase>
constexpr auto kPowersOf = [] {
  std::array<std::uint64_t, kMaxPlaces + 1> powers{1};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = kBase * powers[i - 1];
  return powers;
}();
constexpr auto kFives = kPowersOf<5>;
constexpr auto kTens = kPowersOf<10>;

// The eight digits of a number below 10^8, the first in the lowest byte: halved thrice, all halves at a time.
std::uint64_t eightDigits(std::uint64_t value) {
  std::uint64_t x = value / 10'000 | (value % 10'000) << 32U;
  std::uint64_t high = ((x * 10'486) >> 20U) & 0x0000007f0000007fU;  // x / 100 for x < 10^4
  x = high | (x - 100 * high) << 16U;
  high = ((x * 103) >> 10U) & 0x000f000f000f000fU;  // x / 10 for x < 100
  return high | (x - 10 * high) << 8U;
}

constexpr std::uint64_t kEightZeros = 0x3030303030303030U;

void writeEightDigits(char* out, std::uint64_t value) {
  const std::uint64_t text = eightDigits(value) + kEightZeros;
  std::memcpy(out, &text, sizeof text);
}

// Without leading zeros.
char* writeInteger(char* out, std::uint64_t value) {
  const std::uint64_t digits = eightDigits(value);
  const int skipped = value == 0 ? 7 : std::countr_zero(digits) / 8;
  const std::uint64_t text = (digits + kEightZeros) >> (8 * skipped);
  std::memcpy(out, &text, sizeof text);
  return out + 8 - skipped;
}

// For these, as few digits as it takes are never written with an exponent, and all arithmetic below is exact.
constexpr double kMinCommon = 1e-3;
constexpr double kMaxCommon = 1e5;

// `value` in [kMinCommon, kMaxCommon) and no power of two. The decimals that read back as `value` fill an
// interval one unit of its last bit wide. With 10^-places at most that wide and 10^(1-places) wider, it holds
// at most one multiple of the latter, which is the shortest decimal then, and at least one of the former, of
// which the nearest is taken (Giulietti 2021, "The Schubfach way to render doubles", results 2 and 3). In
// this range value * 10^places has an exact value in 128 bits, so that no table of powers is needed.
char* writeCommonDecimal(char* out, std::uint64_t mantissa, int exponent) {
  constexpr int kLog10Of2Times2To18 = 78'913;
  const int places = -((exponent * kLog10Of2Times2To18) >> 18U);
  const std::uint64_t scale = kFives[static_cast<std::size_t>(places)];
  // All below in units of 2^-shift of the last decimal place.
  const int shift = 2 - exponent - places;
  const Wide scaled = Wide{4 * mantissa} * scale;
  const auto whole = static_cast<std::uint64_t>(scaled >> shift);
  const std::uint64_t one = std::uint64_t{1} << shift;
  const std::uint64_t rest = static_cast<std::uint64_t>(scaled) & (one - 1);
  // A reader that finds itself halfway between two numbers takes the even one.
  const std::uint64_t reach = 2 * scale - (mantissa % 2);
  const std::uint64_t last_digit = whole % 10;
  const std::uint64_t above_ten = (last_digit << shift) + rest;
  std::uint64_t decimal = whole + static_cast<std::uint64_t>(2 * rest + whole % 2 > one);  // ties to even
  if (above_ten <= reach) decimal = whole - last_digit;
  if (10 * one - above_ten <= reach) decimal = whole - last_digit + 10;
  // No decimal but an integer's own reads back as the integer, so that none was rounded to the next one.
  const std::uint64_t integer = mantissa >> -exponent;
  const std::uint64_t fraction = decimal - integer * kTens[static_cast<std::size_t>(places)];
  out = writeInteger(out, integer);
  if (fraction == 0) return out;
  *out++ = '.';
  // From the left, with zeros behind, which `out` has room for.
  const std::uint64_t padded = fraction * kTens[static_cast<std::size_t>(kMaxPlaces - places)];
  writeEightDigits(out, padded / 100'000'000'000);
  writeEightDigits(out + 8, padded / 1000 % 100'000'000);
  if (places > 16) writeEightDigits(out + 16, padded % 1000 * 100'000);
  out += places;
  while (out[-1] == '0') --out;
  return out;
}

}  // namespace

char* writeDecimal(char* out, double value) {
  constexpr bool kIsLittleEndian = std::endian::native == std::endian::little;  // as eightDigits() has it
  if (kIsLittleEndian && std::abs(value) >= kMinCommon && std::abs(value) < kMaxCommon) {
    constexpr std::uint64_t kImplied = std::uint64_t{1} << (kMantissaBits - 1);
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const std::uint64_t mantissa = (bits & (kImplied - 1)) | kImplied;
    const int exponent =
        static_cast<int>((bits >> (kMantissaBits - 1)) & 0x7ffU) - 1023 - (kMantissaBits - 1);
    if (mantissa != kImplied) {  // below a power of two the next number is nearer than above
      if (value < 0) *out++ = '-';
      return writeCommonDecimal(out, mantissa, exponent);
    }
  }
  return std::to_chars(out, out + kMaxDecimalChars, value).ptr;
}

}  // namespace alidade
