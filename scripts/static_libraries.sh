#!/usr/bin/env bash
# Builds static, position-independent ones of our libraries, from the distribution's own source
# packages, in build/static: of those that the distribution has as shared ones alone, and of those
# whose static ones only a program can be linked with. Safe to run again; quick when nothing is
# missing. The program of one file and the wheel are linked with them (cmake/StaticLibraries.cmake).
#
#     scripts/static_libraries.sh
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

root=$PWD/build/static
prefix=$root/installed
# By the package that brings the headers; the static ones of the last four serve as they are.
libraries=(libtbb-dev libhwy-dev libzip-dev libfmt-dev libspdlog-dev libtomlplusplus-dev libyaml-cpp-dev libpng-dev
  libjpeg62-turbo-dev libzstd-dev libbz2-dev libdeflate-dev liblz4-dev libsqlite3-dev zlib1g-dev)

# What is installed is known by what it was made of; a run that was cut off leaves no mark.
versions=$(dpkg-query -W "${libraries[@]}") || { echo "scripts/install_dependencies.sh installs what is missing" >&2; exit 1; }
wanted="$versions $(c++ --version | head -1) $(sha256sum scripts/static_libraries.sh)"
if [[ -f $root/installed.txt && $(<"$root/installed.txt") == "$wanted" ]]; then
  exit 0
fi

packages=()
command -v dpkg-source >/dev/null || packages+=(dpkg-dev)
command -v cmake >/dev/null || packages+=(cmake)
command -v ninja >/dev/null || packages+=(ninja-build)
[[ $(uname -m) != x86_64 ]] || command -v nasm >/dev/null || packages+=(nasm) # of libjpeg-turbo
install_packages "${packages[@]}"

rm -rf "$root"
mkdir -p "$root/sources"
private_apt "$root/apt" deb-src
# A mirror may know of an update whose sources it does not have.
fetch() { # NAME
  quietly "$root/apt/log" "${apt[@]}" source "$1" 2>/dev/null || quietly "$root/apt/log" "${apt[@]}" source "$1/$release"
}
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
for source in onetbb highway libzip fmtlib spdlog yaml-cpp libpng1.6 libjpeg-turbo libzstd bzip2; do
  (cd "$root/sources" && fetch "$source")
done

source_of() { # NAME
  echo "$root"/sources/"$1"-*/
}
build() { # FOLDER [CMAKE_ARGUMENT...]
  local source=$1
  shift
  quietly "$root/build.log" cmake -S "$source" -B "$root/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=OFF \
    -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_INSTALL_LIBDIR:PATH=lib -DBUILD_TESTING=OFF "$@"
  quietly "$root/build.log" cmake --build "$root/build" --parallel "${JOBS:-$(nproc)}"
  quietly "$root/build.log" cmake --install "$root/build"
  rm -rf "$root/build"
}
build "$(source_of onetbb)" -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF
build "$(source_of highway)" -DHWY_ENABLE_TESTS=OFF -DHWY_ENABLE_EXAMPLES=OFF -DHWY_ENABLE_CONTRIB=OFF
# arc4random: the C library has it from 2.36 on, and the wheel is for 2.35, too.
build "$(source_of libzip)" -DHAVE_ARC4RANDOM=OFF -DENABLE_COMMONCRYPTO=OFF -DENABLE_GNUTLS=OFF -DENABLE_MBEDTLS=OFF \
  -DENABLE_OPENSSL=OFF -DENABLE_BZIP2=OFF -DENABLE_LZMA=OFF -DENABLE_ZSTD=OFF -DBUILD_TOOLS=OFF -DBUILD_REGRESS=OFF -DBUILD_EXAMPLES=OFF -DBUILD_DOC=OFF
build "$(source_of fmtlib)" -DFMT_TEST=OFF -DFMT_DOC=OFF
build "$(source_of spdlog)" -DSPDLOG_FMT_EXTERNAL=ON -DSPDLOG_BUILD_EXAMPLE=OFF "-DCMAKE_PREFIX_PATH=$prefix"
build "$(source_of yaml-cpp)" -DYAML_CPP_BUILD_TESTS=OFF -DYAML_CPP_BUILD_TOOLS=OFF -DYAML_CPP_BUILD_CONTRIB=OFF
build "$(source_of libpng1.6)" -DPNG_SHARED=OFF -DPNG_TESTS=OFF
build "$(source_of libjpeg-turbo)" -DENABLE_SHARED=OFF -DWITH_TURBOJPEG=OFF -DWITH_JAVA=OFF
build "$(source_of libzstd)/build/cmake" -DZSTD_BUILD_SHARED=OFF -DZSTD_BUILD_PROGRAMS=OFF -DZSTD_LEGACY_SUPPORT=OFF
quietly "$root/build.log" make -C "$(source_of bzip2)" libbz2.a "CFLAGS=-O2 -fPIC -D_FILE_OFFSET_BITS=64"
cp "$(source_of bzip2)/libbz2.a" "$prefix/lib/"
# This one is all there in its development package.
printf '#define TOML_IMPLEMENTATION\n#include <toml++/toml.h>\n' >"$root/toml.cpp"
c++ -std=c++17 -O2 -fPIC -DTOML_HEADER_ONLY=0 -c "$root/toml.cpp" -o "$root/toml.o"
ar rcsD "$prefix/lib/libtomlplusplus.a" "$root/toml.o"

# Their licences go where they go.
mkdir -p "$prefix/licenses"
for library in "${libraries[@]}"; do
  cp -L "/usr/share/doc/$library/copyright" "$prefix/licenses/${library%-dev}"
done
rm -rf "$root/sources" "$root/apt"
printf '%s\n' "$wanted" >"$root/installed.txt"
