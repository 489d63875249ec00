#!/usr/bin/env bash
# Writes python/bindings/_core.pyi, from which the documentation site takes the docstrings of the
# extension module, as scripts/test_python.sh built it. Without the version, which stands elsewhere.
#
#     scripts/write_python_stub.sh [build/python/wheel/python/loopstone/_core.pyi]
set -euo pipefail
cd "$(dirname "$0")/.."

sed -E 's/^(version: str) = .*/\1/' "${1:-build/python/wheel/python/loopstone/_core.pyi}" >build/_core.pyi
mv build/_core.pyi python/bindings/_core.pyi
