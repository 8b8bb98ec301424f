#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the man pages that apps/alidade/man_pages makes against what the program says.

usage: man_pages_test.py PROGRAM

There has to be one page for each command and no other; each has all sections, all flags and examples of --help, and
gets no warning from groff and man. Making the pages twice gives the same bytes. Without help2man, groff or man the
test is skipped (exit code 77).
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

from help_text import all_helps

NUM_PAGES = 25
SECTIONS = ["NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXIT STATUS", "SEE ALSO"]


def files_in(folder):
    """The content of all files, by their path in the folder."""
    content = {}
    for parent, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(parent, name)
            content[os.path.relpath(path, folder)] = open(path, "rb").read()
    return content


def plain(roff):
    """The text of a page as a reader sees it, in one line."""
    text = re.sub(r"\\f[BIR]|\\[&%:]", "", roff)
    return " ".join(text.replace("\\-", "-").replace("\\(aq", "'").split())


def complaints_about(page, roff, help_, pages):
    """Yields what is wrong with one page."""
    title = page.removesuffix(".1").upper().replace("-", "\\-")
    if not re.search(rf'^\.TH {re.escape(title)} "1" "" "alidade [0-9.]+" "Alidade"$', roff, re.MULTILINE):
        yield "its title line lacks the name, section 1 or the version, or has a date"
    found = [section for section in re.findall(r'^\.SH "?(.*?)"?$', roff, re.MULTILINE) if section in SECTIONS]
    if sorted(found) != sorted(SECTIONS):
        yield f"sections {found}; expected {SECTIONS}"
    text = plain(roff)
    for flag in help_.flags:
        if not re.search(rf"(?<![\w-]){flag}(?![\w-])", text):
            yield f"the flag {flag} of --help is missing"
    for flag, choices in help_.choices.items():
        if not all(choice in text for choice in choices):
            yield f"{flag}: not all of {choices} are named"
    for example in re.findall(r"^Example: (.*)$", help_.text, re.MULTILINE):
        if " ".join(example.split()) not in text:
            yield f"the example '{example}' of --help is missing"
    for other in re.findall(r"\\fB([^ ]*?)\\fR\(1\)", roff):
        if plain(other) + ".1" not in pages:
            yield f"it refers to {plain(other)}(1), which does not exist"


def warnings_of(path):
    """What groff, and man as Debian's lintian calls it, say of a page."""
    commands = [["groff", "-man", "-ww", "-Tutf8", path],
                ["man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", "-Z", path]]
    environment = dict(os.environ, LC_ALL="C.UTF-8", MANROFFSEQ="", MANWIDTH="80")
    for command in commands:
        run = subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if run.returncode != 0 or run.stderr:
            yield f"{command[0]}: exit code {run.returncode}: {run.stderr}"


def main():
    program = os.path.abspath(sys.argv[1])
    missing = [tool for tool in ("help2man", "groff", "man") if shutil.which(tool) is None]
    if missing:
        print(f"{' and '.join(missing)} not found (Debian: help2man, groff-base, man-db)")
        return 77
    script = os.path.join(os.path.dirname(__file__), "..", "..", "apps", "alidade", "man_pages")
    wrong = []
    with tempfile.TemporaryDirectory() as scratch:
        made = []
        for name in ("one", "two"):
            folder = os.path.join(scratch, name)
            subprocess.run([script, "help2man", program, folder], check=True)
            made.append(files_in(folder))
        if made[0] != made[1]:
            wrong.append("the pages of two runs differ")
        pages = {name: text.decode("ascii") for name, text in made[0].items()}
        helps = {"-".join(["alidade", *help_.words]) + ".1": help_ for help_ in all_helps(program)}
        for name in sorted(pages.keys() ^ helps.keys()):
            wrong.append(f"{name}: {'no command has this page' if name in pages else 'this page is missing'}")
        for name in sorted(pages.keys() & helps.keys()):
            wrong += [f"{name}: {text}" for text in complaints_about(name, pages[name], helps[name], pages)]
            wrong += [f"{name}: {text}" for text in warnings_of(os.path.join(scratch, "one", name))]
    print("\n".join(wrong))
    print(f"{len(pages)} man pages, {sum(len(h.flags) for h in helps.values())} flags, {len(wrong)} complaints")
    return 1 if wrong or len(pages) != NUM_PAGES else 0


sys.exit(main())
