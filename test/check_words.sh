#!/usr/bin/env bash
# Prints each line of code and documents with a word that must not occur: what leans on its neighbour, what is unfinished, what
# sounds well and says nothing. Prints how often each pattern occurs, and fails where one does.
set -euo pipefail
cd "$(dirname "$0")/.."

words='the same of|\b[Tt]hat of\b|(is|are|be|was|were) told(?! apart)|have told|has told|[Oo]bviously|[Uu]tili[sz]e|[Ll]everag|[Ss]eamless|[Bb]lazing|cutting-edge'
words+='|TO''DO|FIX''ME|HA''CK|\(as of |takes no notice|hang from|what it is worth|\ba place that is none'
# In documents and code, each with its remedy: name the thing, say the number, use the field's word.
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
# In comments of code.
trailing='\S.*(//|///<)\s*(of|by|from|in) '                        # hangs from its line: a noun phrase stands alone
noun='(^\s*(//|\*|/\*)|\s//).*\b[Ww]hat\b(?! to\b)(?![^.]*\?)'      # "what ..." in place of a noun: name the thing
fragment='^\s*(//|/\*\*)\s*(\\brief )?(Of|By|From|In) '              # begins with its attribute: name the thing first
fragment+='(?![^.;:]*, (?!(so that|that|which|whose|where|as|since|if|unless|and|or|but|for|of|by|from|in|on|with|beyond)\b)[^.;:]*\b(is|are|was|were|has|have|may|can|must|does|do|counts?|shows?)\b)'  # but for sentences
modules=(features segmentation registration io apps test cmake README.md CHANGELOG.md CONTRIBUTING.md)
documents=(README.md CHANGELOG.md CONTRIBUTING.md apps/*.md apps/{examples,ros}/README.md {features,segmentation,registration,io}/README.md registration/*/README.md)
files=(--include='*.h' --include='*.hpp' --include='*.cpp' --include='*.md' --include='*.py' --include='*.ini' --include='CMakeLists.txt' --exclude=test_help.cpp)

code=(--include='*.h' --include='*.hpp' --include='*.cpp' features segmentation registration io apps test)

found=0
grep -rnP "$words" "${files[@]}" "${modules[@]}" && found=1
# Counts a pattern in documents and in code, and prints each line that has it.
count() {
  in_documents=0
  [[ $2 == comments ]] || in_documents=$(grep -hoP "$1" "${documents[@]}" | wc -l) || true
  in_code=$(grep -rhoP "$1" "${code[@]}" | wc -l) || true
  printf '%9d %5d  %s\n' "$in_documents" "$in_code" "$1"
  [[ $in_documents -eq 0 ]] || { grep -nP "$1" "${documents[@]}"; found=1; }
  [[ $in_code -eq 0 ]] || { grep -rnP "$1" "${code[@]}"; found=1; }
}
printf '%9s %5s  pattern\n' documents code
for pattern in "${patterns[@]}"; do count "$pattern" everywhere; done
for pattern in "$trailing" "$noun" "$fragment"; do count "$pattern" comments; done
[[ $found -eq 0 ]] || { echo "check_words: other words, please" >&2; exit 1; }
