// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "frame_source.h"

#include <facetloc/io/depth_sequence.h>

namespace facetloc {

/** \brief The images of a folder, at the times of their stamps; at 30 Hz if their names are no times. */
class SequenceSource : public FrameSource {
public:
  /** \brief Reads the first image that can be read, for its camera. Throws IoError. */
  explicit SequenceSource(const std::string& folder);
  std::size_t size() const override { return sequence_.frames().size(); }
  std::uint64_t stamp(std::size_t index) const override;
  void read(std::size_t index, std::uint16_t* depth) const override;

private:
  DepthSequence sequence_;
  bool has_times_ = false;
};

}  // namespace facetloc
