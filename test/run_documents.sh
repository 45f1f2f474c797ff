#!/usr/bin/env bash
# Runs the commands of documents as they stand there, on a made-up room: run_documents.sh FOLDER_OF_TOOLS. Where a command asks
# for a camera, it gets the virtual one, without a window.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
export PATH="$(cd "$1" && pwd):$PATH"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
ln -s "$root/apps" apps
facetloc_simulate room -o room --seed 1 --width 320 --frames 20 --quiet >/dev/null
ln -s room/map walk1
ln -s room/query walk2
ln -s room/query walk

commands=0
for document in README.md apps/RECORDINGS.md apps/ROBOT.md; do
  while IFS= read -r line; do
    command=$(sed -E 's/^    //; s/  +#.*$//' <<<"$line")
    case $command in
      *facetloc_live*--device*) ;;
      *"facetloc_live --build"*) command=${command/facetloc_live/facetloc_live --device walk1 --headless --overwrite} ;;
      *facetloc_live*--headless*) command=${command/facetloc_live/facetloc_live --device walk2} ;;
      *facetloc_live*) command=${command/facetloc_live/facetloc_live --device walk2 --headless} ;;
    esac
    echo "$document: $command"
    bash -o pipefail -c "$command" >out 2>err || { cat out err >&2; exit 1; }
    commands=$((commands + 1))
  done < <(grep -E '^    facetloc_' "$root/$document")
done
echo "$commands commands of documents do what they say"
[ "$commands" -ge 10 ]
