// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "playback.h"

#include <functional>

// OpenNI2's interface of drivers uses macros of a library that is not installed.
#ifndef FALSE
#define FALSE 0
#endif
#ifndef TRUE
#define TRUE 1
#endif
#define XN_NEW(Type, ...) new Type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include <Driver/OniDriverAPI.h>

namespace facetloc {

/** \brief A virtual camera: one depth stream, played like a recording as far as OpenNI2 can tell. */
class DepthDevice : public oni::driver::DeviceBase {
public:
  DepthDevice(std::unique_ptr<FrameSource> source, std::function<void(int)> report);

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override;
  oni::driver::StreamBase* createStream(OniSensorType type) override;
  void destroyStream(oni::driver::StreamBase* stream) override;
  OniBool isPropertySupported(int id) override;
  OniStatus getProperty(int id, void* data, int* size) override;
  OniStatus setProperty(int id, const void* data, int size) override;
  OniBool isCommandSupported(int command) override { return command == ONI_DEVICE_COMMAND_SEEK; }
  OniStatus invoke(int command, void* data, int size) override;

private:
  std::shared_ptr<Playback> playback_;
  std::function<void(int)> report_;
  OniVideoMode mode_;
  OniSensorInfo sensor_{};
  bool has_stream_ = false;  // OpenNI2 shares one among its handles
};

}  // namespace facetloc
