#!/usr/bin/env bash
# Puts nav2's AMCL, which bench/localization_peers.py compares with, into build/bench/peers; nothing
# is installed into the system. Where it can't be had, the comparison goes on without it. MRPT's
# pf-localization comes with Debian's mrpt-apps: `scripts/install_oracles.sh --localization`.
#   AMCL    the source package amcl from PyPI (GPL-3), compiled into a program of its own
set -uo pipefail
cd "$(dirname "$0")/../.."
root=$PWD
peers=$root/build/bench/peers
mkdir -p "$peers"

say() { echo "bench/peers/install_localization.sh: $*" >&2; }

amcl() {
  local version=0.1.2
  local source=$peers/amcl-$version objects=$peers/amcl_objects file name
  if [[ ! -d $source ]]; then
    [[ -x $peers/venv/bin/pip ]] || python3 -m venv "$peers/venv" || return 1
    "$peers/venv/bin/pip" --quiet --disable-pip-version-check download --no-deps --no-binary amcl -d "$peers" "amcl==$version" &&
      tar -xzf "$peers/amcl-$version.tar.gz" -C "$peers" || return 1
  fi
  mkdir -p "$objects"
  for file in map/map.c map/map_range.c pf/eig3.c pf/pf.c pf/pf_kdtree.c pf/pf_pdf.c pf/pf_vector.c; do
    name=$(basename "$file" .c)
    "${CC:-cc}" -O3 -DNDEBUG -DHAVE_DRAND48 -D_GNU_SOURCE -w -I "$source/include" -c "$source/src/$file" -o "$objects/$name.o" ||
      return 1
  done
  "${CXX:-g++}" -std=c++20 -O3 -DNDEBUG -isystem "$source/include" bench/peers/amcl_localizer.cpp -w \
    "$source"/src/{map/map_cspace,motion_model/differential_motion_model}.cpp \
    "$source"/src/sensors/laser/{laser,likelihood_field_model,likelihood_field_model_prob}.cpp "$objects"/*.o \
    -o "$peers/amcl_localizer" && echo "AMCL $version" >"$peers/amcl_localizer.version"
}

# What was built from the same source stays.
program=$peers/amcl_localizer
[[ -x $program && $program -nt bench/peers/amcl_localizer.cpp ]] || amcl || say "AMCL: missing (no PyPI, or no compiler?)"
exit 0
