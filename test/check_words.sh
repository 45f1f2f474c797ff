#!/usr/bin/env bash
# Prints each line of code and documents with a word that must not occur: what leans on its neighbour, what is unfinished, what
# sounds well and says nothing.
set -euo pipefail
cd "$(dirname "$0")/.."

words='the same of|\b[Tt]hat of\b|(is|are|be|was|were) told(?! apart)|have told|has told|[Oo]bviously|[Uu]tili[sz]e|[Ll]everag|[Ss]eamless|[Bb]lazing|cutting-edge'
words+='|TO''DO|FIX''ME|HA''CK'
modules=(features segmentation registration io apps test cmake README.md CHANGELOG.md CONTRIBUTING.md)
files=(--include='*.h' --include='*.hpp' --include='*.cpp' --include='*.md' --include='*.py' --include='*.ini' --include='CMakeLists.txt' --exclude=test_help.cpp)
if grep -rnP "$words" "${files[@]}" "${modules[@]}"; then
  echo "check_words: other words, please" >&2
  exit 1
fi
