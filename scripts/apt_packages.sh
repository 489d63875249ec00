# shellcheck shell=bash
# For the scripts that install something, to be sourced:
#
#     install_packages PACKAGE...     system packages, as root or by sudo; nothing to do for none

install_packages() {
  if [[ $# -eq 0 ]]; then
    return 0
  fi
  if ! command -v apt-get >/dev/null; then
    echo "apt-get not found. Install these, or what your system calls them: $*" >&2
    return 1
  fi
  local as_root=()
  if [[ $(id -u) -ne 0 ]]; then
    command -v sudo >/dev/null || { echo "Run as root, or install sudo: missing $*" >&2; return 1; }
    as_root=(sudo)
  fi
  echo "Installing: $*"
  local install=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@")
  "${install[@]}" </dev/null || { "${as_root[@]}" apt-get update -q </dev/null && "${install[@]}" </dev/null; }
}
