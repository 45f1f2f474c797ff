// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace facetloc::internal {

/** \brief Things kept of some images of a run once they are read, so that a later step need not read them
 * again: of those that are asked for, however long the run is. Thread-safe but for ask(). */
template <typename Thing>
class KeptOfImages {
public:
  /** \brief Gives up the things of other images. */
  void ask(const std::vector<std::size_t>& images) {
    std::map<std::size_t, std::optional<Thing>> asked;
    for (const std::size_t image : images) asked.try_emplace(image, std::move(things_[image]));
    things_ = std::move(asked);
  }

  /** \brief Is it asked for, and not there? */
  bool lacks(std::size_t image) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = things_.find(image);
    return found != things_.end() && !found->second;
  }

  /** \brief If it is asked for and not there. */
  void keep(std::size_t image, Thing thing) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = things_.find(image);
    if (found != things_.end() && !found->second) found->second.emplace(std::move(thing));
  }

  /** \brief Null if it is not there; valid until ask(). */
  const Thing* find(std::size_t image) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = things_.find(image);
    return found != things_.end() && found->second ? &*found->second : nullptr;
  }

private:
  mutable std::mutex mutex_;
  std::map<std::size_t, std::optional<Thing>> things_;
};

}  // namespace facetloc::internal
