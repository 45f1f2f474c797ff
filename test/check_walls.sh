#!/usr/bin/env bash
# Who may include what: modules, rooms within modules, and nothing private in a public header. Prints each include that
# breaks a wall and fails if there is one.
set -euo pipefail
cd "$(dirname "$0")/.."

# module: the modules that it may include
declare -A modules=(
  [features]="features"
  [segmentation]="features segmentation"
  [registration]="features segmentation registration"
  [localization]="features segmentation registration localization"
  [mapping]="features segmentation registration localization mapping"
  [simulation]="features simulation"
  [io]="features io"
  [openni]="features io openni"
  [openni_driver]="features io simulation"
  [apps]="features segmentation registration localization mapping io openni simulation apps"
)
# room: the rooms that it may include, of its own module and of those below
declare -A rooms=(
  [registration/depth]="depth"
  [registration/pairs]="pairs depth"
  [registration/nearby]="nearby pairs depth"
  [registration/motion]="motion nearby pairs depth"
  [registration/pcl]="pcl pairs"
  [localization/shortlist]="shortlist pairs depth"
  [localization/ranking]="ranking shortlist nearby pairs depth"
  [localization/belief]="belief ranking motion nearby pairs depth"
  [mapping/graph]="graph nearby"
  [mapping/trajectory]="trajectory graph shortlist motion nearby pairs depth"
  [mapping/calibration]="calibration ranking motion nearby depth"
  [mapping/models]="models sessions calibration nearby depth"
  [mapping/sessions]="sessions calibration graph trajectory ranking motion nearby depth"
  [io/bytes]="bytes"
  [io/images]="images bytes"
  [io/clouds]="clouds bytes"
  [io/results]="results clouds bytes"
  [io/devices]="devices images bytes"
  [io/recordings]="recordings results devices clouds images bytes"
  [io/maps]="maps results images bytes"
  [apps/cli]="cli batch"
  [apps/batch]="batch cli"
  [apps/outputs]="outputs batch cli"
  [apps/inputs]="inputs outputs batch cli"
  [apps/drawing]="drawing inputs outputs batch cli"
  [apps/evaluation]="evaluation drawing inputs outputs batch cli"
  [apps/live]="live drawing inputs outputs batch cli"
  [apps/tools]="tools evaluation drawing inputs outputs batch cli"
)
# The internal interface of registration, and of localization: the private headers that the modules above them include.
declare -A interface=(
  [localization]="depth/depth_consistency.h depth/moved_pixels.h motion/camera_motion.h nearby/hypothesis_ranking.h
    nearby/nearby_models.h nearby/view_alignment.h pairs/consensus.h pairs/mounting_check.h pairs/view_registration.h"
  [mapping]="depth/depth_consistency.h depth/depth_difference.h motion/step_prior.h motion/view_odometry.h motion/view_placing.h
    nearby/nearby_models.h nearby/view_alignment.h ranking/global_localization.h shortlist/plane_triplet_matcher.h"
)

# moduleOf FILE: sets module; a process for each line would take a minute on a busy machine.
moduleOf() {
  case $1 in
    io/simulation/*) module=simulation ;;
    io/openni/*) module=openni ;;
    io/openni_driver/*) module=openni_driver ;;
    registration/localization/*) module=localization ;;
    registration/mapping/*) module=mapping ;;
    *) module=${1%%/*} ;;
  esac
}

has() { [[ " $1 " == *" $2 "* ]]; }

faults=0
complain() {
  echo "$1: $2 includes $3"
  faults=1
}

while IFS=: read -r file line include; do
  moduleOf "$file"
  if [[ $include =~ \<facetloc/([a-z_]+)/ ]]; then
    has "${modules[$module]}" "${BASH_REMATCH[1]}" || complain "$file:$line" "$module" "${BASH_REMATCH[1]}"
  elif [[ $include =~ \"([^\"]+)\" ]]; then
    private=${BASH_REMATCH[1]}
    [[ $file == */include/* ]] && complain "$file:$line" "a public header" "\"$private\""
    room=${private%%/*}
    if [[ $private != */* || $room =~ ^(base|poses|threads)$ ]]; then continue; fi
    [[ $file =~ (.*/src)/([^/]+)/ ]] || continue  # in no room, such as a main()
    src=${BASH_REMATCH[1]} own=$module/${BASH_REMATCH[2]}
    has "${rooms[$own]:-}" "$room" || complain "$file:$line" "$own" "$room"
    if [ -n "${interface[$module]:-}" ] && [ ! -d "$src/$room" ]; then
      has "${interface[$module]//$'\n'/ }" "$private" || complain "$file:$line" "$module" "\"$private\""
    fi
  fi
done < <(git grep -nE '^#include (<facetloc/|")' -- ':!*.md' 'features/*' 'segmentation/*' 'registration/*' 'io/*' 'apps/*' |
         sed -E 's/#include //')
exit $faults
