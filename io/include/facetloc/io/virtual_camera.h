// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * Requests to our OpenNI2 driver beyond the standard (openni::Device::setProperty and
 * getProperty; OpenNIGrabber does it for you). See io/README.md for the inputs of the driver. */

namespace facetloc {

/** \brief Device property, int, write: n >= 0 = deliver n more frames as fast as possible and no other;
 * -1 = deliver in real time, which is the default. */
constexpr int kVirtualCameraTrigger = 0x7D000001;
/** \brief Device property, char[kVirtualCameraTextSize], read: why the last image that could not be served
 * could not; "" if all could. */
constexpr int kVirtualCameraError = 0x7D000002;
constexpr int kVirtualCameraTextSize = 1024;
/** \brief Device property, double[4], read: fx, fy, cx, cy [px]. OpenNI2 itself knows only fields of view,
 * and PCL takes the centre to be the image's. */
constexpr int kVirtualCameraIntrinsics = 0x7D000003;
/** \brief Device property, double[6], read: how the camera sits on its robot, the fields of CameraMounting in
 * their order; ONI_STATUS_NOT_IMPLEMENTED where they are unknown. */
constexpr int kVirtualCameraMounting = 0x7D000004;

/** \brief Environment variable: a path that the driver announces as a connected device, for programs that can
 * only open the first one. Without it nothing is announced. */
constexpr const char* kVirtualCameraAnnounce = "FACETLOC_ANNOUNCE_CAMERA";

}  // namespace facetloc
