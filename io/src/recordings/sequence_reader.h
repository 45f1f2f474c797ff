// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/image_container.h"
#include "recordings/recorded_camera.h"
#include "recordings/recording_layout.h"

#include <facetloc/io/depth_sequence.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Finds out the kind of a recording, whatever its layout. Private to io. */
class SequenceReader {
public:
  /** \brief Lists the images. Throws IoError if it is no recording. */
  SequenceReader(const std::filesystem::path& path, const RecordingHints& hints);

  /** \brief Throws IoError if there are no images, and with advice if nothing says which camera took PNGs. */
  DepthSequence read() const;
  /** \brief For who asks for its poses alone, which may be there without images. */
  DepthSequence readWithoutCamera() const;

private:
  void listImages();
  bool needsCamera() const;
  bool hasSegments() const;
  DepthSequence readWith(std::optional<RecordedCamera> camera) const;
  std::optional<RecordedCamera> camera() const;

  std::filesystem::path path_, asked_;
  RecordingHints hints_;
  std::vector<std::filesystem::path> beside_;  // where files that belong to it can be
  std::vector<std::filesystem::path> within_;  // those of these that are its own
  RecordingLayout layout_;
  std::shared_ptr<const ImageContainer> container_;
};

}  // namespace facetloc::internal
