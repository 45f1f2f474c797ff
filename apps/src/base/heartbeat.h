// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/app.h"

#include <memory>
#include <string>

namespace facetloc {

/** \brief Shows that work goes on if nothing is printed for a second: the time it has taken, in the line of
 * progress on a terminal, else a dot every two seconds. Output through console() comes whole, on
 * lines of its own. Nothing if quiet. */
class Heartbeat {
public:
  Heartbeat(const Console& console, const std::string& what);
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /** \brief For the work: remarks and progress are seen here. Results go to a stream of the work's own. */
  Console console(std::ostream& out) const;
  double seconds() const;

private:
  class Watch;
  const Console& console_;
  std::unique_ptr<Watch> watch_;
  std::unique_ptr<std::ostream> err_;
};

}  // namespace facetloc
