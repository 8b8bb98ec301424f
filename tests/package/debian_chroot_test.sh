#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Debian packages on a bare Debian of this machine's release in a folder of its own, uses them, removes them,
# and looks for what is left: debian_chroot_test.sh PACKAGES_DIR
#
# PACKAGES_DIR holds the packages (debian_test.sh). Beside it, a folder debian_cache keeps the bare system and the
# downloaded packages for the next run.
set -euo pipefail
unset CDPATH
skip() { echo "SKIPPED: $*"; exit 0; }
failed() { echo "$*" >&2; exit 1; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

. "$here/../../scripts/packaging/bare_system.sh"

# ---- inside the namespace: debian_chroot_test.sh --inside SYSTEM CACHE MIRROR SUITE ------------------------------------
if [ "$1" = --inside ]; then
  system=$2
  cache=$3
  mirror=$4
  suite=$5
  if [ ! -f "$cache/bare.tar" ]; then
    make_bare_system "$suite" "$system" "$mirror" "$cache/debootstrap.log"
    tar -C "$system" --one-file-system --exclude="./proc/*" --exclude=./test -cf "$cache/bare.tar.new" .
    mv "$cache/bare.tar.new" "$cache/bare.tar"
  else
    tar -C "$system" -xpf "$cache/bare.tar"
  fi
  prepare_bare_system "$suite" "$system" "$mirror"
  mount --bind "$cache/archives" "$system/var/cache/apt/archives"
  in_bare_system "$system" bash /test/debian_chroot_steps.sh
fi

# ---- outside ------------------------------------------------------------------------------------------------------------
packages=$1
root=$(cd "$here/../.." && pwd)
. /etc/os-release
[[ "$ID ${VERSION_ID:-}" =~ ^debian\ 1[23]$ ]] || skip "the packages are for Debian 12 and 13, and this is ${PRETTY_NAME:-$ID}"
[ "$(id -u)" -eq 0 ] || skip "only root can make another root folder"
command -v debootstrap >/dev/null || skip "debootstrap was not found; run scripts/setup package"
unshare --mount --pid --fork true 2>/dev/null || skip "this machine allows no namespaces for mounts"
compgen -G "$packages/*.deb" >/dev/null || skip "$packages holds no packages (see package.debian)"

cache=$packages/../debian_cache
mkdir -p "$cache/archives/partial"
cache=$(cd "$cache" && pwd)
mirror=$(debian_mirror)
[ -n "$mirror" ] || skip "apt has no source for $VERSION_CODENAME main"
/usr/lib/apt/apt-helper download-file "${mirror%/}/dists/$VERSION_CODENAME/Release" "$cache/Release" >/dev/null 2>&1 ||
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
cp "$packages"/*.deb "$root/testdata/checkerboard.yaml" "$here/debian_chroot_steps.sh" "$system/test"
cp -r "$root"/docs/examples/{test_harness,rig} "$system/test"
cp "$root/testdata/checkerboard/camera.yaml" "$system/test/true_camera.yaml"
unshare --mount --pid --fork --kill-child "$here/debian_chroot_test.sh" --inside "$system" "$cache" "$mirror" "$VERSION_CODENAME"
