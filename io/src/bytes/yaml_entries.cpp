// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/yaml_entries.h"

#include "base/text.h"

#include <algorithm>
#include <sstream>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

namespace facetloc::internal {
namespace {

/** Takes the events of a parser: a tree of nodes could have no end, by an alias of itself. */
class Collector : public YAML::EventHandler {
public:
  void OnDocumentStart(const YAML::Mark&) override { open_.clear(); }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override { next(); }
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override { next(); }
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string& value) override {
    if (!open_.empty() && open_.back() == Part::key)
      entries.push_back({text::lower(value.substr(value.find_last_of("./") + 1)), {}, {}});
    else if (!entries.empty())
      take(value);
    next();
  }
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open_.push_back(Part::item);
  }
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open_.push_back(Part::key);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

  std::vector<YamlEntry> entries;

private:
  enum class Part { item, key, value };  // next one of a sequence or a map

  void close() {
    open_.pop_back();
    next();
  }
  void next() {
    if (!open_.empty() && open_.back() != Part::item)
      open_.back() = open_.back() == Part::key ? Part::value : Part::key;
  }
  void take(std::string scalar) {
    entries.back().words.push_back(scalar);
    std::replace(scalar.begin(), scalar.end(), ',', ' ');
    for (std::string_view digits : text::words(scalar)) {
      if (digits.size() > 1 && digits.back() == '.') digits.remove_suffix(1);  // OpenCV's "0."
      if (const auto number = text::to<double>(digits)) entries.back().numbers.push_back(*number);
    }
  }

  std::vector<Part> open_;  // next part of each sequence and map
};

}  // namespace

std::vector<YamlEntry> yamlEntries(std::string_view text) {
  constexpr int kMostDocuments = 100;  // yaml-cpp 0.7 never ends with a document that begins with a bracket
  Collector collector;
  std::istringstream in{std::string(text)};
  try {
    YAML::Parser parser(in);
    for (int i = 0; i < kMostDocuments && parser.HandleNextDocument(collector);) ++i;
  } catch (const YAML::Exception&) {  // entries up to the fault are kept
  }
  return collector.entries;
}

}  // namespace facetloc::internal
