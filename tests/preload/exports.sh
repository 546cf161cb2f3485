#!/usr/bin/env bash
# The library shows nothing but Embree's names, needs no Embree by itself, and stands before all it must.
# Usage: exports.sh LIBRARY MAJOR
set -euo pipefail
library=$1
major=$2
fail() { echo "$1" >&2; exit 1; }

foreign=$(nm -D --defined-only "$library" | awk '$2 != "A" && $3 !~ /^rtc/ { print $3 }')
[ -z "$foreign" ] || fail "exported besides rtc*: $foreign"
wanted=$(nm -D --undefined-only "$library" | awk '$2 ~ /^rtc/ { print $2 }')
[ -z "$wanted" ] || fail "wanted from Embree at load time: $wanted"
! readelf -d "$library" | grep -q 'NEEDED.*embree' || fail "the library needs Embree itself"

exported=$(nm -D --defined-only "$library" | awk '{ print $3 }')
for name in rtcNewDevice rtcNewScene rtcNewGeometry rtcCommitScene rtcJoinCommitScene rtcPointQuery16 rtcCollide; do
  grep -qx "$name" <<< "$exported" || fail "$name is not exported"
done
# What is called for each ray goes straight to Embree 3; 4 lets rays bring callbacks that would be called for our geometry.
rays=(rtcIntersect{1,4,8,16} rtcOccluded{1,4,8,16})
if [ "$major" -ge 4 ]; then
  for name in "${rays[@]}" "${rays[@]/rtc/rtcTraversable}"; do
    grep -qx "$name" <<< "$exported" || fail "$name is not exported"
  done
  rays=()
fi
for name in "${rays[@]}" rtcGetGeometry rtcGetGeometryUserData rtcInterpolate; do
  ! grep -qx "$name" <<< "$exported" || fail "$name is exported"
done
