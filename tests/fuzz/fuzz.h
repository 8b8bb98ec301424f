// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "alidade/core/error.h"

// libFuzzer calls this with every input that it makes up.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace alidade::fuzz {

inline std::string textOf(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Runs a reader. It may complain with an Error that says something; anything else it throws, and every
/// crash, is a finding.
template <class Read>
void read(const Read& reader) {
  try {
    reader();
  } catch (const Error& error) {
    expect(error.what()[0] != '\0' && error.code() != ErrorCode::kVerdict, "a complaint about the input");
  }
}

}  // namespace alidade::fuzz
