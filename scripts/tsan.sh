#!/usr/bin/env bash
# Thread sanitizer over what is threaded: suites whose name holds Thread, Parallel, Determin,
# TaskQueue or Mapper. Only the test sources that have such suites are built.
set -euo pipefail
cd "$(dirname "$0")/.."

words='Thread|Parallel|Determin|TaskQueue|Mapper'
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
CMAKE_ARGS="-DLOOPSTONE_LAST_PART=formats -DLOOPSTONE_TEST_SUITES=$words" scripts/build.sh tsan "${targets[@]}"

# The sanitizer of GCC 12 cannot start where the kernel randomises addresses by 32 bits; then switch
# that off, for it alone.
without_randomisation=()
if ! "build/tsan/bin/${targets[0]}" --gtest_list_tests >/dev/null 2>&1; then
  without_randomisation=(setarch --addr-no-randomize)
fi
# A program that cannot list its tests becomes a failing test named CANNOT_LIST.
LOOPSTONE_TEST_SCALE=small "${without_randomisation[@]}" ctest --preset tsan -R "$words|CANNOT_LIST" -j1
