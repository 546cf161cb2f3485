# Shell functions that harness/run, tests/run and .ci/run share; to be sourced by bash.

# What the build needs beyond Debian 12's base system, and what the tests and CI need besides.
build_packages=(cmake ninja-build g++ git libembree-dev libtbb-dev libfmt-dev libpng-dev libopenexr-dev
  libosd-dev nlohmann-json3-dev libcli11-dev libgmp-dev libbenchmark-dev libpugixml-dev libglfw3-dev libimgui-dev
  libgl-dev pkgconf)
test_packages=(libgtest-dev embree-tools pkgconf python3 xvfb libgl1-mesa-dri libx11-dev)
processor_packages=(qemu-user)
chart_packages=(python3-matplotlib)
rules_packages=(clang-format git python3)
package_packages=(help2man dpkg-dev binutils)
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
  echo "installing ${missing[*]}" >&2
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "neither root nor sudo: please install ${missing[*]}" >&2; return 1; }
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}"
}

# build_preset PRESET TARGET...: configures the preset (build/PRESET below the current folder) and builds the targets.
build_preset() {
  local preset=$1
  shift
  cmake --preset "$preset"
  cmake --build --preset "$preset" --target "$@"
}
