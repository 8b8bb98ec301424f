# SPDX-License-Identifier: MIT
# Turns text files into C++ strings: cmake -D OUTPUT=assets.cc -D FOLDER=assets -P embed_assets.cmake
# Each file of the list becomes a function of report_assets.h.
set(assets "palette.css:paletteCss" "figure.css:figureCss" "page.css:pageCss" "page.js:pageScript")
set(code "// Made by embed_assets.cmake.\n#include \"alidade/report/canvas/report_assets.h\"\n\nnamespace alidade {\n")
foreach(asset IN LISTS assets)
  string(REPLACE ":" ";" parts "${asset}")
  list(GET parts 0 file)
  list(GET parts 1 function)
  # As numbers: brackets and semicolons of the text mean something to CMake.
  file(READ "${FOLDER}/${file}" bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND code "std::string_view ${function}() {\n  static constexpr char kBytes[] = {${bytes}};\n"
                     "  return {kBytes, sizeof(kBytes)};\n}\n")
endforeach()
string(APPEND code "}  // namespace alidade\n")
file(WRITE "${OUTPUT}" "${code}")
