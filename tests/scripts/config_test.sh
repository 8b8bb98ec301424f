#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs the "# Use:" line of every file in config/ as it is written, once with the values of the file and once with all
# keys that are commented out there: config_test.sh ALIDADE
set -euo pipefail
unset CDPATH
alidade=$(realpath "$1")
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scratch=$(mktemp -d)
trap 'rm -r "$scratch"' EXIT
alidade() { "$alidade" "$@"; }

run_use_line() {  # FILE, in the folder of the example
  local use
  use=$(sed -n 's/^# Use: //p' "$1")
  if ! eval "$use" >"$scratch/log" 2>&1; then
    echo "$1: '$use' fails:" >&2
    cat "$scratch/log" >&2
    exit 1
  fi
}

count=0
while read -r file; do
  for keys in as_written all; do
    folder=$scratch/$keys/${file//\//_}
    mkdir -p "$folder/photos"
    cd "$folder"
    cp -r "$root/config" .
    cp "$root"/testdata/checkerboard/images/view_00[1-6].png photos
    for name in camera a b start other; do cp "$root/testdata/checkerboard/camera.yaml" $name.yaml; done
    [ $keys = as_written ] || sed -i -E 's/^# ([a-z-]+: )/\1/' "$file"
    sed -i 's/random: 12/random: 1/' config/scene.yaml  # one rendered view shows as much as twelve
    sed -i 's/frames: 60/frames: 2/' config/footage.yaml
    run_use_line "$file"
  done
  count=$((count + 1))
done < <(cd "$root" && grep -rl '^# Use: alidade ' config)
[ "$count" -ge 7 ] || { echo "config/: only $count files have a line '# Use: alidade ...'; expected 7" >&2; exit 1; }
echo "config: the Use lines of $count files run"
