#!/usr/bin/env bash
# Makes a root folder with Debian's packages for 64-bit ARM that a build for it needs, those of
# scripts/install_dependencies.sh. They are unpacked and not installed: dpkg on this machine hears
# nothing of another architecture, and nothing needs root. Quick when it is there already.
#
#     scripts/arm_sysroot.sh [FOLDER]     build/arm/sysroot; remove it to have it anew
set -euo pipefail
cd "$(dirname "$0")/.."

sysroot=$(realpath -m "${1:-build/arm/sysroot}")
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
mapfile -t packages < <(scripts/install_dependencies.sh --list | grep -e '-dev$' | sort)
wanted="$release ${packages[*]}"
if [[ -f $sysroot/made_of && $(<"$sysroot/made_of") == "$wanted" ]]; then
  exit 0
fi

# An apt of its own: the sources of Debian on this machine, no package installed, another
# architecture.
work=$sysroot.work
rm -rf "$work"
mkdir -p "$work"/{state/lists/partial,cache/archives/partial,etc/sources.list.d,root}
while read -r source; do
  cp "$source" "$work/etc/sources.list.d/"
done < <(grep -lsE "^(Suites:|deb ).* $release( |\$)" /etc/apt/sources.list /etc/apt/sources.list.d/*)
: >"$work/status"
options=(
  -q -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User= -o APT::Install-Recommends=false
  -o "Dir::State=$work/state" -o "Dir::State::status=$work/status" -o "Dir::Cache=$work/cache"
  -o Dir::Etc::sourcelist=/dev/null -o "Dir::Etc::sourceparts=$work/etc/sources.list.d"
  -o Dir::Etc::preferences=/dev/null -o Dir::Etc::preferencesparts=/dev/null
  -o Acquire::Languages=none -o APT::Update::Post-Invoke-Success= -o APT::Update::Post-Invoke=
  -o Debug::NoLocking=true
)
fetch() {
  apt-get "${options[@]}" update && apt-get "${options[@]}" install -y --download-only "${packages[@]}"
}
echo "Fetching packages for arm64: ${packages[*]}"
fetch >"$work/apt.log" 2>&1 || { tail -20 "$work/apt.log" >&2; exit 1; }

root=$work/root
mkdir -p "$root"/usr/{bin,sbin,lib}
for folder in bin sbin lib; do
  ln -s "usr/$folder" "$root/$folder"
done
# Settings and fonts are those of this machine: qemu looks in this root first.
for deb in "$work"/cache/archives/*.deb; do
  dpkg-deb --fsys-tarfile "$deb" | tar -x --keep-directory-symlink --no-same-owner -C "$root" \
    --exclude './usr/share/doc/*' --exclude './usr/share/man/*' --exclude './usr/share/locale/*' \
    --exclude './etc/*' --exclude './usr/share/fonts/*'
done
echo "$wanted" >"$root/made_of"
rm -rf "$sysroot"
mv "$root" "$sysroot"
rm -rf "$work"
