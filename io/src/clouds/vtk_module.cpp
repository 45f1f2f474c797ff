// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/vtk_models.h"

#include <facetloc/io/error.h>

#include <pcl/conversions.h>
#include <pcl/point_types.h>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkExecutive.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <regex>
#include <string>

namespace facetloc {
namespace {

pcl::PolygonMesh meshOf(vtkPolyData& data) {
  pcl::PointCloud<pcl::PointXYZ> points;
  for (vtkIdType i = 0; i < data.GetNumberOfPoints(); ++i) {
    double p[3];
    data.GetPoint(i, p);
    points.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]));
  }
  pcl::PolygonMesh mesh;
  pcl::toPCLPointCloud2(points, mesh.cloud);
  const vtkNew<vtkIdList> corners;
  vtkCellArray* polygons = data.GetPolys();
  for (polygons->InitTraversal(); polygons->GetNextCell(corners);) {
    pcl::Vertices& polygon = mesh.polygons.emplace_back();
    for (vtkIdType k = 0; k < corners->GetNumberOfIds(); ++k)
      polygon.vertices.push_back(static_cast<pcl::index_t>(corners->GetId(k)));
  }
  return mesh;
}

/** The cause in an error of VTK, "ERROR: In FILE, line N CLASS (ADDRESS): CAUSE", on one line. */
std::string causeOf(std::string complaint) {
  std::replace(complaint.begin(), complaint.end(), '\n', ' ');
  complaint = std::regex_replace(complaint, std::regex(R"(^\w+: In .*?, line \d+ \w+ \(\w+\): *)"), "");
  complaint.erase(complaint.find_last_not_of(' ') + 1);
  return complaint;
}

/** A complaint of the reader becomes the cause of an IoError. */
template <class Reader>
pcl::PolygonMesh read(const std::filesystem::path& path) {
  std::string complaint;
  const vtkNew<vtkCallbackCommand> observer;
  observer->SetClientData(&complaint);
  observer->SetCallback([](vtkObject*, unsigned long, void* client, void* text) {
    auto& first = *static_cast<std::string*>(client);
    if (text && first.empty()) first = static_cast<const char*>(text);
  });
  const vtkNew<Reader> reader;
  reader->AddObserver(vtkCommand::ErrorEvent, observer);
  reader->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, observer);  // repeats it, and would print it
  reader->SetFileName(path.c_str());
  reader->Update();
  if (!complaint.empty()) throw IoError(path.string(), "cannot be read: " + causeOf(complaint));
  vtkPolyData* data = reader->GetOutput();
  return data && data->GetNumberOfPoints() > 0 ? meshOf(*data) : pcl::PolygonMesh();
}

}  // namespace

extern "C" void facetlocReadByVtk(const std::filesystem::path& path, pcl::PolygonMesh& mesh) {
  const std::string ending = path.extension().string();
  const bool is_stl = ending.size() == 4 && (ending[1] == 's' || ending[1] == 'S');
  mesh = is_stl ? read<vtkSTLReader>(path) : read<vtkXMLPolyDataReader>(path);
}

}  // namespace facetloc
