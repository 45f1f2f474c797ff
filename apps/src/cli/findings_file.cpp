// SPDX-License-Identifier: BSD-3-Clause
#include "cli/findings_file.h"

#include "cli/text.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <json/json.h>
#include <ostream>
#include <sstream>

namespace facetloc {
namespace {

Json::Value jsonOf(const Finding& finding) {
  Json::Value value;
  value["id"] = finding.id;
  value["severity"] = toString(finding.severity);
  value["words"] = finding.words;
  value["cure"] = finding.cure;
  value["evidence"] = Json::Value(Json::arrayValue);
  for (const Evidence& number : finding.evidence) {
    Json::Value& item = value["evidence"].append(Json::Value());
    item["quantity"] = number.quantity;
    item["value"] = number.value;
    item["std"] = number.std;
  }
  return value;
}

Json::StreamWriterBuilder writerOf(const char* indentation) {
  Json::StreamWriterBuilder builder;
  builder["indentation"] = indentation;
  builder["precision"] = 6;
  return builder;
}

/** Throws std::exception for another value. */
Finding findingOf(const Json::Value& value) {
  Finding finding{value["id"].asString(), Severity::note, value["words"].asString(),
                  value["cure"].asString()};
  for (const Severity severity : {Severity::doubt, Severity::refusal})
    if (value["severity"].asString() == toString(severity)) finding.severity = severity;
  for (const Json::Value& item : value["evidence"])
    finding.evidence.push_back(
        {item["quantity"].asString(), item["value"].asDouble(), item["std"].asDouble()});
  return finding;
}

}  // namespace

std::string toJson(const Finding& finding) {
  Json::Value line;
  line["finding"] = jsonOf(finding);
  return Json::writeString(writerOf(""), line);
}

std::string toString(const Findings& findings) {
  std::string lines;
  for (const Finding& finding : findings) lines += "- " + printable(finding.text()) + "\n";
  return lines;
}

void writeFindings(const std::filesystem::path& path, const Findings& findings) {
  Json::Value list(Json::arrayValue);
  for (const Finding& finding : findings) list.append(jsonOf(finding));
  const Json::StreamWriterBuilder builder = writerOf("  ");
  writeTextAtomically(path, [&](std::ostream& out) { out << Json::writeString(builder, list) << "\n"; });
}

Findings readFindings(const std::filesystem::path& path) try {
  std::istringstream in(readText(path));
  Json::Value list;
  in >> list;
  Findings findings;
  for (const Json::Value& value : list) findings.push_back(findingOf(value));
  return findings;
} catch (const std::exception&) {
  throw IoError(path.string(), "is no list of findings");
}

}  // namespace facetloc
