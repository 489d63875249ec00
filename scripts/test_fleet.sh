#!/usr/bin/env bash
# Builds the wheel of loopstone-fleet (python/fleet) in build/fleet/dist, installs it in a virtual
# environment of its own with what its tests need, and runs tests and mypy. Dask and a store come
# from packages, on loopback; Ray is large and left out, with its reason, where it can't be had.
# Safe to run again; quick when nothing has changed.
#
#     scripts/test_fleet.sh                 the program is that of build/release
#     scripts/test_fleet.sh -- ARGUMENT...  for pytest
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

pytest_arguments=()
if [[ ${1:-} == -- ]]; then
  shift
  pytest_arguments=("$@")
elif [[ $# -gt 0 ]]; then
  sed -n '2,/^[^#]/s/^# \?//p' "$0"
  exit 2
fi

packages=()
python3 -c 'import ensurepip, venv' 2>/dev/null || packages+=(python3-venv)
install_packages "${packages[@]}"
[[ -x build/release/bin/loopstone ]] || scripts/build.sh release loopstone_program

folder=build/fleet
venv=$folder/venv
pip=("$venv/bin/pip" --quiet --disable-pip-version-check --no-input)
[[ -x $venv/bin/pip ]] || python3 -m venv "$venv"

rm -rf "$folder/dist"
"${pip[@]}" wheel ./python/fleet --no-deps --wheel-dir "$folder/dist"
wheel=("$folder"/dist/loopstone_fleet-*.whl)
"${pip[@]}" uninstall --yes loopstone-fleet 2>/dev/null
"${pip[@]}" install "${wheel[0]}[s3,dask,test]"
"${pip[@]}" install 'ray>=2.9' 2>"$folder/ray.log" ||
  printf '%s: Ray cannot be installed, so its tests are skipped: %s\n' "$0" "$(tail -1 "$folder/ray.log")" >&2

# From here, so that the package is the one that was installed.
"$venv/bin/python" -m pytest -c python/fleet/pyproject.toml -rs "${pytest_arguments[@]}" python/fleet/tests
mypy=("$venv/bin/mypy" --config-file python/fleet/pyproject.toml)
"${mypy[@]}" -p loopstone_fleet
MYPYPATH=python/fleet/tests "${mypy[@]}" python/fleet/tests/test_*.py
