#!/usr/bin/env bash
# Puts the libraries that bench/registration.py and bench/pose_graphs.py compare with into
# build/bench/peers; nothing is installed into the system. Whatever can't be had is left out, and
# the comparison goes on without it.
#   small_gicp  its source package from PyPI (headers) and its wheel
#   Open3D      wheel from PyPI (the CPU build), in a virtual environment with numpy and scipy; what
#               it takes from the system and is not there (libusb, libGL), from Debian's packages,
#               unpacked beside
#   PCL         Debian's packages, unpacked beside (no dependencies on VTK and the like are pulled
#               in); needs apt-get and dpkg
# and those that bench/pose_graphs.py compares with:
#   GTSAM, g2o  wheels from PyPI (gtsam, g2opy), in the same virtual environment
#   Ceres       Debian's packages, unpacked beside
# small_gicp and Ceres are called from C++, since their wheels would not do the same: that of
# small_gicp holds no degree of freedom, which a scan in the plane needs, and pyceres has no cost
# between two poses, so that Python would be called for each edge.
set -uo pipefail
cd "$(dirname "$0")/../.."
root=$PWD
peers=$root/build/bench/peers
mkdir -p "$peers"
cxx=${CXX:-g++}
flags=(-std=c++20 -O3 -DNDEBUG -I "$root/include" -isystem /usr/include/eigen3)

# Whether all libraries of a program are found.
runs() { ! ldd "$1" | grep -q 'not found'; }

say() { echo "bench/peers/install.sh: $*" >&2; }

python_packages() {
  [[ -x $peers/venv/bin/python ]] || python3 -m venv "$peers/venv" || return 1
  # Runs it with what open3d_libraries() unpacked, if anything.
  printf '#!/bin/sh\nLD_LIBRARY_PATH=%s exec %s "$@"\n' "$peers/open3d/usr/lib/$(uname -m)-linux-gnu" \
    "$peers/venv/bin/python" >"$peers/python" && chmod +x "$peers/python" || return 1
  "$peers/python" -c 'import numpy, scipy, small_gicp, open3d' 2>/dev/null && return 0
  "$peers/venv/bin/pip" --quiet install numpy scipy small_gicp==1.0.1 open3d-cpu==0.20.0 || return 1
  "$peers/python" -c 'import open3d' 2>/dev/null || open3d_libraries || return 1
  "$peers/python" -c 'import numpy, scipy, small_gicp, open3d'
}

open3d_libraries() {
  local packages
  mapfile -t packages < <(apt-get -s install --no-install-recommends libusb-1.0-0 libegl1 libgl1 libx11-6 libudev1 libidn2-0 \
    2>/dev/null | sed -n 's/^Inst \([^ ]*\).*/\1/p')
  [[ ${#packages[@]} -gt 0 ]] || return 0
  mkdir -p "$peers/open3d_debs"
  (cd "$peers/open3d_debs" && apt-get -qq download "${packages[@]}" 2>/dev/null) || return 1
  for deb in "$peers/open3d_debs"/*.deb; do dpkg -x "$deb" "$peers/open3d" || return 1; done
}

small_gicp() {
  local version=1.0.1
  local source=$peers/small_gicp-$version
  if [[ ! -d $source ]]; then
    "$peers/venv/bin/pip" --quiet download --no-deps --no-binary small_gicp -d "$peers" "small_gicp==$version" &&
      tar -xzf "$peers/small_gicp-$version.tar.gz" -C "$peers" || return 1
  fi
  "$cxx" "${flags[@]}" -isystem "$source/include" bench/peers/small_gicp_matchers.cpp -o "$peers/small_gicp_matchers" &&
    echo "small_gicp $version" >"$peers/small_gicp_matchers.version"
}

pcl() {
  local prefix=$peers/pcl
  if [[ ! -d $prefix/usr/include/pcl-1.13 ]]; then
    local parts=(registration common kdtree search features filters sample-consensus octree)
    local debs=$peers/debs
    mkdir -p "$debs"
    (cd "$debs" && apt-get -qq download libpcl-dev $(printf 'libpcl-%s1.13 ' "${parts[@]}") libflann-dev libflann1.9 \
      libboost1.74-dev liblz4-dev 2>/dev/null) || return 1
    for deb in "$debs"/*.deb; do dpkg -x "$deb" "$prefix" || return 1; done
  fi
  local libraries=$prefix/usr/lib/$(uname -m)-linux-gnu
  # The libraries need each other, so the path must hold for them too.
  "$cxx" "${flags[@]}" -isystem "$prefix/usr/include/pcl-1.13" -isystem "$prefix/usr/include" bench/peers/pcl_matchers.cpp \
    -o "$peers/pcl_matchers" -L "$libraries" -Wl,--disable-new-dtags,-rpath,"$libraries" \
    -lpcl_registration -lpcl_search -lpcl_kdtree -lpcl_octree -lpcl_filters -lpcl_sample_consensus -lpcl_features \
    -lpcl_common -llz4 &&
    echo "PCL 1.13.0" >"$peers/pcl_matchers.version"
}

graph_wheels() {
  [[ -x $peers/venv/bin/python ]] || python3 -m venv "$peers/venv" || return 1
  "$peers/venv/bin/python" -c 'import numpy, gtsam, g2opy' 2>/dev/null && return 0
  "$peers/venv/bin/pip" --quiet install numpy && "$peers/venv/bin/pip" --quiet install --no-deps gtsam==4.3.0 g2opy==2.3.0
}

ceres() {
  rm -f "$peers/ceres_pose_graph.version"
  local prefix=$peers/ceres
  if [[ ! -d $prefix/usr/include/ceres ]]; then
    local debs=$peers/ceres_debs
    mkdir -p "$debs"
    (cd "$debs" && apt-get -qq download libceres-dev libceres3 libgoogle-glog-dev libgoogle-glog0v6 libgflags-dev libgflags2.2 \
      libunwind8 libspqr2 libcholmod3 libccolamd2 libcamd2 libcolamd2 libamd2 libsuitesparseconfig5 libmetis5 libcxsparse3 \
      libblas3 liblapack3 libatlas3-base libgfortran5 2>/dev/null) || return 1
    for deb in "$debs"/*.deb; do dpkg -x "$deb" "$prefix" || return 1; done
  fi
  local libraries=$prefix/usr/lib/$(uname -m)-linux-gnu
  # Where Debian's alternatives would put links to them.
  ln -sf blas/libblas.so.3 lapack/liblapack.so.3 "$libraries/" || return 1
  # The libraries need each other, so the path must hold for them too.
  "$cxx" "${flags[@]}" -isystem "$prefix/usr/include" bench/peers/ceres_pose_graph.cpp -o "$peers/ceres_pose_graph" \
    -L "$libraries" -Wl,--disable-new-dtags,-rpath,"$libraries" \
    -Wl,--allow-shlib-undefined "$libraries/libceres.so" "$libraries/libglog.so" && runs "$peers/ceres_pose_graph" &&
    echo "Ceres 2.1.0" >"$peers/ceres_pose_graph.version"
}

# What was built from the same sources stays.
newer() { [[ -x $1 && $1 -nt $2 && $1 -nt bench/answers.hpp && $1 -nt bench/pairs_file.hpp ]]; }

python_packages || say "Open3D and small_gicp's wheel: missing (no PyPI, or a library of the system that Open3D needs?)"
newer "$peers/small_gicp_matchers" bench/peers/small_gicp_matchers.cpp || small_gicp || say "small_gicp: missing"
newer "$peers/pcl_matchers" bench/peers/pcl_matchers.cpp || pcl || say "PCL: missing (needs apt-get with Debian's package lists)"
graph_wheels || say "GTSAM and g2o's wheels: missing (no PyPI?)"
newer "$peers/ceres_pose_graph" bench/peers/ceres_pose_graph.cpp && runs "$peers/ceres_pose_graph" || ceres || say "Ceres: missing (needs apt-get with Debian's package lists)"
exit 0
