// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The depth frames of an .oni recording (OpenNI 1 and 2), read without OpenNI: each frame once, in
 * any order, from any thread, without waiting. Colour and infrared streams are ignored.
 *
 * Frames are as they were recorded, and as OpenNI2 plays them. A recording that is marked as mirrored may
 * show the world as a mirror does. */
class OniFile {
public:
  /** \brief Lists the frames: of a recording whose recorder was killed, up to the tear. Throws IoError for
   * a file that is no recording, or a corrupt one, and if it has no depth or depth that is cropped or of an
   * unknown format. */
  static OniFile open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  std::size_t size() const { return frames_.size(); }
  /** \brief Does it end as its recorder ended it? */
  bool finished() const { return finished_; }
  /** \brief When a frame was taken, since a time that the device chose [s]. */
  double stamp(std::size_t index) const { return 1e-6 * static_cast<double>(frames_.at(index).stamp); }
  /** \brief Intrinsics by the field of view, the centre in the middle; invalid but for the size if it is
   * unknown.
   */
  const Intrinsics& camera() const { return camera_; }
  /** \brief Frames per second, nominal. */
  int rate() const { return rate_; }
  /** \brief Did the device mirror its images? */
  bool mirrored() const { return mirrored_; }

  /** \brief One frame with the intrinsics of camera(). Throws IoError if it is corrupt, std::out_of_range for
   * the index. */
  DepthImage read(std::size_t index) const;
  /** \brief The numbers of a frame as they were recorded, row-major, 0 = not measured; millimetres() each. */
  std::vector<std::uint16_t> readRaw(std::size_t index) const;
  double millimetres() const { return millimetres_; }
  /** \brief Reads all frames. Throws IoError, which tells its number, for the first one that is corrupt. */
  void requireSound() const;
  /** \brief The bytes that the recording takes; OpenNI2 leaves as many zeros behind them. */
  std::uint64_t bytes() const { return bytes_; }

private:
  friend class OniFileIndexer;

  struct Frame {
    std::uint64_t stamp;   // [us]
    std::uint64_t offset;  // place of its data in the file
    std::uint32_t size;    // size of its data
  };
  enum class Codec { none, differences, differences_of_table };

  OniFile() = default;

  std::filesystem::path path_;
  std::vector<Frame> frames_;
  Codec codec_ = Codec::none;
  Intrinsics camera_;
  int rate_ = 0;
  bool mirrored_ = false;
  double millimetres_ = 1;
  std::uint64_t bytes_ = 0;
  bool finished_ = false;
};

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
