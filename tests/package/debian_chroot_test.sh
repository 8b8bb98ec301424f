#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Does steps on a bare Debian in a folder of its own: debian_chroot_test.sh SUITE STEPS PACKAGES_DIR CACHE_DIR
#
# SUITE is bookworm, trixie, or host for that of this machine. STEPS is a script in this folder, which finds in /test what
# PACKAGES_DIR holds (made by package.debian, or by scripts/portable), data and examples. CACHE_DIR keeps the bare system and
# the downloaded packages for the next run.
set -euo pipefail
unset CDPATH
skip() { echo "SKIPPED: $*"; exit 0; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
. "$root/scripts/packaging/bare_system.sh"

# ---- inside the namespace: debian_chroot_test.sh --inside SUITE STEPS SYSTEM CACHE MIRROR ------------------------------
if [ "$1" = --inside ]; then
  suite=$2
  steps=$3
  system=$4
  cache=$5
  mirror=$6
  if [ ! -f "$cache/$suite.tar" ]; then
    make_bare_system "$suite" "$system" "$mirror" "$cache/debootstrap.log"
    tar -C "$system" --one-file-system --exclude="./proc/*" --exclude=./test -cf "$cache/$suite.tar.new" .
    mv "$cache/$suite.tar.new" "$cache/$suite.tar"
  else
    tar -C "$system" -xpf "$cache/$suite.tar"
  fi
  prepare_bare_system "$suite" "$system" "$mirror"
  mount --bind "$cache/archives" "$system/var/cache/apt/archives"
  in_bare_system "$system" bash "/test/$steps"
fi

# ---- outside ------------------------------------------------------------------------------------------------------------
suite=$1
steps=$2
packages=$3
cache=$4
. /etc/os-release
[[ "$ID ${VERSION_ID:-}" =~ ^debian\ 1[23]$ ]] || skip "the packages are for Debian 12 and 13, and this is ${PRETTY_NAME:-$ID}"
[ "$suite" != host ] || suite=$VERSION_CODENAME
[ "$(id -u)" -eq 0 ] || skip "only root can make another root folder"
command -v debootstrap >/dev/null || skip "debootstrap was not found; run scripts/setup package"
unshare --mount --pid --fork true 2>/dev/null || skip "this machine allows no namespaces for mounts"
compgen -G "$packages/*" >/dev/null || skip "$packages holds no packages"

mkdir -p "$cache/archives/partial"
cache=$(cd "$cache" && pwd)
mirror=$(debian_mirror)
/usr/lib/apt/apt-helper download-file "${mirror%/}/dists/$suite/Release" "$cache/Release" >/dev/null 2>&1 ||
  skip "the mirror $mirror cannot be reached"

# What a killed run left goes first. The lock is held until all processes of a run have ended.
exec 9>"$cache/lock"
flock 9
rm -rf --one-file-system "$cache"/system.*
system=$(mktemp -d "$cache/system.XXXXXX")
trap 'rm -rf --one-file-system "$system"' EXIT
chmod 755 "$system"
# Debian has no folder of this name.
mkdir "$system/test"
cp "$packages"/* "$root/testdata/checkerboard.yaml" "$here/$steps" "$system/test"
cp -r "$root"/docs/examples/{test_harness,rig} "$root/testdata/checkerboard/images" "$system/test"
cp "$root/testdata/checkerboard/camera.yaml" "$system/test/true_camera.yaml"
unshare --mount --pid --fork --kill-child "$here/debian_chroot_test.sh" --inside "$suite" "$steps" "$system" "$cache" "$mirror"
