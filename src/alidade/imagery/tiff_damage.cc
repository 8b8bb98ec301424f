// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_damage.h"

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

toff_t seekTo(thandle_t handle, toff_t offset, int whence) {
  Source& source = sourceOf(handle);
  source.at = whence == SEEK_SET   ? offset
              : whence == SEEK_CUR ? source.at + offset
                                   : source.content.size() + offset;
  return source.at;
}

bool isDeflate(TIFF* tiff) {
  std::uint16_t kind = 0;
  TIFFGetField(tiff, TIFFTAG_COMPRESSION, &kind);
  return kind == COMPRESSION_DEFLATE || kind == COMPRESSION_ADOBE_DEFLATE;
}

// Decodes a strip or tile with its checksum: libtiff stops at the last sample, before it.
bool inflatePiece(TIFF* tiff, std::uint32_t i, std::vector<std::uint8_t>& decoded) {
  constexpr std::uint64_t kSlack = 1024;  // for headers and incompressible data
  const std::uint64_t num_raw = TIFFGetStrileByteCount(tiff, i);
  if (num_raw == 0 || num_raw > std::uint64_t{2} * decoded.size() + kSlack) return false;
  std::vector<std::uint8_t> raw(num_raw);
  const auto wanted = static_cast<tmsize_t>(num_raw);
  const auto read = TIFFIsTiled(tiff) != 0 ? TIFFReadRawTile : TIFFReadRawStrip;
  uLongf num_decoded = decoded.size();
  return read(tiff, i, raw.data(), wanted) == wanted &&
         uncompress(decoded.data(), &num_decoded, raw.data(), raw.size()) == Z_OK;
}

}  // namespace

bool isTiffDamaged(std::string_view content) {
  // The process has one handler for all files, so libtiff is silenced permanently.
  [[maybe_unused]] static const auto kErrors = TIFFSetErrorHandler(nullptr);
  [[maybe_unused]] static const auto kWarnings = TIFFSetWarningHandler(nullptr);
  Source source{.content = content};
  const std::unique_ptr<TIFF, decltype(&TIFFClose)> tiff(
      TIFFClientOpen(
          "image", "rm", &source, readBytes, [](thandle_t, void*, tmsize_t) -> tmsize_t { return 0; }, seekTo,
          [](thandle_t) { return 0; },
          [](thandle_t handle) -> toff_t { return sourceOf(handle).content.size(); }, nullptr, nullptr),
      TIFFClose);
  if (!tiff) return true;
  const bool is_tiled = TIFFIsTiled(tiff.get()) != 0;
  const std::uint32_t count = is_tiled ? TIFFNumberOfTiles(tiff.get()) : TIFFNumberOfStrips(tiff.get());
  const tmsize_t size = is_tiled ? TIFFTileSize(tiff.get()) : TIFFStripSize(tiff.get());
  const auto decode = is_tiled ? TIFFReadEncodedTile : TIFFReadEncodedStrip;
  // A small file may claim any size. Deflate and LZW compress by little more than a factor of 1000.
  constexpr std::size_t kMaxShrinkage = 2000;
  if (size <= 0) return true;
  if (static_cast<std::size_t>(size) / kMaxShrinkage > content.size()) return false;
  std::vector<std::uint8_t> decoded(static_cast<std::size_t>(size));
  for (std::uint32_t i = 0; i < count; ++i) {
    const bool is_good = isDeflate(tiff.get()) ? inflatePiece(tiff.get(), i, decoded)
                                               : decode(tiff.get(), i, decoded.data(), size) >= 0;
    if (!is_good) return true;
  }
  return false;
}

}  // namespace alidade
