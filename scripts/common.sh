# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# Every shell script in this folder reads this file first. It sets $root, the folder of the project, and answers --help
# and -h with the comment at the top of the script before the script does anything.
unset CDPATH
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
script=$(basename "$0")

# Ends the script because of a wrong argument: refuse "unknown argument '--fast'; expected --tidy or nothing"
refuse() {
  echo "$script: $1. Run scripts/$script --help for an example." >&2
  exit 2
}

for argument in "$@"; do
  case $argument in
    --) break ;;
    -h | --help)
      awk 'NR > 1 && !/^#/ {exit} NR > 1 {sub(/^# ?/, ""); print}' "$0"
      exit 0
      ;;
  esac
done
