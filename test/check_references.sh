#!/usr/bin/env bash
# Checks the references in code and documents: sections of a METHOD.md, which are numbered from 1 without a gap, files and headings
# behind Markdown links, and no document that is not here. check_references.sh FOLDER checks the links of the documents in another
# folder, as in an installation.
set -euo pipefail
[[ $# -gt 0 ]] || repository=yes
cd "${1:-$(dirname "$0")/..}"

# What exists, as "MODULE/METHOD NUMBER"; an equation, whose number ends a line, with the number in parentheses.
targets() {
  local file
  for file in {features,segmentation,registration,registration/localization,registration/mapping}/METHOD.md; do
    [[ -f $file ]] || continue
    local module=${file%/METHOD.md}
    local method=${module##*/}/METHOD
    sed -nE "s|^##+ ([0-9]+(\.[0-9]+)*)\.? .*|$method \1|p; s|.*(\([0-9]+\.[0-9]+\)) *$|$method \1|p" "$file"
  done
}

# Prints "file:line: message" of each dead reference and "file:line=path" of each link. References may wrap over two lines.
references() {
  awk '
    function checkSections(reference,    module, rest, key) {
      module = match(reference, /[a-z]+\/METHOD/) ? substr(reference, RSTART, RLENGTH - 7) : own_module
      if (reference ~ /[(][.][.]\/METHOD/) module = folder[1]
      if (module == "") print where ": " reference ": of which module? (as in features/METHOD 1)"
      rest = reference
      sub(/^.*METHOD[.]md[)]/, "", rest)
      for (; module != "" && match(rest, number); rest = substr(rest, RSTART + RLENGTH)) {
        key = module "/METHOD " substr(rest, RSTART, RLENGTH)
        if (!(key in exists)) print where ": " reference ": there is no " key
      }
    }
    function checkText(    kind, start, end, reference) {
      for (kind in pattern)
        for (start = 1; match(substr(text, start), pattern[kind]); start = end) {
          end = start + RSTART - 1 + RLENGTH
          if (start + RSTART - 1 > length(here)) break  # in the next line alone
          reference = substr(text, start + RSTART - 1, RLENGTH)
          if (kind == "document") print where ": " reference ": no such document"
          else if (kind == "own") checkSections(substr(reference, 2, length(reference) - 2))
          else checkSections(reference)
        }
    }
    function listLinks(    rest, path) {
      if (here ~ /^ *```/) in_code = !in_code
      rest = here
      gsub(/`[^`]*`/, "code", rest)
      for (; !in_code && match(rest, /[^[]\]\([^) ]+/); rest = substr(rest, RSTART + RLENGTH)) {
        path = substr(rest, RSTART + 3, RLENGTH - 3)
        if (path !~ /^[a-z]+:/) print where "=" path
      }
    }
    function look(following) {
      text = here " " following
      where = file ":" line
      checkText()
      if (file ~ /[.]md$/) listLinks()
    }
    BEGIN {
      number = "([0-9]+([.][0-9]+)*|[(][0-9]+([.][0-9]+)*[)])"
      more = "(, | and |-)" number
      # The list ends before a stop, so that in "METHOD N, 30 px" it has one number.
      pattern["section"] = "([a-z]+/)?METHOD (eqs?[.] |sections? )?" number "((" more ")+[]).,:;`])?"
      pattern["equation"] = "[Ee]qs?[.] " number "(" more ")* of ([a-z]+/)?METHOD"
      pattern["linked"] = "METHOD([.]md)?\\]\\([a-z.\/]*METHOD[.]md\\)(, section)? " number
      pattern["document"] = "METHOD[_]MEASURED|DESIGN [0-9]|(DESIGN|ROOMS|STYLE)[.]md|[P]LATFORM|[F]INDINGS [0-9]"
    }
    NR == FNR { exists[$0]; next }
    FNR == 1 {
      if (file) look("")
      file = FILENAME
      in_code = 0
      delete pattern["own"]
      if (file ~ /METHOD[.]md$/) pattern["own"] = "[(][1-9][0-9]?[.][0-9][)]"
      split(file, folder, "/")
      own_module = folder[1] == "test" || folder[2] ~ /^(localization|mapping)$/ ? folder[2] : folder[1]
      if (own_module !~ /^(features|segmentation|registration|localization|mapping)$/) own_module = ""
    }
    FNR > 1 {
      following = $0
      sub(/^ *(\/\/+<?|\*+|#+)? */, "", following)
      look(following)
    }
    { here = $0; line = FNR }
    END { if (file) look("") }' <(targets) "$@"
}

# The anchors of a document, as GitHub makes them of its headings.
anchors() {
  LC_ALL=C awk '
    /^ *```/ { in_code = !in_code }
    !in_code && /^#+ / {
      anchor = tolower($0)
      sub(/^#+ +/, "", anchor)
      gsub(/[][!-,.\/:-@\\^`{|}~]/, "", anchor)
      gsub(/ /, "-", anchor)
      print anchor (seen[anchor]++ ? "-" seen[anchor] - 1 : "")
    }' "$1"
}

# Prints what is wrong with a link: is_dead DOCUMENT LINK.
is_dead() {
  local path=${2%%#*} target
  target=${path:+$(dirname "$1")/$path}
  target=${target:-$1}
  if [[ ! -e $target ]]; then
    echo "no such file"
  elif [[ $2 == *#* ]] && ! anchors "$target" | grep -qxF -e "${2#*#}"; then
    echo "no such heading"
  fi
}

files=()
while IFS= read -r file; do
  [[ ! -e $file ]] || files+=("$file")
done < <(if [[ ${repository-} ]]; then git ls-files '*.h' '*.hpp' '*.cpp' '*.md' '*.txt' '*.cmake' '*.sh'; else find * -name '*.md' | sort; fi)
[[ ${#files[@]} -gt 0 ]] || { echo "no documents in $PWD" >&2; exit 1; }
found=$(references "${files[@]}")
dead=0
links=0
while IFS= read -r line; do
  if [[ $line =~ ^([^:=]+)(:[0-9]+)=(.*)$ ]]; then
    document=${BASH_REMATCH[1]} number=${BASH_REMATCH[2]} link=${BASH_REMATCH[3]}
    links=$((links + 1))
    fault=$(is_dead "$document" "$link")
    [[ -n $fault ]] || continue
    line="$document$number: $link: $fault"
  fi
  [[ -z $line ]] && continue
  echo "$line"
  dead=1
done <<< "$found"
# Sections of a document are 1, 2, ..., and those of a section N.1, N.2, ...: prints what breaks the order.
disorder=$(targets | grep -v '(' | awk '
  { last = $2; sub(/^.*[.]/, "", last); parent = $2; if (!sub(/[.][0-9]+$/, "", parent)) parent = ""
    if (last != ++count[$1, parent] || parent != "" && !(($1, parent) in exists)) print $1, $2
    exists[$1, $2] }')
[[ -z $disorder ]] || { echo "sections that are not numbered in order: $disorder"; dead=1; }
twice=$(targets | grep -v '(' | sort | uniq -d)
[[ -z $twice ]] || { echo "sections that are there twice: $twice"; dead=1; }
echo "$links links checked" >&2
exit "$dead"
