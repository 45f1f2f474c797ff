// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace facetloc {

/** \brief Records the depth of a device of OpenNI2, bit by bit, while others use it, into an .oni file.
 *
 * Every frame of the driver is recorded, also those that a slow reader of the device misses. Time stamps
 * count from the first of them. The file has its name when it is whole; until then, FILE.oni is called
 * FILE.part-0123456789abcdef.oni, with digits of its own, which can be read if the program is killed.
 * Depth takes as much room as in PNGs, or twice as much if it is noisy. */
class OniRecorder {
public:
  /** \brief Starts to record. The device is one that is open, such as OpenNIGrabber::uri(); frames come while
   * it runs. Throws IoError if the device has no depth or the file cannot be written. */
  OniRecorder(const std::string& device_uri, const std::filesystem::path& file);
  /** \brief As stop(), but says nothing of errors. */
  ~OniRecorder() noexcept;
  OniRecorder(const OniRecorder&) = delete;
  OniRecorder& operator=(const OniRecorder&) = delete;

  /** \brief Is there room on the disk for another frame, however badly it packs? Without it, OpenNI2 loses
   * frames and does not say so. */
  bool hasRoom() const;

  /** \brief Finishes the file; at most once does anything.
   * \return the number of frames in it; with none there is no file.
   * Throws IoError if it is not whole, such as when the disk is full; the frames written before are kept. */
  std::size_t stop();

private:
  struct Recording;
  void start(const std::string& device_uri);

  std::filesystem::path file_, part_;
  std::unique_ptr<Recording> recording_;
  std::size_t frames_ = 0;
  std::uintmax_t frame_size_ = 0;  // unpacked [bytes]
};

}  // namespace facetloc
