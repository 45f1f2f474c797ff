#!/usr/bin/env bash
# Prints the speed tables of README, row by row, and with valgrind installed instruction counts (instructions.md), which
# are repeatable where times are not; those with 142 local models take minutes. README leaves out the row of 12 local models
# with planes only.
#
#   test/benchmark/speed_table.sh [BUILD] [SEQUENCE]     BUILD: the build folder (build); SEQUENCE: a real depth sequence
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
if [ $# -ge 2 ]; then
  [ -d "$2" ] || { echo "speed_table.sh: no folder $2" >&2; exit 1; }
  export FACETLOC_BENCHMARK_SEQUENCE=$2
fi
bin=$build/test/benchmark
[ -x "$bin/benchmark_localization" ] || { echo "speed_table.sh: no benchmarks in $build" >&2; exit 1; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# Lines of: name, time, unit, processor time, unit, ...
run() { "$bin/$1" --benchmark_color=false --benchmark_min_time="${3:-1}" --benchmark_filter="$2" 2>/dev/null; }

echo "Processor time of one core, $(nproc)-core machine, $(sed -n 's/^model name.*: //p;T;q' /proc/cpuinfo)"
if commit=$(git -C "$root" describe --always --dirty 2>/dev/null); then echo "Commit $commit"; fi
echo
run benchmark_segmentation . > "$out/segmentation"
# A stage, of the simulated room (0) or of real images (1), beside the yardsticks of the same images.
awk '
  $5 == "ms" {
    split($1, part, "/"); sub("width:", "", part[2]); sub("real:", "", part[3])
    ms[part[1], part[2], part[3]] = $4
    if (match($0, /segments=[0-9.]+/)) segments[part[1], part[2], part[3]] = substr($0, RSTART + 9, RLENGTH - 9) }
  function ratio(x) { return x == 1 ? "1" : sprintf(x < 20 ? "%.1f" : "%.0f", x) }
  function row(name, stage, real, digits,    t3, t6) {
    t3 = ms[stage, 320, real]; t6 = ms[stage, 640, real]
    if (t3 == 0 || t6 == 0) { print "| " name " | not measured: no sequence | | | | |"; return }
    printf "| %s | %.*f ms | %s | %.*f ms | %s | %s |\n", name,
           digits, t3, ratio(t3 / ms["yardstickMoments", 320, real]),
           digits, t6, ratio(t6 / ms["yardstickMoments", 640, real]), ratio(ms["yardstickPcl", 640, real] / t6) }
  END {
    print "| | 320x240 | x (a) | 640x480 | x (a) | (b) / it at 640x480 |"
    print "|---|---|---|---|---|---|"
    row("(a)", "yardstickMoments", 0, 2)
    row("(b)", "yardstickPcl", 0, 1)
    row("noise of the image", "noise", 0, 2)
    row("split", "split", 0, 1)
    row("merge", "merge", 0, 1)
    row("features", "features", 0, 1)
    row("segmentation and features", "segmentationAndFeatures", 0, 1)
    row("of real images", "segmentationAndFeatures", 1, 1)
    row("by triangles", "segmentationAndFeaturesByTriangles", 0, 1)
    row("by triangles, of real images", "segmentationAndFeaturesByTriangles", 1, 1)
    print ""
    print "(a) yardstickMoments: one pass that reads the image and accumulates moments; (b) yardstickPcl: integral-image"
    print "normals and OrganizedMultiPlaneSegmentation; of real images beside (a) and (b) of these."
    printf "Segments at 320x240 and 640x480: %s and %s", segments["segmentationAndFeatures", 320, 0],
           segments["segmentationAndFeatures", 640, 0]
    if (ms["yardstickPcl", 640, 1] > 0)
      printf ", of real images %s and %s", segments["segmentationAndFeatures", 320, 1],
             segments["segmentationAndFeatures", 640, 1]
    printf "; by PCL at 640x480: %s", segments["yardstickPcl", 640, 0]
    if (ms["yardstickPcl", 640, 1] > 0) printf ", of real images %s", segments["yardstickPcl", 640, 1]
    print "." }
' "$out/segmentation"
echo
run benchmark_localization . 3 > "$out/localization"
awk '
  function time(models, dense, shortlist,    t) {
    t = ms[models, dense, shortlist]
    return t == "" ? "" : sprintf(t < 9.95 ? "%.1f ms" : "%.0f ms", t) }
  function row(models, dense, words) {
    if (time(models, dense, 1) time(models, dense, 0) != "")
      print "| " models words " | " time(models, dense, 1) " | " time(models, dense, 0) " |" }
  $5 == "ms" {
    split($1, part, "/"); for (i = 2; i <= 4; ++i) sub(".*:", "", part[i])
    ms[part[2], part[3], part[4]] = $4
    if (match($0, /segments_per_model=[0-9.]+/)) {
      n = substr($0, RSTART + 19, RLENGTH - 19)
      if (least == "" || n + 0 < least) least = n + 0
      if (n + 0 > most) most = n + 0 } }
  END {
    printf "| local models, of %.0f to %.0f segments | with the shortlist | with all |\n", least, most
    print "|---|---|---|"
    row(142, 0, ", planes only"); row(142, 1, ", with all dense steps")
    row(30, 1, ""); row(12, 0, ", planes only"); row(12, 1, ""); row(5, 1, ""); row(2, 1, "") }
' "$out/localization"

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
for models in 12 142; do
  for dense in 0 1; do
    n=$(count benchmark_localization "^localization/models:$models/dense:$dense/shortlist:1" \
        'facetloc::internal::GlobalLocalization::localize(facetloc::View const&) const')
    [ $dense = 0 ] && what="planes only" || what="all dense steps"
    echo "| one view in $models local models with the shortlist, $what | $(awk "BEGIN { printf \"%.1f\", $n / 1e6 }") M |"
  done
done
