#!/usr/bin/env bash
# Builds the page of the live view, viewer/built/index.html, from viewer/src: the same sources give
# the same bytes.
#
#     scripts/build_viewer.sh             writes it
#     scripts/build_viewer.sh --check     fails where it is not what the sources give
set -euo pipefail
cd "$(dirname "$0")/.."

command -v node >/dev/null || { echo "node not found: scripts/install_viewer.sh" >&2; exit 1; }
scripts/install_viewer.sh --modules
cd viewer
node_modules/.bin/tsc --noEmit
node build.mjs "$@"
