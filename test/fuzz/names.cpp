// SPDX-License-Identifier: BSD-3-Clause
// Lines as the names of images: their numbers, times and series.
#include "base/text.h"
#include "fuzz_file.h"
#include "recordings/name_numbers.h"

#include <cmath>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  std::vector<std::string> names;
  for (const auto line : text::lines(fuzz::asText(data, size))) names.emplace_back(line);
  for (const std::string& name : names) {
    internal::numbersOf(name);
    internal::hasWord(name, "depth");
    const auto stamp = internal::stampInName(name);
    fuzz::require(!stamp || std::isfinite(*stamp), "a time is not finite");
  }
  const auto series = internal::seriesInNames(names);
  fuzz::require(series.size() == names.size(), "a name has no series");
  for (const std::size_t s : series) fuzz::require(s < names.size(), "there are more series than names");
  if (const auto found = internal::numbersInNames(names)) {
    fuzz::require(found->numbers.size() == names.size(), "a name has no number");
    for (const double number : found->numbers) fuzz::require(std::isfinite(number), "a number is not finite");
    fuzz::require(internal::unitOfNumbers(found->numbers, found->decimal, found->padded).seconds > 0,
                  "a unit of no time");
  }
  return 0;
}
