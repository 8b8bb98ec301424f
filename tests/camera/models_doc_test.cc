// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "alidade/camera/model_traits.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

constexpr std::string_view kHead = "| id | lens parameters | good for | elsewhere |\n|---|---|---|---|\n";

std::string contentOf(const std::string& path) {
  std::ostringstream content;
  content << std::ifstream(path).rdbuf();
  return content.str();
}

// The rows of all models. The columns that are written by hand are kept.
std::string rowsFor(const std::string& old_rows) {
  std::map<std::string, std::string, std::less<>> by_hand;
  std::istringstream lines(old_rows);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t id_end = line.find("` |");
    const std::size_t parameters_end = line.find(" | ", id_end + 4);
    by_hand[line.substr(3, id_end - 3)] = line.substr(parameters_end);
  }
  std::string rows;
  for (const ModelTraits& model : allModelTraits()) {
    std::string parameters;
    for (const std::string_view name : model.parameter_names.subspan(kNumAffine))
      parameters += (parameters.empty() ? "" : " ") + std::string(name);
    const auto found = by_hand.find(model.id);
    rows += "| `" + std::string(model.id) + "` | " + (parameters.empty() ? "-" : parameters) +
            (found == by_hand.end() ? " | | |" : found->second) + "\n";
  }
  return rows;
}

TEST(ModelsDoc, HasTheModelsWithTheirParameters) {
  const char* const other = std::getenv("ALIDADE_MODELS_DOC");
  const std::string path = other != nullptr ? other : sourcePath("docs/models.md");
  const std::string text = contentOf(path);
  const std::size_t head = text.find(kHead);
  ASSERT_NE(head, std::string::npos);
  const std::size_t begin = head + kHead.size();
  const std::size_t end = text.find("\n\n", begin) + 1;
  const std::string expected =
      text.substr(0, begin) + rowsFor(text.substr(begin, end - begin)) + text.substr(end);
  if (std::getenv("ALIDADE_WRITE_MODELS_DOC") != nullptr) std::ofstream(path) << expected;
  EXPECT_EQ(contentOf(path), expected) << "scripts/formats_doc writes the table anew";
}

}  // namespace
}  // namespace alidade
