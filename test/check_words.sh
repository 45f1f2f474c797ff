#!/usr/bin/env bash
# Prints each line of code and documents with a word that must not occur: what leans on its neighbour, what is unfinished, what
# sounds well and says nothing. Documents that users read are held to more than code is, where some patterns are only counted.
set -euo pipefail
cd "$(dirname "$0")/.."

words='the same of|\b[Tt]hat of\b|(is|are|be|was|were) told(?! apart)|have told|has told|[Oo]bviously|[Uu]tili[sz]e|[Ll]everag|[Ss]eamless|[Bb]lazing|cutting-edge'
words+='|TO''DO|FIX''ME|HA''CK|\(as of |takes no notice|hang from|what it is worth|\ba place that is none'
# In documents, each with its remedy: name the thing, say the number, use the field's word.
patterns=(
  '\bso many\b'                                                  # N
  'there is none|that is none'                                   # empty, missing, invalid
  '\balike\b|look-alike'                                         # equal, of the same shape
  '\bby itself\b|\bby themselves\b'                              # automatically, on its own
  '\b[Mm]ade[ -]up\b'                                            # simulated
  '\b[Nn]obody\b'                                                # no process, no one; or passive
  '\bdear(er|est)?\b'                                            # expensive
  '\bhangs? (from|on)\b'                                         # is attached to, depends on
  'what [a-z ]{0,30}(is|are) worth'                              # value, accuracy
  'beyond sense|in peace|woke up|closed eyes'                    # impossible, cleanly, restarted, covered
  ', too\.'                                                      # also
  'ha(s|ve) to do with|has to be given|passed over|\b[Bb]eside that\b'  # differs from, required, ignored, furthermore
  '\btells? of\b'                                                # reports, shows
)
modules=(features segmentation registration io apps test cmake README.md CHANGELOG.md CONTRIBUTING.md)
documents=(README.md CHANGELOG.md CONTRIBUTING.md apps/*.md apps/examples/README.md {features,segmentation,registration,io}/README.md registration/*/README.md)
files=(--include='*.h' --include='*.hpp' --include='*.cpp' --include='*.md' --include='*.py' --include='*.ini' --include='CMakeLists.txt' --exclude=test_help.cpp)

found=0
grep -rnP "$words" "${files[@]}" "${modules[@]}" && found=1
printf '%9s %5s  pattern\n' documents code
for pattern in "${patterns[@]}"; do
  in_documents=$(grep -hoP "$pattern" "${documents[@]}" | wc -l) || true
  in_code=$(grep -rhoP "$pattern" --include='*.h' --include='*.hpp' --include='*.cpp' features segmentation registration io apps | wc -l) || true
  printf '%9d %5d  %s\n' "$in_documents" "$in_code" "$pattern"
  [[ $in_documents -eq 0 ]] || { grep -nP "$pattern" "${documents[@]}"; found=1; }
done
[[ $found -eq 0 ]] || { echo "check_words: other words, please" >&2; exit 1; }
