// SPDX-License-Identifier: BSD-3-Clause
#include "cli/given_inputs.h"

#include "base/text.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/results.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

/** Cheap, and without doubt: else the tool itself finds out. */
bool isMisplaced(const GivenInput& input) {
  std::error_code ignored;
  if (isMap(input.word)) return fs::is_directory(input.path, ignored);
  if (input.word == "INPUT") return false;  // any kind
  return isMap(input.path) || (input.word == "GROUNDTRUTH" && isResultsFolder(input.path));
}

/** Kind of a misplaced input. */
std::string kindOf(const std::string& path) {
  if (isMap(path)) return "a map";
  if (isResultsFolder(path)) return "a folder of results";
  try {
    RecordingHints hints;
    hints.segments = true;
    DepthSequence::open(path, hints);
    return "a recording";
  } catch (const std::exception&) {
    return "a folder";
  }
}

}  // namespace

bool isMap(const fs::path& path) { return text::lowerExtension(path) == ".flmap"; }

std::vector<std::string> misplacedInputs(const std::vector<GivenInput>& inputs) {
  std::vector<std::string> facts;
  for (const GivenInput& input : inputs)
    if (isMisplaced(input)) facts.push_back(input.path + " is " + kindOf(input.path));
  return facts;
}

}  // namespace facetloc
