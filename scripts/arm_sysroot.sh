#!/usr/bin/env bash
# Makes a root folder with Debian's packages for 64-bit ARM that a build for it needs, those of
# scripts/install_dependencies.sh. They are unpacked and not installed: dpkg on this machine hears
# nothing of another architecture, and nothing needs root. Quick when it is there already.
#
#     scripts/arm_sysroot.sh [FOLDER]     build/arm/sysroot; remove it to have it anew
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

sysroot=$(realpath -m "${1:-build/arm/sysroot}")
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
mapfile -t packages < <(scripts/install_dependencies.sh --list | grep -e '-dev$' | sort)
wanted="$release ${packages[*]}"
if [[ -f $sysroot/made_of && $(<"$sysroot/made_of") == "$wanted" ]]; then
  exit 0
fi

echo "Fetching packages for arm64: ${packages[*]}"
work=$sysroot.work
rm -rf "$work"
private_apt "$work" deb -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Install-Recommends=false
quietly "$work/log" "${apt[@]}" install -y --download-only "${packages[@]}"

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
