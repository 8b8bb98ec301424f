#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the man pages that the build made against what the program says now.

usage: man_pages_test.py PROGRAM FOLDER

FOLDER is what the build made with "alidade help --write". There has to be one page for each command and no other; each
has all sections and all flags of --help, has the bytes that the program writes now, and gets no warning from groff
and man. Without these two programs the test checks the rest and is skipped at the end (exit code 77).
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

from help_text import all_helps

NUM_PAGES = 20
SECTIONS = ["NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXIT STATUS", "EXAMPLES", "SEE ALSO"]


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
    if not re.match(rf'\.TH {re.escape(title)} 1 "" "alidade [0-9.]+" "Alidade"\n', roff):
        yield f"its first line is {roff.splitlines()[0]}; expected the title, section 1, no date and the version"
    found = [section for section in re.findall(r"^\.SH (.*)$", roff, re.MULTILINE) if section in SECTIONS]
    if found != SECTIONS:
        yield f"sections {found}; expected {SECTIONS}"
    entries = re.findall(r"^\.TP\n(.*)$", roff, re.MULTILINE)
    documented = [plain(name) for entry in entries for name in re.findall(r"\\fB(.*?)\\fR", entry)]
    for flag in help_.flags:
        if flag not in documented:
            yield f"the flag {flag} of --help is missing"
    for flag, choices in help_.choices.items():
        if not all(choice in plain(roff) for choice in choices):
            yield f"{flag}: not all of {choices} are named"
    for example in re.findall(r"^Example: (.*)$", help_.text, re.MULTILINE):
        if example not in plain(roff):
            yield f"the example '{example}' of --help is missing"
    for other in re.findall(r"\\%\\fB(.*?)\\fR\(1\)", roff):
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
    program, built = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    wrong = []
    with tempfile.TemporaryDirectory() as scratch:
        subprocess.run([program, "help", "--write", scratch], check=True)
        made, now = files_in(built), files_in(scratch)
    for name in sorted(made.keys() | now.keys()):
        if made.get(name) != now.get(name):
            wrong.append(f"{name}: differs from what 'alidade help --write' writes now; build again")
    pages = {os.path.basename(name): text.decode("ascii") for name, text in made.items() if name.startswith("man/man1/")}
    helps = {"-".join(["alidade", *help_.words]) + ".1": help_ for help_ in all_helps(program)}
    for name in sorted(pages.keys() ^ helps.keys()):
        wrong.append(f"{name}: {'no command has this page' if name in pages else 'this page is missing'}")
    for name in sorted(pages.keys() & helps.keys()):
        wrong += [f"{name}: {text}" for text in complaints_about(name, pages[name], helps[name], pages)]
    missing = [tool for tool in ("groff", "man") if shutil.which(tool) is None]
    if not missing:
        for name in sorted(pages):
            wrong += [f"{name}: {text}" for text in warnings_of(os.path.join(built, "man", "man1", name))]
    print("\n".join(wrong))
    print(f"{len(pages)} man pages, {sum(len(h.flags) for h in helps.values())} flags, {len(wrong)} complaints")
    if wrong or len(pages) != NUM_PAGES:
        return 1
    if missing:
        print(f"{' and '.join(missing)} not found (Debian: groff-base, man-db): warnings were not looked for")
        return 77
    return 0


sys.exit(main())
