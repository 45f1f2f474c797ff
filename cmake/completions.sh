#!/usr/bin/env bash
# Completion for bash and zsh, of the options that the tools themselves list: completions.sh FOLDER_OF_TOOLS OUT_FOLDER
# Writes OUT_FOLDER/bash/TOOL for each tool, and OUT_FOLDER/zsh/_facetloc.
set -euo pipefail
tools=$1 out=$2

commands_of() { "$1" --help 2>/dev/null | sed -nE '/^Commands:/,/^$/s/^  ([a-z-]+) .*/\1/p' | tr '\n' ' '; }
options_of() { "$@" --help-all 2>/dev/null | grep -oE '^ +(-[a-z] \[ )?--[a-z][a-z0-9._-]*' | grep -oE -- '--.*' | sort -u | tr '\n' ' '; }

mkdir -p "$out/bash" "$out/zsh"
zsh=$out/zsh/_facetloc
names=$(cd "$tools" && for tool in facetloc_*; do [ -x "$tool" ] && [ -f "$tool" ] && echo "$tool"; done)
{
  echo "#compdef facetloc $(tr '\n' ' ' <<<"$names")"
  echo 'local -A facetloc_options facetloc_commands'
} >"$zsh"
for tool in $names; do
  has=$(commands_of "$tools/$tool") cases=""
  if [ -n "$has" ]; then
    for command in $has; do
      list=$(options_of "$tools/$tool" "$command")
      cases+="    $command) options=\"$list\" ;;"$'\n'
      echo "facetloc_options+=('$tool $command' '$list')" >>"$zsh"
    done
    echo "facetloc_commands+=($tool '$has')" >>"$zsh"
  else
    list=$(options_of "$tools/$tool")
    echo "facetloc_options+=($tool '$list')" >>"$zsh"
  fi
  {
    echo "# Completion of $tool for bash."
    echo "_$tool() {"
    echo '  local word=${COMP_WORDS[COMP_CWORD]} options=""'
    if [ -n "$has" ]; then
      echo "  if [ \"\$COMP_CWORD\" -eq 1 ]; then COMPREPLY=(\$(compgen -W \"$has --help --version\" -- \"\$word\")); return; fi"
      printf '  case ${COMP_WORDS[1]} in\n%s  esac\n' "$cases"
    else
      echo "  options=\"$list\""
    fi
    echo '  case $word in'
    echo '    -*) COMPREPLY=($(compgen -W "$options" -- "$word")) ;;'
    echo '    *) COMPREPLY=($(compgen -f -- "$word")) ;;'
    echo '  esac'
    echo '}'
    echo "complete -o filenames -F _$tool $tool"
  } >"$out/bash/$tool"
done
commands=$(commands_of "$tools/facetloc")
cat >"$out/bash/facetloc" <<END
# Completion of facetloc for bash: the commands, and then the options of the tool behind each.
_facetloc() {
  if [ "\$COMP_CWORD" -eq 1 ]; then COMPREPLY=(\$(compgen -W "$commands--help --version" -- "\${COMP_WORDS[1]}")); return; fi
  local tool=facetloc_\${COMP_WORDS[1]} file=\${BASH_SOURCE[0]%/*}/facetloc_\${COMP_WORDS[1]}
  if [ -e "\$file" ]; then
    source "\$file"
    COMP_WORDS=("\$tool" "\${COMP_WORDS[@]:2}") COMP_CWORD=\$((COMP_CWORD - 1))
    "_\$tool"
  else
    COMPREPLY=(\$(compgen -f -- "\${COMP_WORDS[COMP_CWORD]}"))
  fi
}
complete -o filenames -F _facetloc facetloc
END
{
  echo "facetloc_commands+=(facetloc '$commands')"
  cat <<'END'
local tool=${words[1]:t}
if [[ $tool == facetloc ]] && (( CURRENT > 2 )); then
  tool=facetloc_${words[2]}
  shift words
  (( CURRENT -= 1 ))
fi
if (( CURRENT == 2 )) && [[ -n ${facetloc_commands[$tool]} ]]; then
  compadd -- ${=facetloc_commands[$tool]} --help --version
elif [[ $PREFIX == -* ]]; then
  local key=$tool
  [[ -n ${facetloc_commands[$tool]} ]] && key="$tool ${words[2]}"
  compadd -- ${=facetloc_options[$key]}
else
  _files
fi
END
} >>"$zsh"
