// SPDX-License-Identifier: MIT
#include "junit.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include <pugixml.hpp>

#include "alidade/core/error.h"
#include "console.h"

namespace alidade {
namespace {

bool isJunitReport(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  for (int i = 0; i < 2 && std::getline(file, line); ++i) {
    if (line.starts_with("<testsuites")) return true;
  }
  return false;
}

void addTestCase(pugi::xml_node suite, const TestCase& tested) {
  pugi::xml_node test = suite.append_child("testcase");
  test.append_attribute("classname") = tested.kind.c_str();
  test.append_attribute("name") = printable(tested.name).c_str();
  if (tested.error) {
    test.append_child("error").append_attribute("message") = tested.error->c_str();
  } else if (tested.skipped) {
    test.append_child("skipped").append_attribute("message") = tested.skipped->c_str();
  } else if (tested.failure) {
    pugi::xml_node failure = test.append_child("failure");
    failure.append_attribute("message") = tested.failure->c_str();
    failure.text().set(tested.text.c_str());
  } else {
    test.append_child("system-out").text().set(tested.text.c_str());
  }
}

}  // namespace

std::string junitText(const std::string& suite_name, std::span<const TestCase> cases) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node suites = document.append_child("testsuites");
  pugi::xml_node suite = suites.append_child("testsuite");
  suite.append_attribute("name") = suite_name.c_str();
  const auto numWith = [&](const auto member) {
    return static_cast<unsigned long long>(
        std::ranges::count_if(cases, [&](const TestCase& test) { return (test.*member).has_value(); }));
  };
  for (pugi::xml_node node : {suites, suite}) {
    node.append_attribute("tests") = static_cast<unsigned long long>(cases.size());
    node.append_attribute("failures") = numWith(&TestCase::failure);
    node.append_attribute("errors") = numWith(&TestCase::error);
    node.append_attribute("skipped") = numWith(&TestCase::skipped);
  }
  for (const TestCase& test : cases) addTestCase(suite, test);
  std::ostringstream out;
  document.save(out, "  ", pugi::format_default, pugi::encoding_utf8);
  return out.str();
}

void addJunitFlag(Flags& flags, CommonOptions& options) {
  flags.add("--junit", &options.junit, "Write the result as JUnit XML to this file", kFilePath);
}

void checkJunitPath(const std::string& path) {
  std::error_code error;
  if (path.empty() || !std::filesystem::is_regular_file(path, error) || isJunitReport(path)) return;
  throw usageError({.where = "--junit " + path,
                    .found = "an existing file that is no JUnit report",
                    .expected = "a new file, or an earlier report",
                    .next_step = "choose another name, otherwise the file would be overwritten"});
}

}  // namespace alidade
