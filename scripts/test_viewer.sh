#!/usr/bin/env bash
# Tests the page of the live view. Ends with 77, and says why, where what it needs is not there
# (scripts/install_viewer.sh).
#
#     scripts/test_viewer.sh unit       types, whether the built page is current, single parts
#     scripts/test_viewer.sh browser    the page in Chromium, against a server with a made run
set -euo pipefail
cd "$(dirname "$0")/.."

part=${1:-}
skip() {
  echo "skipped: $1"
  # scripts/test.sh counts them.
  if [[ -n ${LOOPSTONE_SKIPPED_TESTS:-} ]]; then
    printf 'viewer\t%s\t%s\n' "$part" "$1" >>"$LOOPSTONE_SKIPPED_TESTS"
  fi
  exit 77
}
case $part in
  unit | browser) ;;
  *)
    sed -n '2,/^[^#]/s/^# \?//p' "$0"
    exit 2
    ;;
esac

command -v node >/dev/null || skip "no Node (scripts/install_viewer.sh)"
[[ $(node -p 'process.versions.node.split(".")[0] >= 18') == true ]] || skip "Node is older than 18"
cd viewer
asked=$(sha256sum package.json package-lock.json)
[[ -f node_modules/.installed && $(<node_modules/.installed) == "$asked" ]] ||
  skip "no modules of Node, or old ones (scripts/install_viewer.sh)"
if [[ $part == unit ]]; then
  node_modules/.bin/tsc --noEmit
  node build.mjs --check
  exec node run.mjs --test tests/*.test.ts
fi
[[ -n ${CHROMIUM:-} ]] || command -v chromium chromium-browser google-chrome >/dev/null ||
  skip "no Chromium (scripts/install_viewer.sh)"
for tests in tests/*.e2e.ts; do
  node run.mjs --test "$tests" && continue
  echo "$tests once more: on a busy machine a browser may miss a moment that a test waits for"
  node run.mjs --test "$tests"
done
