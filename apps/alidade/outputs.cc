// SPDX-License-Identifier: MIT
#include "outputs.h"

#include <filesystem>

#include "alidade/core/error.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_list.h"
#include "command.h"
#include "console.h"

namespace alidade {
namespace {

void refuseInput(const Output& output, const std::vector<std::string>& sources) {
  for (const std::string& source : sources) {
    std::error_code ignored;  // of missing paths, which are never the same
    if (!std::filesystem::equivalent(output.path, source, ignored)) continue;
    throw flagError(output.flag + " " + output.path, "this is also an input", "a different file",
                    "choose another name, otherwise the input would be overwritten");
  }
}

// The other use of a further output's path; empty if none.
std::string otherUse(const Output& output, std::span<const Output> others) {
  if (output.path == "-") return "standard output, which is used for the results";
  for (const Output& other : others) {
    if (!other.path.empty() && writtenPath(output.path) == writtenPath(other.path))
      return "the same file as " + other.flag;
  }
  return "";
}

}  // namespace

void checkOutputs(std::span<const Output> outputs, const std::vector<std::string>& sources,
                  const CommonOptions& options, std::size_t num_checked) {
  for (std::size_t i = num_checked; i < outputs.size(); ++i) {
    const Output& output = outputs[i];
    if (output.path.empty()) continue;
    const bool is_main = output.flag == "--output";
    if (const std::string use = is_main ? "" : otherUse(output, outputs.first(i)); !use.empty()) {
      throw flagError(output.flag + " " + output.path, use,
                      "a different file" + (output.example.empty() ? "" : ", for example " + output.example));
    }
    refuseInput(output, sources);
    if (output.path != "-") {
      checkWritable(output.path);
    } else if (options.json) {
      throw flagError("--json with --output -", "both write to standard output", "only one of them",
                      "give --output a file name, or remove one of the two flags");
    }
  }
}

std::vector<std::string> withImages(std::vector<std::string> inputs) {
  try {
    append(inputs, listInputs(inputs).all());
  } catch (const Error&) {
    // An error in the output comes first; this one recurs when the images are read.
  }
  return inputs;
}

std::string notWritten(const std::string& output) {
  std::error_code ignored;
  const bool is_older = output != "-" && std::filesystem::exists(output, ignored);
  return output + " was not written" + (is_older ? "; the file of that name is an older one" : "");
}

void printRefusal(const std::string& claim, const std::string& output, bool is_kept) {
  printMessage("error: " + claim +
               (is_kept || output.empty()
                    ? ""
                    : "; " + notWritten(output) + " (use --keep-untrustworthy to write it anyway)"));
}

}  // namespace alidade
