#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What debian_chroot_test.sh does with the ready program and the wheels of scripts/portable in /test, as root of a bare
# Debian.
set -euo pipefail
cd /test
failed() { echo "$*" >&2; exit 1; }
step() { printf '%3d s  %s\n' $SECONDS "$*"; }
quietly() {  # shows the output of a command that fails
  "$@" >/test/log 2>&1 || { cat /test/log >&2; failed "$* failed"; }
}

step "unpacking and using the program"
quietly apt-get update
quietly apt-get install -y xz-utils
tar -xf alidade-*-linux-x86_64.tar.xz
program=$(echo alidade-*-linux-x86_64/bin/alidade)
[ "$(ldd "$program" | grep -vcE '(linux-vdso|libc|libm|ld-linux-x86-64)\.so')" -eq 0 ] || failed "$program needs: $(ldd "$program")"
$program --version
$program calibrate images --board checkerboard:9x6:25mm -o camera.yaml --report page.html >messages 2>&1
quietly $program diff camera.yaml true_camera.yaml --tolerance 0.5
grep -q '</html>' page.html || failed "page.html is no complete page"
for format in pdf svg png; do
  $program board checkerboard:9x6:25mm -o board.$format >>messages 2>&1
done
! grep -i fontconfig messages || failed "a system without fonts is not silent"

step "installing the wheel"
quietly apt-get install -y python3-numpy python3-pip python3-venv
python3 -m venv --system-site-packages venv
quietly venv/bin/pip install --no-index --find-links . alidade
step "using the Python module"
venv/bin/python -c '
import alidade
alidade.calibrate("images", "checkerboard:9x6:25mm").save("python.yaml")'
cmp camera.yaml python.yaml
step "done"
