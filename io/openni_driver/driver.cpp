// SPDX-License-Identifier: BSD-3-Clause
#include "depth_device.h"

#include <facetloc/io/virtual_camera.h>

#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>

namespace facetloc {
namespace {

/** Turns paths into devices. */
class Driver : public oni::driver::DriverBase {
public:
  explicit Driver(OniDriverServices* services) : DriverBase(services) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback state_changed, void* cookie) override {
    const OniStatus status = DriverBase::initialize(connected, disconnected, state_changed, cookie);
    const char* path = std::getenv(kVirtualCameraAnnounce);
    if (status == ONI_STATUS_OK && path && isFrameSource(path)) announce(path);
    return status;
  }
  void shutdown() override {}

  /** Claims files that look like ours; their faults are reported when they are opened. */
  OniStatus tryDevice(const char* uri) override {
    if (std::strlen(uri) >= ONI_MAX_STR || !isFrameSource(uri)) return ONI_STATUS_ERROR;
    announce(uri);
    return ONI_STATUS_OK;
  }

  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    try {
      const OniDeviceInfo& info = announced(uri);
      return new DepthDevice(openFrameSource(uri),
                             [this, &info](int state) { deviceStateChanged(&info, state); });
    } catch (const std::exception& e) {
      getServices().errorLoggerAppend("%s", e.what());
      return nullptr;
    }
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

private:
  OniDeviceInfo& announced(const std::string& uri) {
    const std::lock_guard lock(mutex_);
    return infos_[uri];
  }

  void announce(const std::string& uri) {
    OniDeviceInfo& info = announced(uri);
    info = {};
    const auto put = [](char(&field)[ONI_MAX_STR], const std::string& text) {
      std::strncpy(field, text.c_str(), ONI_MAX_STR - 1);
    };
    put(info.uri, uri);
    put(info.vendor, "facetloc");
    put(info.name, "virtual depth camera");
    deviceConnected(&info);
  }

  std::mutex mutex_;
  std::map<std::string, OniDeviceInfo> infos_;  // OpenNI2 keeps pointers to them
};

}  // namespace
}  // namespace facetloc

ONI_EXPORT_DRIVER(facetloc::Driver)
