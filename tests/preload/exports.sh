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
rays=(rtcIntersect{1,4,8,16} rtcOccluded{1,4,8,16})
if [ "$major" -ge 4 ]; then rays+=("${rays[@]/rtc/rtcTraversable}"); fi
for name in "${rays[@]}"; do
  grep -qx "$name" <<< "$exported" || fail "$name is not exported"
done
# Streams go straight to Embree 3, as does what is not changed by us.
for name in rtcIntersect{1M,1Mp,NM,Np} rtcOccluded{1M,1Mp,NM,Np} rtcGetGeometry rtcGetGeometryUserData rtcInterpolate; do
  ! grep -qx "$name" <<< "$exported" || fail "$name is exported"
done
