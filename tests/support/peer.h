// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

/// Skips a test against another program that is not installed: `path` is a file of it, `package` Debian's.
/// scripts/test --full installs the packages and asks for all peers by ALIDADE_REQUIRE_PEERS; the test fails
/// then.
#define ALIDADE_NEED_PEER(path, package)                                                                 \
  if (!std::filesystem::exists(path)) {                                                                  \
    if (std::getenv("ALIDADE_REQUIRE_PEERS") != nullptr)                                                 \
      FAIL() << "there is no " << (path) << ": install " << (package);                                   \
    GTEST_SKIP() << "there is no " << (path) << " (Debian: " << (package) << "), so it is no peer here"; \
  }
