// SPDX-License-Identifier: MIT
#include "alidade/core/digest.h"

#include <array>
#include <new>

// Compiles xxHash into this file, so that users of the package do not need the library.
#define XXH_INLINE_ALL
#include <xxhash.h>

namespace alidade {
namespace {

std::string hexOf(const XXH128_hash_t& hash) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, hash);
  std::string text;
  for (const unsigned char byte : canonical.digest) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

}  // namespace

struct DigestOfParts::State {
  alignas(64) XXH3_state_t hash;
};

DigestOfParts::DigestOfParts() : state_(std::make_unique<State>()) {
  XXH3_128bits_reset(&state_->hash);
}

DigestOfParts::~DigestOfParts() = default;

void DigestOfParts::add(std::string_view bytes) {
  XXH3_128bits_update(&state_->hash, bytes.data(), bytes.size());
}

std::string DigestOfParts::hex() const {
  return hexOf(XXH3_128bits_digest(&state_->hash));
}

std::string digestOf(std::string_view bytes) {
  return hexOf(XXH3_128bits(bytes.data(), bytes.size()));
}

}  // namespace alidade
