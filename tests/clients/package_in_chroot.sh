#!/usr/bin/env bash
# The packages of tools/package: lintian finds no error in them, and in a fresh Debian without a compiler they are installed,
# drop a mesh and are imported. Prints how long the way to the first clip is, downloads left out. tools/package --try calls it.
# usage: package_in_chroot.sh PACKAGE_FOLDER [SUITE]    as root, or with sudo; needs debootstrap and lintian
# SUITE: "trixie"; without: the Debian that runs it
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/../../tools/suite.sh"
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
new_debian "$suite" "$root" "$scratch/debootstrap.log" || fail "debootstrap"
rm "$root/etc/dpkg/dpkg.cfg.d/no-waiting"  # from here on everything takes as long as it does for others
mount -t proc proc "$root/proc"
debs=("$packages"/*"~deb$(. "$root/etc/os-release" && echo "$VERSION_ID")_amd64.deb")
[ ${#debs[@]} -eq 3 ] || fail "there are ${#debs[@]} packages for $suite in $packages, not 3: run tools/package"
lintian --allow-root --fail-on error "${debs[@]}" || fail "lintian finds errors"
cp "${debs[@]}" "$root/tmp/"
cp "$(dirname "${BASH_SOURCE[0]}")/../support/octahedron.obj" "$root/tmp/mesh.obj"
within() { chroot "$root" env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 sh -euc "cd /tmp; $1" </dev/null; }
install='apt-get install -y -qq --no-install-recommends'
depends=$(dpkg-deb -f "$root"/tmp/umax_*.deb Depends)
for package in libc6 libembree libopenblas0-pthread ffmpeg fonts-dejavu-core libjs-chart.js libjs-three; do
  [[ ", $depends" == *", $package"* ]] || fail "umax does not depend on $package: $depends"
done
within "apt-get update -qq; $install -d ./umax_*.deb >/dev/null"

first_clip() {
  within "$install ./umax_*.deb >install.log 2>&1" || { tail -5 "$root/tmp/install.log"; fail "apt-get install"; }
  within 'umax drop mesh.obj --quick --quiet -o clip' || fail "umax drop"
}
load=$(cut -d' ' -f1 /proc/loadavg)
TIMEFORMAT='%R %U %S'
{ time first_clip 2>&3; } 3>&2 2>"$scratch/time"
[ -s "$root/tmp/clip/clip.mp4" ] || fail "there is no clip"
for file in bash-completion/completions/umax zsh/vendor-completions/_umax umax/scenes/figure.toml man/man1/umax.1.gz; do
  [ -s "$root/usr/share/$file" ] || fail "/usr/share/$file is missing"
done
grep -q "a work under the GPL" "$root/usr/share/doc/umax/copyright" || fail "copyright does not speak of the GPL"
within '! command -v g++ && ! command -v cc' || fail "a compiler came with it"
within 'doctor=$(umax doctor || true); echo "$doctor" | grep -q "umax-import reads"' ||
  fail "the helper program is not found"

within "$install ./python3-umax_*.deb >install.log 2>&1" || { tail -5 "$root/tmp/install.log"; fail "apt-get install python3-umax"; }
within 'python3 -c "import umax; s = umax.Simulation(\"beam\"); assert s.step().converged; print(s)"' || fail "import umax"
for deb in "${debs[@]}"; do echo "$(basename "$deb"): $(du -k "$deb" | cut -f1) kB"; done
awk -v load="$load" '{ printf "packages installed and the first clip made in %.0f s (%.0f s of processor time), asked: at most 90", $1, $2 + $3
  printf " on an idle machine; load before: %s\n", load }' "$scratch/time"
echo passed
