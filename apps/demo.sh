#!/usr/bin/env bash
# From a clone to a result: installs the packages, builds the tools and repeats the paper's experiment in small. A
# simulated office floor is mapped from one drive of a depth camera, the images of that drive and of a later one are
# localized in the map, and tables and pictures say how good that was. In full: apps/README.md.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
build=${FACETLOC_BUILD:-$root/build}
out=${1:-$root/out/demo}

"$root/cmake/install_dependencies.sh"
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DFACETLOC_BUILD_TESTS=OFF >/dev/null
cmake --build "$build" --target facetloc_{simulate,map,segment,localize,render,evaluate}
bin=$build/apps

mkdir -p "$out"
rm -rf "$out"/{office,segments,results,evaluation,office.flmap,fig1.png,map.png}  # of an earlier demo
"$bin/facetloc_simulate" office -o "$out/office" --seed 1 --width 320
"$bin/facetloc_map" build "$out/office/map" -o "$out/office.flmap"
"$bin/facetloc_map" check "$out/office.flmap"
"$bin/facetloc_segment" "$out/office/query" -o "$out/segments" --overlay
for run in map query; do
  "$bin/facetloc_localize" "$out/office.flmap" "$out/office/$run" -o "$out/results/$run"
done
"$bin/facetloc_render" "$out/office/query/depth/1000.000000.png" -o "$out/fig1.png"
"$bin/facetloc_render" "$out/office.flmap" -o "$out/map.png" --trajectory "$out/office/query"
"$bin/facetloc_evaluate" "$out/results" "$out/office" --map "$out/office.flmap" -o "$out/evaluation" --table-paper

cat <<TEXT

Where things are:
  report with all pictures  ${out}/evaluation/report.html
  map to turn, with answers ${out}/evaluation/map.html
  tables, charts, failures  ${out}/evaluation
  one image, the floor map  ${out}/fig1.png ${out}/map.png
  images of both drives     ${out}/office/{map,query}/depth
  segment overlays          ${out}/segments
  map                       ${out}/office.flmap
  ranked poses per image    ${out}/results/{map,query}/hypotheses.csv
TEXT
