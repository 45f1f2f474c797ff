// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <sys/types.h>

namespace facetloc {

/** \brief Why a build without VTK, which has pages in their place, draws no pictures. */
constexpr const char* kWithoutVtk =
    "this build is without VTK, which draws them; the package facetloc-tools-gui has it";

/** \brief Can the X server that DISPLAY names be reached? */
bool displayUsable();

/** \brief An X display to render into, for as long as the object lives.
 *
 * Debian's VTK renders through X only, and aborts the process without it. Where no X server can be reached, a
 * private Xvfb is started, DISPLAY is set, and both are undone in the end. Everything that renders has to be
 * gone by then. */
class OffscreenDisplay {
public:
  OffscreenDisplay();
  ~OffscreenDisplay();
  OffscreenDisplay(const OffscreenDisplay&) = delete;
  OffscreenDisplay& operator=(const OffscreenDisplay&) = delete;

  bool available() const { return problem_.empty(); }
  /** \brief Why no display is available, and the remedy. */
  const std::string& problem() const { return problem_; }

private:
  void startServer();
  void stopServer();

  std::string problem_;
  std::optional<std::string> display_before_;
  pid_t server_ = -1;
};

}  // namespace facetloc
