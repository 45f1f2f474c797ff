// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Which images a recording has. Private to io. */

namespace facetloc::internal {

/** \brief An image that a folder or a list names. */
struct ListedImage {
  std::filesystem::path path;
  std::optional<double> stamp{};  ///< [s], where a list says it
};

bool endsWith(const std::string& name, const std::string& ending);
/** \brief ".png" of a.PNG. */
std::string lowerExtension(const std::filesystem::path& path);
/** \brief The name of a frame by its file's: "a" of a.png and of a.segments.pcd. */
std::string frameName(const std::filesystem::path& path);
bool isPng(const std::filesystem::path& path);
bool isImage(const std::filesystem::path& path);
/** \brief Is it a list by its name? */
bool isImageList(const std::filesystem::path& path);

/** \brief The images in a folder, in the order of their names; those with the ending `.depth` alone if there
 * are any, since others beside them show something else; before these, files of
 * segments alone, beside which facetloc_segment writes labels and pictures. Throws IoError. */
std::vector<ListedImage> imagesOfFolder(const std::filesystem::path& folder);

/** \brief The images that a text file lists, in its order; # starts a comment line. A line is a path,
 * relative to the list, or a stamp and a path (depth.txt of TUM), or two of these pairs (associations), of
 * which the one in a folder called depth counts. Throws IoError with the line for anything else. */
std::vector<ListedImage> imagesOfList(const std::filesystem::path& list);

/** \brief The paths at which a file that belongs to a recording can be: in the folder of the images, its
 * parent, or the folder that was asked for and its parent. Of a folder that is a link, the parent is where
 * the link is, and else where the folder is. */
std::vector<std::filesystem::path> placesBeside(const std::filesystem::path& images,
                                                const std::filesystem::path& asked);

/** \brief The first regular file of this name in any of the folders. */
std::optional<std::filesystem::path> findIn(const std::vector<std::filesystem::path>& folders,
                                            const std::filesystem::path& name);

}  // namespace facetloc::internal
