#!/usr/bin/env bash
# Installs a build to a temporary prefix, then configures, builds and runs a project outside that
# finds it there.
#
#     tests/install/run.sh BUILD_DIR VERSION
set -euo pipefail

build=$(cd "$1" && pwd)
version=$2
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" >"$work/install.log" || { cat "$work/install.log"; exit 1; }
cp -r "$here/outside" "$work/outside"
cmake -S "$work/outside" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix" \
  -DCMAKE_CXX_COMPILER="${CXX:-c++}" -DLOOPSTONE_ASKED="${version%.*}" >"$work/configure.log" || { cat "$work/configure.log"; exit 1; }
cmake --build "$work/build"
output=$(LD_LIBRARY_PATH="$work/prefix/lib:$work/prefix/lib/$(uname -m)-linux-gnu" "$work/build/outside")
echo "$output"
[[ $output == "loopstone $version:"* ]] || { echo "expected version $version"; exit 1; }

# The installed headers include one another and Eigen only, in whatever order they come.
cd "$work/prefix/include"
find loopstone -name '*.hpp' | sort | sed 's/.*/#include "&"/' >"$work/sorted.cpp"
tac "$work/sorted.cpp" >"$work/reversed.cpp"
for order in sorted reversed; do
  "${CXX:-c++}" -std=c++20 -fsyntax-only -Wall -Wextra -Werror -I. -isystem /usr/include/eigen3 "$work/$order.cpp"
done
echo "$(wc -l <"$work/sorted.cpp") public headers compile"

# Nothing installed may point back into the source or build tree.
if grep -rIl -e "$build" -e "$(cd "$here/../.." && pwd)" "$work/prefix"; then
  echo "installed files name the build tree"
  exit 1
fi
