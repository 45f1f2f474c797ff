#!/usr/bin/env bash
# Completion in bash offers the options that the tools have: check_completions.sh FOLDER_OF_TOOLS
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$root/cmake/completions.sh" "$1" "$work"

# completed TOOL WORD...: what is offered for the last word
completed() {
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  # shellcheck disable=SC1090
  source "$work/bash/$1"
  "_$1"
  echo "${COMPREPLY[*]}"
}
expect() { [ "$1" = "$2" ] || { echo "check_completions: '$1' instead of '$2'" >&2; exit 1; }; }

expect "$(completed facetloc loc)" localize
expect "$(completed facetloc_map ext)" extend
expect "$(completed facetloc_map build --map.dis)" --map.distance
expect "$(completed facetloc_map info --map.dis)" ""
expect "$(completed facetloc_live walk --dev)" --device
expect "$(completed facetloc_localize --seq)" "--sequence"
cd "$root"
expect "$(completed facetloc_segment LIC)" LICENSE
for tool in "$work"/bash/facetloc_*; do
  [ "$(grep -o -- '--' "$tool" | wc -l)" -gt 10 ] || { echo "check_completions: no options in $tool" >&2; exit 1; }
done
if command -v zsh >/dev/null; then zsh -n "$work/zsh/_facetloc"; fi
