// SPDX-License-Identifier: MIT
// What fuzzing kept, in testdata/fuzz, once through each target.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "support/source_tree.h"

#define TARGET(name) extern "C" int fuzz_##name(const std::uint8_t* data, std::size_t size);
#include "fuzz_targets.inc"
#undef TARGET

namespace alidade {
namespace {

void replay(const std::string& name, int (*target)(const std::uint8_t*, std::size_t)) {
  int num_inputs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sourcePath("testdata/fuzz/" + name))) {
    SCOPED_TRACE(entry.path().string());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    EXPECT_EQ(target(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()), 0);
    ++num_inputs;
  }
  EXPECT_GT(num_inputs, 0);
}

#define TARGET(name)            \
  TEST(Replay, name) {          \
    replay(#name, fuzz_##name); \
  }
#include "fuzz_targets.inc"
#undef TARGET

}  // namespace
}  // namespace alidade
