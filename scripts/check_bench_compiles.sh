#!/usr/bin/env bash
# Whether the programs of bench/ compile, without building them: their syntax and types, by clang,
# as the preset tidy has them. A quarter of a minute where building would take minutes.
set -euo pipefail
cd "$(dirname "$0")/.."

cmake --preset tidy >/dev/null
python3 - <<'PYTHON' | xargs -P "${JOBS:-$(nproc)}" -d '\n' -I{} bash -c '{}'
import json
import shlex

found = 0
for entry in json.load(open("build/tidy/compile_commands.json", encoding="utf-8")):
    if "/bench/" not in entry["file"]:
        continue
    words = shlex.split(entry["command"])
    words = words[next(i for i, word in enumerate(words) if word.endswith("clang++")):]
    at = words.index("-o")
    del words[at:at + 2]
    words[words.index("-c")] = "-fsyntax-only"
    print(f"cd {shlex.quote(entry['directory'])} && {shlex.join(words)} || {{ echo {entry['file']}: does not compile >&2; exit 255; }}")
    found += 1
if found < 10:
    raise SystemExit(f"only {found} sources of bench/ in the compilation database")
PYTHON
echo "bench/ compiles"
