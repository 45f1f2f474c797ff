#!/usr/bin/env bash
# Prints how covariances agree with errors (in95 and nees of the ledger) on simulated places, for each camera preset: with the errors
# that pixels share, bent surfaces and map poses that are a little off.
#
#   test/benchmark/covariance_table.sh [BUILD] [FOLDER] [PLACE...]
#
# BUILD: the build folder (build); FOLDER: where simulated runs go and are reused, and results (covariances);
# PLACE: scenes of facetloc_simulate (office boards doors box). CAMERAS, in the environment, chooses the presets.
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-covariances}
places=("${@:3}")
[ ${#places[@]} -gt 0 ] || places=(office boards doors box)
read -ra cameras <<< "${CAMERAS:-kinect xtion realsense_d435 azure_kinect phone_lidar}"
apps=$build/apps
[ -x "$apps/facetloc_simulate" ] || { echo "covariance_table.sh: no tools in $build" >&2; exit 1; }

for camera in "${cameras[@]}"; do
  width=320
  [ "$camera" != phone_lidar ] || width=256
  for place in "${places[@]}"; do
    name=$camera-$place
    options=(--frames 120)
    [ "$place" != office ] || options=(--map-frames 444 --query-frames 348)
    [ "$place" != boards ] || options+=(--drive.camera_height 0.6 --drive.camera_tilt_deg 60)
    if [ ! -d "$folder/$name" ]; then
      "$apps/facetloc_simulate" "$place" -o "$folder/$name.part" --camera "$camera" --width "$width" "${options[@]}" \
        --shared-errors --surface-error 0.003 --map_poses.translation_std 0.005 --map_poses.rotation_std_deg 0.1 --quiet > /dev/null
      mv "$folder/$name.part" "$folder/$name"
    fi
    map=$folder/$name.flmap results=$folder/$name.results
    "$apps/facetloc_map" build "$folder/$name/map" --poses "$folder/$name/map/poses.txt" -o "$map" --overwrite --quiet > /dev/null
    "$apps/facetloc_localize" "$map" "$folder/$name/query" -o "$results/single" --quiet > /dev/null
    "$apps/facetloc_localize" "$map" "$folder/$name/query" -o "$results/drive" --sequence --quiet > /dev/null
    "$apps/facetloc_evaluate" "$results" "$folder/$name/query" -o "$results/evaluation" --quiet \
      --evaluation.max_translation 0.3 --evaluation.max_rotation_deg 5 > /dev/null
    python3 "$root/test/ledger.py" answers "$name" "$results/evaluation/frames.csv" 0.3 5 | grep -E '\.(images|sure_right|in95|nees)'
  done
done
