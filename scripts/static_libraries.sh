#!/usr/bin/env bash
# Builds those of our libraries that the distribution has as shared ones alone as static ones, from
# the distribution's own source packages, in build/static. Safe to run again; quick when nothing is
# missing. The program of one file is linked with them.
#
#     scripts/static_libraries.sh
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

packages=()
command -v dpkg-source >/dev/null || packages+=(dpkg-dev)
command -v cmake >/dev/null || packages+=(cmake)
command -v ninja >/dev/null || packages+=(ninja-build)
install_packages "${packages[@]}"

sources=(onetbb highway libzip fmtlib spdlog)
root=$PWD/build/static
prefix=$root/installed
mkdir -p "$root/apt/lists/partial" "$root/apt/archives/partial" "$root/sources"

# The mirror and release that the binary packages come from.
read -r mirror suite < <(apt-cache policy libtbb-dev | awk '$2 ~ /^https?:/ && !done { split($3, at, "/"); print $2, at[1]; done = 1 }')
echo "deb-src $mirror $suite main" >"$root/apt/sources.list"
# -o APT::Sandbox::User: root's folders can't be read by the user that apt downloads as.
private_apt=(apt-get -qq -o "Dir::Etc::sourcelist=$root/apt/sources.list" -o Dir::Etc::sourceparts=-
  -o "Dir::State::lists=$root/apt/lists" -o "Dir::Cache::archives=$root/apt/archives" -o APT::Sandbox::User=root)

# What is installed is known by what was asked for; a run that was cut off leaves no mark.
asked="$(apt-cache policy libtbb-dev libhwy-dev libzip-dev libfmt-dev libspdlog-dev libtomlplusplus-dev |
  awk '/Candidate/ { print $2 }' | paste -sd' ') $(c++ --version | head -1)"
if [[ -f $root/installed.txt && $(<"$root/installed.txt") == "$asked" ]]; then
  exit 0
fi
rm -rf "$prefix" "$root/sources" "$root/installed.txt"
mkdir -p "$root/sources"
"${private_apt[@]}" update
(cd "$root/sources" && "${private_apt[@]}" source "${sources[@]}")

# Position-independent, so that a shared library can have them, too.
build() { # FOLDER [CMAKE_ARGUMENT...]
  local source
  source=$(echo "$root"/sources/"$1"-*/)
  shift
  cmake -S "$source" -B "$source/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=OFF \
    -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_INSTALL_LIBDIR=lib \
    -DBUILD_TESTING=OFF "$@" >"$source/build.log"
  cmake --build "$source/build" --parallel "${JOBS:-$(nproc)}" >>"$source/build.log"
  cmake --install "$source/build" >>"$source/build.log"
}
build onetbb -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF
build highway -DHWY_ENABLE_TESTS=OFF -DHWY_ENABLE_EXAMPLES=OFF -DHWY_ENABLE_CONTRIB=OFF
build libzip -DENABLE_COMMONCRYPTO=OFF -DENABLE_GNUTLS=OFF -DENABLE_MBEDTLS=OFF -DENABLE_OPENSSL=OFF \
  -DENABLE_BZIP2=OFF -DENABLE_LZMA=OFF -DENABLE_ZSTD=OFF -DBUILD_TOOLS=OFF -DBUILD_REGRESS=OFF -DBUILD_EXAMPLES=OFF -DBUILD_DOC=OFF
build fmtlib -DFMT_TEST=OFF -DFMT_DOC=OFF
build spdlog -DSPDLOG_FMT_EXTERNAL=ON -DSPDLOG_BUILD_EXAMPLE=OFF "-DCMAKE_PREFIX_PATH=$prefix"
# This one is all there in its development package.
printf '#define TOML_IMPLEMENTATION\n#include <toml++/toml.h>\n' >"$root/toml.cpp"
c++ -std=c++17 -O2 -fPIC -DTOML_HEADER_ONLY=0 -c "$root/toml.cpp" -o "$root/toml.o"
ar rcsD "$prefix/lib/libtomlplusplus.a" "$root/toml.o"
printf '%s\n' "$asked" >"$root/installed.txt"
