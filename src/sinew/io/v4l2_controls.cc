#include "sinew/io/v4l2_controls.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <optional>

namespace sinew::io {
namespace {

/// A switch between automatic and manual, and what the automatic chooses.
struct Automatic {
  std::uint32_t id;
  std::array<std::int32_t, 2> on;       ///< the first that the camera takes
  std::array<std::int32_t, 2> off;      ///< likewise
  std::array<std::uint32_t, 3> chosen;  ///< 0: none
};

constexpr std::array<Automatic, 4> kAutomatics{{
    {V4L2_CID_EXPOSURE_AUTO,
     {V4L2_EXPOSURE_APERTURE_PRIORITY, V4L2_EXPOSURE_AUTO},
     {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_SHUTTER_PRIORITY},
     // Webcams choose their gain with their exposure, and have no switch for it.
     {V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CID_EXPOSURE, V4L2_CID_GAIN}},
    {V4L2_CID_AUTOGAIN, {1, 1}, {0, 0}, {V4L2_CID_GAIN, 0, 0}},
    {V4L2_CID_AUTO_WHITE_BALANCE,
     {1, 1},
     {0, 0},
     {V4L2_CID_WHITE_BALANCE_TEMPERATURE, V4L2_CID_RED_BALANCE, V4L2_CID_BLUE_BALANCE}},
    {V4L2_CID_FOCUS_AUTO, {1, 1}, {0, 0}, {V4L2_CID_FOCUS_ABSOLUTE, 0, 0}},
}};

/// Whether the camera has it, and it can be set (or could, if its automatic were off).
bool has_control(const V4l2Device& device, std::uint32_t id) {
  v4l2_queryctrl about{};
  about.id = id;
  constexpr std::uint32_t kUnusable =
      V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_WRITE_ONLY;
  return id != 0 && device.request(VIDIOC_QUERYCTRL, &about) == 0 && (about.flags & kUnusable) == 0;
}

std::optional<std::int32_t> value_of(const V4l2Device& device, std::uint32_t id) {
  v4l2_control control{};
  control.id = id;
  if (device.request(VIDIOC_G_CTRL, &control) != 0) return std::nullopt;
  return control.value;
}

bool set_control(const V4l2Device& device, const VideoControl& wanted) {
  v4l2_control control{};
  control.id = wanted.id;
  control.value = wanted.value;
  return device.request(VIDIOC_S_CTRL, &control) == 0;
}

}  // namespace

void start_automatics(const V4l2Device& device) {
  for (const Automatic& automatic : kAutomatics) {
    if (!has_control(device, automatic.id)) continue;
    for (const std::int32_t on : automatic.on) {
      if (set_control(device, {automatic.id, on})) break;
    }
  }
}

std::vector<VideoControl> chosen_controls(const V4l2Device& device) {
  std::vector<VideoControl> switches;
  std::vector<VideoControl> values;
  for (const Automatic& automatic : kAutomatics) {
    if (!has_control(device, automatic.id)) continue;
    switches.push_back({automatic.id, automatic.off[0]});
    for (const std::uint32_t id : automatic.chosen) {
      const bool is_known = std::ranges::find(values, id, &VideoControl::id) != values.end();
      if (is_known || !has_control(device, id)) continue;
      if (const auto value = value_of(device, id)) values.push_back({id, *value});
    }
  }
  switches.insert(switches.end(), values.begin(), values.end());
  return switches;
}

void set_controls(const V4l2Device& device, std::span<const VideoControl> controls) {
  for (const VideoControl& control : controls) {
    if (set_control(device, control)) continue;
    const auto automatic = std::ranges::find(kAutomatics, control.id, &Automatic::id);
    if (automatic != kAutomatics.end()) set_control(device, {control.id, automatic->off[1]});
  }
}

}  // namespace sinew::io
