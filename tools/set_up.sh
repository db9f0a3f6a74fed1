# Sourced by tools/demo, tools/test and tools/bench: installs the packages that are missing, configures the preset
# (release, unless `preset` names another one) and builds the targets that the array `targets` names. more_packages names
# further lists of packages.
# Defines: root (the source folder), build (build/release), jobs. Works from any current directory.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
preset=${preset:-release}
build=$root/build/$preset

. "$root/tools/install.sh"

# as many compilers as there are cores, but no more than one for every 1.5 GiB of memory
count_jobs() {
  local cores memory_kib by_memory
  cores=$(nproc)
  # without /proc (a bare chroot) there is no telling: as many as cores
  memory_kib=$(sed -n 's/^MemAvailable: *\([0-9]*\).*/\1/p' /proc/meminfo 2>/dev/null) || true
  by_memory=$((${memory_kib:-1000000000} / 1572864))
  [ "$by_memory" -ge 1 ] || by_memory=1
  echo $((cores < by_memory ? cores : by_memory))
}

build_targets() {
  say "configuring $build"
  (cd "$root" && cmake --preset "$preset" >"$build.log" 2>&1) ||
    { cat "$build.log" >&2; die "cmake failed" 70; }
  say "building ${targets[*]} with $jobs jobs"
  cmake --build "$build" --parallel "$jobs" --target "${targets[@]}" || die "the build failed" 70
}

mkdir -p "$root/build"
install_packages packages ${more_packages:-}
jobs=$(count_jobs)
build_targets
