// SPDX-License-Identifier: BSD-3-Clause
//
// Prints the data of a figure as JSON: figure_data NAME
#include "facts.h"

#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <string>

namespace facetloc::figures {

Json::Value smallDepth(const DepthImage& image) {
  Json::Value lines(Json::arrayValue);
  for (int v = 0; v < image.camera.height; v += 2) {
    Json::Value line(Json::arrayValue);
    for (int u = 0; u < image.camera.width; u += 2)
      line.append(static_cast<int>(std::lround(100 * image.at(u, v))));
    lines.append(line);
  }
  return lines;
}

Eigen::Vector2d pixelOf(const Intrinsics& camera, const Eigen::Vector3d& point) {
  return {camera.fx * point.x() / point.z() + camera.cx, camera.fy * point.y() / point.z() + camera.cy};
}

Json::Value outlines(const View& view) {
  Json::Value all(Json::arrayValue);
  for (const Segment& segment : view.segments) {
    Json::Value outline(Json::arrayValue);
    for (const Eigen::Vector2f& vertex : segment.hull)
      outline.append(
          numbers(pixelOf(view.intrinsics, segment.t + segment.R.leftCols<2>() * vertex.cast<double>()), 1));
    all.append(outline);
  }
  return all;
}

}  // namespace facetloc::figures

int main(int argc, char** argv) {
  using namespace facetloc::figures;
  const std::map<std::string, std::function<Json::Value()>> facts{
      {"pipeline", pipelineFacts}, {"split", splitFacts},      {"segment", segmentFacts},
      {"tree", treeFacts},         {"verdicts", verdictFacts}, {"direction", directionFacts}};
  const auto chosen = facts.find(argc == 2 ? argv[1] : "");
  if (chosen == facts.end()) {
    std::cerr << "usage: figure_data pipeline|split|segment|tree|verdicts|direction\n";
    return 2;
  }
  try {
    Json::StreamWriterBuilder writer;
    writer["indentation"] = "";
    std::cout << Json::writeString(writer, chosen->second()) << "\n";
  } catch (const std::exception& error) {
    std::cerr << "figure_data: " << error.what() << "\n";
    return 1;
  }
}
