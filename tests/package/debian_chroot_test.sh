#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Debian packages on a bare Debian 12 in a folder of its own, uses them, removes them, and looks for what is
# left: debian_chroot_test.sh PACKAGES_DIR
#
# PACKAGES_DIR holds the packages (debian_test.sh). Beside it, a folder debian_cache keeps the bare system and the
# downloaded packages for the next run. The work happens in a mount namespace: no mount is visible outside of it, and
# all end with it, so that removing the folder afterwards cannot reach anything else.
set -euo pipefail
unset CDPATH
skip() { echo "SKIPPED: $*"; exit 0; }
failed() { echo "$*" >&2; exit 1; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

# ---- inside the namespace: debian_chroot_test.sh --inside SYSTEM CACHE MIRROR -------------------------------------------
if [ "$1" = --inside ]; then
  system=$2
  cache=$3
  mirror=$4
  if [ ! -f "$cache/bare.tar" ]; then
    debootstrap --variant=minbase bookworm "$system" "$mirror" >"$cache/debootstrap.log" 2>&1 ||
      { tail -n 20 "$cache/debootstrap.log" >&2; failed "debootstrap failed"; }
    tar -C "$system" --one-file-system --exclude="./proc/*" --exclude=./test -cf "$cache/bare.tar.new" .
    mv "$cache/bare.tar.new" "$cache/bare.tar"
  else
    tar -C "$system" -xpf "$cache/bare.tar"
  fi
  mount -t proc proc "$system/proc"
  mount --bind "$cache/archives" "$system/var/cache/apt/archives"

  # The machine's own mirror, proxy and limits.
  apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Identifier: Packages' |
    grep -E ' bookworm(-updates|-security)? main$' | sort -u >"$system/etc/apt/sources.list"
  apt-config dump | grep -E '^Acquire::(https?::(Proxy|Timeout)|Check-Valid-Until|Check-Date|Retries)' \
    >"$system/etc/apt/apt.conf.d/90machine" || true
  cat >"$system/etc/apt/apt.conf.d/91test" <<'END'
APT::Install-Recommends "false";
Acquire::Languages "none";
Binary::apt-get::APT::Keep-Downloaded-Packages "true";
END
  echo force-unsafe-io >"$system/etc/dpkg/dpkg.cfg.d/test"  # a power failure may spoil this system
  printf '#!/bin/sh\nexit 101\n' >"$system/usr/sbin/policy-rc.d"  # no service starts
  chmod +x "$system/usr/sbin/policy-rc.d"
  cp -L /etc/resolv.conf /etc/hosts "$system/etc/"
  proxies=()
  for name in http_proxy https_proxy no_proxy; do
    [ -z "${!name:-}" ] || proxies+=("$name=${!name}")
  done
  exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "${proxies[@]}" \
    chroot "$system" bash /test/debian_chroot_steps.sh
fi

# ---- outside ------------------------------------------------------------------------------------------------------------
packages=$1
root=$(cd "$here/../.." && pwd)
. /etc/os-release
[ "$ID ${VERSION_ID:-}" = "debian 12" ] || skip "the packages are for Debian 12, and this is ${PRETTY_NAME:-$ID}"
[ "$(id -u)" -eq 0 ] || skip "only root can make another root folder"
command -v debootstrap >/dev/null || skip "debootstrap was not found; run scripts/setup package"
unshare --mount --pid --fork true 2>/dev/null || skip "this machine allows no namespaces for mounts"
compgen -G "$packages/*.deb" >/dev/null || skip "$packages holds no packages (see package.debian)"

cache=$packages/../debian_cache
mkdir -p "$cache/archives/partial"
cache=$(cd "$cache" && pwd)
mirror=$(apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Identifier: Packages' |
         awk '$2 == "bookworm" && $3 == "main" {print $1; exit}')
[ -n "$mirror" ] || skip "apt has no source for bookworm main"
/usr/lib/apt/apt-helper download-file "${mirror%/}/dists/bookworm/Release" "$cache/Release" >/dev/null 2>&1 ||
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
unshare --mount --pid --fork --kill-child "$here/debian_chroot_test.sh" --inside "$system" "$cache" "$mirror"
