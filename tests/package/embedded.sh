#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds a project that contains Alidade's sources (embedded/), unlike the other tests: as an ordinary user who may not
# write to the sources, in a folder whose name has spaces and letters beyond ASCII, with shared libraries, for this
# machine's own processor, and through ccache where it is installed: embedded.sh SOURCE_DIR WORK_DIR COMPILER
set -euo pipefail
failed() { echo "$*" >&2; exit 1; }
source=$1
work=$2/embedded
rm -rf "$work"
folder="$work/ein Ordner für 相机"
mkdir -p "$folder"
as_user=()
if [ "$(id -u)" -eq 0 ]; then
  ! runuser -u nobody -- test -w "$source/CMakeLists.txt" || failed "nobody may write to $source"
  if runuser -u nobody -- test -r "$source/CMakeLists.txt" && runuser -u nobody -- test -x "$work"; then
    as_user=(runuser -u nobody -- env HOME="$folder")
    chown -R nobody "$work"
  fi
fi
launcher=()
! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
quietly() { "${as_user[@]}" "$@" >"$work.log" 2>&1 || { tail -n 50 "$work.log" >&2; failed "$* failed"; }; }
before=$(ls -lR --time-style=full-iso "$source/src" "$source/apps" | cksum)
quietly cmake -S "$source/tests/package/embedded" -B "$folder/build" -G Ninja -DALIDADE_SOURCE="$source" \
  -DCMAKE_CXX_COMPILER="$3" -DCMAKE_CXX_FLAGS="-O0 -march=native" -DBUILD_SHARED_LIBS=ON "${launcher[@]}"
quietly cmake --build "$folder/build" --parallel "$(nproc)" --target embedded
quietly env DESTDIR="$folder/staged" cmake --install "$folder/build/_deps/alidade-build/src/alidade/core" --component program
[ "$before" = "$(ls -lR --time-style=full-iso "$source/src" "$source/apps" | cksum)" ] || failed "the build wrote to $source"
compgen -G "$folder/build/_deps/alidade-build/src/alidade/camera/libalidade_camera.so*" >/dev/null || failed "no shared library was built"
compgen -G "$folder/staged/usr/local/lib*/libalidade_core.so.*" >/dev/null || failed "DESTDIR holds no shared library"
found=$("$folder/build/embedded" "$source/testdata/checkerboard/camera.yaml")
[ "$found" = "375.802 211.503" ] || failed "the program prints '$found', not the pixel that README.md shows"
