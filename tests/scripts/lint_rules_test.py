#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests scripts/lint_rules.py on a small project that breaks each rule once."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import lint_rules  # noqa: E402

SOURCES = '''
namespace alidade {
struct Forward;
enum class Colour { kRed };
namespace { struct Hidden {}; }
template <class T = std::less<>>
struct Outer : Base<T> { struct Nested { int a{0}; }; const char* text = "}"; };
template <> struct Outer<int> {};
int kDigits = 1'000;  // {
Outer::Outer(int x, std::function<void(int)> f = {}) noexcept : a_{x}, b_(f) {

}
template <class T>
  requires(sizeof(T) > 4)
auto twice(T x) -> std::vector<T> { return {x, x}; }
bool operator<(const A& a, const A& b) {
  return R"({)" == a;
}
const auto kTable = make({1, 2}, [] { return '{'; });
}
'''


class LintRulesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        old_root, lint_rules.ROOT = lint_rules.ROOT, self.root
        self.addCleanup(setattr, lint_rules, "ROOT", old_root)
        for cached in (lint_rules.read, lint_rules.files_in, lint_rules.scanned, lint_rules.includes, lint_rules.links,
                       lint_rules.public_headers, lint_rules.prose):
            cached.cache_clear()
        self.write("scripts/lint_rules.py", "")

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")

    def assert_findings(self, check, *expected):
        found = sorted(str(f) for f in set(check()) if f.path != "scripts/lint_rules.py")
        self.assertEqual([f.split(";")[0] for f in found], list(expected))

    def test_reads_types_and_functions(self):
        types, functions = lint_rules.scan("a.h", SOURCES)
        self.assertEqual([t.name for t in types], ["Colour", "Outer"])
        self.assertEqual([(f.name, f.line, f.num_lines) for f in functions],
                         [("Outer::Outer", 10, 1), ("twice", 15, 0), ("operator<", 16, 1)])

    def test_names_and_sizes(self):
        self.write("src/alidade/core/a.h", "namespace n {\nstruct A {};\n}\n")
        self.write("apps/b.h", "struct A;\nclass A final {};\n")
        self.write("src/alidade/core/long.cc",
                   "void f() {\n" + "g();\n" * 81 + "}\nvoid h() {\n" + "g();\n" * 80 + "}\n")
        self.write("src/alidade/core/longer.cc", "\n" * 601)
        self.assert_findings(lint_rules.check_type_names,
                             "apps/b.h:2: the type A is also declared in src/alidade/core/a.h:2")
        self.assert_findings(lint_rules.check_function_lengths,
                             "src/alidade/core/long.cc:1: the body of f has 81 lines")
        self.assert_findings(lint_rules.check_file_lengths, "src/alidade/core/longer.cc:601: the file has 601 lines")

    def test_layers(self):
        self.write("src/alidade/core/CMakeLists.txt", "alidade_add_library(core HEADERS a.h b.h SOURCES a.cc)")
        self.write("src/alidade/camera/CMakeLists.txt", "alidade_add_library(camera HEADERS c.h PUBLIC alidade::core)")
        self.write("src/alidade/core/a.h", '#include "alidade/camera/c.h"\n#include "../../../apps/d.h"\n')
        self.write("src/alidade/camera/c.h", '#include "alidade/core/a.h"\n')
        self.write("apps/d.h", '#include "alidade/core/a.h"\n')
        self.assert_findings(
            lint_rules.check_layers,
            "src/alidade/camera/c.h:1: the folders camera and core include each other, directly or through others",
            "src/alidade/core/a.h:1: core includes camera, which it does not link",
            "src/alidade/core/a.h:1: the folders core and camera include each other, directly or through others",
            'src/alidade/core/a.h:2: #include "../../../apps/d.h" is not a file of src/')
        self.assertEqual(len(lint_rules.public_headers()), 3)

    def test_rooms(self):
        base = "src/alidade/calibrate/"
        for name in ("start/s.h", "judge/j.h"):
            self.write(base + name, "")
        self.write(base + "calibrator.h", '#include "alidade/calibrate/judge/j.h"\n')
        self.write(base + "clean/c.cc", "".join(f'#include "alidade/calibrate/{name}"\n'
                                                for name in ("start/s.h", "judge/j.h", "calibrator.h")))
        self.write(base + "judge/j.cc", '#include "alidade/calibrate/judge/k.h"\n')
        self.write(base + "judge/k.h", '#include "alidade/calibrate/judge/j.h"\n')
        circle = "include each other, directly or through others"
        self.assert_findings(
            lint_rules.check_rooms,
            f"{base}judge/j.cc:1: the units calibrate/judge/j and calibrate/judge/k {circle}",
            f"{base}judge/k.h:1: the units calibrate/judge/k and calibrate/judge/j {circle}")
        self.write(base + "judge/k.h", '#include "alidade/calibrate/calibrator.h"\n')
        lint_rules.read.cache_clear()
        lint_rules.includes.cache_clear()
        self.assert_findings(
            lint_rules.check_rooms,
            f"{base}calibrator.h:1: the folders calibrate and calibrate/judge {circle}",
            f"{base}calibrator.h:1: the units calibrate/calibrator and calibrate/judge/j {circle}",
            f"{base}judge/j.cc:1: the units calibrate/judge/j and calibrate/judge/k {circle}",
            f"{base}judge/k.h:1: the folders calibrate/judge and calibrate {circle}",
            f"{base}judge/k.h:1: the units calibrate/judge/k and calibrate/calibrator {circle}")

    def test_phrases(self):
        phrase = lint_rules.Phrase(r"\bfor ever\b", "'always'", "")
        self.write("README.md", "read for\never")
        self.write("docs/a.md", "forever\n\nfor ever")
        self.write("apps/a.cc", '// for ever\nf("kept "\n  "for "\n  "ever");\n')
        self.write("src/a.h", "// for ever\n/// kept for\n/// ever\nint for_ever;\n")
        hits = [(path, line) for area in lint_rules.AREAS for path, line, _ in lint_rules.phrase_hits(phrase, area)]
        self.assertEqual(hits, [("README.md", 1), ("docs/a.md", 3), ("apps/a.cc", 3), ("src/a.h", 2), ("src/a.h", 1),
                                ("apps/a.cc", 1)])

    def test_room_table(self):
        self.write("src/CMakeLists.txt", "add_subdirectory(alidade/core)\nadd_subdirectory(alidade/camera)\n")
        self.write("CONTRIBUTING.md", "| room |\n|---|\n| `core` | a |\n| `camera` | b |\n")
        self.assert_findings(lint_rules.check_room_table)
        lint_rules.read.cache_clear()
        self.write("CONTRIBUTING.md", "| room |\n|---|\n| `camera` | b |\n| `core` | a |\n")
        self.assert_findings(lint_rules.check_room_table,
                             "CONTRIBUTING.md:3: the table of rooms has camera where src/CMakeLists.txt has core")

    def test_named_places(self):
        self.write("src/alidade/core/a.h", "void know();\nint kLimit;\n")
        self.write("tests/core/a_test.cc", "")
        self.write("CONTRIBUTING.md", "`core/a.h` `core/` `know()` `kLimit` `X_text.cc` `g++` `core/b.h`\n`cor/` `no()` `kNone`\n")
        self.assert_findings(lint_rules.check_named_places, "CONTRIBUTING.md:1: there is no core/b.h",
                             "CONTRIBUTING.md:2: there is no cor/", "CONTRIBUTING.md:2: there is no kNone",
                             "CONTRIBUTING.md:2: there is no no()")

    def test_links(self):
        self.write("README.md", "[a](docs/a.md) [b](docs/a.md#two-words) [c](https://x.org/y) [d](#top)\n# Top\n")
        self.write("docs/a.md", "# `Two` words!\n[back](../README.md)\n[gone](b.md)\n[no](../README.md#bottom)\n")
        self.assert_findings(lint_rules.check_links, "docs/a.md:3: there is no docs/b.md",
                             "docs/a.md:4: README.md has no heading #bottom")


if __name__ == "__main__":
    unittest.main()
