// SPDX-License-Identifier: MIT
#include "report_output.h"

#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/imagery/image_set.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/pages/validation_page.h"

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

std::optional<GrayImage> readOrNone(const ImageSet& set, std::size_t i) {
  try {
    return set.read(i).decode().image;
  } catch (const Error&) {
    return std::nullopt;  // the page shows the corners in its place
  }
}

// The images of an evidence document, each once; what is no such document has none, and is refused later.
std::set<std::string> viewNames(const std::string& evidence) {
  const json document = json::parse(evidence, nullptr, false);
  std::set<std::string> names;
  if (!document.is_object() || !document.contains("views") || !document["views"].is_array()) return names;
  for (const json& view : document["views"]) {
    if (view.is_object() && view.contains("image") && view["image"].is_string())
      names.insert(view["image"].get<std::string>());
  }
  return names;
}

}  // namespace

PictureSource picturesOf(const GivenViews& given, const PassingPictures& passing) {
  if (!given.image_set) return {};
  std::map<std::string, std::size_t> index_of;
  for (std::size_t i = 0; i < given.images.size(); ++i) index_of[nameInJson(given.images[i])] = i;
  const auto pathOf = [index_of, paths = given.paths](const std::string& name) -> std::string {
    const auto found = index_of.find(name);
    return found == index_of.end() ? "" : paths[found->second];
  };
  const ImageOfView image_of = [=, &passing,
                                set = *given.image_set](const std::string& name) -> std::optional<GrayImage> {
    if (std::optional<GrayImage> kept = passing.imageOf(pathOf(name))) return kept;
    const auto found = index_of.find(name);
    return found == index_of.end() ? std::nullopt : readOrNone(set, found->second);
  };
  return {.image_of = image_of,
          .picture_of = [=, &passing](const std::string& name) { return passing.pictureOf(pathOf(name)); }};
}

PictureSource picturesFrom(const std::string& evidence, const std::vector<std::string>& paths) {
  const std::vector<std::string> names = shortNames(paths);
  std::map<std::string, std::string> path_of;
  for (std::size_t i = 0; i < names.size(); ++i) path_of[nameInJson(names[i])] = paths[i];
  std::vector<std::string> images;
  std::map<std::string, std::size_t> index_of;
  for (const std::string& name : viewNames(evidence)) {
    const auto frame = parseFrameName(name);
    if (const auto file = path_of.find(name); file != path_of.end()) {
      index_of[name] = images.size();
      images.push_back(file->second);
    } else if (frame && path_of.contains(frame->video)) {
      index_of[name] = images.size();
      images.push_back(path_of[frame->video] + "@" + std::to_string(frame->number));
    }
  }
  return {
      .image_of = [index_of, set = openNamed(images)](const std::string& name) -> std::optional<GrayImage> {
        const auto found = index_of.find(name);
        return found == index_of.end() ? std::nullopt : readOrNone(set, found->second);
      },
      .picture_of = {}};
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

void writeValidationReport(const std::string& path, const std::string& evidence, const PageOptions& options) {
  writeFileAtomically(path, validationPage(json::parse(evidence), options.pictures, options.num_jobs));
}

}  // namespace alidade
