#!/usr/bin/env bash
# run.sh BUILD_DIR [SECONDS [TARGET...]]: runs the fuzz targets of a build, or some, 20 s each, as many at a time as there are cores.
# Names the targets that found something and their input, in BUILD_DIR/fuzz/TARGET, and then fails.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "${1:?usage: run.sh BUILD_DIR [SECONDS [TARGET...]]}" && pwd)
seconds=${2:-20}
targets=("${@:3}")
if [ ${#targets[@]} -eq 0 ]; then
  for program in "$build"/test/fuzz/fuzz_*; do targets+=("${program##*/fuzz_}"); done
fi

# In memory: a file is written for each input.
TMPDIR=$(mktemp -d /dev/shm/facetloc_fuzz_XXXXXX)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT
export LSAN_OPTIONS=suppressions=$here/../../.ci/leaks:print_suppressions=0

seeds=$build/fuzz/seeds
"$build/test/fuzz/make_seeds" "$seeds"

# Recordings of ROS 2, as tests have them: one image of 8x6 pixels; of small pages, of which most bytes mean something.
raw=$TMPDIR/raw
mkdir -p "$raw" "$seeds/mcap"
echo 8 6 7 7 3.5 2.5 > "$raw/intrinsics.txt"
head -c 96 /dev/zero | tr '\0' '\5' > "$raw/1.500000.raw"
record() { rm -f "$1" && python3 "$here/../io/write_recording.py" "$raw" "$@"; }
record "$seeds/mcap/chunk" mcap
record "$seeds/mcap/plain" mcap unchunked
record "$TMPDIR/walk.db3" db3
python3 -c 'import sqlite3, sys; sqlite3.connect(sys.argv[1]).executescript("PRAGMA page_size = 512; VACUUM")' "$TMPDIR/walk.db3"
{ printf d; cat "$TMPDIR/walk.db3"; } > "$seeds/bags/rosbag2"
{ printf 'frosbag2_bagfile_information:\n  relative_file_paths:\n    - walk_0.db3\n---\n'; cat "$TMPDIR/walk.db3"; } > "$seeds/bags/folder"

run() {
  local target=$1 folder=$build/fuzz/$1 corpus=()
  for files in "$folder/found" "$build/fuzz/seeds/$target" "$here/corpus/$target"; do
    [ -d "$files" ] && corpus+=("$files")
  done
  if OMP_NUM_THREADS=1 "$build/test/fuzz/fuzz_$target" -seed=1 -max_total_time="$seconds" -max_len=32768 -rss_limit_mb=1024 -timeout=10 \
       -dict="$here/facetloc.dict" -artifact_prefix="$folder/" -print_final_stats=1 "${corpus[@]}" >"$folder/log" 2>&1; then
    sed -nE "s/stat::average_exec_per_sec: +(.*)/$target: \1 inputs per second/p" "$folder/log"
  else
    echo "$target: found $(find "$folder" -maxdepth 1 -name '*-*'); see $folder/log" >&2
    return 1
  fi
}
export -f run
export here build seconds

for target in "${targets[@]}"; do
  mkdir -p "$build/fuzz/$target/found"
  find "$build/fuzz/$target" -maxdepth 1 -name '*-*' -delete  # of an earlier run
done
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I {} bash -c 'run {}'
