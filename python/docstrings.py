#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes a C++ header of the docstrings of a stub file, so that they are written once: docstrings.py STUB HEADER

The names are those of functions and classes, and "Class.member" of their members. The text of a function begins with its
signature, as help() shows it.
"""
from __future__ import annotations

import ast
import pathlib
import sys
from collections.abc import Iterator


def signature(function: ast.FunctionDef) -> str:
    """Returns "name(a, b=1)" without types and without self."""
    arguments = function.args
    for argument in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]:
        argument.annotation = None
    if arguments.args and arguments.args[0].arg == "self":
        del arguments.args[0]
    return f"{function.name}({ast.unparse(arguments)})"


def docstrings(body: list[ast.stmt], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yields the full name and the text of everything that has a docstring; of overloads, all texts together."""
    functions: dict[str, list[str]] = {}
    for node in body:
        if not isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            continue
        text = ast.get_docstring(node)
        if isinstance(node, ast.ClassDef):
            if text:
                yield prefix + node.name, text
            yield from docstrings(node.body, node.name + ".")
        elif text:
            is_property = any(isinstance(d, ast.Name) and d.id == "property" for d in node.decorator_list)
            functions.setdefault(prefix + node.name, []).append(text if is_property else f"{signature(node)}\n\n{text}")
    for name, texts in functions.items():
        yield name, "\n\n".join(texts)


def main() -> None:
    stub, header = map(pathlib.Path, sys.argv[1:])
    lines = ["// Made by docstrings.py.", "#pragma once", "", "#include <string_view>", "", "namespace alidade::python {", "",
             "struct Docstring {", "  std::string_view name;", "  const char* text;", "};", "inline constexpr Docstring kDocstrings[] = {"]
    for name, text in docstrings(ast.parse(stub.read_text(encoding="utf-8")).body):
        lines.append(f'    {{"{name}", R"doc({text})doc"}},')
    header.write_text("\n".join([*lines, "};", "", "}  // namespace alidade::python", ""]), encoding="utf-8")


if __name__ == "__main__":
    main()
