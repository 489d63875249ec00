#!/usr/bin/env bash
# Installs what loopstone needs on Debian 12 (or a close relative), by apt. Safe to run again; quick
# when nothing is missing.
#
#     scripts/install_dependencies.sh          to build, test and run
#     scripts/install_dependencies.sh --all    and to format, tidy, fuzz, benchmark, to build and
#                                              test the page of the live view, and for packages
#     scripts/install_dependencies.sh --ros2   and to build loopstone-ros2 (docs/ros2.md)
#     scripts/install_dependencies.sh --list   installs nothing, and prints the packages' names
set -euo pipefail

packages=(
  g++ cmake ninja-build make ccache lld pkg-config python3
  libeigen3-dev libtbb-dev libhwy-dev libfmt-dev
  nlohmann-json3-dev libtomlplusplus-dev libyaml-cpp-dev
  libpng-dev libjpeg-dev libzip-dev zlib1g-dev libdeflate-dev libbz2-dev libzstd-dev liblz4-dev
  libsqlite3-dev libboost-dev
  libcli11-dev libspdlog-dev
  libgtest-dev libgmock-dev librapidcheck-dev
)
all=
list=
for flag; do
  case $flag in
    --list) list=yes ;;
    --all)
      all=yes
      packages+=(git clang clang-tidy clang-format libclang-rt-14-dev llvm libbenchmark-dev black)
      packages+=(dpkg-dev debootstrap zsh fish groff-base)
      ;;
    --ros2) packages+=(cyclonedds-dev) ;;
    *)
      sed -n '2,/^[^#]/s/^# \?//p' "$0"
      exit 2
      ;;
  esac
done
if [[ -n $list ]]; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi
installed() {
  [[ -z $all ]] || "$(dirname "$0")/install_viewer.sh"
  exit 0
}

present=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${packages[@]}" 2>/dev/null | sed -n 's/^installed //p' || true)
missing=()
for package in "${packages[@]}"; do
  grep -qxF "$package" <<<"$present" || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  installed
fi

if ! command -v apt-get >/dev/null; then
  echo "apt-get not found. Install these packages, or what your system calls them: ${missing[*]}" >&2
  exit 1
fi
as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null || { echo "Run as root, or install sudo: missing ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi

echo "Installing: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
apt_install() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}" </dev/null
}
# The package lists are absent in a fresh container, and old ones point to versions that are gone;
# refresh them when it matters.
lists=$(find /var/lib/apt/lists -maxdepth 1 -name '*_Packages*' -print -quit 2>/dev/null || true)
if [[ -n $lists ]] && apt_install; then
  installed
fi
"${as_root[@]}" apt-get update -q </dev/null
apt_install
installed
