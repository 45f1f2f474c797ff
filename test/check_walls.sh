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
  [simulation]="features simulation"
  [io]="features io"
  [openni_driver]="features io simulation"
  [apps]="features segmentation registration io simulation apps"
)
# room: the rooms of the same module that it may include
declare -A rooms=(
  [registration/depth]="depth"
  [registration/pairs]="pairs depth"
  [registration/nearby]="nearby pairs depth"
  [registration/shortlist]="shortlist pairs depth"
  [registration/global]="global shortlist pairs nearby depth"
  [registration/tracking]="tracking global nearby depth"
  [registration/sequence]="sequence tracking mapping global nearby pairs depth"
  [registration/mapping]="mapping tracking nearby pairs depth"
  [registration/pcl]="pcl global shortlist pairs"
  [io/recordings]="recordings"
  [apps/drawing]="drawing tools"
  [apps/evaluation]="evaluation drawing tools"
  [apps/live]="live drawing tools"
  [apps/tools]="tools drawing evaluation"
)

moduleOf() {
  case $1 in
    io/simulation/*) echo simulation ;;
    io/openni_driver/*) echo openni_driver ;;
    *) echo "${1%%/*}" ;;
  esac
}

has() { [[ " $1 " == *" $2 "* ]]; }

faults=0
complain() {
  echo "$1: $2 includes $3"
  faults=1
}

while IFS=: read -r file line include; do
  module=$(moduleOf "$file")
  if [[ $include =~ \<facetloc/([a-z_]+)/ ]]; then
    has "${modules[$module]}" "${BASH_REMATCH[1]}" || complain "$file:$line" "$module" "${BASH_REMATCH[1]}"
  elif [[ $include =~ \"([^\"]+)\" ]]; then
    private=${BASH_REMATCH[1]}
    [[ $file == */include/* ]] && complain "$file:$line" "a public header" "\"$private\""
    room=${private%%/*}
    if [[ $private != */* || $room == shared ]]; then continue; fi
    [[ $file =~ ^[a-z]+/src/[^/]+$ ]] && continue  # in no room, such as a main()
    own=$module/$(sed -E 's#^[^/]+/src/([^/]+)/.*#\1#' <<<"$file")
    has "${rooms[$own]:-}" "$room" || complain "$file:$line" "$own" "$room"
  fi
done < <(git grep -nE '^#include (<facetloc/|")' -- 'features/*' 'segmentation/*' 'registration/*' 'io/*' 'apps/*' |
         sed -E 's/#include //')
exit $faults
