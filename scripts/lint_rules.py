#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the rules of the project that no compiler checks: names, includes, sizes and wording.

usage: scripts/lint_rules.py [--phrases]

  --phrases  only count the wording that is hard to understand, per part of the project (*: it is an error there)

scripts/lint runs this. Each message names a file, a line, what is wrong, the limit, and what to do. Exit code 1: a rule
is broken. The limits are the constants at the top of this file. Nothing is installed or built, and only Python's
standard library is needed.

example: scripts/lint_rules.py --phrases
"""
from __future__ import annotations

import dataclasses
import functools
import pathlib
import posixpath
import re
import sys
from collections.abc import Iterator

ROOT = pathlib.Path(__file__).resolve().parent.parent

MAX_FILE_LINES = 600
MAX_FUNCTION_LINES = 80  # between the braces of the body
# Longer functions that are allowed for now. Shorten them and remove them here; never add one.
LONG_FUNCTIONS: set[tuple[str, str]] = set()
# Type names that two headers declare for now. Rename one of the two and remove the name here; never add one.
REPEATED_TYPES: set[str] = set()
# The headers that users include, beside those directly in src/alidade. They and what they include are installed.
FRONT_DOORS = ["src/alidade/compare/projection_difference.h"]


@dataclasses.dataclass(frozen=True)
class Phrase:
    """Wording that is hard to understand, what to write instead, and the areas where it is an error."""

    pattern: str
    instead: str
    areas: str


# The areas: readme (README.md), docs (docs/*.md), apps and src (text in string literals), headers (/// comments in
# headers of both), comments (// comments of C++ files), scripts (scripts/, config/ and .ci/). "--phrases" counts the hits in each area. When a phrase has no
# hit left in an area, add the area to its line.
AREAS = ["readme", "docs", "apps", "src", "headers", "comments", "scripts"]
PHRASES = [
    Phrase(r"\b(is|are|was|were|be) told of\b", "'is reported for', 'gets'", "readme docs apps headers scripts"),
    Phrase(r"\bnothing (is|was) told\b", "'nothing is reported'", "readme docs apps src headers scripts"),
    Phrase(r"\bfor ever\b", "'in all later versions', 'always'", "readme docs apps src scripts"),
    Phrase(r"\banew\b", "'again'", "readme docs apps scripts"),
    Phrase(r"\ball the same\b", "'still', or leave it out", "readme docs apps scripts"),
    Phrase(r"\botherwise than\b", "'differently from', 'in another order than'", "readme docs apps headers scripts"),
    Phrase(r"\ba (row|table|line|file) (a|each) [a-z]+\b", "'one row per corner'", "readme docs apps scripts"),
    Phrase(r"\b(px|mm|degrees) an axis\b", "'px per axis'", "docs headers scripts"),
    Phrase(r"\b(sets|trials|one binary|one folder|target) an? (row|model|layer|reader|folder)\b",
           "'per row', 'per model'", "readme docs apps src headers scripts"),
    Phrase(r"\btak(e|es|en|ing) (it |nothing |the best [a-z]+ )?out\b", "'align', 'remove'", "readme docs scripts"),
    Phrase(r"\btaken (for|as)\b", "'assumed to be', 'treated as'", "readme docs scripts"),
    Phrase(r"(?<![\w*])Of the (cost|difference|noise)\b[^.;]*,", "a sentence that begins with its subject",
           "readme docs apps src headers scripts"),
    Phrase(r"(?<!there\s)\b(is|are) (one|none)(?=[.,;:)]|$)",
           "plain words for it, such as 'is valid', 'does not exist'", "readme docs apps src scripts"),
    Phrase(r"\bnatural sizes?\b", "'prior width'", "readme docs scripts"),
    Phrase(r"\bheld out\b", "'unseen', 'cross-validation error'", "readme headers scripts"),
    Phrase(r"\bfor the [a-z]+'? sake\b", "'because of'", "readme docs src headers scripts"),
    Phrase(r"\bguesswork\b", "'was never covered'", "readme docs apps headers scripts"),
    Phrase(r"\bon end\b", "'upright (portrait)'", "readme apps headers scripts"),
    Phrase(r"\bhow far apart\b|\bApart\b", "'difference in pixels'", "src scripts"),
    Phrase(r"\bas they like\b", "'any'", "readme docs apps src headers scripts"),
    Phrase(r"\bWho [a-z]+s\b", "'If you ...'", "readme docs apps src headers scripts"),
    Phrase(r"\bby the clock\b", "'elapsed time'", "readme docs apps src headers scripts"),
    Phrase(r"\bput(s)? up with\b", "'tolerate'", "readme docs apps src scripts"),
    Phrase(r"\b(lens|axis|bias)'(?!s)", "'of the lens'", "readme docs src scripts"),
    Phrase(r"\b(cannot be told|nobody can tell|can be told)\b", "'it is not possible to tell'", "readme docs scripts"),
    Phrase(r"\bto be had\b", "'available'", "readme docs apps src headers scripts"),
    Phrase(r"\bwhat has to be there\b", "'all required keys'", "readme docs apps src headers scripts"),
    Phrase(r"\banother one\b", "'a different camera', 'the other image'", ""),
    Phrase(r"\b(comes?|came) by\b(?! (view|corner|image)s?\b)", "'reach', 'find'", ""),
    Phrase(r"\bas a rule\b", "'usually'", ""),
    Phrase(r"\bshall\b", "'must', or the plain present", ""),
    Phrase(r"\bnobody\b", "the passive, or who it is", ""),
    Phrase(r"\bwhoever\b", "'a reader', 'the caller'", ""),
    Phrase(r"\bgoes? before\b", "'overrides', 'takes precedence'", "readme docs apps src scripts"),
]


@dataclasses.dataclass(frozen=True, order=True)
class Finding:
    """One broken rule."""

    path: str
    line: int
    message: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.message}"


@dataclasses.dataclass(frozen=True)
class Type:
    """A class, struct, union or enum that a header defines outside of other types and unnamed namespaces."""

    name: str
    path: str
    line: int


@dataclasses.dataclass(frozen=True)
class Function:
    """The body of a function; num_lines counts the lines between its braces."""

    name: str
    path: str
    line: int
    num_lines: int


@dataclasses.dataclass(frozen=True)
class Include:
    """One #include "..." of a file; target is the path in the project, or None if there is no such file."""

    path: str
    line: int
    text: str
    target: str | None


# ---- reading C++ ----------------------------------------------------------------------------------------------------

_TOKEN = re.compile(
    r"""(?P<comment>//[^\n]*|/\*.*?\*/)
      | (?P<directive>^[ \t]*\#(?:\\\n|[^\n])*)
      | (?P<raw>R"(?P<mark>[^\s()\\]{0,16})\(.*?\)(?P=mark)")
      | (?P<string>"(?:\\.|[^"\\\n])*")
      | (?P<char>'(?:\\.|[^'\\\n])+')
      | (?P<word>[A-Za-z_]\w* (?=[^\w"]|$) | \d(?:[\w.]|'(?=\w))*)
    """, re.VERBOSE | re.DOTALL | re.MULTILINE)


def _blank(text: str) -> str:
    """Replaces everything but line ends by spaces, so that all positions stay as they are."""
    return re.sub(r"[^\n]", " ", text)


def _only(text: str, kinds: set[str], trim: int) -> str:
    """Returns the text with only tokens of these kinds left, each without `trim` characters at both ends."""
    parts, at = [], 0
    for token in _TOKEN.finditer(text):
        if token.lastgroup in kinds or (token["raw"] and "string" in kinds):
            begin, end = token.start() + trim, token.end() - trim
            parts += [_blank(text[at:begin]), text[begin:end]]
            at = end
    return "".join(parts) + _blank(text[at:])


def code_of(text: str) -> str:
    """Returns C++ source without comments, preprocessor lines and the content of literals."""
    return _TOKEN.sub(lambda token: token[0] if token["word"] else _blank(token[0]), text)


def strings_of(text: str) -> str:
    """Returns only the content of the string literals."""
    return _only(text, {"string", "raw"}, 1)


def doc_comments_of(text: str) -> str:
    """Returns only the /// comments."""
    comments = _only(text, {"comment"}, 0)
    return "\n".join(line.replace("///", "   ", 1) if line.lstrip().startswith("///") else ""
                     for line in comments.split("\n"))


def plain_comments_of(text: str) -> str:
    """Returns only the // comments, without the slashes."""
    lines = []
    for line in _only(text, {"comment"}, 0).split("\n"):
        bare = line.lstrip()
        lines.append(line.replace("//", "  ", 1) if bare.startswith("//") and not bare.startswith("///") else "")
    return "\n".join(lines)


def line_at(text: str, position: int) -> int:
    """Returns the line of a position in the text; the first line is 1."""
    return text.count("\n", 0, position) + 1


@dataclasses.dataclass
class _Scope:
    """An open brace: its kind, the text before it, and the state to return to when it closes."""

    kind: str  # namespace, unnamed, type, function, initializer or block
    name: str
    start: int
    head_start: int
    num_parens: int


def _without_angles(head: str) -> str:
    """Removes template arguments, so that the first parenthesis is that of the parameters."""
    head = head.replace("->", "")
    while (shorter := re.sub(r"<[^<>]*>", "", head)) != head:
        head = shorter
    return re.sub(r"^template\s*", "", head.strip())


def _classify(head: str) -> tuple[str, str]:
    """Returns what the brace after this text opens in a namespace or a type, and its name."""
    head = re.sub(r"alignas\s*\([^)]*\)|\[\[.*?\]\]|\b(public|private|protected)\s*:(?!:)", " ", head).strip()
    if match := re.fullmatch(r"(?:inline\s+)?namespace\s*([\w:]*)", head):
        return ("namespace", match[1]) if match[1] else ("unnamed", "")
    if head == "extern":
        return "namespace", ""
    if match := re.search(r"\b(operator\s*(?:\(\)|[^\s(]+))\s*\(", head):
        return "function", match[1]
    plain = re.sub(r"^requires\s*\((?:[^()]|\([^()]*\))*\)", "", _without_angles(head))
    if match := re.match(r"(?:typedef\s+)?(?:class|struct|union|enum(?:\s+(?:class|struct))?)\b\s*([\w:]*)", plain):
        if "(" not in plain:
            is_specialization = re.search(rf"\b{re.escape(match[1])}\s*<", head.split(":")[0]) is not None
            return "type", "" if is_specialization or "::" in match[1] else match[1]
    if "(" not in plain:
        return "initializer", ""
    before = plain[:plain.index("(")]
    if "=" in before:
        return "initializer", ""
    has_init_list = re.search(r"\)\s*(?:noexcept\s*)?:(?!:)", plain) is not None
    if has_init_list and re.search(r"\w$", plain) and not re.search(r"\b(const|noexcept|override|final)$", plain):
        return "initializer", ""  # a_{x} in the initializer list of a constructor
    name = re.search(r"([~\w:]+)\s*$", before)
    return "function", name[1] if name else "(unnamed)"


def scan(path: str, text: str) -> tuple[list[Type], list[Function]]:
    """Returns the types and the function bodies that a C++ file defines."""
    code = code_of(text)
    types, functions = [], []
    scopes: list[_Scope] = []
    head_start = num_parens = 0
    for match in re.finditer(r"[(){};]", code):
        char, at = match[0], match.start()
        if char == "(":
            num_parens += 1
        elif char == ")":
            num_parens -= 1
        elif char == ";":
            if num_parens == 0:
                head_start = at + 1
        elif char == "{":
            parent = scopes[-1].kind if scopes else "namespace"
            head = code[head_start:at]
            if num_parens > 0:
                kind, name = "initializer", ""
            elif parent in ("namespace", "unnamed", "type"):
                kind, name = _classify(head)
            else:
                kind, name = "block", ""
            if kind == "type" and name and all(s.kind == "namespace" for s in scopes):
                types.append(Type(name, path, line_at(code, at)))
            scopes.append(_Scope(kind, name, at, head_start, num_parens))
            head_start, num_parens = at + 1, 0
        elif scopes:
            scope = scopes.pop()
            num_parens = scope.num_parens
            head_start = scope.head_start if scope.kind == "initializer" else at + 1
            if scope.kind == "function":
                first = line_at(code, scope.start)
                functions.append(Function(scope.name, path, first, max(0, line_at(code, at) - first - 1)))
    return types, functions


# ---- the files ------------------------------------------------------------------------------------------------------


@functools.cache
def read(path: str) -> str:
    """Returns the text of a file of the project."""
    return (ROOT / path).read_text(encoding="utf-8")


@functools.cache
def files_in(folder: str, *suffixes: str) -> list[str]:
    """Returns the files below a folder with one of these endings (all files, if none is given), sorted."""
    found = (p for p in (ROOT / folder).rglob("*") if p.is_file() and "__pycache__" not in p.parts)
    return sorted(p.relative_to(ROOT).as_posix() for p in found if not suffixes or p.suffix in suffixes)


def sources() -> list[str]:
    """Returns all C++ files of the library, the program and the Python module."""
    return [path for folder in ("src", "apps", "python") for path in files_in(folder, ".h", ".cc")]


@functools.cache
def scanned() -> tuple[list[Type], list[Function]]:
    """Returns the types and functions of all sources."""
    types, functions = [], []
    for path in sources():
        more_types, more_functions = scan(path, read(path))
        types += more_types if path.endswith(".h") else []
        functions += more_functions
    return types, functions


@functools.cache
def includes() -> list[Include]:
    """Returns all #include "..." of the sources."""
    found = []
    for path in sources():
        for match in re.finditer(r'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', read(path), re.MULTILINE):
            roots = [(ROOT / path).parent, ROOT / "src", ROOT / "apps/alidade"]
            target = next((p.resolve() for root in roots if (p := root / match[1]).is_file()), None)
            relative = target.relative_to(ROOT).as_posix() if target and target.is_relative_to(ROOT) else None
            found.append(Include(path, line_at(read(path), match.start()), match[1], relative))
    return found


def layer_of(path: str) -> str:
    """Returns the layer that a file belongs to, or the first folder of its path.

    A layer is a folder below src/alidade; src/alidade/files.h, its front door, belongs to it too.
    """
    parts = path.split("/")
    return parts[2].removesuffix(".h") if parts[:2] == ["src", "alidade"] and len(parts) > 2 else parts[0]


# ---- the rules ------------------------------------------------------------------------------------------------------


def check_type_names() -> Iterator[Finding]:
    """No two types in headers have the same name, and the list of exceptions has no entry that is not needed."""
    first: dict[str, Type] = {}
    unused = set(REPEATED_TYPES)
    for found in scanned()[0]:
        other = first.setdefault(found.name, found)
        if other is found:
            continue
        if found.name in REPEATED_TYPES:
            unused.discard(found.name)
        else:
            yield Finding(found.path, found.line,
                          f"the type {found.name} is also declared in {other.path}:{other.line}; the limit is one "
                          "declaration per name; rename one of the two, or use the same type in both places")
    for name in sorted(unused):
        yield _own_finding(f'"{name}"', f"no two headers declare the type {name} any more; the limit is no unused "
                           "exception; remove it from REPEATED_TYPES")


def check_file_lengths() -> Iterator[Finding]:
    """No source file is too long."""
    for path in sources():
        count = read(path).count("\n")
        if count > MAX_FILE_LINES:
            yield Finding(path, count,
                          f"the file has {count} lines; the limit is {MAX_FILE_LINES}; split it by topic")


def check_function_lengths() -> Iterator[Finding]:
    """No function is too long, and the list of exceptions has no entry that is not needed."""
    unused = set(LONG_FUNCTIONS)
    for f in scanned()[1]:
        if f.num_lines <= MAX_FUNCTION_LINES:
            continue
        if (f.path, f.name) in LONG_FUNCTIONS:
            unused.discard((f.path, f.name))
        else:
            yield Finding(f.path, f.line, f"the body of {f.name} has {f.num_lines} lines; the limit is "
                          f"{MAX_FUNCTION_LINES}; move parts of it to functions of their own")
    for path, name in sorted(unused):
        yield _own_finding(f'"{name}"', f"{name} in {path} is not longer than {MAX_FUNCTION_LINES} lines any more; "
                           "the limit is no unused exception; remove it from LONG_FUNCTIONS")


def _own_finding(text: str, message: str) -> Finding:
    """Returns a finding at the first line of this file that has the text."""
    own = "scripts/lint_rules.py"
    return Finding(own, line_at(read(own), max(0, read(own).find(text))), message)


@functools.cache
def links() -> dict[str, set[str]]:
    """Returns the layers that each layer links, directly or through others, from the CMakeLists.txt files."""
    direct: dict[str, set[str]] = {}
    for path in files_in("src/alidade", ".txt"):
        text = re.sub(r"#[^\n]*", "", read(path))
        direct.setdefault(layer_of(path), set()).update(re.findall(r"\balidade::(\w+)", text))
    for _ in direct:  # as often as the longest possible chain
        for linked in direct.values():
            linked.update(*(direct.get(other, set()) for other in list(linked)))
    return direct


def check_layers() -> Iterator[Finding]:
    """A layer includes only headers of the layers that it links, nothing includes apps/, and there is no cycle."""
    arrows: dict[str, dict[str, Include]] = {}
    for include in includes():
        here = layer_of(include.path)
        if include.path.startswith("src/") and (include.target is None or not include.target.startswith("src/")):
            yield Finding(include.path, include.line, f'#include "{include.text}" is not a file of src/; src/ may '
                          "include only its own files; move what is needed to a layer in src/")
        if include.path.startswith("python/") and (include.target or "").startswith("apps/"):
            yield Finding(include.path, include.line, f'#include "{include.text}" is a file of apps/, which nothing may '
                          "include; move what is needed to a layer in src/")
        if include.target is None or not include.target.startswith("src/"):
            continue
        there = layer_of(include.target)
        if here == there:
            continue
        arrows.setdefault(here, {}).setdefault(there, include)
        if here not in ("apps", "python") and there not in links().get(here, set()):
            allowed = ", ".join(sorted(links().get(here, set()))) or "none"
            yield Finding(include.path, include.line, f"{here} includes {there}, which it does not link; it links: "
                          f"{allowed}; move the code, or add alidade::{there} to src/alidade/{here}/CMakeLists.txt")
    yield from _cycles(arrows, "folders")


def _cycles(arrows: dict[str, dict[str, Include]], kind: str) -> Iterator[Finding]:
    """Reports each of these folders or units that includes itself through others."""
    reached = {folder: set(targets) for folder, targets in arrows.items()}
    for _ in arrows:
        for targets in reached.values():
            targets.update(*(reached.get(other, set()) for other in list(targets)))
    for folder, targets in arrows.items():
        for other, include in targets.items():
            if folder in reached.get(other, set()):
                yield Finding(include.path, include.line, f"the {kind} {folder} and {other} include each other, "
                              "directly or through others; the limit is no cycle; move what both need to a lower one")


def unit_of(path: str) -> str:
    """Returns the unit of a header and its source: detect/corner/corner_fit."""
    return path.removeprefix("src/alidade/").rsplit(".", 1)[0]


def folder_of(path: str) -> str:
    """Returns the folder of a file, or of a unit: detect/corner."""
    return posixpath.dirname(unit_of(path))


def check_rooms() -> Iterator[Finding]:
    """Inside a layer, and in apps/, neither units nor folders include each other in a circle.

    The files that lie directly in a layer count as one folder: either they include its subfolders or these them.
    """
    arrows: dict[str, dict[str, dict[str, dict[str, Include]]]] = {}
    for include in includes():
        room = layer_of(include.path)
        if include.target is None or layer_of(include.target) != room:
            continue
        for kind, of in (("units", unit_of), ("folders", folder_of)):
            here, there = of(include.path), of(include.target)
            if here != there:
                of_room = arrows.setdefault(room, {}).setdefault(kind, {})
                of_room.setdefault(here, {}).setdefault(there, include)
    for kinds in arrows.values():
        for kind, of_kind in kinds.items():
            yield from _cycles(of_kind, kind)


def num_units() -> int:
    """Returns the number of units that check_rooms() looks at."""
    return len({unit_of(path) for path in sources()})


@functools.cache
def public_headers() -> list[str]:
    """Returns the headers that the CMakeLists.txt files install."""
    found = []
    for path in files_in("src", ".txt"):
        folder = path.rsplit("/", 1)[0]
        text = re.sub(r"#[^\n]*", "", read(path))
        for call in re.finditer(r"\b(?:alidade_add_library|target_sources)\s*\(([^()]*)\)", text):
            keyword = ""
            for word in call[1].split():
                if re.fullmatch(r"[A-Z_]+", word):
                    keyword = word if word != "FILES" else keyword + "_FILES"
                elif keyword in ("HEADERS", "HEADERS_FILES") and word.endswith(".h"):
                    found.append(posixpath.normpath(f"{folder}/{word}"))
    return found


def check_public_headers() -> Iterator[Finding]:
    """Installed are the front doors, what they include directly or through others, and nothing else."""
    included: dict[str, set[str]] = {}
    for include in includes():
        if include.target is not None:
            included.setdefault(include.path, set()).add(include.target)
    front = [path for path in files_in("src/alidade", ".h") if path.count("/") == 2] + FRONT_DOORS
    reached: set[str] = set()
    while front:
        path = front.pop()
        if path not in reached:
            reached.add(path)
            front += included.get(path, set())
    listed = set(public_headers())
    for path in sorted(reached - listed):
        yield Finding(path, 1, "a front door includes this header; list it under HEADERS in CMakeLists.txt")
    for path in sorted(listed - reached):
        yield Finding(path, 1, "no front door includes this header; remove it from HEADERS in CMakeLists.txt")


def check_room_table() -> Iterator[Finding]:
    """The table of rooms in CONTRIBUTING.md has the order of src/CMakeLists.txt, from the bottom up."""
    built = re.findall(r"^add_subdirectory\(alidade/(\w+)\)", read("src/CMakeLists.txt"), re.MULTILINE)
    rows = [(match[1], line_at(read("CONTRIBUTING.md"), match.start()))
            for match in re.finditer(r"^\| `(\w+)` \|", read("CONTRIBUTING.md"), re.MULTILINE)]
    for i in range(max(len(built), len(rows))):
        room = built[i] if i < len(built) else "no further room"
        row, line = rows[i] if i < len(rows) else ("no further row", rows[-1][1] if rows else 1)
        if room != row:
            yield Finding("CONTRIBUTING.md", line, f"the table of rooms has {row} where src/CMakeLists.txt has {room}; "
                          "the limit is the same order; correct the table")
            return


def check_named_places() -> Iterator[Finding]:
    """Each file and each name of the code that CONTRIBUTING.md mentions is there."""
    text = read("CONTRIBUTING.md")
    files = [f for folder in ("src", "apps", "tests", "scripts", "docs", "config", "python", "bench", ".ci")
             for f in files_in(folder)]
    folders = {parent.as_posix() for f in files for parent in pathlib.PurePosixPath(f).parents}
    code = "".join(read(f) for f in files if f.endswith((".h", ".cc")))
    for match in re.finditer(r"`([^`\s]+)`", text):
        name = match[1]
        if re.search(r"\b(X|GROUP)\b|\bX_|[*<^]|^build|^\.\w+$", name):  # several, or made
            continue
        if name.endswith("/"):
            known = any(f"/{folder}/".endswith(f"/{name}") for folder in folders)
        elif re.search(r"\.(h|cc|py|yaml|md|txt)$", name):
            known = (ROOT / name).exists() or any(f.endswith(f"/{name}") for f in files)
        elif re.fullmatch(r"k[A-Z]\w+|\w+\(\)", name):
            known = re.search(rf"\b{name.removesuffix('()')}\b", code)
        else:
            continue
        if not known:
            yield Finding("CONTRIBUTING.md", line_at(text, match.start()), f"there is no {name}; what it names is in the "
                          "project; correct it")


def anchors_of(path: str) -> set[str]:
    """Returns the anchors of the headings of a Markdown file."""
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")
            for heading in re.findall(r"^#+ (.*)$", read(path), re.MULTILINE)}


def check_links() -> Iterator[Finding]:
    """Each link of a page to another file or heading of the project leads somewhere."""
    for path in [p.name for p in sorted(ROOT.glob("*.md"))] + files_in("docs", ".md") + files_in("bench", ".md"):
        for match in re.finditer(r"\]\(([^)\s:]+)\)", read(path)):
            file, _, anchor = match[1].partition("#")
            target = posixpath.normpath(posixpath.join(posixpath.dirname(path), file)) if file else path
            if not (ROOT / target).exists():
                what = f"there is no {target}"
            elif anchor and target.endswith(".md") and anchor not in anchors_of(target):
                what = f"{target} has no heading #{anchor}"
            else:
                continue
            yield Finding(path, line_at(read(path), match.start()), f"{what}; every link leads somewhere; correct it")


@functools.cache
def prose(area: str) -> dict[str, str]:
    """Returns the text that users read in an area, per file, with all positions as in the file."""
    if area == "readme":
        return {"README.md": read("README.md")}
    if area == "docs":
        return {path: read(path) for path in files_in("docs", ".md")}
    if area == "scripts":
        paths = files_in("scripts") + files_in("config") + files_in(".ci")
        return {path: read(path) for path in paths if path != "scripts/lint_rules.py"}
    if area == "comments":
        return {path: plain_comments_of(read(path)) for path in sources()}
    if area == "headers":
        return {path: doc_comments_of(read(path)) for path in sources() if path.endswith(".h")}
    return {path: strings_of(read(path)) for path in files_in(area, ".h", ".cc")}


def phrase_hits(phrase: Phrase, area: str) -> Iterator[tuple[str, int, str]]:
    """Yields file, line and text of each place in the area that has the phrase, also across line ends."""
    pattern = re.compile(phrase.pattern.replace(" ", r"\s+"))
    for path, text in prose(area).items():
        for match in pattern.finditer(text):
            yield path, line_at(text, match.start()), " ".join(match[0].split())


def check_phrases() -> Iterator[Finding]:
    """What users read has no phrase that is hard to understand."""
    for phrase in PHRASES:
        for area in phrase.areas.split():
            for path, line, text in phrase_hits(phrase, area):
                yield Finding(path, line, f"'{text}' is hard to understand; the limit is 0 in this area "
                              f"({area}); use {phrase.instead}")


def print_phrases() -> None:
    """Prints how often each phrase occurs in each area; a star marks areas where it is an error."""
    print(" ".join(f"{area:>8}" for area in AREAS) + "  phrase")
    for phrase in PHRASES:
        counts = [(sum(1 for _ in phrase_hits(phrase, area)), area in phrase.areas.split()) for area in AREAS]
        print(" ".join(f"{count:>7}{'*' if enforced else ' '}" for count, enforced in counts) + "  " + phrase.pattern)


def main() -> int:
    """Checks all rules and returns the exit code."""
    if set(sys.argv[1:]) & {"-h", "--help"}:
        print(__doc__.strip())
        return 0
    if sys.argv[1:] == ["--phrases"]:
        print_phrases()
        return 0
    if sys.argv[1:]:
        print(f"lint_rules.py: unknown argument '{sys.argv[1]}'; expected --phrases or nothing. Run "
              "scripts/lint_rules.py --help for an example.", file=sys.stderr)
        return 2
    types, functions = scanned()
    checks = [
        (check_type_names, f"{len(types)} types in headers differ in name ({len(REPEATED_TYPES)} exceptions)"),
        (check_function_lengths, f"{len(functions)} functions are short enough ({len(LONG_FUNCTIONS)} exceptions)"),
        (check_file_lengths, f"{len(sources())} files are short enough"),
        (check_layers, f"{len(includes())} includes follow the links of {len(links())} layers"),
        (check_rooms, f"{num_units()} units include each other in one direction"),
        (check_public_headers, f"{len(public_headers())} headers are public"),
        (check_room_table, "CONTRIBUTING.md names the rooms in their order"),
        (check_named_places, "CONTRIBUTING.md names files and code that exist"),
        (check_links, "all links of the pages lead somewhere"),
        (check_phrases, f"{len(PHRASES)} phrases do not occur where they are banned"),
    ]
    has_failed = False
    for check, summary in checks:
        findings = sorted(set(check()))
        for finding in findings:
            print(finding, file=sys.stderr)
        has_failed = has_failed or bool(findings)
        if not findings:
            print(f"lint: {summary}")
    return 1 if has_failed else 0


if __name__ == "__main__":
    sys.exit(main())
