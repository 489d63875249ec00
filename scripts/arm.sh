#!/usr/bin/env bash
# 64-bit ARM on another processor: compiles library, program and some tests for it (the sysroot is
# made by scripts/arm_sysroot.sh), runs the tests under qemu, and holds what the program writes
# against what the release build writes here.
#
#     scripts/arm.sh            all of it
#     scripts/arm.sh --build    compiles only
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

build_only=
case ${1:-} in
  '') ;;
  --build) build_only=yes ;;
  *)
    sed -n '2,/^[^#]/s/^# \?//p' "$0"
    exit 2
    ;;
esac

missing=()
command -v aarch64-linux-gnu-g++ >/dev/null || missing+=(g++-aarch64-linux-gnu)
command -v qemu-aarch64-static >/dev/null || missing+=(qemu-user-static)
install_packages "${missing[@]}"
scripts/arm_sysroot.sh

# What reckons most for its size: the tests take qemu some minutes.
tests='base|geometry|grid|graph'
targets=(loopstone_program)
for part in ${tests//|/ }; do
  targets+=("test_$part")
done
scripts/build.sh arm "${targets[@]}"
[[ -z $build_only ]] || exit 0

ctest --preset arm -R "^test_($tests)(\.|_NOT_BUILT|_CANNOT_LIST)" -j "${JOBS:-$(nproc)}"

scripts/build.sh release loopstone_program
tests/processors/check_same_bytes.py build/release/bin/loopstone -- \
  qemu-aarch64-static -L build/arm/sysroot build/arm/bin/loopstone
