// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "live/live_result.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Commands of the user of a live window. */
enum class LiveCommand { screenshot, record, pause, relocalize, quit };
/** \brief The command of a key, as X names keys; nothing for the others. */
std::optional<LiveCommand> commandOf(const std::string& key);
/** \brief All keys and their commands, on one line. */
std::string keysText();

/** \brief A window on the screen that shows a live run. Needs an X display; one thread for all of VTK. */
class LiveWindow {
public:
  LiveWindow(const std::string& title, std::shared_ptr<const Map> map);
  ~LiveWindow();

  /** \brief Draws a frame as LivePicture does. \param footer lines at the bottom, above the keys. */
  void show(const LiveResult& result, const std::vector<std::string>& footer);
  /** \brief The commands of the user since the last call, without waiting. */
  std::vector<LiveCommand> commands();
  /** \brief As if the user had pressed a key. */
  void press(const std::string& key);

private:
  struct Insides;
  std::unique_ptr<Insides> insides_;
};

}  // namespace facetloc
