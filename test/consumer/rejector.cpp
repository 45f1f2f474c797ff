// SPDX-License-Identifier: BSD-3-Clause
//
// An outside project: a registration of the module with a rejector of PCL, which drops a wrong pair of
// points.
#include <facetloc/registration/planar_registration.h>

#include <pcl/registration/correspondence_rejection_sample_consensus.h>

#include <cstddef>
#include <cstdio>

int main() {
  constexpr std::size_t kPairs = 12;
  const auto source = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>(),
             target = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  pcl::Correspondences pairs, kept;
  for (std::size_t i = 0; i < kPairs; ++i) {
    const auto x = static_cast<float>(i % 3), y = static_cast<float>(i % 4), z = static_cast<float>(i % 5);
    source->emplace_back(x, y, z);
    target->emplace_back(x + (i == 4 ? 2.f : 0.1f), y, z);
    pairs.emplace_back(static_cast<int>(i), static_cast<int>(i), 0.f);
  }
  const auto rejector =
      pcl::make_shared<pcl::registration::CorrespondenceRejectorSampleConsensus<pcl::PointXYZ>>();
  rejector->setInputSource(source);
  rejector->setInputTarget(target);
  rejector->setInlierThreshold(0.01);
  facetloc::PlanarRegistration<pcl::PointXYZ> registration;
  registration.addCorrespondenceRejector(rejector);
  rejector->getRemainingCorrespondences(pairs, kept);
  std::printf("%zu of %zu pairs remain\n", kept.size(), pairs.size());
  return kept.size() == kPairs - 1 ? 0 : 1;
}
