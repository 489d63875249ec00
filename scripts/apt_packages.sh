# shellcheck shell=bash
# For the scripts that install or fetch something, to be sourced:
#
#     install_packages PACKAGE...
#         system packages, as root or by sudo; nothing to do for none
#     private_apt FOLDER TYPE [OPTION...]
#         makes an apt of its own in FOLDER, with this machine's sources of Debian, of TYPE deb or
#         deb-src, and no package installed; leaves its command in "${apt[@]}"
#     quietly LOG COMMAND...
#         tells what the command said only if it fails

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

private_apt() {
  local folder=$1 type=$2 release source
  shift 2
  release=$(. /etc/os-release && echo "$VERSION_CODENAME")
  rm -rf "$folder/sources"
  mkdir -p "$folder"/{state/lists/partial,cache/archives/partial,sources}
  # The machine's own sources of this release, whatever stands in them: mirror, keys, components.
  while read -r source; do
    sed -E -e '/^deb-src /d' -e "s/^deb /$type /" -e "s/^Types:.*/Types: $type/" "$source" >"$folder/sources/${source##*/}"
  done < <(grep -lsE "^(Suites:|deb ).* $release( |\$)" /etc/apt/sources.list /etc/apt/sources.list.d/*)
  : >"$folder/status" # no package is installed
  # Sandbox: the user that apt downloads as can't read root's folders.
  apt=(apt-get -q -o APT::Sandbox::User=root -o "Dir::State=$folder/state" -o "Dir::State::status=$folder/status"
    -o "Dir::Cache=$folder/cache" -o Dir::Etc::sourcelist=/dev/null -o "Dir::Etc::sourceparts=$folder/sources"
    -o Dir::Etc::preferences=/dev/null -o Dir::Etc::preferencesparts=/dev/null -o Acquire::Languages=none
    -o APT::Update::Post-Invoke-Success= -o APT::Update::Post-Invoke= -o Debug::NoLocking=true "$@")
  quietly "$folder/log" "${apt[@]}" update
}

quietly() {
  local log=$1
  shift
  "$@" >"$log" 2>&1 || { tail -20 "$log" >&2; return 1; }
}
