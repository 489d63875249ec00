#!/usr/bin/env bash
# Spoiled files against every reader and the program: ATTACK_INPUTS (20000) a format, made with
# ATTACK_SEED (1). What fell stays in build/attack/failures/. SANITIZE=1: the same inputs under the
# address and undefined-behaviour sanitizers.
#
#     scripts/attack.sh [ARGUMENT...]      more arguments of tests/attack/attack.py, such as
#                                        --format png
set -euo pipefail
cd "$(dirname "$0")/.."

preset=release
limits=()
if [[ -n ${SANITIZE:-} ]]; then
  preset=asan
  limits=(--sanitizer)
fi
targets=(loopstone_program)
for source in fuzz/fuzz_*.cpp; do
  targets+=("$(basename "$source" .cpp)")
done
scripts/build.sh "$preset" "${targets[@]}"
exec tests/attack/attack.py --programs "build/$preset/bin" --inputs "${ATTACK_INPUTS:-20000}" --seed "${ATTACK_SEED:-1}" \
  --jobs "${JOBS:-$(nproc)}" "${limits[@]}" "$@"
