// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/camera_file.h>
#include <facetloc/io/frame_source.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

namespace internal {
struct FrameHeader;
}  // namespace internal

/** \brief Frames that another program writes to a pipe, a socket or a file: of each frame a line of JSON
 * (apps/frame.schema.json) and its width * height depths, 16 bit each, little-endian.
 *
 * The first header describes the camera: its intrinsics fx, fy, cx, cy, or the name of a CameraPreset,
 * whose typical ones hold; later ones may leave that out and must not contradict it. Lines without width and
 * height are handed on (setLines()). Bytes before the first header, such as the rest of a frame that a
 * program before has begun to read, are skipped. No size in a header is trusted before the bytes are
 * there: memory grows with the bytes received. */
class PipeFrames : public FrameSource {
public:
  /** \brief A line that is no header, in the order in which it came among the frames. */
  using OnLine = std::function<void(const std::string& line)>;

  /** \param file descriptor, which stays open and is not closed \param name for messages
   * \param known of the camera; overrides the headers
   * Throws IoError for a terminal. */
  PipeFrames(int file, std::string name, std::optional<CameraFile> known = {});

  /** \brief Who gets the lines that are no headers, also those that have come already. They are handed on by
   * the thread that reads. */
  void setLines(OnLine on_line);

  const std::string& name() const override { return name_; }
  std::shared_ptr<const CameraFile> camera(Patience patience) override;
  DepthFrame::ConstPtr next(Patience patience) override;
  bool atEnd() const override { return ended_; }
  bool isLive() const override { return true; }
  /** \brief Has a frame been torn or impossible? No other can be read then. */
  bool hasFailed() const { return failed_; }

private:
  bool fill(std::chrono::steady_clock::time_point end);
  void skip(std::size_t bytes);
  std::optional<internal::FrameHeader> headerAtEnd(const std::string& line);
  void takeLine(const std::string& line);
  void begin(const internal::FrameHeader& header);
  std::shared_ptr<const CameraFile> cameraOf(const internal::FrameHeader& header) const;
  bool hasFrame() const;
  void readPixels(std::size_t available);
  [[noreturn]] void fail(const std::string& cause);

  const int file_;
  const std::string name_;
  const std::optional<CameraFile> known_;
  OnLine on_line_;
  std::vector<std::string> early_lines_;  // before anybody wanted them
  std::string text_;                      // text of a line that has not ended
  std::vector<char> bytes_;               // read, and not looked at
  std::size_t used_ = 0;                  // part of these that is used
  std::size_t skipped_ = 0;               // before the first header
  std::shared_ptr<const CameraFile> camera_;
  CameraKeys first_;                     // camera in the first header
  std::shared_ptr<DepthFrame> pending_;  // whose header has come
  std::vector<char> pixels_;             // part of it received so far
  std::size_t missing_ = 0;              // bytes of these
  std::uint64_t frames_ = 0;
  bool ended_ = false, failed_ = false;
};

}  // namespace facetloc
