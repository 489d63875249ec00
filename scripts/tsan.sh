#!/usr/bin/env bash
# Thread sanitizer over what is threaded: suites whose name holds Thread, Parallel or Determin.
# Only the test programs that have such suites are built.
set -euo pipefail
cd "$(dirname "$0")/.."

words='Thread|Parallel|Determin'
targets=()
for folder in tests/unit/*/ tests/property/ tests/scenario/; do
  [[ -d $folder ]] || continue
  if grep -qEs "TEST(_F|_P)?\(\w*($words)|RC_GTEST(_FIXTURE)?_PROP\(\w*($words)" "$folder"*.cpp; then
    targets+=("test_$(basename "$folder")")
  fi
done
if [[ ${#targets[@]} -eq 0 ]]; then
  echo "no threaded suites"
  exit 0
fi
echo "threaded suites are in: ${targets[*]}"
scripts/build.sh tsan "${targets[@]}"
LOOPSTONE_TEST_SCALE=small ctest --preset tsan -R "$words" -E NOT_BUILT -j1
