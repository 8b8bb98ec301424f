#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the Debian packages of what was built, checks them with lintian, and checks what they hold and need:
# debian_test.sh BUILD_DIR INSTALL_DIR PACKAGES_DIR
#
# INSTALL_DIR is a plain installation of the same build. The packages must hold all of it, each file in one of them.
set -euo pipefail
unset CDPATH
build=$1
installed=$2
packages=$3
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
skip() { echo "SKIPPED: $*"; exit 0; }
failed() { echo "$*" >&2; exit 1; }

. /etc/os-release
[[ "$ID ${VERSION_ID:-}" =~ ^debian\ 1[23]$ ]] || skip "the packages are for Debian 12 and 13, and this is ${PRETTY_NAME:-$ID}"
for tool in dpkg-shlibdeps lintian cpack; do
  command -v $tool >/dev/null || skip "$tool was not found; run scripts/setup package"
done
for setting in ALIDADE_BUILD_PYTHON:BOOL=ON CMAKE_BUILD_TYPE:STRING=Release ALIDADE_SANITIZE:STRING=; do
  grep -qx "$setting" "$build/CMakeCache.txt" || skip "only builds with $setting are packed"
done

scratch=$(mktemp -d)
trap 'rm -r "$scratch"' EXIT
rm -f "$packages"/*.deb
"$root/scripts/package" --from "$build" --into "$packages" | tee "$scratch/log"
version=$(sed -n 's/^project(alidade VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
[ "$(dpkg-parsechangelog -l "$root/scripts/packaging/debian/changelog" -S Version)" = "$version" ] ||
  failed "the last entry of scripts/packaging/debian/changelog is not for version $version; add one"
date=$(date -u -d "@$(dpkg-parsechangelog -l "$root/scripts/packaging/debian/changelog" -S Timestamp)" '+%F %R')
multiarch=$(dpkg-architecture -q DEB_HOST_MULTIARCH)

# What each package may hold, as a pattern for the paths of files.
declare -A allowed=(
  [alidade]="usr/bin/alidade|usr/share/(alidade/workflow|doc/alidade|man/man[1-8]|bash-completion/completions|zsh/vendor-completions|fish/vendor_completions.d)/.*"
  [libalidade-dev]="usr/include/alidade/.*\.h|usr/lib/$multiarch/(libalidade_[a-z]*\.a|cmake/alidade/.*\.cmake|pkgconfig/alidade[a-z-]*\.pc)|usr/share/doc/libalidade-dev/.*"
  [python3-alidade]="usr/lib/python3/dist-packages/alidade/.*|usr/share/doc/python3-alidade/.*"
)
num_files=0
for name in alidade libalidade-dev python3-alidade; do
  file=$packages/${name}_${version}_$(dpkg --print-architecture).deb
  [ -f "$file" ] || failed "scripts/package made no $file"
  TZ=UTC dpkg-deb --contents "$file" >"$scratch/contents"
  dates=$(awk '{print $4, $5}' "$scratch/contents" | sort -u)
  [ "$dates" = "$date" ] || failed "$name: the dates of files are not that of the changelog, $date: $dates"
  owners=$(awk '{print $2}' "$scratch/contents" | sort -u)
  [ "$owners" = root/root ] || failed "$name: the files belong to $owners, not to root/root"
  if grep -E '^d' "$scratch/contents" | grep -v '^drwxr-xr-x '; then failed "$name: the folders above are not for all users"; fi
  sed -n 's|^-.* \./||p' "$scratch/contents" >"$scratch/$name"
  if [ "$name" = alidade ]; then  # what Snakemake starts
    for path in step profiles/slurm/status profiles/slurm/submit; do
      grep -q "^-rwxr-xr-x .* ./usr/share/alidade/workflow/$path$" "$scratch/contents" || failed "$name has no program workflow/$path"
    done
  fi
  if grep -vxE "${allowed[$name]}" "$scratch/$name"; then failed "$name: the files above do not belong there"; fi
  for path in copyright changelog.gz; do
    grep -qx "usr/share/doc/$name/$path" "$scratch/$name" || failed "$name has no $path"
  done
  grep -vE "^usr/share/(doc/$name/(copyright|changelog\.gz)|lintian/overrides/.*)$" "$scratch/$name" >>"$scratch/packed"
  dpkg-deb --raw-extract "$file" "$scratch/raw"
  (cd "$scratch/raw" && md5sum --check --quiet DEBIAN/md5sums) || failed "$name: files differ from its md5sums"
  [ "$(wc -l <"$scratch/raw/DEBIAN/md5sums")" -eq "$(wc -l <"$scratch/$name")" ] || failed "$name: md5sums lists other files"
  rm -r "$scratch/raw"
  num_files=$((num_files + $(wc -l <"$scratch/$name")))
done

# A plain installation goes below another prefix, which has other folders for libraries and Python, and it compresses no
# manual pages.
(cd "$installed" && find . -type f -printf 'usr/%P\n') |
  sed -E "s,^(usr/share/man/.*\.[1-8])$,\1.gz,; s,^usr/lib/(lib|cmake|pkgconfig),usr/lib/$multiarch/\1,; s,^usr/lib/python3\.[0-9]+/,usr/lib/python3/," |
  sort >"$scratch/plain"
sort "$scratch/packed" | diff "$scratch/plain" - ||
  failed "a plain installation (<) and the packages (>) hold different files; give each install() a COMPONENT: program, development or python"

field() { dpkg-deb --field "$packages/${1}_$version"_*.deb "$2"; }
num_needs=0
needs() {  # PACKAGE DEPENDENCY...
  local name=$1 depends dependency
  shift
  depends=", $(field "$name" Depends),"
  for dependency in "$@"; do
    [[ $depends == *", "$dependency,* || $depends == *", "$dependency" ("* ]] || failed "$name does not depend on $dependency:$depends"
    num_needs=$((num_needs + 1))
  done
}
needs alidade libc6 libstdc++6 'libopencv-core4[0-9][0-9]' 'libopencv-imgcodecs4[0-9][0-9]' '@(libcholmod3|libceres4t64)' 'libyaml-cpp0.[78]' libcairo2
minor=$(/usr/bin/python3 -c 'import sys; print(sys.version_info.minor)')
needs python3-alidade "python3 (>= 3.$minor)" "python3 (<< 3.$((minor + 1)))" python3-numpy libc6 'libopencv-core4[0-9][0-9]' '@(libcholmod3|libceres4t64)'
needs libalidade-dev libeigen3-dev libyaml-cpp-dev libfmt-dev nlohmann-json3-dev libpugixml-dev libopencv-dev libjpeg-dev \
  libtiff-dev zlib1g-dev libwebp-dev libceres-dev libgoogle-glog-dev
[ "$(field alidade Suggests)" = snakemake ] || failed "alidade suggests '$(field alidade Suggests)', not snakemake"
for name in alidade libalidade-dev python3-alidade; do
  [[ ", $(field $name Recommends)" == *", ffmpeg" ]] || failed "$name does not recommend ffmpeg: $(field $name Recommends)"
  [[ $(field $name Depends) != *libav* ]] || failed "$name depends on FFmpeg's libraries: $(field $name Depends)"
done
for name in alidade python3-alidade; do
  [[ $(field $name Depends) != *-dev* ]] || failed "$name depends on a -dev package: $(field $name Depends)"
done
for name in alidade libalidade-dev python3-alidade; do
  for key in Section Priority Maintainer Source Installed-Size; do
    [ -n "$(field $name $key)" ] || failed "$name has no $key"
  done
  [ "$(field $name Description | wc -l)" -ge 4 ] || failed "$name has no long description"
done
echo "debian: $num_files files and $num_needs dependencies of 3 packages are as expected"
