#!/usr/bin/env bash
# The packages of tools/package: lintian finds no error in them, and in a fresh Debian without a compiler they are installed,
# drop a mesh and are imported. Prints how long the way to the first clip is, downloads left out.
# usage: package_in_chroot.sh PACKAGE_FOLDER [SUITE]    as root, or with sudo; needs debootstrap and lintian
# SUITE: "trixie"; without: the Debian that runs it
set -euo pipefail
packages=$(realpath "$1")
suite=${2:-$(. /etc/os-release && echo "$VERSION_CODENAME")}
[ "$(id -u)" -eq 0 ] || exec sudo "$0" "$packages" "$suite"
fail() { echo "FAILED: $*"; exit 1; }
scratch=$(mktemp -d)
root=$scratch/root
finish() {
  mountpoint -q "$root/proc" && umount "$root/proc"
  rm -rf "$scratch"
}
trap finish EXIT
debootstrap --variant=minbase "$suite" "$root" >"$scratch/debootstrap.log" 2>&1 || { tail -5 "$scratch/debootstrap.log"; fail "debootstrap"; }
mount -t proc proc "$root/proc"
debs=("$packages"/*"~deb$(. "$root/etc/os-release" && echo "$VERSION_ID")_amd64.deb")
[ ${#debs[@]} -eq 3 ] || fail "there are ${#debs[@]} packages for $suite in $packages, not 3: run tools/package"
lintian --allow-root --fail-on error "${debs[@]}" || fail "lintian finds errors"
cp "${debs[@]}" "$root/tmp/"
cp "$(dirname "${BASH_SOURCE[0]}")/../support/octahedron.obj" "$root/tmp/mesh.obj"
within() { chroot "$root" env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 sh -euc "cd /tmp; $1" </dev/null; }
install='apt-get install -y -qq --no-install-recommends'
within "apt-get update -qq; $install -d ./umax_*.deb >/dev/null"

begin=$(date +%s.%N)
within "$install ./umax_*.deb >install.log 2>&1" || { tail -5 "$root/tmp/install.log"; fail "apt-get install"; }
within 'umax drop mesh.obj --quick --quiet -o clip' || fail "umax drop"
end=$(date +%s.%N)
[ -s "$root/tmp/clip/clip.mp4" ] || fail "there is no clip"
within '! command -v g++ && ! command -v cc' || fail "a compiler came with it"
within 'doctor=$(umax doctor || true); echo "$doctor" | grep -q "umax-import reads"' ||
  fail "the helper program is not found"

within "$install ./python3-umax_*.deb >install.log 2>&1" || { tail -5 "$root/tmp/install.log"; fail "apt-get install python3-umax"; }
within 'python3 -c "import umax; s = umax.Simulation(\"beam\"); assert s.step().converged; print(s)"' || fail "import umax"
for deb in "${debs[@]}"; do echo "$(basename "$deb"): $(du -k "$deb" | cut -f1) kB"; done
echo "$begin $end" | awk '{ printf "packages installed and the first clip made in %.0f s\n", $2 - $1 }'
echo passed
