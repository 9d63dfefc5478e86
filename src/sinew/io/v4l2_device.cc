#include "sinew/io/v4l2_device.h"

#include <fcntl.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <optional>

namespace sinew::io {
namespace {

// A driver that goes on and on is left at these.
constexpr std::uint32_t kFormatsMax = 64;
constexpr std::uint32_t kSizesMax = 256;
constexpr std::uint32_t kRatesMax = 64;

constexpr const char* kWhichThereAre =
    "; v4l2-ctl --list-devices, or ls /dev/video*, shows the cameras";

struct FormatCode {
  VideoFormat format;
  std::uint32_t code;
};

constexpr std::array<FormatCode, 4> kCodes{{{VideoFormat::kMjpg, V4L2_PIX_FMT_MJPEG},
                                            {VideoFormat::kMjpg, V4L2_PIX_FMT_JPEG},
                                            {VideoFormat::kYuyv, V4L2_PIX_FMT_YUYV},
                                            {VideoFormat::kGrey, V4L2_PIX_FMT_GREY}}};

std::optional<VideoFormat> format_of(std::uint32_t code) {
  const auto known = std::ranges::find(kCodes, code, &FormatCode::code);
  return known != kCodes.end() ? std::optional(known->format) : std::nullopt;
}

std::uint32_t code_of(VideoFormat format) {
  return std::ranges::find(kCodes, format, &FormatCode::format)->code;
}

double rate_of(const v4l2_fract& interval) {
  if (interval.numerator == 0) return 0;
  return static_cast<double>(interval.denominator) / interval.numerator;
}

std::size_t row_bytes(VideoFormat format, std::uint32_t width) {
  switch (format) {
    case VideoFormat::kYuyv:
      return 4 * ((std::size_t{width} + 1) / 2);
    case VideoFormat::kGrey:
      return width;
    case VideoFormat::kMjpg:
      break;
  }
  return 0;
}

v4l2_format format_request(VideoFormat format, int width, int height) {
  v4l2_format request{};
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.fmt.pix.width = static_cast<std::uint32_t>(width);
  request.fmt.pix.height = static_cast<std::uint32_t>(height);
  request.fmt.pix.pixelformat = code_of(format);
  request.fmt.pix.field = V4L2_FIELD_ANY;
  return request;
}

/// Grey cameras use all values of their bytes; colour ones those of BT.601 unless they say so.
bool is_full_range(const v4l2_pix_format& pix, VideoFormat format) {
  if (pix.quantization == V4L2_QUANTIZATION_FULL_RANGE) return true;
  if (pix.quantization == V4L2_QUANTIZATION_LIM_RANGE) return false;
  return format == VideoFormat::kGrey || pix.colorspace == V4L2_COLORSPACE_JPEG;
}

/// Whether a stepwise range has this size.
bool has_size(const v4l2_frmsize_stepwise& range, int width, int height) {
  const auto fits = [](int value, std::uint32_t least, std::uint32_t most, std::uint32_t step) {
    const auto size = static_cast<std::uint32_t>(value);
    return size >= least && size <= most && (size - least) % std::max(step, 1U) == 0;
  };
  return fits(width, range.min_width, range.max_width, range.step_width) &&
         fits(height, range.min_height, range.max_height, range.step_height);
}

IoError no_camera(const std::string& path) {
  return {path + ": is no camera" + kWhichThereAre};
}

}  // namespace

IoResult<V4l2Device> V4l2Device::open(const std::string& path, const V4l2Calls& calls) {
  const int descriptor = calls.open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) {
    const int number = errno;
    IoError error = system_error(path, number);
    if (number == EBUSY) return std::unexpected(V4l2Device(calls, path, -1).error(number));
    if (number == EACCES || number == EPERM) {
      error.sentence +=
          "; the group 'video' may use cameras: sudo adduser $USER video, then log in again";
    } else if (number == ENOENT || number == ENODEV || number == ENXIO) {
      error.sentence += std::string("; plug the camera in") + kWhichThereAre;
    }
    return std::unexpected(std::move(error));
  }
  V4l2Device device(calls, path, descriptor);
  v4l2_capability about{};
  if (const int number = device.request(VIDIOC_QUERYCAP, &about); number != 0) {
    if (number == ENODEV) return std::unexpected(device.error(number));
    return std::unexpected(no_camera(path));
  }
  const std::uint32_t can =
      (about.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? about.device_caps : about.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0) {
    return std::unexpected(IoError{path +
                                   ": gives its pictures in several planes, which is not read; "
                                   "use a USB camera, or an HTTP stream of this one"});
  }
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0) {
    return std::unexpected(IoError{path +
                                   ": gives no pictures. A camera has several device files; the "
                                   "first of them gives its pictures" +
                                   kWhichThereAre});
  }
  if ((can & V4L2_CAP_STREAMING) == 0) {
    return std::unexpected(IoError{path + ": this camera cannot stream; use another one"});
  }
  return device;
}

V4l2Device::~V4l2Device() {
  if (descriptor_ >= 0) calls_->close(descriptor_);
}

int V4l2Device::request(unsigned long code, void* argument) const {
  while (calls_->ioctl(descriptor_, code, argument) != 0) {
    if (errno != EINTR) return errno;
  }
  return 0;
}

IoError V4l2Device::error(int errno_value) const {
  if (errno_value == EBUSY) {
    return {path_ + ": another program is using this camera; close it (fuser -v " + path_ +
            " shows which)"};
  }
  if (errno_value == ENOSPC) {
    return {path_ +
            ": the USB bus has no room for this camera's pictures; plug it in at another port, "
            "away from other cameras, or choose a smaller size"};
  }
  if (errno_value == ENODEV) return {path_ + ": the camera was unplugged; plug it in again"};
  return system_error(path_, errno_value);
}

double V4l2Device::highest_rate(VideoFormat format, int width, int height) const {
  double best = 0;
  for (std::uint32_t i = 0; i < kRatesMax; ++i) {
    v4l2_frmivalenum interval{};
    interval.index = i;
    interval.pixel_format = code_of(format);
    interval.width = static_cast<std::uint32_t>(width);
    interval.height = static_cast<std::uint32_t>(height);
    if (request(VIDIOC_ENUM_FRAMEINTERVALS, &interval) != 0) break;
    const bool is_one = interval.type == V4L2_FRMIVAL_TYPE_DISCRETE;
    best = std::max(best, rate_of(is_one ? interval.discrete : interval.stepwise.min));
    if (!is_one) break;
  }
  return best;
}

/// For a driver that does not list its sizes: what it makes of the wanted one.
void V4l2Device::add_guess(VideoFormat format, const VideoWanted& wanted,
                           std::vector<VideoMode>& modes) const {
  const bool any_size = wanted.width == 0 || wanted.height == 0;
  v4l2_format attempt =
      format_request(format, any_size ? 1280 : wanted.width, any_size ? 720 : wanted.height);
  if (request(VIDIOC_TRY_FMT, &attempt) != 0) return;
  if (format_of(attempt.fmt.pix.pixelformat) != format) return;
  const auto width = static_cast<int>(attempt.fmt.pix.width);
  const auto height = static_cast<int>(attempt.fmt.pix.height);
  modes.push_back({format, width, height, highest_rate(format, width, height)});
}

void V4l2Device::add_sizes(VideoFormat format, const VideoWanted& wanted,
                           std::vector<VideoMode>& modes) const {
  const auto add = [&](int width, int height) {
    modes.push_back({format, width, height, highest_rate(format, width, height)});
  };
  for (std::uint32_t i = 0; i < kSizesMax; ++i) {
    v4l2_frmsizeenum size{};
    size.index = i;
    size.pixel_format = code_of(format);
    if (request(VIDIOC_ENUM_FRAMESIZES, &size) != 0) {
      if (i == 0) add_guess(format, wanted, modes);
      return;
    }
    if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      add(static_cast<int>(size.discrete.width), static_cast<int>(size.discrete.height));
      continue;
    }
    if (wanted.width > 0 && has_size(size.stepwise, wanted.width, wanted.height)) {
      add(wanted.width, wanted.height);
    }
    for (const auto& [width, height] : {std::pair(1280, 720), std::pair(640, 480)}) {
      if (has_size(size.stepwise, width, height)) add(width, height);
    }
    add(static_cast<int>(size.stepwise.max_width), static_cast<int>(size.stepwise.max_height));
    return;
  }
}

std::vector<VideoMode> V4l2Device::modes(const VideoWanted& wanted) const {
  std::vector<VideoMode> modes;
  for (std::uint32_t i = 0; i < kFormatsMax; ++i) {
    v4l2_fmtdesc description{};
    description.index = i;
    description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (request(VIDIOC_ENUM_FMT, &description) != 0) break;
    const auto format = format_of(description.pixelformat);
    // Made from another format by a library or the driver: no better than that one.
    const bool is_emulated = (description.flags & V4L2_FMT_FLAG_EMULATED) != 0;
    if (format && code_of(*format) == description.pixelformat && !is_emulated) {
      add_sizes(*format, wanted, modes);
    }
  }
  std::erase_if(modes, [](const VideoMode& mode) { return mode.width < 1 || mode.height < 1; });
  return modes;
}

/// The interval between frames that the driver made of it; zero where it does not say.
Duration V4l2Device::set_rate(double fps) const {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_fract& interval = parameters.parm.capture.timeperframe;
  if (fps > 0) {
    interval = {1000, static_cast<std::uint32_t>(std::lround(1000 * std::min(fps, 1000.0)))};
    static_cast<void>(request(VIDIOC_S_PARM, &parameters));
  }
  if (request(VIDIOC_G_PARM, &parameters) != 0) return from_seconds(fps > 0 ? 1 / fps : 0);
  const double rate = rate_of(interval);
  return from_seconds(rate > 0.1 ? 1 / rate : 0);
}

IoResult<V4l2Device::Format> V4l2Device::set_format(const VideoWanted& wanted) const {
  const std::vector<VideoMode> offered = modes(wanted);
  if (offered.empty()) {
    return std::unexpected(IoError{
        path_ + ": this camera has none of the formats MJPG, YUYV and GREY; use another camera"});
  }
  const auto mode = best_mode(offered, wanted);
  if (!mode) {
    return std::unexpected(IoError{path_ + ": no pictures of " + std::to_string(wanted.width) +
                                   " x " + std::to_string(wanted.height) + " pixels; it has " +
                                   size_list(offered) +
                                   ". Calibrate it again in one of these sizes"});
  }
  v4l2_format attempt = format_request(mode->format, mode->width, mode->height);
  if (const int number = request(VIDIOC_S_FMT, &attempt); number != 0) {
    return std::unexpected(error(number));
  }
  const v4l2_pix_format& pix = attempt.fmt.pix;
  Format format{*mode, 0, is_full_range(pix, mode->format), {}};
  format.mode.width = static_cast<int>(pix.width);
  format.mode.height = static_cast<int>(pix.height);
  if (format_of(pix.pixelformat) != mode->format || format.mode.width != mode->width ||
      format.mode.height != mode->height) {
    return std::unexpected(
        IoError{path_ + ": does not give the pictures of " + std::to_string(mode->width) + " x " +
                std::to_string(mode->height) + " pixels that it offers; choose another size"});
  }
  const std::size_t row = row_bytes(mode->format, pix.width);
  if (row > 0) format.stride = std::max<std::size_t>(pix.bytesperline, row);
  const double fps = wanted.fps > 0 ? wanted.fps : mode->fps;
  format.interval = set_rate(mode->fps > 0 ? std::min(fps, mode->fps) : fps);
  return format;
}

}  // namespace sinew::io
