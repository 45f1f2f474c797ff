#!/usr/bin/env bash
# From a clone to a result: installs the packages, builds the tools, maps a simulated room from one drive of a depth
# camera, localizes the images of another drive in it, and says how good that was and where the pictures are.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
build=${FACETLOC_BUILD:-$root/build}
out=${1:-$root/out/demo}

"$root/cmake/install_dependencies.sh"
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DFACETLOC_BUILD_TESTS=OFF >/dev/null
cmake --build "$build"
bin=$build/apps

mkdir -p "$out"
rm -rf "$out"/{room,segments,results,evaluation,room.flmap}  # of an earlier demo
"$bin/facetloc_simulate" room -o "$out/room" --seed 2 --frames 60
"$bin/facetloc_segment" "$out/room/query" -o "$out/segments" --overlay --labels
"$bin/facetloc_map" build "$out/room/map" -o "$out/room.flmap"
"$bin/facetloc_map" check "$out/room.flmap"
"$bin/facetloc_localize" "$out/room.flmap" "$out/room/query" -o "$out/results"
"$bin/facetloc_evaluate" "$out/results" "$out/room/query/groundtruth.txt" --map "$out/room.flmap" -o "$out/evaluation"

cat <<TEXT

Where things are:
  images of both drives     ${out}/room/{map,query}/depth
  segments and overlays     ${out}/segments
  map                       ${out}/room.flmap
  ranked poses per image    ${out}/results/hypotheses.csv
  tables and charts         ${out}/evaluation
TEXT
