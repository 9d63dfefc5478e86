#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/io/io_error.h"
#include "sinew/io/v4l2_calls.h"
#include "sinew/io/video_modes.h"

namespace sinew::io {

/// An open video device: what it can do, and what it was set to. For one thread.
class V4l2Device {
 public:
  /// How frames come from now on.
  struct Format {
    VideoMode mode;
    std::size_t stride = 0;      ///< bytes from row to row; 0 for MJPG
    bool is_full_range = false;  ///< luma 0 to 255, else 16 to 235
    Duration interval{};         ///< between two frames; zero where the driver does not say
  };

  /// @error  a sentence: not there, no permission, used by another program, no camera
  static IoResult<V4l2Device> open(const std::string& path, const V4l2Calls& calls);
  V4l2Device(V4l2Device&& other) noexcept
      : calls_(other.calls_),
        path_(std::move(other.path_)),
        descriptor_(std::exchange(other.descriptor_, -1)) {}
  V4l2Device& operator=(V4l2Device&&) = delete;
  ~V4l2Device();

  /// Those in formats that are read.
  std::vector<VideoMode> modes(const VideoWanted& wanted) const;
  /// Sets the best of them.
  /// @error  a sentence: none that is read, none of the wanted size, used by another program
  IoResult<Format> set_format(const VideoWanted& wanted) const;

  /// 0, or the errno value of a request of VIDIOC_*; begun again where a signal came.
  int request(unsigned long code, void* argument) const;
  /// "DEVICE: ..." for the errno value of a request that failed.
  IoError error(int errno_value) const;

  const V4l2Calls& calls() const { return *calls_; }
  const std::string& path() const { return path_; }
  int descriptor() const { return descriptor_; }

 private:
  V4l2Device(const V4l2Calls& calls, std::string path, int descriptor)
      : calls_(&calls), path_(std::move(path)), descriptor_(descriptor) {}
  void add_sizes(VideoFormat format, const VideoWanted& wanted,
                 std::vector<VideoMode>& modes) const;
  void add_guess(VideoFormat format, const VideoWanted& wanted,
                 std::vector<VideoMode>& modes) const;
  double highest_rate(VideoFormat format, int width, int height) const;
  Duration set_rate(double fps) const;

  const V4l2Calls* calls_;
  std::string path_;
  int descriptor_;
};

}  // namespace sinew::io
