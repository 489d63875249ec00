#!/usr/bin/env bash
# Installs what tests/ros2 holds loopstone-ros2 against, in build/ros2_peers: the Python of Cyclone
# DDS, and where there is Cargo, a program by ros2-client and RustDDS, an implementation of its own.
# Safe to run again; quick when nothing is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

packages=()
python3 -c 'import ensurepip, venv' 2>/dev/null || packages+=(python3-venv)
command -v ip >/dev/null || packages+=(iproute2)
install_packages "${packages[@]}"

# What is installed is known by what was asked for; a run that was cut off leaves no mark.
folder=build/ros2_peers
asked=$(cat tests/ros2/requirements.txt; python3 --version)
if [[ ! -f $folder/installed.txt || $(<"$folder/installed.txt") != "$asked" ]]; then
  rm -rf "$folder/venv"
  mkdir -p "$folder"
  python3 -m venv "$folder/venv"
  "$folder/venv/bin/pip" install --quiet --disable-pip-version-check --no-input -r tests/ros2/requirements.txt
  printf '%s\n' "$asked" >"$folder/installed.txt"
fi
if command -v cargo >/dev/null; then
  cargo build --quiet --locked --manifest-path tests/ros2/rust_peer/Cargo.toml --target-dir "$folder/rust"
else
  echo "no Cargo: without the program by RustDDS" >&2
fi
