// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "apps/run_program.h"
#include "support/scratch_folder.h"

namespace alidade {

/// The size and SPEC of the board in the images of testdata/.
inline constexpr const char* kBoardSpec = "checkerboard:9x6:25mm";
inline constexpr int kNumImages = 12;

/// Path of the program that was built.
[[nodiscard]] const std::string& alidadeProgram();

/// Runs it.
[[nodiscard]] RunResult runAlidade(const std::vector<std::string>& args, RunOptions options = {});

/// A file of testdata/checkerboard, and its i-th image from 1.
[[nodiscard]] std::string dataPath(const std::string& name);
[[nodiscard]] std::string imagePath(int i);

/// A folder with links to images of testdata/, from the first.
std::string linkImages(const ScratchFolder& scratch, const std::string& folder, int count);

[[nodiscard]] std::string readFile(const std::string& path);

/// `text` with its only occurrence of `from` replaced; a test that replaces nothing fails.
[[nodiscard]] std::string replaced(std::string text, const std::string& from, const std::string& to);

/// The parameters in a camera file.
[[nodiscard]] std::vector<double> parametersOf(const std::string& camera_text);

/// A camera file as short as it may be.
[[nodiscard]] std::string smallCamera();

/// Ended by itself, in time, with this code.
MATCHER_P(EndsWith, code, "ends with exit code " + std::to_string(code)) {
  return !arg.is_late && arg.signal == 0 && arg.exit_code == code;
}

/// Failed as a good program fails: with this code, nothing on standard output, and a complaint that is not
/// about itself. Indented lines before it may say what came of each input.
MATCHER_P2(FailsWith, code, message,
           "fails with exit code " + std::to_string(code) + " and a message that " +
               testing::DescribeMatcher<std::string>(message)) {
  std::string complaint = arg.err;
  while (complaint.starts_with("  ") && complaint.find('\n') != std::string::npos)
    complaint.erase(0, complaint.find('\n') + 1);
  return testing::Value(arg, EndsWith(code)) && arg.out.empty() && complaint.starts_with("error: ") &&
         !complaint.starts_with("error: internal") && testing::Value(arg.err, message);
}

}  // namespace alidade
