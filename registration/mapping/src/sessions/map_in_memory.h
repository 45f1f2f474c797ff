// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/map_parts.h>
#include <facetloc/mapping/map_making.h>

#include <utility>

namespace facetloc::internal {

/** \brief A map that is made in memory. */
class MapInMemory : public MapSink {
public:
  explicit MapInMemory(std::shared_ptr<Map> map) : map_(std::move(map)) {}

  std::shared_ptr<Map> map() override { return map_; }
  void setCamera(const Camera& camera) override { map_->camera = camera; }
  void setMeta(const std::string& key, const std::string& value) override { map_->meta[key] = value; }
  void add(const Link& link) override { map_->links.push_back(link); }
  void setWhole() override { placeByLinks(*map_); }

private:
  std::shared_ptr<Map> map_;
};

}  // namespace facetloc::internal
