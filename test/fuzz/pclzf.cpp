// SPDX-License-Identifier: BSD-3-Clause
// A folder of one of PCL's compressed images: the text of its camera, a zero, and the image. PCL has to
// survive any accepted input.
#include "fuzz_file.h"
#include "live/pclzf_folder.h"

#include <facetloc/io/error.h>
#include <facetloc/io/pclzf.h>

#include <pcl/console/print.h>
#include <pcl/io/lzf_image_io.h>
#include <pcl/point_types.h>

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto input = fuzz::asText(data, size);
  const auto zero = std::min(input.find('\0'), input.size());
  const auto camera = folder.put("frame_20121214T142255.814212.xml", input.substr(0, zero));
  const auto image = folder.put("frame_20121214T142255.814212_depth.pclzf",
                                zero < input.size() ? input.substr(zero + 1) : std::string_view());
  if (!fuzz::accepts<IoError>([&] { requireSoundPclzfFolder(folder.path()); })) return 0;
  fuzz::accepts<IoError>([&] { readPclzf(image); });
  pcl::io::LZFDepth16ImageReader reader;
  pcl::PointCloud<pcl::PointXYZ> cloud;
  fuzz::require(reader.readParameters(camera.string()), "PCL does not read a camera that was read");
  reader.read(image.string(), cloud);
  return 0;
}
