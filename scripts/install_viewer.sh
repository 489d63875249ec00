#!/usr/bin/env bash
# Installs what the page of the live view is built and tested with: Node and Chromium by apt where
# they are missing, and the modules of viewer/package-lock.json in viewer/node_modules. Safe to run
# again; quick when nothing is missing. Who only builds the program needs none of it: the built page
# is viewer/built/index.html.
#
#     scripts/install_viewer.sh
#     scripts/install_viewer.sh --modules     the modules alone
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

packages=()
case ${1:-} in
  '')
    command -v node >/dev/null || packages+=(nodejs)
    command -v npm >/dev/null || packages+=(npm)
    command -v chromium >/dev/null || packages+=(chromium)
    ;;
  --modules) ;;
  *)
    sed -n '2,/^[^#]/s/^# \?//p' "$0"
    exit 2
    ;;
esac

install_packages "${packages[@]}"

# What is installed is known by what was asked for; a run that was cut off leaves no mark.
cd viewer
asked=$(sha256sum package.json package-lock.json)
mark=node_modules/.installed
if [[ -f $mark && $(<"$mark") == "$asked" ]]; then
  exit 0
fi
npm ci --ignore-scripts --no-audit --no-fund --loglevel=error </dev/null
printf '%s\n' "$asked" >"$mark"
