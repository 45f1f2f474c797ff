// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Consequence of a finding. */
enum class Severity {
  note,    ///< worth knowing; results do not suffer
  doubt,   ///< something may be wrong: no result is derived, and none advised, by the numbers concerned
  refusal  ///< the input cannot be right as it is read: no map is made of it, unless this is asked for
};

/** \brief "note", "doubt", "refusal". */
constexpr const char* toString(Severity severity) {
  return severity == Severity::note ? "note" : severity == Severity::doubt ? "doubt" : "refusal";
}

/** \brief A number that a finding rests on. */
struct Evidence {
  std::string quantity;  ///< with its unit: "rotation_deg"
  double value = 0;
  double std = 0;  ///< standard deviation; 0 = exact, or not known
};

/** \brief A fact that a stage has found about its input, in words and numbers. All tools show the same ones.
 *
 * apps/FINDINGS.md lists the ids with their meaning and certainty. */
struct Finding {
  std::string id;  ///< stage and kind: "poses.convention"
  Severity severity = Severity::note;
  std::string words;  ///< a sentence without full stop
  std::string cure;   ///< remedy: a command line or a line of camera.ini; empty where nothing helps
  std::vector<Evidence> evidence{};

  /** \brief The words and the cure, a sentence without full stop. */
  std::string text() const { return cure.empty() ? words : words + "; " + cure; }
};

using Findings = std::vector<Finding>;

/** \brief The first finding of that severity or a worse one, or null. */
inline const Finding* firstOf(const Findings& findings, Severity least) {
  const auto found = std::find_if(findings.begin(), findings.end(),
                                  [least](const Finding& finding) { return finding.severity >= least; });
  return found == findings.end() ? nullptr : &*found;
}

inline void append(Findings&& more, Findings& all) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

}  // namespace facetloc
