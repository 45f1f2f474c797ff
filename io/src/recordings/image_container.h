// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/io/camera_file.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

/** \file
 * Recordings that are one file. Private to io. */

namespace facetloc::internal {

/** \brief One file that has all depth images of a recording. All calls are thread-safe and throw IoError. */
class ImageContainer {
public:
  virtual ~ImageContainer() = default;

  virtual std::size_t size() const = 0;
  virtual double stamp(std::size_t index) const = 0;  ///< [s]
  /** \brief What it says of its camera. */
  virtual CameraFile camera() const = 0;
  /** \brief An image, with the size that it has and whatever intrinsics. */
  virtual DepthImage read(std::size_t index) const = 0;
  /** \brief What its user should know of it, a sentence without full stop; empty if there is nothing. */
  virtual std::string remark() const = 0;
};

/** \brief Is it one, by its name? */
bool isContainer(const std::filesystem::path& path);
/** \brief Throws IoError. \param topic of a bag: which of its images (bag.h) */
std::shared_ptr<const ImageContainer> openContainer(const std::filesystem::path& path,
                                                    const std::string& topic);

/** \brief Is it a ROS 1 bag, by its name? */
bool isBag(const std::filesystem::path& path);

}  // namespace facetloc::internal
