#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/io/v4l2_device.h"

namespace sinew::io {

/// A setting of a camera: V4L2_CID_* and its value.
struct VideoControl {
  std::uint32_t id = 0;
  std::int32_t value = 0;

  friend bool operator==(const VideoControl&, const VideoControl&) = default;
};

/// Exposure, gain, white balance and focus choose for themselves from now on, as far as the camera
/// can. Another program may have left them otherwise.
void start_automatics(const V4l2Device& device);

/// What they chose: the settings that keep the camera as it is now, in the order in which they have
/// to be set. Controls that the camera does not have are missing.
std::vector<VideoControl> chosen_controls(const V4l2Device& device);

/// What the camera refuses stays as it is.
void set_controls(const V4l2Device& device, std::span<const VideoControl> controls);

}  // namespace sinew::io
