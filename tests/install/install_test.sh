#!/usr/bin/env bash
# The installed library, as an application sees it.
# Usage: install_test.sh STEP BUILD_FOLDER SOURCE_FOLDER CMAKE CC CXX EMBREE_MAJOR
# STEP `install` leaves a prefix in BUILD_FOLDER/tests/install/prefix, which the other steps use.
set -euo pipefail
step=$1 build=$2 source=$3 cmake=$4 cc=$5 cxx=$6 major=$7
work=$build/tests/install/embree$major
prefix=$build/tests/install/prefix
example=$source/plugin/examples/from_triangles
kernels_example=$source/kernels/examples/two_meshes

fail() { echo "$*" >&2; exit 1; }
name=stbvh
[ "$major" = 3 ] || name=stbvh$major
other_major=$((7 - major))
library() { find "$prefix" -name "lib$name.so"; }
use_pkg_config() { PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name "$name.pc")"); export PKG_CONFIG_PATH; }
flags() { pkg-config "$@" "$name"; }
# Where the application finds us, and the Embree of this build.
prefixes="$prefix;$(sed -n 's/^CMAKE_PREFIX_PATH:[A-Z]*=//p' "$build/CMakeCache.txt")"
project_version() { sed -n 's/^project(stbvh VERSION \([0-9.]*\).*/\1/p' "$source/CMakeLists.txt"; }
export CMAKE_GENERATOR=Ninja  # as the project itself: make need not be there
mkdir -p "$work"
warnings=(-pedantic -Wall -Wextra -Werror)

# Installed, then moved: nothing that is found later may name the first place.
install_and_move() {
  rm -rf "$prefix" "$work/first"
  "$cmake" --install "$build" --prefix "$work/first" > "$work/install.log"
  mv "$work/first" "$prefix"
  ! grep -rlI --exclude-dir=doc -e "$work/first" -e "$source" "$prefix" || fail "these name the place where they were made"
  [ "$(find "$prefix" -name '*.a' -printf '%f\n')" = libstbvh_kernels.a ] || fail "other static libraries than the kernels"
}

# Exactly what the header declares for this Embree, and nothing of C++.
exports() {
  use_pkg_config
  # shellcheck disable=SC2046  # the flags are words
  diff <("$cc" -E -P $(flags --cflags) -x c "$(find "$prefix" -name stbvh_embree.h)" | tr '\n' ' ' |
      grep -oP '__attribute__\(\(visibility\("default"\)\)\) [^;(]*?\K\w+(?=\()' | sort) \
    <(nm --dynamic --defined-only "$(library)" | awk '{ print $3 }' | sort) ||
    fail "left: what the header declares; right: what the library exports"
}

soname() {
  local version
  version=$(project_version)
  readelf --dynamic "$(library)" | grep -qF "soname: [lib$name.so.${version%.*}]" || fail "not the soname of version $version"
  [ "$(basename "$(readlink -f "$(library)")")" = "lib$name.so.$version" ] || fail "the file is not that of version $version"
  use_pkg_config
  [ "$(flags --modversion)" = "$version" ] || fail "$name.pc has another version than $version"
  [ "$(pkg-config --modversion stbvh-kernels)" = "$version" ] || fail "stbvh-kernels.pc has another version than $version"
  grep -qxF "#define STBVH_VERSION_STRING \"$version\"" "$(find "$prefix" -name stbvh_embree.h)" ||
    fail "the header has another version than $version"
}

check_example() {
  "$1" > "$1.log" || { cat "$1.log"; fail "the example failed"; }
  grep -q ' rays hit, 0 differ$' "$1.log" || fail "the example does not say what it found"
}

by_cmake() {
  rm -rf "$work/by_cmake"
  "$cmake" -S "$example" -B "$work/by_cmake" -DCMAKE_PREFIX_PATH="$prefixes" -DCMAKE_C_COMPILER="$cc" \
    -DCMAKE_C_FLAGS="-std=c99 ${warnings[*]}"
  "$cmake" --build "$work/by_cmake"
  check_example "$work/by_cmake/from_triangles"
}

# A version that is not there must be refused by the version file, not by the compiler.
by_cmake_version() {
  local wanted
  for wanted in 0.0 0.2 1.0; do
    mkdir -p "$work/version"
    printf 'cmake_minimum_required(VERSION 3.16)\nproject(p LANGUAGES NONE)\nfind_package(stbvh %s REQUIRED)\n' "$wanted" \
      > "$work/version/CMakeLists.txt"
    rm -rf "$work/version/build"
    ! "$cmake" -S "$work/version" -B "$work/version/build" -DCMAKE_PREFIX_PATH="$prefixes" > "$work/version.log" 2>&1 ||
      fail "version $wanted was found"
    tr -s ' \n' ' ' < "$work/version.log" | grep -q "compatible with requested version \"$wanted\"" ||
      { cat "$work/version.log"; fail "refused for another reason"; }
  done
}

# The component of a major, the application's own Embree, and the other major, which is refused where it is not installed.
by_cmake_major() {
  configure() {
    mkdir -p "$work/major"
    printf 'cmake_minimum_required(VERSION 3.16)\nproject(p LANGUAGES C CXX)\n%s\n' "$1" > "$work/major/CMakeLists.txt"
    rm -rf "$work/major/build"
    "$cmake" -S "$work/major" -B "$work/major/build" -DCMAKE_PREFIX_PATH="$prefixes" -DCMAKE_C_COMPILER="$cc" \
      -DCMAKE_CXX_COMPILER="$cxx" > "$work/major.log" 2>&1
  }
  configure "find_package(stbvh 0.1 REQUIRED COMPONENTS embree$major)
    get_target_property(d stbvh::stbvh INTERFACE_COMPILE_DEFINITIONS)
    if(NOT d STREQUAL \"STBVH_EMBREE_MAJOR=$major\")
      message(FATAL_ERROR \"\${d}\")
    endif()" || { cat "$work/major.log"; fail "the component embree$major was not found"; }
  configure "find_package(embree $major REQUIRED)
    add_subdirectory($example example)" || { cat "$work/major.log"; fail "not found after Embree"; }
  "$cmake" --build "$work/major/build"
  check_example "$work/major/build/example/from_triangles"
  [ "$(readelf --dynamic "$work/major/build/example/from_triangles" | grep -oE '(embree|stbvh)[34]?\.so' | sort)" = \
    "embree$major.so
$name.so" ] || fail "the example is linked with other libraries than $name and embree$major"
  [ ! -e "$(dirname "$(library)")/cmake/stbvh/stbvh-embree$other_major-targets.cmake" ] || return 0
  ! configure "find_package(stbvh 0.1 REQUIRED COMPONENTS embree$other_major)" || fail "Embree $other_major was found"
  tr -s ' \n' ' ' < "$work/major.log" | grep -q "Embree $other_major and the STBVH library for it are not both installed" ||
    { cat "$work/major.log"; fail "refused for another reason"; }
}

# All that differs between the majors, for the other one, where both are installed.
both_majors() {
  if [ -z "$(find "$prefix" -name "stbvh-embree$other_major-targets.cmake")" ]; then
    echo "Embree $other_major is not installed"
    exit 77
  fi
  local step
  for step in exports soname by_cmake_major mixed_majors by_pkg_config header nodiscard; do
    "$0" "$step" "$build" "$source" "$cmake" "$cc" "$cxx" "$other_major" || fail "$step, with Embree $other_major"
  done
}

# A program that has included one Embree and is told that the library is for the other.
mixed_majors() {
  use_pkg_config
  # shellcheck disable=SC2046
  ! "$cc" -fsyntax-only $(flags --cflags) -USTBVH_EMBREE_MAJOR -DSTBVH_EMBREE_MAJOR="$other_major" -x c - \
    2> "$work/mixed_majors.log" <<< "#include <embree$major/rtcore.h>
#include <stbvh/stbvh_embree.h>" || fail "the two majors were mixed up"
  grep -q 'for another major version of Embree' "$work/mixed_majors.log" ||
    { cat "$work/mixed_majors.log"; fail "no clear error"; }
}

by_pkg_config() {
  use_pkg_config
  local program files
  for program in from_triangles moving_triangles; do
    files=("$source/plugin/examples/$program"*.c)
    [ "$program" = moving_triangles ] || files=("$example"/*.c)
    # shellcheck disable=SC2046  # the flags are words
    "$cc" -std=c99 "${warnings[@]}" "${files[@]}" -o "$work/$program" $(flags --cflags --libs) -lm
  done
  LD_LIBRARY_PATH=$(flags --libs-only-L | sed 's/^-L//; s/ *-L/:/g; s/ *$//')
  export LD_LIBRARY_PATH
  check_example "$work/from_triangles"
  "$work/moving_triangles"
}

# The installed harness, where it was built, finds its scripts: they refuse what holds no records.
harness() {
  [ -e "$prefix/bin/stbvh-ab" ] || return 0
  ! "$prefix/bin/stbvh-ab" charts "$source/README.md" -o "$work/charts" > "$work/charts.log" 2>&1 || fail "records in README.md"
  grep -q 'README\.md' "$work/charts.log" || { cat "$work/charts.log"; fail "the script was not found"; }
}

# The kernels alone, by CMake and by pkg-config; their headers are out of the way of those who use the plugin.
kernels() {
  use_pkg_config
  rm -rf "$work/kernels"
  "$cmake" -S "$kernels_example" -B "$work/kernels" -DCMAKE_PREFIX_PATH="$prefixes" -DCMAKE_CXX_COMPILER="$cxx" \
    -DCMAKE_CXX_FLAGS="${warnings[*]}"
  "$cmake" --build "$work/kernels"
  "$work/kernels/two_meshes"
  # shellcheck disable=SC2046
  "$cxx" -std=c++20 "${warnings[@]}" "$kernels_example/two_meshes.cpp" -o "$work/two_meshes" \
    $(pkg-config --cflags --libs stbvh-kernels)
  "$work/two_meshes"
  ! readelf --dynamic "$work/two_meshes" | grep -q 'NEEDED.*\(embree\|libstbvh\)' || fail "the kernels need Embree"
  [ "$(cd "$prefix"/include/stbvh && echo ./*)" = ./stbvh_embree.h ] || fail "other headers beside the plugin's"
  local header
  for header in "$prefix"/include/stbvh-kernels/stbvh/*.h; do
    # shellcheck disable=SC2046
    "$cxx" -std=c++20 "${warnings[@]}" -fsyntax-only -x c++ $(pkg-config --cflags stbvh-kernels) - \
      <<< "#include <stbvh/$(basename "$header")>" || fail "$header cannot be included alone"
  done
}

# The installed script finds the installed library, which takes over what the example gives to Embree.
preload() {
  use_pkg_config
  # shellcheck disable=SC2046
  "$cc" -std=c99 "$example"/*.c -o "$work/preload" $(flags --cflags --libs) -lm
  printf '#!/bin/sh\nLD_LIBRARY_PATH=%s exec %s/bin/stbvh-run --json %s %s\n' "$(dirname "$(library)")" "$prefix" \
    "$work/preload.json" "$work/preload" > "$work/preload.sh"
  chmod +x "$work/preload.sh"
  rm -f "$work/preload.json"
  check_example "$work/preload.sh"
  grep -q '"meshes_taken_over": 1' "$work/preload.json" || fail "nothing was taken over"
}

# The header alone, in the languages that it is for.
header() {
  use_pkg_config
  local language compiler
  for language in c99 c11 c++11 c++14 c++17 c++20; do
    case $language in c++*) compiler=("$cxx" -x c++) ;; *) compiler=("$cc" -x c) ;; esac
    # shellcheck disable=SC2046
    "${compiler[@]}" "-std=$language" "${warnings[@]}" -fsyntax-only $(flags --cflags) - <<< '#include <stbvh/stbvh_embree.h>
      void use(void); void use(void) { struct StbvhMeshArguments mesh; stbvhInitMeshArguments(&mesh); (void)mesh; }' ||
      fail "the header is not $language"
  done
}

# Compilers warn where an error is dropped, and only there.
nodiscard() {
  use_pkg_config
  local language compiler function
  for language in c99 c++11 c++17; do
    case $language in c++*) compiler=("$cxx" -x c++) ;; *) compiler=("$cc" -x c) ;; esac
    for function in 'AddMesh(g, a, 0)' 'SetMesh(g, 0, a)' 'GetMesh(g, 0, a)' 'CommitGeometry(g)' 'GetStatistics(g, s)' \
      'SetGeometryPrecision(g, STBVH_PRECISION_FAST)' 'SetGeometryMaxBytes(g, 1, 1)' \
      'SetGeometryTolerance(g, 0)' 'SetGeometryProgressFunction(g, 0, 0)'; do
      try() {
        # shellcheck disable=SC2046
        "${compiler[@]}" "-std=$language" "${warnings[@]}" -S -o /dev/null $(flags --cflags) - 2> "$work/nodiscard.log" << END
#include <stbvh/stbvh_embree.h>
int use(StbvhGeometry g, struct StbvhMeshArguments* a, struct StbvhStatistics* s);
int use(StbvhGeometry g, struct StbvhMeshArguments* a, struct StbvhStatistics* s) { (void)a; (void)s; (void)g; $1 return 0; }
END
      }
      try "if (stbvh$function) return 1;" || { cat "$work/nodiscard.log"; fail "$language: stbvh$function is no error to check"; }
      ! try "stbvh$function;" || fail "$language: no warning where the error of stbvh$function is dropped"
      grep -qE 'unused.result|nodiscard' "$work/nodiscard.log" || { cat "$work/nodiscard.log"; fail "another warning"; }
    done
  done
}

# How much an application has to change: the lines of one attach function, besides keeping and releasing the handle.
handful() {
  local new
  new=$(diff "$example/with_embree.c" "$example/with_stbvh.c" | grep -c '^> .*[^ ]') || true
  [ "$new" -gt 5 ] || fail "the two ways are no longer two"
  [ "$new" -le 20 ] || fail "$new lines differ: more than a handful"
}

case $step in
  install) install_and_move ;;
  exports | soname | by_cmake | by_cmake_version | by_cmake_major | both_majors | mixed_majors | by_pkg_config | kernels | \
    preload | harness | header | nodiscard | handful) "$step" ;;
  *) fail "no such step: $step" ;;
esac
