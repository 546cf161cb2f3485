# Shell functions that harness/run, tests/run and .ci/run share; to be sourced by bash.

# What the build needs beyond Debian 12's base system, and what the tests and CI need besides.
build_packages=(cmake ninja-build g++ git libembree-dev libtbb-dev libxxhash-dev libfmt-dev libpng-dev libopenexr-dev
  libosd-dev nlohmann-json3-dev libcli11-dev libgmp-dev libbenchmark-dev libpugixml-dev libglfw3-dev libimgui-dev
  libgl-dev pkgconf)
test_packages=(libgtest-dev embree-tools pkgconf python3 xvfb libgl1-mesa-dri libx11-dev)
processor_packages=(qemu-user)
chart_packages=(python3-matplotlib)
shot_packages=(python3-venv)
farm_packages=(slurmctld slurmd slurm-client munge)
rules_packages=(clang-format git python3)
package_packages=(help2man dpkg-dev binutils file)
fuzz_packages=(clang-14 libclang-rt-14-dev)

# ensure_packages PACKAGE...: installs those that are missing; touches neither apt nor the network if none is.
ensure_packages() {
  local missing=() package
  for package in "$@"; do
    if [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
      missing+=("$package")
    fi
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "neither root nor sudo: please install ${missing[*]}" >&2; return 1; }
    as_root=(sudo)
  fi
  quietly "asking for packages" "${as_root[@]}" apt-get update
  quietly "installing ${missing[*]}" \
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"
}

# quietly WHAT COMMAND...: runs it and says so in one line, which on a terminal shows its last line. All that the command
# printed follows if it fails.
quietly() {
  local what=$1 log status=0
  shift
  log=$(mktemp)
  if [ -t 2 ]; then
    "$@" 2>&1 </dev/null | tee "$log" | one_line "$what" || status=$?
  else
    echo "$what" >&2
    "$@" >"$log" 2>&1 </dev/null || status=$?
  fi
  [ "$status" -eq 0 ] || cat "$log" >&2
  rm -f "$log"
  return "$status"
}

# one_line WHAT: shows each line of standard input over the one before.
one_line() {
  local width line
  width=$(tput cols 2>/dev/null || echo 80)
  while IFS= read -r line; do printf '\r\e[K%.*s' "$((width - 1))" "$1: $line" >&2; done
  printf '\r\e[K' >&2
}

# build_preset PRESET TARGET...: configures the preset (build/PRESET below the current folder) and builds the targets.
build_preset() {
  local preset=$1
  shift
  cmake --preset "$preset"
  cmake --build --preset "$preset" --target "$@"
}
