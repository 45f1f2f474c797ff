#!/usr/bin/env bash
# Prints the rows of public.md for downloaded recordings, each as it was downloaded.
#
#   test/benchmark/public.sh [-b BUILD] [-o OUT] FOLDER...
#
# BUILD: the build folder (build); OUT: where maps and results go (public). What a FOLDER is follows from what lies in it:
#   label/ or labelled clouds (mOSD of PCL's data)     segments across objects, beside PCL's OrganizedMultiPlaneSegmentation
#   TrainSplit.txt and TestSplit.txt (7-Scenes)        a map of the training sequences, the test sequences localized in it
#   map/ and query/                                    a map of the one, the other localized in it
#   anything else with depth images and poses          the trajectory from depth alone, beside generalized ICP (TUM, ICL-NUIM)
# Right at rank 1 is printed within 5 cm and 5 deg, 0.2 m and 2 deg, and 0.3 m and 5 deg.
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
build=$root/build out=public
usage() { sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; }
fail() { echo "public.sh: $1" >&2; exit "${2:-1}"; }
while getopts b:o:h option; do
  case $option in
    b) build=$OPTARG ;;
    o) out=$OPTARG ;;
    h) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
done
shift $((OPTIND - 1))
[ $# -gt 0 ] || { usage >&2; exit 2; }

. "$root/test/benchmark/rows.sh"
apps=$build/apps bench=$build/test/benchmark
need() { for program in "$@"; do [ -x "$program" ] || fail "no program $program; build it, or name the build folder with -b"; done; }

# localized NAME MAP QUERY
localized() {
  rm -rf "$out/$1"
  "$apps/facetloc_localize" "$2" "$3" -o "$out/$1" --quiet > /dev/null
  row "$1" "$out/$1" "$3" "$2" 0.05 5
  row "$1" "$out/$1" "$3" "$2" 0.2 2
  row "$1" "$out/$1" "$3" "$2" 0.3 5
}

# The sequences that a split of 7-Scenes names: "sequence3" is seq-03.
sequencesOf() { tr -d '\r' < "$1" | sed -nE 's/^sequence([0-9]+)$/\1/p' | while read -r n; do printf 'seq-%02d\n' "$((10#$n))"; done; }

ofScene() {
  local scene=$1 name sequence maps=()
  name=$(basename "$(realpath "$scene")")
  for sequence in $(sequencesOf "$scene/TrainSplit.txt"); do
    [ -d "$scene/$sequence" ] || fail "$scene/$sequence is missing: unpack all sequences of the scene"
    "$apps/facetloc_map" build "$scene/$sequence" -o "$out/$name-$sequence.flmap" --overwrite --quiet > /dev/null
    maps+=("$out/$name-$sequence.flmap")
  done
  [ ${#maps[@]} -gt 0 ] || fail "$scene/TrainSplit.txt names no sequence"
  "$apps/facetloc_map" merge "${maps[@]}" -o "$out/$name.flmap" --same-coordinates --overwrite --quiet > /dev/null
  rowHead
  for sequence in $(sequencesOf "$scene/TestSplit.txt"); do
    localized "$name-$sequence" "$out/$name.flmap" "$scene/$sequence"
  done
}

ofPlace() {
  local name
  name=$(basename "$(realpath "$1")")
  "$apps/facetloc_map" build "$1/map" -o "$out/$name.flmap" --overwrite --quiet > /dev/null
  rowHead
  localized "$name" "$out/$name.flmap" "$1/query"
}

hasLabels() {
  [ ! -d "$1/label" ] || return 0
  local clouds=("$1"/*.pcd)
  [ -e "${clouds[0]}" ] && head -n 5 "${clouds[0]}" | grep -aq '^FIELDS.*\blabel\b'
}

mkdir -p "$out"
for folder in "$@"; do
  [ -e "$folder" ] || fail "no folder $folder"
  echo "== $folder"
  if hasLabels "$folder"; then
    need "$bench/score_segments"
    "$bench/score_segments" "$folder"
  elif [ -e "$folder/TrainSplit.txt" ]; then
    need "$apps/facetloc_map" "$apps/facetloc_localize" "$apps/facetloc_evaluate"
    ofScene "$folder"
  elif [ -d "$folder/map" ] && [ -d "$folder/query" ]; then
    need "$apps/facetloc_map" "$apps/facetloc_localize" "$apps/facetloc_evaluate"
    ofPlace "$folder"
  else
    need "$bench/score_mapping"
    "$bench/score_mapping" "$folder"
  fi
done
