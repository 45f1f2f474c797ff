#!/usr/bin/env bash
# Manual pages of what the tools and their commands list about themselves: manuals.sh FOLDER_OF_TOOLS OUT_FOLDER VERSION TOOL...
set -euo pipefail
tools=$1 out=$2 version=$3
shift 3
here=$(cd "$(dirname "$0")" && pwd)

# commands_of TOOL: "NAME<tab>PURPOSE", a line for each command.
commands_of() { "$tools/$1" --help | sed -nE '/^Commands:/,/^$/s/^  ([a-z-]+)( [^ ]+)*  +([^ ].*)$/\1\t\3/p'; }
# page PURPOSE TOOL [COMMAND]
page() {
  local file
  file=$out/$(IFS=-; echo "${*:2}").1
  help2man --no-info --include "$here/manual.h2m" --version-string "$version" --name "$1" --output "$file" "$tools/$2 ${*:3}"
}

rm -rf "$out" && mkdir -p "$out"
for tool in "$@"; do
  if [ "$tool" = facetloc ]; then
    page "find where a depth camera is, from the planes that it sees" facetloc
    page "$(commands_of facetloc | sed -n 's/^try\t//p')" facetloc try
  else
    page "$(commands_of facetloc | sed -n "s/^${tool#facetloc_}\t//p")" "$tool"
  fi
  [ "$tool" = facetloc_map ] || continue
  commands_of "$tool" | while IFS=$'\t' read -r command purpose; do page "$purpose" "$tool" "$command"; done
done
