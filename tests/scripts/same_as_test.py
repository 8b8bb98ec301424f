#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""scripts/same_as finds nothing between a program and itself, and names what a slightly different one does differently.

usage: same_as_test.py PROGRAM
"""
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# Other programs: one digit of standard output, one digit of a written file, and the exit code.
STUB = """#!/bin/sh
"{program}" "$@" >"$0.out"
code=$?
case "$*" in
  *"-o board1.pdf --json") sed "s/1/2/" "$0.out" ;;
  *"-o board2.svg --json") cat "$0.out"; sed -i "s/841.889764/841.889765/" board2.svg ;;
  "board nonsense:"*) cat "$0.out"; code=7 ;;
  *) cat "$0.out" ;;
esac
exit $code
"""


def compare(folder, *programs):
    words = [sys.executable, os.path.join(ROOT, "scripts", "same_as"), *programs, "--only", "printed", "--jobs", "1"]
    environment = dict(os.environ, ALIDADE_BUILD_DIR=os.path.join(folder, "builds"))
    return subprocess.run(words, env=environment, capture_output=True, text=True)


def expect(is_true, what, run):
    if not is_true:
        sys.exit(f"{what}; it printed:\n{run.stdout}{run.stderr}")


def main():
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        same = compare(folder, program, program)
        expect(same.returncode == 0, f"the program and itself: exit code {same.returncode}, expected 0", same)
        expect(", 0 differ" in same.stdout, "the program and itself: expected '0 differ'", same)
        expect(not os.listdir(os.path.join(folder, "builds")), "files of equal results remain", same)
        stub = os.path.join(folder, "stub")
        with open(stub, "w", encoding="utf-8") as out:
            out.write(STUB.format(program=program))
        os.chmod(stub, 0o755)
        other = compare(folder, program, stub)
        expect(other.returncode == 3, f"another program: exit code {other.returncode}, expected 3", other)
        for text in ("-o board1.pdf --json\n  standard output: line ", "-o board2.svg --json\n  board2.svg: line ",
                     "-o none.pdf\n  exit code: line 1\n", ", 3 differ"):
            expect(text in other.stdout, f"another program: expected '{text}'", other)


main()
