#!/usr/bin/env bash
# Installs the reference libraries that tests/oracles holds recordings against, in build/oracles: a
# virtual environment of Python and modules of Node. Safe to run again; quick when nothing is
# missing.
#
#     scripts/install_oracles.sh
#     scripts/install_oracles.sh --localization   instead, what bench/localization_peers.py compares
#                                                 with: MRPT's programs (mrpt-apps, a system package
#                                                 of 430 MB with what it needs), and nav2's AMCL in
#                                                 build/bench/peers
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

localization=
case ${1:-} in
  '') ;;
  --localization) localization=yes ;;
  *)
    sed -n '2,/^[^#]/s/^# \?//p' "$0"
    exit 2
    ;;
esac

packages=()
python3 -c 'import ensurepip, venv' 2>/dev/null || packages+=(python3-venv)
if [[ -n $localization ]]; then
  command -v pf-localization >/dev/null || packages+=(mrpt-apps)
  [[ -d /usr/share/mrpt ]] || packages+=(mrpt-common)
else
  command -v node >/dev/null || packages+=(nodejs)
  command -v npm >/dev/null || packages+=(npm)
fi
install_packages "${packages[@]}"

if [[ -n $localization ]]; then
  bench/peers/install_localization.sh
  exit 0
fi

# What is installed is known by what was asked for; a run that was cut off leaves no mark.
folder=build/oracles
asked=$(cat tests/oracles/requirements.txt tests/oracles/package.json; python3 --version)
if [[ -f $folder/installed.txt && $(<"$folder/installed.txt") == "$asked" ]]; then
  exit 0
fi
rm -rf "$folder"
mkdir -p "$folder"
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --no-input -r tests/oracles/requirements.txt
cp tests/oracles/package.json "$folder/"
npm install --prefix "$folder" --no-package-lock --no-audit --no-fund --ignore-scripts --loglevel=error
printf '%s\n' "$asked" >"$folder/installed.txt"
