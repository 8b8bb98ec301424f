// SPDX-License-Identifier: MIT
#include "alidade/imagery/tiff_damage.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include <tiffio.h>
#include <zlib.h>

namespace alidade {
namespace {

// A file in memory, as libtiff reads it.
struct Source {
  std::string_view content;
  std::uint64_t at = 0;
};

Source& sourceOf(thandle_t handle) {
  return *static_cast<Source*>(handle);
}

tmsize_t readBytes(thandle_t handle, void* bytes, tmsize_t size) {
  Source& source = sourceOf(handle);
  if (size < 0 || source.at > source.content.size()) return 0;
  const std::size_t count = std::min(static_cast<std::size_t>(size), source.content.size() - source.at);
  std::memcpy(bytes, source.content.data() + source.at, count);
  source.at += count;
  return static_cast<tmsize_t>(count);
}

tmsize_t writeNothing(thandle_t /*handle*/, void* /*bytes*/, tmsize_t /*size*/) {
  return 0;
}

toff_t seekTo(thandle_t handle, toff_t offset, int whence) {
  Source& source = sourceOf(handle);
  source.at = whence == SEEK_SET   ? offset
              : whence == SEEK_CUR ? source.at + offset
                                   : source.content.size() + offset;
  return source.at;
}

int closeNothing(thandle_t /*handle*/) {
  return 0;
}

toff_t sizeOf(thandle_t handle) {
  return sourceOf(handle).content.size();
}

// The strips or tiles of a TIFF image.
struct Pieces {
  TIFF* tiff;
  bool is_tiled;
  bool is_deflate;
  std::uint32_t count;
  tmsize_t size;  // of the largest piece, decoded

  explicit Pieces(TIFF* of)
      : tiff(of),
        is_tiled(TIFFIsTiled(of) != 0),
        is_deflate(isDeflate(of)),
        count(is_tiled ? TIFFNumberOfTiles(of) : TIFFNumberOfStrips(of)),
        size(is_tiled ? TIFFTileSize(of) : TIFFStripSize(of)) {}

  static bool isDeflate(TIFF* of) {
    std::uint16_t kind = 0;
    TIFFGetField(of, TIFFTAG_COMPRESSION, &kind);
    return kind == COMPRESSION_DEFLATE || kind == COMPRESSION_ADOBE_DEFLATE;
  }

  bool decode(std::uint32_t i, std::vector<std::uint8_t>& decoded) const {
    return (is_tiled ? TIFFReadEncodedTile(tiff, i, decoded.data(), size)
                     : TIFFReadEncodedStrip(tiff, i, decoded.data(), size)) >= 0;
  }

  // Decodes with zlib, because libtiff stops at the last sample, before the checksum.
  bool inflate(std::uint32_t i, std::vector<std::uint8_t>& decoded) const {
    const std::uint64_t num_raw = TIFFGetStrileByteCount(tiff, i);
    if (num_raw == 0 || num_raw > std::uint64_t{2} * decoded.size() + kSlack) return false;
    std::vector<std::uint8_t> raw(num_raw);
    const auto wanted = static_cast<tmsize_t>(num_raw);
    const tmsize_t got = is_tiled ? TIFFReadRawTile(tiff, i, raw.data(), wanted)
                                  : TIFFReadRawStrip(tiff, i, raw.data(), wanted);
    uLongf num_decoded = decoded.size();
    return got == wanted && uncompress(decoded.data(), &num_decoded, raw.data(), raw.size()) == Z_OK;
  }
  static constexpr std::uint64_t kSlack = 1024;  // for headers and incompressible data
};

}  // namespace

bool isTiffDamaged(std::string_view content) {
  // The process has one handler for all files, so libtiff is silenced permanently.
  [[maybe_unused]] static const auto kErrors = TIFFSetErrorHandler(nullptr);
  [[maybe_unused]] static const auto kWarnings = TIFFSetWarningHandler(nullptr);
  Source source{.content = content};
  const std::unique_ptr<TIFF, decltype(&TIFFClose)> tiff(
      TIFFClientOpen("image", "rm", &source, readBytes, writeNothing, seekTo, closeNothing, sizeOf, nullptr,
                     nullptr),
      TIFFClose);
  if (!tiff) return true;
  const Pieces pieces(tiff.get());
  // A small file may claim any size. Deflate and LZW compress by little more than a factor of 1000.
  constexpr std::size_t kMaxShrinkage = 2000;
  if (pieces.size <= 0) return true;
  if (static_cast<std::size_t>(pieces.size) / kMaxShrinkage > content.size()) return false;
  std::vector<std::uint8_t> decoded(static_cast<std::size_t>(pieces.size));
  for (std::uint32_t i = 0; i < pieces.count; ++i) {
    if (!(pieces.is_deflate ? pieces.inflate(i, decoded) : pieces.decode(i, decoded))) return true;
  }
  return false;
}

}  // namespace alidade
