#!/usr/bin/env bash
# Prints how covariances agree with errors (score_covariance) on simulated places, for each camera preset: with the errors that
# pixels share, bent surfaces and map poses that are a little off.
#
#   test/benchmark/covariance_table.sh [BUILD] [FOLDER] [PLACE...]
#
# BUILD: the build folder (build); FOLDER: where simulated runs and tables (CAMERA-PLACE.csv) go and are reused (covariances);
# PLACE: scenes of facetloc_simulate (office boards doors box). CAMERAS, in the environment, chooses the presets.
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-covariances}
places=("${@:3}")
[ ${#places[@]} -gt 0 ] || places=(office boards doors box)
read -ra cameras <<< "${CAMERAS:-kinect xtion realsense_d435 azure_kinect phone_lidar}"
for program in apps/facetloc_simulate test/benchmark/score_covariance; do
  [ -x "$build/$program" ] || { echo "covariance_table.sh: no $program in $build" >&2; exit 1; }
done

for camera in "${cameras[@]}"; do
  width=320
  [ "$camera" != phone_lidar ] || width=256
  for place in "${places[@]}"; do
    name=$camera-$place
    options=(--frames 120)
    [ "$place" != office ] || options=(--map-frames 444 --query-frames 348)
    [ "$place" != boards ] || options+=(--drive.camera_height 0.6 --drive.camera_tilt_deg 60)
    if [ ! -d "$folder/$name" ]; then
      "$build/apps/facetloc_simulate" "$place" -o "$folder/$name.part" --camera "$camera" --width "$width" "${options[@]}" \
        --shared-errors --surface-error 0.003 --map_poses.translation_std 0.005 --map_poses.rotation_std_deg 0.1 --quiet > /dev/null
      mv "$folder/$name.part" "$folder/$name"
    fi
    "$build/test/benchmark/score_covariance" "$folder/$name" --map-poses poses.txt --csv "$folder/$name.csv"
  done
done
