#!/usr/bin/env bash
# Puts the libraries that bench/file_readers.py compares with into build/bench/peers/file_readers;
# nothing is installed into the system. Whatever can't be had is left out, and the comparison goes
# on without it.
#   libtiff, matio, PCL, xtensor, netpbm    Debian's packages, unpacked beside, with what they need
#                                           and the system lacks (PCL brings VTK and MPI)
#   miniply                                 in the source package of pyminiply, from PyPI
set -uo pipefail
cd "$(dirname "$0")/../.."
root=$PWD
peers=$root/build/bench/peers/file_readers
mkdir -p "$peers"
cxx=${CXX:-g++}
flags=(-std=c++20 -O3 -DNDEBUG -isystem /usr/include/eigen3)
architecture=$(uname -m)-linux-gnu

say() { echo "bench/peers/install_file_readers.sh: $*" >&2; }

# unpack NAME PACKAGE...: the packages and what the system lacks of their needs, except of -dev
# packages, whose needs are many and not needed.
unpack() {
  local prefix=$peers/$1 libraries=() packages
  shift
  [[ -d $prefix/usr ]] && return 0
  for package; do [[ $package == *-dev ]] || libraries+=("$package"); done
  packages=("$@")
  if [[ ${#libraries[@]} -gt 0 ]]; then
    mapfile -t -O $# packages < <(apt-get -s install --no-install-recommends "${libraries[@]}" 2>/dev/null |
      sed -n 's/^Inst \([^ ]*\).*/\1/p')
  fi
  mkdir -p "$prefix.debs"
  (cd "$prefix.debs" && apt-get -qq download $(printf '%s\n' "${packages[@]}" | sort -u) 2>/dev/null) || return 1
  for deb in "$prefix.debs"/*.deb; do dpkg -x "$deb" "$prefix" || return 1; done
  rm -r "$prefix.debs"
}

# compile NAME LIBRARY...: with headers and libraries of the prefix first.
compile() {
  local name=$1 prefix=$peers/$1
  shift
  local libraries=$prefix/usr/lib/$architecture
  # The libraries need each other, so the path must hold for them too.
  "$cxx" "${flags[@]}" -isystem "$prefix/usr/include/pcl-1.13" -isystem "$prefix/usr/include" \
    -isystem "$prefix/usr/include/$architecture" "bench/peers/${name}_files.cpp" -o "$peers/${name}_files" \
    -L "$libraries" -Wl,--disable-new-dtags,-rpath,"$libraries:$libraries/openmpi/lib:$prefix/usr/lib" -Wl,--allow-shlib-undefined "$@"
}

# told NAME TITLE PACKAGE: which version was compared.
told() {
  local version
  version=$(apt-cache show --no-all-versions "$3" | sed -n 's/^Version: \([0-9.]*[0-9]\).*/\1/p')
  echo "$2 $version" >"$peers/$1_files.version"
}

tiff() { unpack tiff libtiff6 libtiff-dev && compile tiff -ltiff && told tiff libtiff libtiff6; }
mat() { unpack mat libmatio11 libmatio-dev && compile mat -lmatio && told mat matio libmatio11; }
netpbm() { unpack netpbm libnetpbm11 libnetpbm-dev && compile netpbm -lnetpbm && told netpbm libnetpbm libnetpbm11; }
xtensor() { unpack xtensor libxtensor-dev xtl-dev && compile xtensor && told xtensor xtensor libxtensor-dev; }
pcl() {
  unpack pcl libpcl-io1.13 libpcl-dev libboost1.74-dev && compile pcl -lpcl_io -lpcl_io_ply -lpcl_common &&
    told pcl PCL libpcl-io1.13
}
miniply() {
  local version=0.2.3
  local source=$peers/pyminiply-$version
  if [[ ! -d $source ]]; then
    python3 -m pip --quiet download --no-deps --no-binary pyminiply -d "$peers" "pyminiply==$version" &&
      tar -xzf "$peers/pyminiply-$version.tar.gz" -C "$peers" || return 1
  fi
  "$cxx" "${flags[@]}" -isystem "$source/src/miniply" bench/peers/miniply_files.cpp "$source/src/miniply/miniply.cpp" \
    -o "$peers/miniply_files" && echo "miniply of pyminiply $version" >"$peers/miniply_files.version"
}

for name in tiff mat netpbm xtensor pcl miniply; do
  program=$peers/${name}_files
  source=bench/peers/${name}_files.cpp
  # What was built from the same sources stays.
  [[ -x $program && $program -nt $source && $program -nt bench/reader_trials.hpp ]] && continue
  "$name" || say "$name: missing (needs apt-get with Debian's package lists, miniply PyPI)"
done
exit 0
