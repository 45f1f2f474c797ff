#!/usr/bin/env bash
# Prints the speed tables of README and of instructions.md: times of all stages with their ratio to the yardsticks of the
# same run, and instruction counts, which are repeatable where times are not.
#
#   test/benchmark/speed_table.sh [BUILD] [SEQUENCE]     BUILD: the build folder (build); SEQUENCE: a real depth sequence
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
[ $# -lt 2 ] || export FACETLOC_BENCHMARK_SEQUENCE=$2
bin=$build/test/benchmark
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# Lines of: name, time, unit, processor time, unit, ...
run() { "$bin/$1" --benchmark_color=false --benchmark_min_time="${3:-1}" --benchmark_filter="$2" 2>/dev/null; }

echo "Processor time of one core, $(nproc)-core machine, $(sed -n 's/^model name.*: //p;T;q' /proc/cpuinfo)"
echo
run benchmark_segmentation . > "$out/segmentation"
for source in 0 1; do
  [ $source = 0 ] && echo "| simulated room | 320x240 | x (a) | 640x480 | x (a) | (b) / it |" \
                  || echo "| real images | 320x240 | x (a) | 640x480 | x (a) | (b) / it |"
  echo "|---|---|---|---|---|---|"
  awk -v real="real:$source" '
    $5 == "ms" && index($1, real) {
      split($1, part, "/"); sub("width:", "", part[2]); ms[part[1], part[2]] = $4
      if (!(part[1] in seen)) { seen[part[1]] = 1; order[++n] = part[1] } }
    END {
      if (n == 0) { print "| no sequence given | | | | | |"; exit }
      for (i = 1; i <= n; ++i) { s = order[i]
        printf "| %s | %.2f ms | %.1f | %.2f ms | %.1f | %.1f |\n", s, ms[s, 320], ms[s, 320] / ms["yardstickMoments", 320],
               ms[s, 640], ms[s, 640] / ms["yardstickMoments", 640], ms["yardstickPcl", 640] / ms[s, 640] } }
  ' "$out/segmentation"
  echo
done
echo "(a) yardstickMoments: one pass that reads the image and accumulates moments; (b) yardstickPcl: integral-image normals"
echo "and OrganizedMultiPlaneSegmentation, at 640x480."
echo
echo "| localization, one view | processor time |"
echo "|---|---|"
run benchmark_localization . 3 | awk '$5 == "ms" { split($1, part, "/"); sub("models:", "", part[2])
  printf "| %s local models, %s%s | %.1f ms |\n", part[2], part[3] == "dense:1" ? "all dense steps" : "planes only",
         part[4] == "shortlist:0" ? ", without a shortlist" : "", $4 }'

command -v valgrind >/dev/null || { echo; echo "no valgrind: no instruction counts"; exit 0; }
# Instructions of one call of a function, callees included.
count() {
  valgrind --tool=callgrind --callgrind-out-file="$out/callgrind" --collect-atstart=no "--toggle-collect=$3" \
    "$bin/$1" "--benchmark_filter=$2" --benchmark_min_time=0.000001 >/dev/null 2>&1
  local instructions
  instructions=$(sed -n 's/^summary: //p' "$out/callgrind")
  [ "${instructions:-0}" -gt 0 ] || { echo "callgrind has seen no call of $3" >&2; return 1; }
  echo "$instructions"
}
echo
echo "| hot path | instructions |"
echo "|---|---|"
for width in 320 640; do
  n=$(count benchmark_segmentation "^segmentationAndFeatures/width:$width/real:0" \
      'facetloc::ViewBuilder::build(facetloc::DepthImage const&, facetloc::View&)')
  echo "| view of the simulated room at width $width | $(awk "BEGIN { printf \"%.1f\", $n / 1e6 }") M |"
done
for dense in 0 1; do
  n=$(count benchmark_localization "^localization/models:12/dense:$dense/shortlist:1" \
      'facetloc::GlobalLocalization::localize(facetloc::View const&) const')
  [ $dense = 0 ] && what="planes only" || what="all dense steps"
  echo "| one view in 12 local models with the shortlist, $what | $(awk "BEGIN { printf \"%.1f\", $n / 1e6 }") M |"
done
