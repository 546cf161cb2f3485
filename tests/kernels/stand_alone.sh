#!/usr/bin/env bash
# The kernels need none of Embree, OpenEXR, OpenSubdiv, GLFW, and share no inline function between sources that are
# compiled for different instruction sets. layout/ and simd/ need nothing above them, and each part of the traversal can
# be parsed alone. Usage: stand_alone.sh LIBRARY SOURCE_FOLDER
set -euo pipefail
library=$1 sources=$2

if grep -rnE '#include *[<"](embree|rtcore|Imf|OpenEXR|Imath|opensubdiv|GLFW|GL/)' "$sources"; then
  echo "a kernel source includes a library that only the other folders may use" >&2
  exit 1
fi
if nm --undefined-only --demangle "$library" 2>/dev/null | grep -E ' (rtc[A-Z]|Imf_|glfw|OpenSubdiv)'; then
  echo "the kernels call a library that only the other folders may use" >&2
  exit 1
fi

for folder in layout include simd; do
  if grep -rnE '#include "(builder|traverse|plugin|harness)/' "$sources/$folder"; then
    echo "$folder/ includes what is above it" >&2
    exit 1
  fi
done
for part in "$sources"/traverse/*.inl; do
  if ! ${CXX:-c++} -std=c++20 -fsyntax-only -w -x c++ -I "$sources" -I "$sources/include" "$part"; then
    echo "$(basename "$part") does not include what it uses" >&2
    exit 1
  fi
done

# Weak symbols are what the linker may take from either object: the vector sources must define none, and nothing
# strong but their kernel table.
objects=$(mktemp -d)
trap 'rm -rf "$objects"' EXIT
(cd "$objects" && ar x "$library")
for object in "$objects"/traverse_*.o; do
  shared=$(nm --defined-only --demangle "$object" | grep -E ' [BDRTVWu] ' | grep -vE 'stbvh::k[A-Za-z0-9]+Kernels$' || true)
  if [ -n "$shared" ] && ! nm "$object" | grep -qE '__(asan|tsan|ubsan)_'; then
    echo "$(basename "$object") defines symbols that another source could be given:" >&2
    echo "$shared" >&2
    exit 1
  fi
done
echo "kernels stand alone"
