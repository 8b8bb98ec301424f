#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What debian_chroot_test.sh does as root of a bare Debian: installs, uses and removes the packages in /test.
set -euo pipefail
cd /test
failed() { echo "$*" >&2; exit 1; }
step() { printf '%3d s  %s\n' $SECONDS "$*"; }
quietly() {  # shows the output of a command that fails
  "$@" >/test/log 2>&1 || { cat /test/log >&2; failed "$* failed"; }
}

step "apt-get update"
quietly apt-get update
step "installing alidade and python3-alidade"
quietly apt-get install -y ./alidade_*.deb ./python3-alidade_*.deb
step "using the program"
version=$(dpkg-query -W -f '${Version}' alidade)
[ "$(alidade --version)" = "alidade $version" ] || failed "alidade --version prints '$(alidade --version)', not 'alidade $version'"
begin=$(date +%s%N)
alidade --version >/dev/null
echo "alidade --version takes $((($(date +%s%N) - begin) / 1000000)) ms"
quietly alidade simulate checkerboard.yaml -o scene
quietly alidade calibrate scene/images --board checkerboard:9x6:25mm -o camera.yaml

step "using the Python module"
cat >project.py <<'END'
import alidade
import numpy as np

points = np.array([[x, y, 1.0] for x in (-0.3, 0, 0.3) for y in (-0.2, 0, 0.2)])
found, found_status = alidade.load_camera("camera.yaml").project(points)
true, true_status = alidade.load_camera("true_camera.yaml").project(points)
assert found.shape == (9, 2) and not found_status.any() and not true_status.any()
worst_px = np.linalg.norm(found - true, axis=1).max()
print(f"the calibrated camera differs from the true one by up to {worst_px:.3f} px")
assert worst_px < 0.5
END
python3 project.py

step "installing libalidade-dev, g++, cmake and pkgconf"
quietly apt-get install -y ./libalidade-dev_*.deb g++ cmake make pkgconf
for project in test_harness rig; do
  step "building and running a program: $project"
  quietly cmake -S $project -B build/$project
  quietly cmake --build build/$project
  quietly build/$project/$project build/$project
done
step "building and running a program by pkg-config, with all of the archives"
# shellcheck disable=SC2046  # several words
quietly g++ -std=c++20 rig/rig.cc -o by_pkg_config -Wl,--whole-archive $(pkg-config --cflags --libs alidade) -Wl,--no-whole-archive
quietly ./by_pkg_config .

step "removing the packages"
names=(alidade libalidade-dev python3-alidade)
dpkg-query -L "${names[@]}" | grep '^/' | sort -u >paths
quietly apt-get purge -y "${names[@]}"
num_paths=0
while read -r path; do
  num_paths=$((num_paths + 1))
  [ -e "$path" ] || [ -L "$path" ] || continue
  dpkg-query -S "$path" >/dev/null 2>&1 || [ "$path" = /. ] || failed "$path is left behind"
done <paths
[ $num_paths -ge 200 ] || failed "the packages had only $num_paths files and folders"
left=$(find / -xdev -path /test -prune -o -path /proc -prune -o -name '*alidade*' -print)
[ -z "$left" ] || failed "this is left behind: $left"
for name in "${names[@]}"; do
  ! dpkg-query -W -f '${Status}' "$name" >/dev/null 2>&1 || failed "dpkg still knows $name"
done
step "nothing of $num_paths files and folders is left"
