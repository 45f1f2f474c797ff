// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/cloud_file.h>

#include <gtest/gtest.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

namespace facetloc::test {
namespace {

class ModelFile : public InAFolder {
protected:
  std::filesystem::path write(const std::string& name, const std::string& content) const {
    return putBytes(folder_ / name, content);
  }
  /** The cause of the error that reading it ends with. */
  static std::string refusal(const std::filesystem::path& path) {
    const std::string error = ioErrorOf([&] { readModel(path); }), of_file = path.string() + ": ";
    EXPECT_THAT(error, testing::AnyOf(testing::IsEmpty(), testing::StartsWith(of_file)));
    return error.empty() ? "" : error.substr(of_file.size());
  }
};

pcl::PointCloud<pcl::PointXYZ> pointsOf(const pcl::PolygonMesh& mesh) {
  pcl::PointCloud<pcl::PointXYZ> points;
  pcl::fromPCLPointCloud2(mesh.cloud, points);
  return points;
}

/** A roof of two triangles, as each format stores it. */
void expectRoof(const pcl::PolygonMesh& mesh) {
  const auto points = pointsOf(mesh);
  ASSERT_EQ(2u, mesh.polygons.size());
  float area = 0, highest = 0;
  for (const pcl::Vertices& polygon : mesh.polygons) {
    ASSERT_EQ(3u, polygon.vertices.size());
    const auto corner = [&](std::size_t i) {
      return points.at(static_cast<std::size_t>(polygon.vertices[i])).getVector3fMap();
    };
    area += (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm() / 2;
    for (std::size_t i = 0; i < 3; ++i) highest = std::max(highest, corner(i).z());
  }
  EXPECT_NEAR(std::sqrt(2.0), area, 1e-5);
  EXPECT_FLOAT_EQ(1, highest);
}

const std::string kPlyHead =
    "ply\nformat ascii 1.0\ncomment a roof\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kPlyData = "0 0 0\n1 0 0\n0 1 1\n1 -1 1\n3 0 1 2\n3 0 3 1\n";

std::string bytesOf(float x, float y, float z) {
  std::string bytes(12, '\0');
  const float numbers[] = {x, y, z};
  std::memcpy(bytes.data(), numbers, sizeof numbers);
  return bytes;
}

TEST_F(ModelFile, ReadsMeshes) {
  expectRoof(readModel(write("a.ply", kPlyHead + kPlyData)));
  expectRoof(readModel(write("a.obj", "# roof\nv 0 0 0\nv 1 0 0\nv 0 1 1\nv 1 -1 1\nf 1 2 3\nf 1 4 2\n")));
  std::string stl(84, ' ');
  const std::uint32_t two = 2;
  std::memcpy(stl.data() + 80, &two, 4);
  const std::string zero(2, '\0'), normal = bytesOf(0, 0, 0), a = bytesOf(0, 0, 0), b = bytesOf(1, 0, 0);
  stl += normal + a + b + bytesOf(0, 1, 1) + zero + normal + a + bytesOf(1, -1, 1) + b + zero;
  expectRoof(readModel(write("A.STL", stl)));
  const std::string roof = "solid roof\n facet normal 0 0 0\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 "
                           "0\n   vertex 0 1 1\n  endloop\n endfacet\n"
                           " FACET NORMAL 0 0 0\n  OUTER LOOP\n   VERTEX 0 0 0\n   VERTEX 1 -1 1\n   VERTEX "
                           "1e0 0 0\n  ENDLOOP\n ENDFACET\nendsolid\n";
  expectRoof(readModel(write("text.stl", roof)));
  std::string solid = stl;
  solid.replace(0, 5, "solid");
  solid[70] = '\0';
  expectRoof(readModel(write("solid.stl", solid)));
}

TEST_F(ModelFile, ReadsHeadersWithMarksOtherLinesAndOtherLetters) {
  constexpr const char* kMark = "\xEF\xBB\xBF";
  const std::string ply = kPlyHead + kPlyData;
  std::string lines = ply, utf16 = "\xFF\xFE", upper = ply;
  std::replace(lines.begin(), lines.end(), '\n', '\r');
  for (const char c : ply) utf16.append({c, '\0'});
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  expectRoof(readModel(write("marked.ply", kMark + ply)));
  for (const std::string& text : {lines, utf16, upper}) expectRoof(readModel(write("other.PLY", text)));
  const std::string facets = "facet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 1\nendfacet\nfacet\nvertex 0 0 "
                             "0\nvertex 1 -1 1\nvertex 1 0 0\nendfacet\nendsolid\n";
  expectRoof(readModel(write("named.stl", "SOLID B\xC3\xBCro\n" + facets)));
  expectRoof(readModel(write("marked.stl", kMark + ("solid roof\n" + facets))));
  const std::string pcd =
      "version 0.7\nfields x y z\nsize 4 4 4\ntype F F F\ncount 1 1 1\nwidth 2\nheight 1\n"
      "points 2\ndata ASCII\n1 2 3\n4 5 6\n";
  EXPECT_EQ(6, pointsOf(readModel(write("marked.pcd", kMark + pcd))).at(1).z);
  EXPECT_THAT(refusal(write("wide.pcd", utf16)), HasSubstr("save it as UTF-8"));
}

TEST_F(ModelFile, ReadsObjFilesAsTheyAreWritten) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 1\nv 1 -1 1\n";
  std::string normals;  // normals of corners, many more than vertices
  for (int i = 0; i < 100000; ++i) normals += "vn 0 0 1\n";
  expectRoof(readModel(write("normals.obj", corners + normals + "f 1//9 2//8 3//7\nf 1//1 4//2 2//3\n")));
  expectRoof(readModel(write("textured.obj", "mtllib none.mtl\no roof\n" + corners +
                                                 "vt 0 0\nusemtl a\ns off\nf 1/1 2/1 3/1\nf 1/1 4/1 2/1\n")));
  expectRoof(readModel(write("back.obj", corners + "f -4 -3 -2\nf -4 -1 -3\n")));
  expectRoof(
      readModel(write("lines.obj", "v\t0\t0\t0\r\nv  1 0 0 0.5 0.5 0.5\r\nv 0 1 \\\r\n1\r\nv 1 -1 1 # top\r\n"
                                   "f 1 2 3\r\nf 1 \\\r\n 4 2")));
}

TEST_F(ModelFile, NamesTheLineOfAnObjFileThatCannotBeRead) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 1\n";
  EXPECT_EQ("line 4: has a face of fewer than three corners", refusal(write("a.obj", corners + "f 1 2\n")));
  EXPECT_EQ("line 4: has 'a' as a vertex of a face", refusal(write("b.obj", corners + "f a b c\n")));
  EXPECT_EQ("line 4: has '0' as a vertex of a face", refusal(write("c.obj", corners + "f 1 0 2\n")));
  EXPECT_NE("", refusal(write("d.obj", corners + "f 99999999999999999999 2 3\n")));
  EXPECT_EQ("line 1: has a vertex of fewer than three coordinates", refusal(write("e.obj", "v 1 2\n")));
  EXPECT_EQ("line 2: has 'x' as a coordinate", refusal(write("f.obj", "v 1 2 3\nv 1 x 3")));
}

TEST_F(ModelFile, ReadsClouds) {
  pcl::PointCloud<pcl::PointXYZI> points;
  for (int i = 0; i < 20; ++i) {
    pcl::PointXYZI p;
    p.x = static_cast<float>(i), p.y = 2, p.z = -1, p.intensity = 7;
    points.push_back(p);
  }
  pcl::io::savePCDFileBinaryCompressed((folder_ / "a.pcd").string(), points);
  const auto read = pointsOf(readModel(folder_ / "a.pcd"));
  ASSERT_EQ(20u, read.size());
  EXPECT_EQ(19, read[19].x);
  // Doubles, in centimetres.
  const pcl::PolygonMesh ply = readModel(
      write(
          "a.ply",
          "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double z\n"
          "end_header\n100 200 300\n1 2 3\n"),
      0.01);
  EXPECT_TRUE(ply.polygons.empty());
  ASSERT_EQ(2u, pointsOf(ply).size());
  EXPECT_FLOAT_EQ(3, pointsOf(ply)[0].z);
}

/** PCL writes the files, of each kind and encoding. */
TEST_F(ModelFile, ReadsCloudsAndMeshesOfPcl) {
  pcl::PointCloud<pcl::PointXYZRGBNormal> points;
  for (int i = 0; i < 500; ++i) {
    pcl::PointXYZRGBNormal p;
    p.x = 0.1f * static_cast<float>(i), p.y = static_cast<float>(i % 7), p.z = i == 4 ? NAN : -1.25f;
    p.r = static_cast<std::uint8_t>(i), p.g = 200, p.b = 7;
    points.push_back(p);
  }
  const auto path = [&](const char* name) { return (folder_ / name).string(); };
  pcl::io::savePCDFileASCII(path("text.pcd"), points);
  pcl::io::savePCDFileBinary(path("binary.pcd"), points);
  pcl::io::savePCDFileBinaryCompressed(path("compressed.pcd"), points);
  pcl::PolygonMesh mesh;
  pcl::toPCLPointCloud2(points, mesh.cloud);
  for (pcl::index_t i = 0; i + 3 < 500; ++i) {
    mesh.polygons.emplace_back();
    mesh.polygons.back().vertices = {i, i + 1, i + 2};
    if (i % 2) mesh.polygons.back().vertices.push_back(i + 3);
  }
  pcl::io::savePLYFile(path("text.ply"), mesh, 9);
  pcl::io::savePLYFileBinary(path("binary.ply"), mesh);
  pcl::io::savePLYFileBinary(path("cloud.ply"), points);
  for (const char* name :
       {"text.pcd", "binary.pcd", "compressed.pcd", "text.ply", "binary.ply", "cloud.ply"}) {
    const pcl::PolygonMesh read = readModel(path(name));
    const auto positions = pointsOf(read);
    ASSERT_EQ(points.size(), positions.size()) << name;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(points[i].x, positions[i].x, 1e-5) << name;
      EXPECT_EQ(points[i].y, positions[i].y) << name;
      EXPECT_TRUE(i == 4 ? std::isnan(positions[i].z) : points[i].z == positions[i].z) << name << i;
    }
    const bool has_faces = name == std::string("text.ply") || name == std::string("binary.ply");
    ASSERT_EQ(has_faces ? mesh.polygons.size() : 0u, read.polygons.size()) << name;
    for (std::size_t i = 0; i < read.polygons.size(); ++i)
      EXPECT_EQ(mesh.polygons[i].vertices, read.polygons[i].vertices) << name;
  }
}

TEST_F(ModelFile, ReadsPlyFilesOfEitherByteOrder) {
  const auto swapped = [](std::string bytes) {
    for (std::size_t i = 0; i + 3 < bytes.size(); i += 4)
      std::reverse(bytes.begin() + i, bytes.begin() + i + 4);
    return bytes;
  };
  std::string head = kPlyHead;
  head.replace(head.find("ascii"), 5, "binary_big_endian");
  head.replace(head.find("element face"), 0,
               "property list uchar short weights\n");  // which nothing asks for
  const std::string none(1, '\0'), two("\x02\0\0\0\0", 5);
  const std::string points = swapped(bytesOf(0, 0, 0)) + none + swapped(bytesOf(1, 0, 0)) + two +
                             swapped(bytesOf(0, 1, 1)) + none + swapped(bytesOf(1, -1, 1)) + none;
  const std::string faces("\x03\0\0\0\0\0\0\0\x01\0\0\0\x02\x03\0\0\0\0\0\0\0\x03\0\0\0\x01", 26);
  expectRoof(readModel(write("big.ply", head + points + faces)));
  const auto cutOff = [&](std::size_t n) {
    return refusal(write("cut.ply", (head + points + faces).substr(0, n)));
  };
  EXPECT_THAT(cutOff(head.size() + points.size() + 25), HasSubstr("cut off"));
  std::string endless = faces;
  endless[0] = '\xff';  // corners of a face
  EXPECT_THAT(refusal(write("endless.ply", head + points + endless)), HasSubstr("cut off"));
}

TEST_F(ModelFile, RefusesPlyFilesWithoutPositions) {
  EXPECT_THAT(
      refusal(write("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n")),
      HasSubstr("no x, y and z"));
  EXPECT_THAT(refusal(write("b.ply", "ply\nformat ascii 1.0\nelement vertex 2000000000\nend_header\n")),
              HasSubstr("no x, y and z"));
  EXPECT_THAT(refusal(write("c.ply", "ply\nformat text 1.0\nend_header\n")), HasSubstr("format"));
  EXPECT_THAT(refusal(write("d.ply", kPlyHead + "0 0 zero\n1 0 0\n0 1 1\n1 -1 1\n3 0 1 2\n3 0 3 1\n")),
              HasSubstr("'zero'"));
}

TEST_F(ModelFile, NamesWhatStandsInPlaceOfAModel) {
  for (const char* name : {"a.ply", "a.obj", "a.stl", "a.pcd"})
    EXPECT_THAT(
        refusal(write(name, "version https://git-lfs.github.com/spec/v1\noid sha256:07\nsize 1234567\n")),
        HasSubstr("git lfs pull"));
  EXPECT_THAT(refusal(write("b.ply", "/annex/objects/SHA256E-s9--7.ply\n")), HasSubstr("git annex get"));
  std::filesystem::create_symlink(".git/annex/objects/a/b/SHA256E-s9--7.ply/SHA256E-s9--7.ply",
                                  folder_ / "c.ply");
  EXPECT_THAT(refusal(folder_ / "c.ply"), HasSubstr("git annex get"));
  EXPECT_THAT(refusal(write("plan.pgm", "P5 1 1 255 a")),
              AllOf(HasSubstr("plan.yaml"), HasSubstr("\n  image: plan.pgm\n  resolution: 0.05"),
                    HasSubstr("\n  free_thresh: 0.196")));
  write("plan.yaml", "image: plan.pgm\n");
  EXPECT_THAT(refusal(folder_ / "plan.pgm"), HasSubstr("name its plan.yaml"));
  expectRoof(
      readModel(write("marked.obj", "\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 1\nv 1 -1 1\nf 1 2 3\nf 1 4 2\n")));
}

TEST_F(ModelFile, RefusesFilesThatAreNoModel) {
  std::string pointless = kPlyHead;
  pointless.replace(pointless.find("vertex 4"), 8, "vertex 0");
  EXPECT_NE("", refusal(write("pointless.ply", pointless + "3 0 1 2\n3 0 3 1\n")));
  EXPECT_NE("", refusal(folder_ / "missing.ply"));
  EXPECT_EQ("is empty", refusal(write("empty.obj", "")));
  EXPECT_THAT(refusal(write("a.dwg", "x")), HasSubstr(".ply, .obj"));
  EXPECT_THAT(refusal(write("text.ply", "hello")), HasSubstr("first line"));
  EXPECT_NE("", refusal(write("text.obj", "hello\n")));
  EXPECT_NE("", refusal(write("text.stl", "hello\n")));
  EXPECT_THAT(refusal(write("a.vtp", "<hello/>\n")), HasSubstr(".ply, .obj, .stl and .pcd"));
  EXPECT_NE("", refusal(write("text.pcd", "hello\n")));
  EXPECT_THROW(readModel(write("a.ply", kPlyHead + kPlyData), 0), std::invalid_argument);
}

TEST_F(ModelFile, RefusesHeadersThatPromiseMoreThanThereIs) {
  std::string huge = kPlyHead;
  huge.replace(huge.find("vertex 4"), 8, "vertex 2000000000");
  EXPECT_THAT(refusal(write("huge.ply", huge + kPlyData)), HasSubstr("cut off"));
  std::string negative = kPlyHead;
  negative.replace(negative.find("face 2"), 6, "face -2");
  EXPECT_THAT(refusal(write("negative.ply", negative + kPlyData)), HasSubstr("number of elements"));
  std::string typeless = kPlyHead;
  typeless.replace(typeless.find("float y"), 7, "quaternion y");
  EXPECT_THAT(refusal(write("type.ply", typeless + kPlyData)), HasSubstr("type"));
  EXPECT_NE("", refusal(write("head.ply", kPlyHead.substr(0, 60))));
  std::string binary = kPlyHead;
  binary.replace(binary.find("ascii"), 5, "binary_little_endian");
  EXPECT_THAT(refusal(write("binary.ply", binary + std::string(40, '\0'))), HasSubstr("cut off"));
}

TEST_F(ModelFile, RefusesMoreTrianglesThanBytes) {
  std::string stl(84 + 50, '\x95');  // as many as 2 509 608 341
  EXPECT_THAT(refusal(write("many.stl", stl)), HasSubstr("binary STL"));
  EXPECT_THAT(refusal(write("torn.stl", "solid caf\xe9\nfacet")), HasSubstr("no points"));
  EXPECT_THAT(refusal(write("control.stl", "solid" + std::string(200, '\f'))), HasSubstr("binary STL"));
}

TEST_F(ModelFile, NamesTheTriangleOfAnStlFileThatCannotBeRead) {
  const std::string first =
      "solid\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n";
  EXPECT_EQ("has 'one' as a coordinate of triangle 2",
            refusal(write("word.stl", first + "facet outer loop vertex 0 0 one")));
  EXPECT_EQ("ends within a triangle", refusal(write("torn.stl", first + "facet outer loop vertex 0 0 1")));
  EXPECT_EQ("has no points", refusal(write("empty.stl", "solid")));
}

/** Whatever is cut off, reading ends with a mesh or with an error. */
TEST_F(ModelFile, SurvivesFilesThatAreCutOff) {
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 1\nvn 0 0 1\nf 1//1 2//9 -1\nf 1 99 3\nf 0 -7 2\nf 1\n";
  std::string binary = kPlyHead;
  binary.replace(binary.find("ascii"), 5, "binary_little_endian");
  binary += bytesOf(0, 0, 0) + bytesOf(1, 0, 0) + bytesOf(0, 1, 1) + bytesOf(1, -1, 1);
  binary += std::string("\x03\0\0\0\0\x01\0\0\0\x02\0\0\0\xff\0\0\0\0", 18) + std::string(20, '\x7f');
  for (const auto& [name, whole] : {std::pair<std::string, std::string>{"cut.ply", kPlyHead + kPlyData},
                                    {"cut.obj", obj},
                                    {"binary.ply", binary}})
    for (std::size_t size = 1; size <= whole.size(); size += 3) refusal(write(name, whole.substr(0, size)));
}

}  // namespace
}  // namespace facetloc::test
