#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Completes command lines of alidade in bash, zsh or fish, with the files that are installed for them.

usage: completion_test.py SHELL PROGRAM

What is expected comes from the program's --help. Where the shell is not installed, the test is skipped (exit code 77).
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

from help_text import all_helps

FILES, FOLDERS = ["camera.yaml", "notes.txt"], ["photos", "rigs"]
# Lines with fixed answers, lists of commands, the flags of each command, and the values of flags that have a list.
NUM_CASES = 14 + 3 + 25 + 57

# bash completes files and folders itself, when the function asks for it.
BASH = """
source "$FOLDER/alidade.bash"
compopt() {
  case "$*" in
    '-o default') compgen -f -- "${COMP_WORDS[COMP_CWORD]}" ;;
    '-o dirnames') compgen -d -- "${COMP_WORDS[COMP_CWORD]}" ;;
    *) echo "unexpected: compopt $*" ;;
  esac
}
[ "$(complete -p alidade)" = 'complete -F _alidade alidade' ] || echo 'no completion is registered'
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
_alidade
for reply in "${COMPREPLY[@]}"; do printf '%s\\n' "$reply"; done
"""

# The line is put into the editor of an interactive shell, and what would be offered is written to a file.
ZSH = """
fpath=($FOLDER $fpath)
autoload -Uz compinit
compinit -u -C -d $ZDOTDIR/dump  # which is made once
zstyle ':completion:*' completer _complete
compadd() {
  if [[ ${@[1,(i)(-|--)]} == *-(O|A|D)* ]]; then
    builtin compadd "$@"
    return
  fi
  local -a offered
  builtin compadd -O offered "$@"
  (( $#offered )) && print -l -- $offered >>$ANSWER
  builtin compadd "$@"
}
zle-line-init() {
  BUFFER=$LINE
  CURSOR=$#BUFFER
  zle complete-word
  exit
}
zle -N zle-line-init
"""

FISH = """
source $FOLDER/alidade.fish
complete -C "$LINE"
"""


def bash(line, folder, work):
    words = [word for word in re.split(r" |(=)", line) if word is not None and word != ""]
    if line[-1] in " =":
        words += [""] if line[-1] == " " else []
    run = subprocess.run(["bash", "--norc", "-c", BASH, "bash", *words], cwd=work, env=dict(os.environ, FOLDER=folder),
                         capture_output=True, text=True)
    return run.stdout.split("\n"), run.stderr


def zsh(line, folder, work):
    home = os.path.join(work, ".zsh")
    answer = os.path.join(home, "answer")
    if not os.path.isdir(home):
        os.mkdir(home)
        open(os.path.join(home, ".zshrc"), "w", encoding="utf-8").write(ZSH)
    open(answer, "w", encoding="utf-8").close()
    environment = dict(os.environ, ZDOTDIR=home, FOLDER=folder, ANSWER=answer, LINE=line, TERM="dumb")
    terminal, child = os.openpty()
    run = subprocess.Popen(["zsh", "-d", "-i"], cwd=work, env=environment, stdin=child, stdout=child, stderr=child,
                           start_new_session=True)
    os.close(child)
    printed = b""
    while True:
        try:
            more = os.read(terminal, 4096)
        except OSError:  # the shell has ended
            break
        if not more:
            break
        printed += more
    run.wait()
    os.close(terminal)
    # "_arguments:comparguments:325: invalid argument: ..."
    problems = [text for text in printed.decode().splitlines() if re.match(r"[^ ]*:\d+: ", text)]
    return open(answer, encoding="utf-8").read().split("\n"), "".join(problems)


def fish(line, folder, work):
    environment = dict(os.environ, FOLDER=folder, LINE=line, XDG_DATA_HOME=work + "/.none", HOME=work + "/.none")
    run = subprocess.run(["fish", "--no-config", "-c", FISH], cwd=work, env=environment, capture_output=True, text=True)
    return run.stdout.split("\n"), run.stderr


def offered(shell, line, folder, work):
    """What the shell offers for the last word, without descriptions and marks, and what went wrong."""
    lines, problem = {"bash": bash, "zsh": zsh, "fish": fish}[shell](line, folder, work)
    start = line.split(" ")[-1].split("=")[0] + "=" if "=" in line.split(" ")[-1] else ""
    words = {text.split("\t")[0].removeprefix(start).rstrip("/").removesuffix("=") for text in lines}
    return words - {""}, problem


def cases(helps):
    """Yields (line, all words that are to be offered)."""
    of = {" ".join(help_.words): help_ for help_ in helps}
    yield "alidade cal", {"calibrate"}
    yield "alidade un", {"undistort", "unproject"}
    yield "alidade nonsen", set()
    yield "alidade rig tri", {"triangulate"}
    yield "alidade help rig rec", {"rectify"}
    yield "alidade help calibrate ", set()
    yield "alidade rig calibrate --mod", {"--model"}
    yield "alidade calibrate photos --model ra", {"radtan", "rational"}
    yield "alidade calibrate --board-shape=un", {"uneven"}
    yield "alidade rig rectify --keep ", {"all", "valid"}
    yield "alidade validate cam", {"camera.yaml"}
    yield "alidade diff camera.yaml ", {*FILES, *FOLDERS}
    yield "alidade calibrate photos --cache ", {*FOLDERS}
    yield "alidade calibrate photos --tolerance ", set()
    yield "alidade ", set(of[""].commands)
    yield "alidade rig ", set(of["rig"].commands)
    yield "alidade help ", set(of[""].commands)
    for help_ in helps:
        long_flags = {flag for flag in help_.flags if flag.startswith("--")}
        yield " ".join(["alidade", *help_.words, "--"]), long_flags
        for flag, choices in help_.choices.items():
            yield " ".join(["alidade", *help_.words, flag, ""]), set(choices)


def main():
    shell, program = sys.argv[1], os.path.abspath(sys.argv[2])
    folder = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", "apps", "alidade", "completion"))
    os.environ["PATH"] = os.path.dirname(program) + ":" + os.environ["PATH"]  # the completions call the program
    if shutil.which(shell) is None:
        print(f"{shell} is not installed")
        return 77
    num_checked = num_wrong = 0
    with tempfile.TemporaryDirectory() as work:
        for name in FILES:
            open(os.path.join(work, name), "w", encoding="utf-8").close()
        for name in FOLDERS:
            os.mkdir(os.path.join(work, name))
        for line, expected in cases(all_helps(program)):
            words, problem = offered(shell, line, folder, work)
            num_checked += 1
            if words != expected or problem:
                num_wrong += 1
                print(f"'{line}': offers {sorted(words)}; expected {sorted(expected)}. {problem}")
    print(f"{shell}: {num_checked} lines completed, {num_wrong} wrong")
    return 0 if num_checked == NUM_CASES and num_wrong == 0 else 1


sys.exit(main())
