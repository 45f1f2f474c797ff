// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/segment.h>

#include <pcl/PolygonMesh.h>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace facetloc {

// Points and polygons for PCL's tools and for mesh viewers. All files are written atomically; all functions
// throw IoError for a file that cannot be written.

/** \brief A colour of points and polygons. */
struct PointColour {
  std::uint8_t red = 0, green = 0, blue = 0;
};

/** \brief The colours of a PCD file, of each pixel of the image that was read from it. Empty if it has none,
 * or if its points are not in the axes and the order of the image. Throws IoError for an unreadable file. */
std::vector<PointColour> readColours(const std::filesystem::path& path, const DepthImage& image);

/** \brief Writes the points of an image as an organized PCD (x, y, z, and rgb if there are colours), moved to
 * other axes; unmeasured pixels are NaN. \param colours of each pixel, or none. Throws
 * std::invalid_argument if they are not as many as pixels. */
void writeCloud(const std::filesystem::path& path, const DepthImage& image,
                const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity(),
                const std::vector<PointColour>& colours = {});

/** \brief Writes them as an organized PCD of pcl::PointXYZRGBL. \param colours of label k at k - 1; a pixel
 * without a label, or with one beyond them, is grey. Throws std::invalid_argument if the sizes differ. */
void writeLabelledCloud(const std::filesystem::path& path, const DepthImage& image, const LabelImage& labels,
                        const std::vector<PointColour>& colours);

/** \brief Writes the points of a PCD file with a field `label`, in place of one of that name, beside all
 * other fields and its viewpoint. \param pixels pixel of the labels for each point
 * (DepthSequence::pixelsOfPoints()); a point that is not finite or at none has label 0. \param colours as
 * above, for files without colours. Throws std::invalid_argument if pixels and points differ in number. */
void writeLabelledCloud(const std::filesystem::path& path, const std::filesystem::path& points,
                        const std::vector<std::uint32_t>& pixels, const LabelImage& labels,
                        const std::vector<PointColour>& colours);

/** \brief A flat polygon in space, such as the outline of a segment. */
struct ColouredPolygon {
  std::vector<Eigen::Vector3d> vertices;  ///< sorted around the polygon [m]
  PointColour colour;
};
/** \brief The hull of a segment. */
ColouredPolygon polygonOf(const Segment& segment, const PointColour& colour);

/** \brief Writes polygons as a binary PLY mesh; those of fewer than three vertices are left out. */
void writePolygons(const std::filesystem::path& path, const std::vector<ColouredPolygon>& polygons);

/** \brief Writes a mesh as binary PLY. */
void writeMesh(const std::filesystem::path& path, const pcl::PolygonMesh& mesh);

/** \brief Reads a scan or mesh: a .ply, .obj or .stl mesh, or, as a mesh without polygons, a .ply or .pcd
 * cloud. Of points, the positions are kept, as pcl::PointXYZ. They may be NaN, and indices of
 * polygons are not checked: surfaces leave such things out. Throws IoError for a file that is no such model,
 * promises more than it holds, or has no point. \param metres_per_unit factor of all coordinates. Throws
 * std::invalid_argument unless it is positive and finite */
pcl::PolygonMesh readModel(const std::filesystem::path& path, double metres_per_unit = 1);

}  // namespace facetloc
