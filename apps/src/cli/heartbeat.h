// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

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

  /** \brief For work whose results go to a stream of its own, which does not count as output here. */
  Console console(std::ostream& out) const;
  /** \brief For work that prints to the console given. */
  Console console() const;
  double seconds() const;

private:
  class Watch;
  class Relay;
  const Console& console_;
  std::unique_ptr<Watch> watch_;
  std::unique_ptr<Relay> out_relay_, err_relay_;
  std::unique_ptr<std::ostream> out_, err_;
};

}  // namespace facetloc
