// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/files.h"

#include <Eigen/Geometry>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace facetloc::internal {

/** \brief An image that a folder or a list names. */
struct ListedImage {
  std::filesystem::path path;
  std::optional<double> stamp{};             ///< as a list says it
  std::optional<Eigen::Isometry3d> T_w_c{};  ///< as a list says it
};

/** \brief The name of a frame by its file's: "a" of a.png and of a.segments.pcd. */
std::string frameName(const std::filesystem::path& path);
bool isCloud(const std::filesystem::path& path);
/** \brief A depth image or a cloud, by its name. */
bool isImage(const std::filesystem::path& path);
/** \brief ".pcd, .png, ...", for messages. */
std::string imageEndings();
/** \brief Is it a list by its name? */
bool isImageList(const std::filesystem::path& path);

/** \brief The images in a folder, in the order of their names; those with the word depth in their names alone
 * if there are any, since others beside them show something else, as confidences and colours do; before
 * these, files of segments alone, beside which facetloc_segment writes labels and pictures. Throws IoError.
 */
std::vector<ListedImage> imagesOfFolder(const std::filesystem::path& folder);

/** \brief The folder of a recording that has its images: the one called depth, or itself, or else the one
 * below it, to a depth of two, that has depth in its name and depth images in it, or images with depth in
 * their names. Throws IoError if there are several. */
std::filesystem::path folderOfImages(const std::filesystem::path& recording);

/** \brief The content of a folder without depth images, and advice. */
std::string foundIn(const std::filesystem::path& folder);
/** \brief Advice on files of an unsupported kind, by their extension; empty for others. */
std::string adviceOnFile(const std::filesystem::path& path);

/** \brief The images that a text file lists, in its order, each once; # starts a comment line. A line is a
 * path, relative to the list, or a stamp and a path (depth.txt of TUM), or several of these pairs
 * (associations), of which the one with depth in its folder or name counts, with a pose or without: seven
 * numbers, or eight with its stamp, in front or behind. Throws IoError with the line for anything else. */
std::vector<ListedImage> imagesOfList(const std::filesystem::path& list);

/** \brief The paths at which a file that belongs to a recording can be: in the folder of the images, its
 * parent, or the folder that was asked for and its parent. Of a folder that is a link, the parent is where
 * the link is, and else where the folder is. */
std::vector<std::filesystem::path> placesBeside(const std::filesystem::path& images,
                                                const std::filesystem::path& asked);

/** \brief The first regular file of this name in any of the folders. */
std::optional<std::filesystem::path> findIn(const std::vector<std::filesystem::path>& folders,
                                            const std::filesystem::path& name);

/** \brief Images with the times and poses of the JSON beside them, as scanner apps of phones and NeRF
 * programs write it, in the order of the images. */
struct ScannedImages {
  std::vector<ListedImage> images;  ///< stamps in the unit of the file; poses of the optical frame
  std::filesystem::path file;       ///< the first one; empty without any
  std::size_t unknown = 0;          ///< images without an entry
  std::string fault;                ///< the first file or entry that cannot be read; or nothing

  bool stamped() const;  ///< has each a time of its own?
  bool posed() const;    ///< has any a pose?
  /** \brief Their source and the fault, a sentence without full stop. */
  std::string remark(bool with_times) const;
};

/** \brief The entries of `transforms*.json` (`frames` of `file_path` or `depth_file_path`,
 * `transform_matrix`, `timestamp`), or of one JSON file per image with the numbers of its name
 * (`cameraPoseARFrame`, `time` or `timestamp`). Matrices are 4x4 by rows, of cameras whose y axis points up
 * and z axis backward. Empty unless more than half of the images have an entry. \param folders searched one
 * after the other */
ScannedImages scannedImages(const std::vector<ListedImage>& images,
                            const std::vector<std::filesystem::path>& folders);

}  // namespace facetloc::internal
