# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# Functions for bare Debian systems in folders. Callers run as root in a mount namespace of their own, so that all mounts
# end with it, and removing the folder afterwards cannot reach anything else.

# The machine's own mirror of Debian's main archive, or the public one if apt has none.
debian_mirror() {
  local mirror=
  if [ "$(. /etc/os-release && echo "$ID")" = debian ]; then
    mirror=$(apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Identifier: Packages' |
             awk '$2 ~ /^[a-z]+$/ && $3 == "main" && $1 ~ /debian\/?$/ {print $1; exit}')
  fi
  echo "${mirror:-http://deb.debian.org/debian}"
}

# make_bare_system SUITE FOLDER MIRROR LOG
make_bare_system() {
  debootstrap --variant=minbase "$1" "$2" "$3" >"$4" 2>&1 ||
    { tail -n 20 "$4" >&2; echo "debootstrap failed; see $4" >&2; return 1; }
}

# prepare_bare_system SUITE FOLDER MIRROR: gives it the machine's mirrors, proxy and limits, and lets no service start.
prepare_bare_system() {
  local suite=$1 system=$2 mirror=$3 host
  host=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
  mount -t proc proc "$system/proc"
  {
    echo "deb $mirror $suite main"
    [ "$suite" = sid ] || apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Identifier: Packages' |
      sed -nE "s/ $host-(updates|security) main$/ $suite-\1 main/p" | sort -u
  } >"$system/etc/apt/sources.list"
  apt-config dump | grep -E '^Acquire::(https?::(Proxy|Timeout)|Check-Valid-Until|Check-Date|Retries)' \
    >"$system/etc/apt/apt.conf.d/90machine" || true
  cat >"$system/etc/apt/apt.conf.d/91bare" <<'END'
APT::Install-Recommends "false";
Acquire::Languages "none";
Binary::apt-get::APT::Keep-Downloaded-Packages "true";
END
  echo force-unsafe-io >"$system/etc/dpkg/dpkg.cfg.d/bare"  # a power failure may spoil this system
  printf '#!/bin/sh\nexit 101\n' >"$system/usr/sbin/policy-rc.d"
  chmod +x "$system/usr/sbin/policy-rc.d"
  cp -L /etc/resolv.conf /etc/hosts "$system/etc/"
}

# in_bare_system FOLDER COMMAND...: replaces the shell by the command.
in_bare_system() {
  local system=$1 name proxies=()
  shift
  for name in http_proxy https_proxy no_proxy; do
    [ -z "${!name:-}" ] || proxies+=("$name=${!name}")
  done
  exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "${proxies[@]}" \
    chroot "$system" "$@"
}
