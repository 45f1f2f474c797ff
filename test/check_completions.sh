#!/usr/bin/env bash
# Completion in bash, and in zsh where it is installed, offers the options that the tools have: check_completions.sh FOLDER_OF_TOOLS
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
expect "$(completed facetloc localize --seq)" --sequence
expect "$(completed facetloc map build --map.dis)" --map.distance
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
command -v zsh >/dev/null || exit 0

# offered LINE: the line as zsh completes it, typed into a terminal
cat >"$work/offered.zsh" <<'END'
zmodload zsh/zpty
export FPATH=$1/zsh:$FPATH
zpty terminal zsh -f -i
zpty -w terminal "autoload -U compinit; compinit -u -D; function show { print -r -- \"<\$BUFFER>\"; BUFFER=''; zle accept-line }; zle -N show; bindkey '^X' show; PS1=ready"
zpty -r terminal seen '*ready*ready*'
zpty -n -w terminal "$2"$'\t\C-x'
zpty -r terminal seen '*<*>*'
seen=${seen##*<}
print -r -- "${seen%%>*}"
END
offered() { timeout 60 zsh "$work/offered.zsh" "$work" "$1"; }
expect "$(offered 'facetloc loc')" "facetloc localize "
expect "$(offered 'facetloc_map build --map.dis')" "facetloc_map build --map.distance "
expect "$(offered 'facetloc map build --map.dis')" "facetloc map build --map.distance "
expect "$(offered 'facetloc_localize --seq')" "facetloc_localize --sequence "
