#!/usr/bin/env bash
# Makes the documentation site, build/site/html: a page to begin with for each kind of reader, the
# pages of docs/, the library from its headers, a search. Needs Python's venv and PyPI the first
# time; what it makes loads nothing from elsewhere. Its search needs a server, however small.
#
#     scripts/build_site.sh          builds; a link that leads nowhere is an error
#     scripts/build_site.sh --serve  and shows it at http://127.0.0.1:8000
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

case ${1:-} in
  '' | --serve) ;;
  *)
    sed -n '2,/^[^#]/s/^# \?//p' "$0"
    exit 2
    ;;
esac

python3 -c 'import ensurepip, venv' 2>/dev/null || install_packages python3-venv
venv=build/site/venv
asked=$(sha256sum site/requirements.txt)
if [[ ! -f $venv/.installed || $(<"$venv/.installed") != "$asked" ]]; then
  python3 -m venv --clear "$venv"
  "$venv/bin/pip" install -q --disable-pip-version-check -r site/requirements.txt
  echo "$asked" >"$venv/.installed"
fi
python3 -B site/assemble.py
NO_MKDOCS_2_WARNING=1 "$venv/bin/mkdocs" build --strict --quiet -f site/mkdocs.yml
echo "build/site/html/index.html: $(find build/site/html -name '*.html' | wc -l) pages"
if [[ ${1:-} == --serve ]]; then
  exec python3 -m http.server --bind 127.0.0.1 --directory build/site/html 8000
fi
