# SPDX-License-Identifier: BSD-3-Clause
# The stages of all.sh, a function each, in the order of README.md; sourced. Each runs in the folder of the results and prints figures.
# Uses $build, $apps, $data, $every and $root of all.sh.

bench() { "$build/test/benchmark/$1" "${@:2}"; }

# place NAME SCENE [OPTION...]: a simulated place, made once.
place() {
  [ ! -d "$1" ] || return 0
  rm -rf "$1.part"
  "$apps/facetloc_simulate" "$2" -o "$1.part" "${@:3}" --quiet > /dev/null
  mv "$1.part" "$1"
}
# floors SEED...: sets floors to the office, the home and the hall of each seed; with -e, to the office of the first.
floors() {
  local seed kind
  floors=()
  for seed in "$@"; do
    for kind in office home hall; do
      place "$kind$seed" "$kind" --seed "$seed"
      floors+=("$kind$seed")
      [ "$every" -eq 1 ] || return 0
    done
  done
}

has() {
  [ -d "$data/$1" ] && return 0
  echo "skipped: no $data/$1"
  return 1
}

# madeMap MAP ARGUMENT...: what facetloc_map makes of the arguments, once; a stage that was stopped leaves no half of it.
madeMap() {
  [ ! -e "$1" ] || return 0
  local part=${1%.flmap}.part.flmap
  mkdir -p "$(dirname "$1")"
  rm -f "$part"
  "$apps/facetloc_map" "${@:2}" -o "$part" --quiet > /dev/null
  mv "$part" "$1"
}
# thinned RUN FOLDER CONDITION: the images of a run that are kept by a condition in awk: n counts them from 0, t is the time since the
# first [s].
thinned() {
  local image
  mkdir -p "$2/depth"
  for image in "$1"/{camera.ini,groundtruth.txt}; do [ ! -e "$image" ] || ln -s "$(realpath "$image")" "$2"; done
  while read -r image; do
    ln -s "$(realpath "$1/depth/$image")" "$2/depth"
  done < <(find -L "$1/depth" -name '*.png' -printf '%f\n' | sort -n |
    awk "BEGIN { n = -1 } { ++n; if (n == 0) first = \$1 + 0; t = \$1 + 0 - first } $3")
}
# mapped RUN [OPTION...]: the map of a run; sets map.
mapped() {
  map=map/$(echo "${1#"$data"/}" "${@:2}" | tr -c 'a-zA-Z0-9.\n' _).flmap
  madeMap "$map" build "$@"
}

# localized ROWNAME MAP QUERY LIMITS... -- [OPTION...]: a row for each of the limits "METRES DEGREES"; COLUMN and EVALUATE, if set, go to row.
localized() {
  local name=$1 from=$2 query=$3 limits=() limit
  shift 3
  while [ "$1" != -- ]; do limits+=("$1"); shift; done
  shift
  local results
  results=results/$(echo "$name" | tr -c 'a-zA-Z0-9.\n' _)
  rm -rf "$results"
  mkdir -p results
  "$apps/facetloc_localize" "$from" "$query" -o "$results" --quiet "$@" > /dev/null
  for limit in "${limits[@]}"; do
    # Two numbers, which are two arguments.
    # shellcheck disable=SC2086
    row "$name" "$results" "$query" "$from" $limit "${COLUMN:-all (new)}" ${EVALUATE:-}
  done
}

# ofPlaces LIMITS COLUMN PLACE...: each with its runs map/ and query/, as the tools do it.
ofPlaces() {
  local limits=$1 COLUMN=$2 one
  for one in "${@:3}"; do
    mapped "$one/map"
    localized "$one" "$map" "$one/query" "$limits" --
  done
}

stage_kitchen() {
  has redkitchen || return 0
  local run=$data/redkitchen
  rowHead
  mapped "$run/map"
  localized kitchen "$map" "$run/query" "0.2 2" "0.3 5" "0.05 5" --
  mapped "$run/map" --split delaunay
  localized "kitchen by triangles" "$map" "$run/query" "0.2 2" -- --split delaunay
  mapped "$run/map" --preset paper
  localized "kitchen, --preset paper" "$map" "$run/query" "0.2 2" "0.3 5" -- --preset paper
  mapped "$run/map" --without-poses
  EVALUATE=--align localized "kitchen, map without poses" "$map" "$run/query" "0.3 5" --
}

# Maps of a mesh and of a cloud of the kitchen, and of meshes of simulated offices.
stage_models() {
  local seed
  rowHead
  if has redkitchen; then
    if python3 -c 'import open3d' 2> /dev/null; then
      [ -e kitchen/cloud.ply ] || python3 "$root/test/benchmark/kitchen_mesh.py" "$data/redkitchen/map" kitchen > /dev/null
      ofModel mesh kitchen/mesh.ply --up=0,-0.91,-0.41
      ofModel cloud kitchen/cloud.ply --up=0,-0.91,-0.41
      ofModel "mesh, viewpoints given" kitchen/mesh.ply --up=0,-0.91,-0.41 --viewpoints kitchen/poses.txt
    else
      echo "skipped: the kitchen's mesh needs python3-open3d"
    fi
  fi
  for seed in 1 2 3; do
    modelled "$seed"
    COLUMN=solvable localized "office $seed" "$map" "modelled$seed/query" "0.2 2" --
    [ "$every" -eq 1 ] || break
  done
}
# ofModel NAME MODEL [OPTION...]
ofModel() {
  local out
  out=map/$(echo "$1" | tr -c 'a-zA-Z0-9.\n' _).flmap
  madeMap "$out" from-model "$2" --camera "$data/redkitchen/map/camera.ini" "${@:3}"
  localized "kitchen, $1" "$out" "$data/redkitchen/query" "0.3 5" --
}
# modelled SEED: the office modelledSEED and the map of its mesh; sets map.
modelled() {
  place "modelled$1" office --seed "$1" --model "modelled$1.ply"
  map=map/modelled$1.flmap
  madeMap "$map" from-model "modelled$1.ply" --camera "modelled$1/map/camera.ini"
}

stage_paper() {
  local seeds
  for seeds in "1 2 3" "4 5 6" "13 14 15"; do
    # shellcheck disable=SC2086
    floors $seeds
    bench score_floors --every "$every" "${floors[@]}"
    [ "$every" -eq 1 ] || break
  done
  floors 1 2 3
  bench score_floors --every "$every" --split delaunay "${floors[@]}"
  floors 1
  bench score_floors --every "$every" --map-images "${floors[@]}"
  bench score_floors --every "$every" --map-images --preset paper "${floors[@]}"
}

# Places that the map lacks: of drives, of meshes, with rendered views; seed 13 chose nothing.
stage_unknown() {
  local n=$((4 * every)) seed
  floors 13 14 15
  bench score_unknown --every "$n" "${floors[@]}"
  floors 1 2 3
  bench score_unknown --every "$n" "${floors[@]}"
  for seed in 1 13; do
    modelled "$seed"
    echo "map of a mesh, office $seed"
    bench score_unknown --every "$n" --map "$map" "modelled$seed"
    mapped "modelled$seed/map"
    madeMap "map/dense$seed.flmap" densify "$map"
    echo "densified map, office $seed"
    bench score_unknown --every "$n" --map "map/dense$seed.flmap" "modelled$seed"
    [ "$every" -eq 1 ] || break
  done
  has redkitchen || return 0
  bench score_unknown --every "$every" --radius 1 --evaluation.max_translation 0.3 --evaluation.max_rotation_deg 5 "$data/redkitchen"
}

stage_cross() {
  has recordings || return 0
  local name run i k places=() maps=() runs=()
  for name in recordings/d435_desk recordings/phone_desk recordings/phone_floor recordings/tum_fr3_cabinet recordings/tum_fr3_structure \
    recordings/tum_fr3_teddy redkitchen; do
    [ -d "$data/$name" ] || continue
    for run in map query; do
      mapped "$data/$name/$run" --force
      places+=("$name") maps+=("$map") runs+=("cross/runs/${#runs[@]}")
      [ -d "${runs[-1]}" ] || thinned "$data/$name/$run" "${runs[-1]}" "n % $((4 * every)) == 0"
    done
  done
  for i in "${!maps[@]}"; do
    for k in "${!runs[@]}"; do
      [ "${places[i]}" != "${places[k]}" ] || continue
      "$apps/facetloc_localize" "${maps[i]}" "${runs[k]}" -o "cross/$i-$k" --quiet > /dev/null
    done
  done
  awk -F, '
    FNR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    $column["rank"] <= 1 { ++n; p = $column["probability"] + 0; half += p >= 0.5; sure += p >= 0.9 }
    END { printf "of %d answers %.2f %% have p >= 0.5, %d have p >= 0.9", n, 100 * half / n, sure
          if (!sure) printf ", at most %.2f %% with 95 %% confidence", 100 * (1 - 0.05 ^ (1 / n))
          print "" }
  ' cross/*/hypotheses.csv
}

stage_covariances() {
  local line name degrees millimetres
  for line in "redkitchen 1 20" "recordings/tum_fr3_structure 0.6 8" "recordings/tum_fr3_cabinet 0.6 8" "recordings/d435_desk 1.1 14" \
    "recordings/phone_floor 0.3 5"; do
    read -r name degrees millimetres <<< "$line"
    has "$name" || continue
    bench score_covariance --every "$every" --truth-deg "$degrees" --truth-mm "$millimetres" "$data/$name"
  done
  floors 1
  bench score_covariance --every "$every" "${floors[0]}"
  place doors1 doors --seed 1
  place box1 box --seed 1
  bench score_covariance --every "$every" doors1 box1
}

# One choice at a time put back to the paper's.
stage_choices() {
  floors 1
  bench score_floors --ablation --every $((6 * every)) "${floors[@]}"
  has redkitchen || return 0
  mapped "$data/redkitchen/map"
  rowHead
  local choice
  for choice in "--ekf.iterations 1" "--steps.joint_refinement 0" "--ekf.iterations 1 --steps.joint_refinement 0" "--refinement.enabled 0" \
    "--evidence.enabled 0 --refinement.enabled 0" "--score.by_overlap 1"; do
    # shellcheck disable=SC2086
    localized "$choice" "$map" "$data/redkitchen/query" "0.2 2" -- $choice
  done
}

stage_pieces() {
  local kind tolerance
  rowHead
  for kind in home office; do
    place "${kind}31" "$kind" --seed 31
    mapped "${kind}31/map"
    for tolerance in 2.75 1.0 0.7; do
      localized "$kind, tolerance $tolerance" "$map" "${kind}31/query" "0.2 2" -- --merge.tolerance "$tolerance"
      localized "$kind, tolerance $tolerance, each piece by itself" "$map" "${kind}31/query" "0.2 2" -- --merge.tolerance "$tolerance" \
        --calibration.score.coplanar_weight 0
    done
    [ "$every" -eq 1 ] || break
  done
}

stage_smooth() {
  local kind
  rowHead
  for kind in home office; do
    place "smooth_$kind" "$kind" --seed 21 --width 320 --sensor.disparity_std 2 --sensor.correlation_px 6
    ofPlaces "0.2 2" covered "smooth_$kind"
    [ "$every" -eq 1 ] || break
  done
}

stage_cameras() {
  local camera width
  rowHead
  for camera in kinect xtion realsense_d435 azure_kinect phone_lidar; do
    width=320
    [ "$camera" != phone_lidar ] || width=256
    place "office_$camera" office --seed 1 --width "$width" --camera "$camera"
    ofPlaces "0.2 2" covered "office_$camera"
    [ "$every" -eq 1 ] || break
  done
}

# Trajectories without poses.
stage_trajectories() {
  local runs=() seed
  [ ! -d "$data/redkitchen" ] || runs+=("$data/redkitchen/map" "$data/redkitchen/query")
  for seed in structure teddy; do [ ! -d "$data/recordings/tum_fr3_$seed" ] || runs+=("$data/recordings/tum_fr3_$seed/map"); done
  floors 1 2 3 13 14
  [ "$every" -gt 1 ] || runs+=("${floors[@]/%//map}")
  bench score_mapping "${runs[@]}"
}

stage_gaps() {
  local seed
  floors 1 2
  for seed in 1 2 3 4; do
    bench score_mapping --gaps 4 --seed "$seed" "${floors[0]}/map"
    [ ! -d "$data/redkitchen" ] || bench score_mapping --gaps "$seed" --seed 1 "$data/redkitchen/map" "$data/redkitchen/query"
    [ "$every" -eq 1 ] || break
  done
}

stage_sessions() {
  floors 1
  mapped "${floors[0]}/map"
  [ -e map/extended.flmap ] || { cp "$map" map/extended.part && mv map/extended.part map/extending.flmap &&
    "$apps/facetloc_map" extend map/extending.flmap "${floors[0]}/query" --quiet > /dev/null && mv map/extending.flmap map/extended.flmap; }
  bench score_sessions "${floors[0]}" "$map" map/extended.flmap
}

# A live map of three hours on one route, and after it three mornings: each a third of a later drive, where things have been moved.
stage_hours() {
  local kind
  for kind in home office; do hoursIn "$kind"; done
}
hoursIn() {
  local run=hours_$1 map=hours_$1.flmap morning live=("$apps/facetloc_live" --headless --every-frame --speed 0 --quiet)
  place "$run" "$1" --seed 3 --width 160 --map-frames 400 --rounds $((every > 1 ? 2 : 116)) --query-frames 360
  "${live[@]}" --device "$run/map" --build "$map" --overwrite > /dev/null
  afterHours "$1, evening" "$map" "$run/query"
  for morning in 0 1 2; do
    mkdir -p "$run/$morning/depth"
    ln -sf ../query/camera.ini "$run/$morning"
    find "$run/query/depth" -name '*.png' -printf '%f\n' | sort -n | awk -v m="$morning" 'int((NR - 1) / 120) == m' |
      while read -r image; do ln -sf "../../query/depth/$image" "$run/$morning/depth"; done
    "${live[@]}" --device "$run/$morning" --extend "$map" > /dev/null
    afterHours "$1, morning $((morning + 1))" "$map" "$run/query"
  done
}
afterHours() {
  local EVALUATE=--align  # the map's world is where the robot began
  localized "$1" "$2" "$3" "0.2 2" --
  localized "$1, drive" "$2" "$3" "0.2 2" -- --sequence
  printf '%s: %s models, %s kB\n' "$1" "$("$apps/facetloc_map" info "$2" | awk '/^  number/ { print $2 }')" "$(du -k "$2" | cut -f1)"
}

stage_pairs() {
  floors 1
  local floor
  for floor in "${floors[@]}"; do bench score_pairs "$floor/map"; done
  has redkitchen || return 0
  bench score_pairs "$data/redkitchen/map" "$data/redkitchen/query"
}

# The PCL classes on clouds, and PCL's own registrations.
stage_peers() {
  has recordings/d435_desk || return 0
  has redkitchen || return 0
  local chosen=(--count=60 --min_distance=0.2 --max_distance=0.8 --min_rotation_deg=0 --max_rotation_deg=30 --min_overlap=0)
  local desk=$data/recordings/d435_desk/map kitchen=$data/redkitchen/map
  [ "$every" -eq 1 ] || chosen[0]=--count=10
  bench score_pairs --clouds "${chosen[@]}" --others="$kitchen" "$desk"
  bench score_pairs --clouds "${chosen[@]}" --others="$desk" "$kitchen"
  bench score_pairs --peers "${chosen[@]}" --others="$kitchen" "$desk"
}

stage_rooms() { bench score_rooms; }

# Metres until a moving camera knows where it is.
stage_drives() {
  local kind seed results
  for seed in 1 13; do
    for kind in office home hall; do
      place "drive_$kind$seed" "$kind" --seed "$seed" --runs map,drive --drive 60 --width 320
      mapped "drive_$kind$seed/map"
      [ -d "starts/$kind$seed" ] || thinned "drive_$kind$seed/drive" "starts/$kind$seed" "n % $every == 0"
      results=results/starts_$kind$seed
      "$apps/facetloc_localize" "$map" "starts/$kind$seed" -o "$results" --sequence --starts $((60 / every > 0 ? 60 / every : 1)) \
        --quiet > /dev/null
      echo "$kind $seed"
      "$apps/facetloc_evaluate" "$results" "starts/$kind$seed" --map "$map" | sed -n '/METRES FROM A START/,/^$/p'
      [ "$every" -eq 1 ] || return 0
    done
  done
}

stage_sequences() {
  local name
  rowHead
  for name in redkitchen recordings/tum_fr3_structure recordings/tum_fr3_teddy recordings/tum_fr3_cabinet recordings/d435_desk \
    recordings/phone_floor; do
    [ -d "$data/$name" ] || continue
    mapped "$data/$name/map"
    localized "$name, by images" "$map" "$data/$name/query" "0.3 5" --
    localized "$name, as a sequence" "$map" "$data/$name/query" "0.3 5" -- --sequence
    localized "$name, smoothed" "$map" "$data/$name/query" "0.3 5" -- --sequence --smooth
  done
  [ "$every" -eq 1 ] || return 0
  for name in office1 office13 home14; do
    place "$name" "${name%%[0-9]*}" --seed "${name##*[a-z]}"
    mapped "$name/map"
    localized "$name, by images" "$map" "$name/query" "0.2 2" --
    localized "$name, as a sequence" "$map" "$name/query" "0.2 2" -- --sequence
  done
}

# Several cameras as one view: a corridor's end, an office, a home.
stage_rig() { bench score_rig 11 12 13 14 15; }

# A later run without people, and with three around the camera.
stage_people() {
  local run of_home=(home --seed 31 --width 320 --map-frames 160 --query-frames 160)
  rowHead
  place alone_home31 "${of_home[@]}"
  place peopled_home31 "${of_home[@]}" --people 3
  mapped alone_home31/map
  for run in alone_home31 peopled_home31; do
    localized "$run, by images" "$map" "$run/query" "0.2 2" --
    localized "$run, as a drive" "$map" "$run/query" "0.2 2" -- --sequence
  done
}

stage_tracking() {
  local kind
  for kind in office home hall; do
    place "tracked_$kind" "$kind" --seed 1 --runs map,drive --drive 40 --width 320
    bench score_tracking --busy 100 --kidnap 5 "tracked_$kind"
    [ "$every" -eq 1 ] || break
  done
}

stage_segmentation() {
  bench score_clutter
  bench score_clutter --width=640
  has abw || return 0
  local options
  for options in "" 0.0007 --split.method=delaunay "0.0007 --split.method=delaunay"; do
    # shellcheck disable=SC2086
    bench score_segcomp "$data/abw" $options
  done
}

stage_public() {
  local folders=() name
  for name in mosd redkitchen recordings/tum_fr3_structure/map; do [ ! -d "$data/$name" ] || folders+=("$data/$name"); done
  if [ ${#folders[@]} -eq 0 ]; then has mosd || return 0; fi
  "$root/test/benchmark/public.sh" -b "$build" -o public "${folders[@]}"
}

stage_speed() {
  if [ -d "$data/redkitchen" ]; then "$root/test/benchmark/speed_table.sh" "$build" "$data/redkitchen/query"
  else "$root/test/benchmark/speed_table.sh" "$build"; fi
}

stage_looks() {
  mkdir -p large
  bench score_looks large 5 $((every == 1 ? 8 : 5))
}

stage_large() {
  local models=1000,2000,5000,10000,20000,100000
  [ "$every" -eq 1 ] || models=1000
  mkdir -p large
  bench score_large_maps --floors large --models "$models" --queries $((200 / every > 0 ? 200 / every : 1)) --csv large_maps.csv
}
