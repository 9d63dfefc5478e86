#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/io/io_error.h"
#include "sinew/io/v4l2_calls.h"
#include "sinew/io/v4l2_controls.h"
#include "sinew/io/video_modes.h"

namespace sinew::io {

/// A frame as the driver gave it.
struct VideoFrame {
  VideoMode mode;
  std::size_t stride = 0;      ///< bytes from row to row; 0 for MJPG
  bool is_full_range = false;  ///< luma 0 to 255, else 16 to 235
  std::vector<std::uint8_t> bytes;
};

/// Why a camera gives no frame.
enum class VideoLoss : std::uint8_t {
  kNoFrame,  ///< none came in time, or the end was asked for
  kGone,     ///< unplugged, or its driver failed: open it again
};

/// A camera by Video4Linux2, streaming into mapped buffers from the moment it is opened. For one
/// thread. Source: linux/Documentation/userspace-api/media/v4l.
class V4l2Camera {
 public:
  /// @error  a sentence with the device and what to do: not there, no permission, used by another
  ///         program, no camera, no format that is read, not the wanted size
  static IoResult<V4l2Camera> open(const std::string& device, const VideoWanted& wanted,
                                   const V4l2Calls& calls = system_v4l2_calls());

  V4l2Camera(V4l2Camera&&) noexcept;
  V4l2Camera& operator=(V4l2Camera&&) noexcept;
  ~V4l2Camera();

  const VideoMode& mode() const;

  /// The next frame whose exposure began at `from` or later (CLOCK_MONOTONIC), as far as the
  /// driver's stamps tell. Frames that the driver calls damaged or that are cut short are passed
  /// over.
  /// @param until  CLOCK_MONOTONIC
  std::expected<VideoFrame, VideoLoss> next(Duration from, Duration until,
                                            const std::stop_token& ending);

  /// Lets exposure, white balance and focus settle for 1 s or 20 frames, and keeps them as they
  /// are then: the same cube has the same colour, and sits in the same position of the picture, all
  /// session long.
  /// @return  what was kept; controls that the camera does not have are missing
  /// @error  kGone; kNoFrame where the end was asked for
  std::expected<std::vector<VideoControl>, VideoLoss> settle(const std::stop_token& ending);

  /// Sets what settle() kept: for a camera that was plugged in again.
  void keep(std::span<const VideoControl> controls);

 private:
  struct Stream;
  explicit V4l2Camera(std::unique_ptr<Stream> stream);
  std::unique_ptr<Stream> stream_;
};

}  // namespace sinew::io
