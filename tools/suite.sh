# Sourced by tools/package: another version of Debian in a folder of its own, in which this source is built and packed.

# the archive that apt has its packages of Debian from
debian_mirror() {
  apt-get indextargets --format '$(REPO_URI)' 'Label: Debian' 'Created-By: Packages' | head -1
}

# become_root ARGUMENT...: starts the script again as root, if it is not
become_root() {
  [ "$(id -u)" -ne 0 ] || return 0
  command -v sudo >/dev/null || die "not root and no sudo: another Debian is set up by an administrator" 69
  exec sudo "$root/tools/$(basename "$0")" "$@"
}

# new_debian SUITE FOLDER LOG [PACKAGE]: a minimal system there, from where apt has its packages. Its dpkg does not wait for
# the disk after every file.
new_debian() {
  mkdir -p "$2/etc/dpkg/dpkg.cfg.d"
  echo force-unsafe-io >"$2/etc/dpkg/dpkg.cfg.d/no-waiting"
  debootstrap --variant=minbase ${4:+"--include=$4"} "$1" "$2" "$(debian_mirror)" >"$3" 2>&1 || { tail -5 "$3" >&2; return 1; }
}

# make_suite SUITE FOLDER: the system, whole or not at all
make_suite() {
  [ ! -d "$2" ] || return 0
  say "setting up Debian $1 in $2"
  rm -rf "$2.part"
  mkdir -p "$(dirname "$2")"
  new_debian "$1" "$2.part" "$2.log" git || die "debootstrap cannot set up Debian $1; all of it is in $2.log" 69
  mv "$2.part" "$2"
}

# package_in_suite SUITE, as root: build/packages of this source as that Debian makes them. The system and what is built in it stay
# in build/suites/SUITE; what is mounted there is seen by this call alone, and gone with it.
package_in_suite() {
  local folder=$root/build/suites/$1
  install_packages packages.suite
  make_suite "$1" "$folder"
  mkdir -p "$folder/umax" "$folder/umax-build" "$root/build/packages"
  unshare --mount bash -euc '
    mount --bind "$1" "$2/umax"
    mount --bind "$2/umax-build" "$2/umax/build"
    mount -t proc proc "$2/proc"
    mount -t devpts devpts "$2/dev/pts" 2>/dev/null || true
    chroot "$2" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 HOME=/root /umax/tools/package
  ' bash "$root" "$folder" || die "no packages for Debian $1" 70
  rm -f "$root/build/packages"/*"~$(suite_name "$folder")"_amd64.deb
  cp "$folder"/umax-build/packages/*.deb "$root/build/packages/"
}

# suite_name FOLDER: "deb13", of the system in that folder ("": this one)
suite_name() {
  local name
  name=deb$(. "$1/etc/os-release" && echo "${VERSION_ID:-}")
  [ "$name" != deb ] || die "this Debian does not say which version it is ($1/etc/os-release)" 69
  echo "$name"
}
