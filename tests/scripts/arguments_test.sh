#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Every script answers --help and refuses an argument that it does not know. Neither installs, builds or runs anything.
set -euo pipefail
unset CDPATH
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scratch=$(mktemp -d)
trap 'rm -r "$scratch"' EXIT
failed() { echo "$*; it printed:" >&2; cat "$scratch/out" >&2; exit 1; }

# Stand-ins for all programs that a script may start first.
for program in apt-get clang-format cmake ctest dpkg-query git sudo; do
  printf '#!/bin/sh\necho %s >>"%s/started"\nexit 1\n' "$program" "$scratch" >"$scratch/$program"
  chmod +x "$scratch/$program"
done
# Asking git whether a revision exists starts nothing.
printf '#!/bin/sh\ncase "$*" in *rev-parse*) exit 1 ;; esac\necho git >>"%s/started"\nexit 1\n' "$scratch" >"$scratch/git"
export PATH=$scratch:$PATH

count=0
for script in "$root"/scripts/*; do
  [ -f "$script" ] && [ -x "$script" ] || continue
  for flag in --help -h; do
    "$script" "$flag" >"$scratch/out" 2>&1 || failed "$script $flag: exit code $?, expected 0"
    for text in "usage: scripts/" "example: "; do
      grep -q "$text" "$scratch/out" || failed "$script $flag: its help has no '$text'"
    done
  done
  code=0
  "$script" nonsense >"$scratch/out" 2>&1 || code=$?
  [ $code -eq 2 ] || failed "$script nonsense: exit code $code, expected 2"
  grep -q "nonsense.*--help" "$scratch/out" || failed "$script nonsense: the message names no next step"
  [ ! -e "$scratch/started" ] || failed "$script starts $(sort -u "$scratch/started" | xargs)"
  count=$((count + 1))
done
[ $count -ge 10 ] || { echo "only $count scripts found" >&2; exit 1; }
echo "scripts: the arguments of $count scripts are checked"
