// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/finding.h>

#include <filesystem>
#include <string>

namespace facetloc {

/** \brief Their file in a folder of results. */
constexpr const char* kFindingsFile = "findings.json";

/** \brief A finding as one line of JSON, {"finding": {...}}, without a line feed: its line in a stream of
 * answers (ROBOT.md). */
std::string toJson(const Finding& finding);

/** \brief A line for each, "- WORDS; CURE": their list in the output of a tool. */
std::string toString(const Findings& findings);

/** \brief Writes findings as a JSON list of objects with id, severity, words, cure and evidence. Throws
 * IoError. */
void writeFindings(const std::filesystem::path& path, const Findings& findings);

/** \brief Reads such a file. Throws IoError. */
Findings readFindings(const std::filesystem::path& path);

}  // namespace facetloc
