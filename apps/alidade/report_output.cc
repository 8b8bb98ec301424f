// SPDX-License-Identifier: MIT
#include "report_output.h"

#include <map>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/files/atomic_file.h"
#include "alidade/imagery/image_file.h"
#include "alidade/report/json_output.h"

namespace alidade {
namespace {

json parsedEvidence(const std::string& text, const std::string& file) {
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    throw inputError({.where = file,
                      .found = "no valid JSON (" + std::string(error.what()) + ")",
                      .expected = "the file that alidade calibrate --evidence writes"});
  }
}

// As in a document that was written and read.
std::string nameInJson(const std::string& name) {
  return json::parse(json(name).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

}  // namespace

ImageOfView imagesByName(const std::vector<std::string>& names, const std::vector<std::string>& paths) {
  std::map<std::string, std::string> path_of;
  for (std::size_t i = 0; i < names.size() && i < paths.size(); ++i) path_of[nameInJson(names[i])] = paths[i];
  return [path_of = std::move(path_of)](const std::string& name) -> std::optional<GrayImage> {
    const auto found = path_of.find(name);
    if (found == path_of.end()) return std::nullopt;
    try {
      return readGrayImage(found->second).image;
    } catch (const Error&) {
      return std::nullopt;  // the page shows the corners in its place
    }
  };
}

void writeFigures(const PendingFolder& folder, const std::string& evidence, const std::string& evidence_file,
                  const PageOptions& options) {
  const std::vector<FigureFile> figures =
      reportFigures(parsedEvidence(evidence, evidence_file), evidence_file, options);
  folder.write([&] {
    for (const FigureFile& figure : figures) writeFileAtomically(folder.path(figure.name), figure.svg);
  });
}

void writeReport(const std::string& path, const std::string& evidence, const std::string& evidence_file,
                 const PageOptions& options) {
  const std::string file = evidence_file.empty() ? "the evidence" : evidence_file;
  writeFileAtomically(path, reportPage(parsedEvidence(evidence, file), file, options));
}

}  // namespace alidade
