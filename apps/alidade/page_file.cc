// SPDX-License-Identifier: MIT
#include "page_file.h"

#include <ctime>

#include <fmt/format.h>

#include "console.h"

namespace alidade {

namespace {

std::string pageComplaint(const std::string& path) {
  if (!path.ends_with(".pdf") && !path.ends_with(".PDF")) return {};
  return "found '" + path +
         "', expected a page (.html)\n  next: open the page in a browser, and print it to a PDF file";
}

}  // namespace

void addReportFlag(Flags& flags, std::string& path, const std::string& content, const char* names) {
  flags.add(names, &path,
            "HTML page to write: " + content + ", in one file that needs no network; print it for a PDF file",
            {.word = kFilePath.word, .complaint = pageComplaint});
}

void addDateFlag(Flags& flags, std::string& date) {
  flags.add(
      "--date", &date,
      "Date to state in the results: any text, or today. Default: none, so that equal inputs give equal "
      "files",
      kAside);
}

std::string dateText(const std::string& date) {
  if (date != "today") return date;
  const std::time_t now = std::time(nullptr);
  std::tm day{};
  ::localtime_r(&now, &day);
  return fmt::format("{}-{:02}-{:02}", day.tm_year + 1900, day.tm_mon + 1, day.tm_mday);
}

RunOrigin originOf(std::vector<std::string> inputs, const std::string& date,
                   const std::vector<std::pair<std::string, std::vector<std::string>>>& more) {
  RunOrigin origin{
      .created_by = programName(), .inputs = std::move(inputs), .camera = {}, .date = dateText(date)};
  for (const auto& [flag, values] : more) {
    for (const std::string& value : values)
      if (!value.empty()) origin.inputs.push_back(flag + " " + value);
  }
  return origin;
}

}  // namespace alidade
