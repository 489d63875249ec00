#!/usr/bin/env bash
# Line coverage of include/, src/ and apps/ by the tests, one line a file and the total, from gcov's
# JSON.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/build.sh coverage
find build/coverage -name '*.gcda' -delete
ctest --preset coverage -j "${JOBS:-$(nproc)}" --quiet || echo "some tests failed; coverage is of what ran"
python3 scripts/coverage_report.py build/coverage
