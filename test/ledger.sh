#!/usr/bin/env bash
# Measures the figures that no change may worsen, and compares them with test/ledger.tsv.
#
#   test/ledger.sh [--quick] [--update] [-b BUILD] [-d DATA] [-o OUT] [-j JOBS] [ROWS]
#
# Maps are built and images localized by the tools of BUILD (build), on the recordings of DATA ($FACETLOC_DATA, or ../shared/data) and on
# simulated floors. OUT (out/ledger) gets ledger.tsv, the measured values, and a log of each step. ROWS: a pattern such as 'drive.home*'
# or '*.sure_wrong'. JOBS (one per processor) steps run at a time, those that are timed alone.
#
# --quick leaves out large floors and the build: at most 8 minutes. --update writes the measured values into test/ledger.tsv and keeps its
# tolerances and reasons. Exit code 1: a row is worse than committed by more than its tolerance, or its line got worse without a new
# reason, or a step failed. Rows whose data is missing are skipped.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
build=$root/build data=${FACETLOC_DATA:-$root/../shared/data} out=$root/out/ledger jobs=$(nproc) quick=no update=no
usage() { sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; }
fail() { echo "ledger.sh: $1" >&2; exit "${2:-1}"; }
refused() { usage >&2; exit 2; }
pattern=
while [ $# -gt 0 ]; do
  case $1 in
    --quick) quick=yes ;;
    --update) update=yes ;;
    -b | -d | -o | -j)
      [ $# -ge 2 ] || refused
      case $1 in -b) build=$2 ;; -d) data=$2 ;; -o) out=$2 ;; -j) jobs=$2 ;; esac
      shift ;;
    -h | --help) usage; exit 0 ;;
    -*) refused ;;
    *)
      [ -z "$pattern" ] || refused
      pattern=$1 ;;
  esac
  shift
done
[[ $jobs =~ ^[1-9][0-9]*$ ]] || fail "-j needs a positive number" 2
pattern=${pattern:-*}
for tool in map localize evaluate simulate; do
  [ -x "$build/apps/facetloc_$tool" ] || fail "no facetloc_$tool in $build/apps: run test/run.sh, or name the build folder with -b"
done

mkdir -p "$out"
out=$(realpath "$out") build=$(realpath "$build")
[ ! -d "$data" ] || data=$(realpath "$data")
rm -rf "$out"/{work,log}
mkdir -p "$out/log" "$out/work"/{figures/quick,figures/full,maps,results}
cd "$out/work"
apps=$build/apps every=1
. "$root/test/benchmark/stages.sh"
exec 3>&1  # the terminal, where the output of a step is a file

ledger() { PYTHONDONTWRITEBYTECODE=1 python3 "$root/test/ledger.py" "$@"; }
figure() { printf '%s\t%s\n' "$1" "$2"; }
one=(--threads 1)

# --- Steps: functions that print figures

# wanted PREFIX: ROWS may name figures that begin so.
wanted() {
  local figure
  [[ $pattern != "$1".* ]] || return 0
  for figure in images rank1 sure sure_right sure_wrong sure_prob_mismatch first_sure in95 nees right converged; do
    # shellcheck disable=SC2053  # a pattern
    [[ $1.$figure != $pattern && $1 != $pattern ]] || return 0
  done
  return 1
}
# step WHEN NAME FUNCTION [ARGUMENT...]: begins as soon as fewer than $jobs others run. WHEN: quick, or full for the long ones.
steps=()
step() {
  [ "$1" = quick ] || [ $quick = no ] || return 0
  while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n || true; done
  steps+=("$1/$2")
  measured "$@" 2> "$out/log/$2.txt" &
}
measured() {
  local started=$SECONDS
  "${@:3}" > "figures/$1/$2.part"
  mv "figures/$1/$2"{.part,.tsv}
  [ ! -s "figures/$1/$2.tsv" ] || printf '%-24s %4d s\n' "$2" $((SECONDS - started)) >&3
}
# timed WHEN NAME FUNCTION [ARGUMENT...]: a step with both processors to itself.
timed() {
  wait
  jobs=1 step "$@"
  wait
}
present() { has "$1" >&3; }

# --- Places: a map, and the later run localized in it

# Conditions of thinned for the images of a drive that are kept.
declare -A kept=([gaps]='n % 30 < 15' [2s]='t % 4 < 2' [10s]='t % 12 < 2' [60s]='t % 75 < 15')

# localizedAs NAME RUN VARIANT: single, drive, or drive_GAP with images left out.
localizedAs() {
  local run=$2 gap=${3#drive_} options=("${one[@]}")
  [ "$3" = single ] || options+=(--sequence)
  if [ -n "${kept[$gap]:-}" ]; then
    run=gaps/$1/$gap
    thinned "$2" "$run" "${kept[$gap]}"
  fi
  "$apps/facetloc_localize" "maps/$1.flmap" "$run" -o "results/$1/$3" --quiet "${options[@]}" >&2
}
# rowsOf NAME VARIANT: the prefix of its figures
rowsOf() { echo "${2%%_*}.$1${2#"${2%%_*}"}"; }
# chosen NAME VARIANT...: sets variants to those whose figures are wanted; false if there are none.
chosen() {
  local variant
  variants=()
  for variant in "${@:2}"; do ! wanted "$(rowsOf "$1" "$variant")" || variants+=("$variant"); done
  [ ${#variants[@]} -gt 0 ]
}
# localizedIn NAME MAP_RUN LATER_RUN METRES DEGREES: builds the map, and localizes each of the variants in it.
localizedIn() {
  local variant
  madeMap "maps/$1.flmap" build "$2" "${one[@]}"
  for variant in "${variants[@]}"; do localizedAs "$1" "$3" "$variant"; done
  "$apps/facetloc_evaluate" "results/$1" "$3" -o "evaluations/$1" --quiet "${one[@]}" \
    --evaluation.max_translation "$4" --evaluation.max_rotation_deg "$5" >&2
  ledger answers "$1" "evaluations/$1/frames.csv" "$4" "$5"
}
# recording NAME FOLDER MAP LATER VARIANT...
recording() {
  chosen "$1" "${@:5}" && present "$2" || return 0
  localizedIn "$1" "$data/$2/$3" "$data/$2/$4" 0.3 5
}
# floor NAME SCENE SEED MAP_FRAMES LATER_FRAMES VARIANT...
floor() {
  chosen "$1" "${@:6}" || return 0
  place "$1" "$2" --seed "$3" --width 320 --map-frames "$4" --query-frames "$5" "${one[@]}"
  localizedIn "$1" "$1/map" "$1/query" 0.2 2
}

# heldOut NAME SCENE SEED MAP_FRAMES VARIANT...: a floor that chose nothing, but for home 32; 160 map images cover a part of it
heldOut() {
  chosen "$1" "${@:5}" || return 0
  place "$1" "$2" --seed "$3" --width 320 --map-frames "$4" --query-frames 160 "${one[@]}"
  localizedIn "$1" "$1/map" "$1/query" 0.3 5
}

# passage SEED VARIANT...: a corridor of equal doors, walked by a phone
passage() {
  local name=passage$1
  chosen "$name" "${@:2}" || return 0
  place "$name" passage --seed "$1" --camera phone_lidar --drive.camera_height 1.4 --drive.step 0.6 --pace.speed 1.2 \
    --map-frames 600 --query-frames 400 "${one[@]}"
  localizedIn "$name" "$name/map" "$name/query" 0.3 5
}

# unmapped SCENE SEED REACH: a floor whose map lacks what its later drive sees in its middle third: the images within REACH [m] of it
unmapped() {
  local name=unmapped_$1$2 run
  chosen "$name" single drive || return 0
  place "$name" "$1" --seed "$2" --width 320 --map-frames 240 --query-frames 160 "${one[@]}"
  run=$name/map
  mkdir -p "$name/seen/depth"
  cp "$run/camera.ini" "$name/seen"
  ledger outside "$run" "$name/query" "$3" > "$name/kept.txt"
  while read -r image; do ln -s "$(realpath "$run/depth/$image")" "$name/seen/depth"; done < "$name/kept.txt"
  cp "$run/groundtruth.txt" "$name/seen"
  localizedIn "$name" "$name/seen" "$name/query" 0.3 5
}

# Every second image of a place without true poses, in a map of the others.
cafe() {
  wanted single.cafe && present cafe || return 0
  thinned "$data/cafe" cafe/map 'n % 2 == 0'
  thinned "$data/cafe" cafe/query 'n % 2 == 1'
  madeMap maps/cafe.flmap build cafe/map "${one[@]}"
  localizedAs cafe cafe/query single
  ledger states single.cafe results/cafe/single
}

# --- Figures that are no place's

kitchenWithoutPoses() {
  wanted map.kitchen_without_poses_mm && present redkitchen || return 0
  "$apps/facetloc_map" build "$data/redkitchen/map" -o maps/own.flmap --without-poses --trajectory own.txt --quiet "${one[@]}" >&2
  "$apps/facetloc_evaluate" own.txt "$data/redkitchen/map" -o evaluations/own --quiet >&2
  figure map.kitchen_without_poses_mm "$(awk -F, '/^absolute translation/ { printf "%.1f", $4 }' evaluations/own/trajectory_summary.csv)"
}

# Pairs as in the stage peers of benchmark/all.sh.
pairs() {
  wanted pairs.d435 && present recordings/d435_desk && present redkitchen || return 0
  [ -x "$build/test/benchmark/score_pairs" ] || { echo "skipped: no score_pairs in $build" >&3; return 0; }
  bench score_pairs --clouds --count=60 --min_distance=0.2 --max_distance=0.8 --min_rotation_deg=0 --max_rotation_deg=30 \
    --min_overlap=0 --others="$data/redkitchen/map" "$data/recordings/d435_desk/map" |
    awk -v OFS='\t' '/^(Planar|Ekf)Registration/ { name = /^Ekf/ ? "pairs.d435_ekf" : "pairs.d435"
      print name ".right", $2; print name ".converged", $3; print name ".wrong_converged", $3 - $4 + $5 }'
}

# Times as ratios within one run: three rounds, the shortest time of each image, so that other processes count little.
speed() {
  { wanted speed || wanted cross.kitchen_in_office; } && present redkitchen || return 0
  local round
  place office_short office --seed 1 --width 320 --map-frames 160 --query-frames 160 "${one[@]}"
  madeMap maps/office_short.flmap build office_short/map "${one[@]}"
  madeMap maps/kitchen.flmap build "$data/redkitchen/map" "${one[@]}"
  thinned "$data/redkitchen/query" speed/kitchen 'n % 5 == 0'
  thinned office_short/query speed/office 'n % 4 == 0'
  for round in 1 2 3; do
    query "kitchen$round" kitchen speed/kitchen
    query "office$round" office_short speed/office
    query "strange$round" office_short speed/kitchen
  done
  ledger states cross.kitchen_in_office results/speed/strange1
  ledger ratios results/speed
}
query() { "$apps/facetloc_localize" "maps/$2.flmap" "$3" -o "results/speed/$1" --quiet "${one[@]}" >&2; }

# lines FOLDER...: lines of C++
lines() { (cd "$root" && git grep --untracked -h '' -- "${@/%//*.h}" "${@/%//*.hpp}" "${@/%//*.cpp}" | wc -l); }
# Sizes against DESIGN's budget, which the reasons in ledger.tsv name.
house() {
  wanted house || return 0
  figure house.lines.features "$(lines features base)"
  figure house.lines.segmentation "$(lines segmentation)"
  figure house.lines.registration "$(lines registration/src registration/include)"
  figure house.lines.localization "$(lines registration/localization)"
  figure house.lines.mapping "$(lines registration/mapping)"
  figure house.lines.io "$(lines io/src io/include io/openni io/openni_driver)"
  figure house.lines.simulation "$(lines io/simulation)"
  figure house.lines.apps "$(lines apps)"
  figure house.lines.all "$(lines features base segmentation registration io apps)"
  figure house.lines.test "$(lines test)"
  figure house.public_headers "$(cd "$root" && git ls-files -- '*/include/facetloc/*.h' ':!test' | wc -l)"
  figure house.words "$(cd "$root" && git grep --untracked -h '' -- '*.md' | wc -w)"
  figure house.parameters "$(ledger parameters "$root")"
  configured
  figure house.compile_commands "$(grep -c '"file":' demo/compile_commands.json)"
}
# The demo's configuration, not built.
configured() {
  [ -e demo/compile_commands.json ] || cmake -S "$root" -B demo -G Ninja -DCMAKE_BUILD_TYPE=Release -DFACETLOC_BUILD_TESTS=OFF \
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON > /dev/null
}

# Processor seconds of the demo's build without a cache, as a ratio to a file that no change touches.
coldBuild() {
  wanted house.cold_build_to_reference || return 0
  configured
  cat > reference.cpp << 'TEXT'
#include <Eigen/Dense>
#include <regex>
Eigen::VectorXd singular(const Eigen::MatrixXd& A) { return Eigen::BDCSVD<Eigen::MatrixXd>(A, Eigen::ComputeFullU).singularValues(); }
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A) { return A.eigenvalues(); }
bool matches(const std::string& text) { return std::regex_match(text, std::regex("a+b")); }
TEXT
  export CCACHE_DISABLE=1
  local building reference
  building=$(processorSeconds cmake --build demo)
  reference=$(processorSeconds c++ -O3 -I/usr/include/eigen3 -c reference.cpp -o reference.o)
  figure house.cold_build_to_reference "$(awk "BEGIN { printf \"%.1f\", $building / $reference }")"
}
processorSeconds() {
  local TIMEFORMAT='%U %S'
  { time "$@" > /dev/null 2>&1; } 2>&1 | awk '{ print $1 + $2 }'
}

# --- The run: longest first, timed last

gaps=(drive drive_gaps drive_2s drive_10s)
for seed in 32 33; do
  for scene in office home hall hotel; do
    step full $scene$seed heldOut $scene$seed $scene $seed 240 single "${gaps[@]}" drive_60s
    step full partly_$scene$seed heldOut partly_$scene$seed $scene $seed 160 single drive drive_gaps
  done
done
step full office1 floor office1 office 1 444 348 single "${gaps[@]}"
step full hall1 floor hall1 hall 1 444 348 single "${gaps[@]}"
step full hotel1 floor hotel1 hotel 1 444 348 single "${gaps[@]}"
step quick kitchen_without_poses kitchenWithoutPoses
step quick d435_desk recording d435_desk recordings/d435_desk map query single "${gaps[@]}"
step quick home31 floor home31 home 31 160 160 single "${gaps[@]}"
step quick passage1 passage 1 single drive
for seed in 2 3 4 5; do step full passage$seed passage $seed single drive; done
step quick unmapped_home31 unmapped home 31 2
step full unmapped_office31 unmapped office 31 3
step full unmapped_hall32 unmapped hall 32 3
step quick office_short floor office_short office 1 160 160 single "${gaps[@]}"
step quick kitchen recording kitchen redkitchen map query single "${gaps[@]}"
step quick pairs pairs
step quick structure recording tum_fr3_structure recordings/tum_fr3_structure map query single "${gaps[@]}"
step quick teddy recording tum_fr3_teddy recordings/tum_fr3_teddy map query single "${gaps[@]}"
step quick phone_floor recording phone_floor recordings/phone_floor map query single "${gaps[@]}"
step quick phone_desk recording phone_desk recordings/phone_desk map query single drive
step quick cabinet recording tum_fr3_cabinet recordings/tum_fr3_cabinet map query single drive drive_10s
step quick kinect_study recording kinect_study recordings/kinect_study map query single drive
step quick kinect_person recording kinect_person recordings/kinect_person map query single drive drive_2s
step quick kinect_person_masked recording kinect_person_masked recordings/kinect_person map_masked query_masked single drive drive_2s
step quick cafe cafe
step quick house house
timed quick speed speed
timed full cold_build coldBuild

failed=()
for name in "${steps[@]}"; do [ -e "figures/$name.tsv" ] || failed+=("$(basename "$name")"); done
for name in "${failed[@]}"; do
  echo "failed: $name"
  tail -n 5 "$out/log/$name.txt"
done
echo "all steps: $SECONDS s"
options=(--rows "$pattern")
[ $quick = no ] || options+=(--quick)
[ $update = no ] || options+=(--update)
ledger compare "$root/test/ledger.tsv" figures "$out/ledger.tsv" "${options[@]}"
[ ${#failed[@]} -eq 0 ] || fail "failed: ${failed[*]}; logs in $out/log"
