// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace alidade {

using Bytes = std::vector<std::uint8_t>;

/// A TIFF directory with one unrelated entry before the orientation.
inline Bytes makeExif(int orientation, bool big_endian) {
  const auto o = static_cast<std::uint8_t>(orientation);
  if (big_endian) {
    return {'M', 'M', 0, 42,   0,    0, 0, 8, 0, 2, 0x01, 0x00, 0, 3, 0, 0, 0, 1, 0,
            9,   0,   0, 0x01, 0x12, 0, 3, 0, 0, 0, 1,    0,    o, 0, 0, 0, 0, 0, 0};
  }
  return {'I', 'I', 42, 0,    8,    0, 0, 0, 2, 0, 0x00, 0x01, 3, 0, 1, 0, 0, 0, 9,
          0,   0,   0,  0x12, 0x01, 3, 0, 1, 0, 0, 0,    o,    0, 0, 0, 0, 0, 0, 0};
}

/// Puts an APP1 segment behind the first marker; `tail` stands for a thumbnail.
inline Bytes withExif(Bytes jpeg, const Bytes& exif, const Bytes& tail = {}) {
  const std::size_t length = 2 + 6 + exif.size() + tail.size();
  Bytes segment = {0xFF,
                   0xE1,
                   static_cast<std::uint8_t>(length >> 8),
                   static_cast<std::uint8_t>(length & 0xFF),
                   'E',
                   'x',
                   'i',
                   'f',
                   0,
                   0};
  segment.insert(segment.end(), exif.begin(), exif.end());
  segment.insert(segment.end(), tail.begin(), tail.end());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

}  // namespace alidade
