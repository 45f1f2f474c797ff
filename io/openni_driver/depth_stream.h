// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "openni_driver_api.h"
#include "playback.h"

#include <functional>
#include <thread>
#include <vector>

namespace facetloc {

/** \brief The depth stream of a virtual camera: one mode, depth in mm. */
class DepthStream : public oni::driver::StreamBase {
public:
  /** \param report receives changes of the device: an OniDeviceState. */
  DepthStream(std::shared_ptr<Playback> playback, std::function<void(int)> report);
  ~DepthStream() override { stop(); }

  OniStatus start() override;
  void stop() override;
  OniBool isPropertySupported(int id) override;
  OniStatus getProperty(int id, void* data, int* size) override;
  OniStatus setProperty(int id, const void* data, int size) override;

private:
  int stride() const { return mode_.resolutionX * static_cast<int>(sizeof(OniDepthPixel)); }
  void run();
  void deliver(std::uint64_t stamp);

  std::shared_ptr<Playback> playback_;
  std::function<void(int)> report_;
  OniVideoMode mode_{};
  std::vector<OniDepthPixel> image_;  // the next one
  int number_ = 0;                    // number of the last one delivered
  std::thread thread_;
};

/** \brief The only mode of a source. */
OniVideoMode modeOf(const FrameSource& source);

}  // namespace facetloc
