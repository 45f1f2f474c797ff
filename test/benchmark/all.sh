#!/usr/bin/env bash
# Measures the figures of README.md and test/benchmark again, stage by stage.
#
#   test/benchmark/all.sh [-b BUILD] [-d DATA] [-o OUT] [-e N] [-l] [STAGE...]
#
# BUILD: the build folder (build); DATA: the recordings of test/README.md ($FACETLOC_DATA, or ../shared/data); OUT: simulated places,
# maps, results and OUT/figures/STAGE.txt (figures). -l lists the stages, -e N tries them: every N-th image, one seed, no comparison.
# The figures of README are those of kitchen, paper, models, peers and unknown; tracking and large take longest.
# A stage whose data is not there is skipped. After each, percentages of its output that no document has are listed, and its time.
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
build=$root/build data=${FACETLOC_DATA:-$root/../shared/data} out=figures every=1
stages=(kitchen models paper unknown looks cross covariances choices pieces smooth cameras trajectories gaps sessions hours people rig pairs peers
        rooms drives sequences tracking segmentation public speed large)
usage() { sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; }
fail() { echo "all.sh: $1" >&2; exit "${2:-1}"; }
while getopts b:d:o:e:lh option; do
  case $option in
    b) build=$OPTARG ;;
    d) data=$OPTARG ;;
    o) out=$OPTARG ;;
    e) every=$OPTARG ;;
    l) printf '%s\n' "${stages[@]}"; exit 0 ;;
    h) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
done
shift $((OPTIND - 1))
[[ $every =~ ^[1-9][0-9]*$ ]] || fail "-e needs a positive number" 2
for stage in "$@"; do
  [[ " ${stages[*]} " == *" $stage "* ]] || fail "no stage '$stage'; there are: ${stages[*]}" 2
done
[ $# -eq 0 ] || stages=("$@")
[ -x "$build/test/benchmark/score_floors" ] || fail "no programs that measure in $build: run test/run.sh, or name the build folder with -b"

mkdir -p "$out/figures"
build=$(realpath "$build")
[ ! -d "$data" ] || data=$(realpath "$data")
apps=$build/apps
. "$root/test/benchmark/rows.sh"
. "$root/test/benchmark/stages.sh"
cd "$out"

# Percentages that a stage has printed and no document has.
compare() {
  local figure missing=()
  while read -r figure; do
    grep -qF -- "$figure %" "$root/README.md" "$root"/test/benchmark/*.md || missing+=("$figure %")
  done < <(grep -oE '[0-9]+(\.[0-9]+)? %' "$1" | sed 's/ %//' | sort -un)
  [ ${#missing[@]} -eq 0 ] || echo "in no document: ${missing[*]}"
}

failed=()
for stage in "${stages[@]}"; do
  echo "== $stage"
  started=$SECONDS
  # A subshell of its own, outside of any condition, so that the first error ends the stage and not the others.
  set +e
  (set -e; "stage_$stage") 2>&1 | tee "figures/$stage.txt"
  [ "${PIPESTATUS[0]}" -eq 0 ] || failed+=("$stage")
  set -e
  [ "$every" -gt 1 ] || compare "figures/$stage.txt"
  echo "$stage: $((SECONDS - started)) s"
done
[ ${#failed[@]} -eq 0 ] || fail "failed: ${failed[*]}"
