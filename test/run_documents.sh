#!/usr/bin/env bash
# Runs the commands of documents as they stand there, in a simulated room: run_documents.sh FOLDER_OF_TOOLS. Where a command asks
# for a camera, it gets the virtual one, without a window; what simulates whole floors makes a few small images of them.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
export PATH="$(cd "$1" && pwd):$PATH"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
facetloc_simulate room -o room --seed 1 --width 320 --frames 60 --quiet >/dev/null
facetloc_map build room/map -o room.flmap --quiet >/dev/null

# The files that the commands of a document take for granted, in a folder of their own. README makes its own.
prepare() {
  mkdir "$1" && cd "$1"
  ln -s "$root/apps" apps
  [ "$2" = README.md ] && return 0
  ln -s ../room/map walk1
  ln -s ../room/query walk2
  ln -s ../room/query walk
  grep -h '^    {"T_w_b"' "$root/apps/ROBOT.md" > odometry.jsonl
  ln -s ../room office1
  ln -s ../room/query drive
  for map in office1 office east west ground first second; do cp ../room.flmap $map.flmap; done
  cp ../room/map/groundtruth.txt trajectory.txt
}

commands=0
for document in README.md apps/RECORDINGS.md apps/ROBOT.md apps/README.md; do
  cd "$work"
  prepare "${document//\//_}.files" "$document"
  while IFS= read -r line; do
    command=$(sed -E 's/^    //; s/  +#.*$//' <<<"$line")
    case $command in
      apps/examples/*)  # its frames end
        if ! python3 -c "import numpy, PIL" 2>/dev/null; then echo "left out, without NumPy and Pillow: $command"; continue; fi ;;
      *facetloc_live*--device*)
        command=${command/run.oni/walk1}
        [[ $command == *--headless* ]] || command=${command/facetloc_live/facetloc_live --headless} ;;
      *"facetloc_simulate office"*)
        folder=$(sed -E 's/.* -o ([^ ]*).*/\1/' <<<"$command")
        rm -rf "$folder" results  # the link above, and what commands before have left
        command="$(sed -E 's/ --width 320//; s/--drive 90/--drive 2/' <<<"$command") --frames 8 --width 160" ;;
      *"facetloc_map build office1/map"*) command+=" --overwrite" ;;
      *"facetloc_live --build"*) command=${command/facetloc_live --build /facetloc_live --device walk1 --headless --build own_} ;;
      *facetloc_live*--headless*) command=${command/facetloc_live/facetloc_live --device walk2} ;;
      *facetloc_live*) command=${command/facetloc_live/facetloc_live --device walk2 --headless} ;;
    esac
    [[ $command == apps/examples/* ]] || command=${command/facetloc_live /facetloc_live --max-frames 8 }
    echo "$document: $command"
    bash -o pipefail -c "$command" >out 2>err || { cat out err >&2; exit 1; }
    if grep "is no odometry" err >&2; then exit 1; fi
    commands=$((commands + 1))
  done < <(grep -E '^    (facetloc[_ ]|apps/examples/)' "$root/$document")
done
echo "$commands commands of documents do what they say"
[ "$commands" -ge 45 ]
