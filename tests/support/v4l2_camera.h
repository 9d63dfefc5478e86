#pragma once

#include <linux/videodev2.h>
#include <poll.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sinew/io/v4l2_calls.h"

namespace sinew::test {

/// A camera behind the calls of Video4Linux2, in virtual time: time passes only while the program
/// waits. Frames are exposed back to back; each goes into the first buffer that is queued when it
/// is complete, or is lost.
class TestVideoCamera {
 public:
  struct Size {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<v4l2_fract> intervals;
  };
  struct Format {
    std::uint32_t code = 0;
    std::vector<Size> sizes;
  };
  /// What is in the frame of this number, from 1 on, in rows of `stride` bytes.
  using Paint = std::function<std::vector<std::uint8_t>(int number, const v4l2_pix_format& format)>;

  /// @name To be set by tests
  /// @{
  std::string path = "/dev/video0";
  std::vector<Format> formats{{V4L2_PIX_FMT_YUYV, {{640, 480, {{1, 30}}}}}};
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  bool lists_sizes = true;
  bool is_camera = true;      ///< else it knows no request of cameras
  std::uint32_t padding = 0;  ///< bytes behind each row
  std::uint32_t stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  std::uint32_t colorspace = V4L2_COLORSPACE_SRGB;
  std::uint32_t quantization = V4L2_QUANTIZATION_DEFAULT;
  std::map<std::uint32_t, std::int32_t> controls;
  std::map<unsigned long, int> faults;  ///< errno values of requests
  std::function<bool(int)> is_damaged = [](int) { return false; };
  std::function<bool(int)> is_failed = [](int) { return false; };  ///< its transfer: EIO
  std::function<void(int)> on_frame = [](int) {};
  Paint paint = [](int number, const v4l2_pix_format& format) {
    return std::vector<std::uint8_t>(std::size_t{format.bytesperline} * format.height,
                                     static_cast<std::uint8_t>(number));
  };
  int open_error = 0;
  bool is_silent = false;  ///< no frame comes
  int slowness = 1;        ///< so many intervals for each frame, as in the dark
  /// @}

  /// @name What became of it
  /// @{
  Duration now = std::chrono::seconds(100);
  int open_count = 0;    ///< descriptors that are open
  int opened = 0;        ///< so often
  int mapped_count = 0;  ///< buffers that are mapped
  std::vector<std::pair<std::uint32_t, std::int32_t>> set_controls;
  v4l2_pix_format chosen{};
  v4l2_fract interval{1, 30};
  std::map<int, Duration> exposed;  ///< when the exposure of each frame began
  /// @}

  /// From now on, until plug().
  void unplug() {
    is_plugged_ = false;
    is_streaming_ = false;
  }
  void plug() { is_plugged_ = true; }

  io::V4l2Calls calls() {
    return {
        .open = [this](const char* name, int) { return open(name); },
        .close =
            [this](int) {
              --open_count;
              end_stream();
              return 0;
            },
        .ioctl =
            [this](int, unsigned long request, void* argument) {
              return failed(is_plugged_ ? answer(request, argument) : ENODEV);
            },
        .mmap = [this](std::size_t, int, std::size_t offset) -> void* {
          ++mapped_count;
          return buffers_[offset / kPage].data();
        },
        .munmap =
            [this](void*, std::size_t) {
              --mapped_count;
              return 0;
            },
        .poll = [this](pollfd* waiting, int timeout_ms) { return poll(waiting, timeout_ms); },
        .now = [this] { return now; },
    };
  }

 private:
  static constexpr std::uint32_t kPage = 4096;

  static int failed(int error) {
    errno = error;
    return error == 0 ? 0 : -1;
  }

  int open(const std::string& name) {
    if (!is_plugged_ || name != path) return failed(ENOENT);
    if (open_error != 0) return failed(open_error);
    ++open_count;
    ++opened;
    return 7;
  }

  Duration frame_time() const {
    return std::chrono::nanoseconds(std::chrono::seconds(1)) * interval.numerator * slowness /
           interval.denominator;
  }

  void end_stream() {
    is_streaming_ = false;
    queued_.clear();
    filled_.clear();
  }

  /// Frames that are complete by then go into their buffers.
  void pass_to(Duration then) {
    while (is_streaming_ && !is_silent && next_frame_ <= then) {
      now = std::max(now, next_frame_);
      const int number = ++frames_;
      exposed[number] = next_frame_ - frame_time();
      if (!queued_.empty()) {
        fill(queued_.front(), number);
        queued_.pop_front();
      }
      next_frame_ += frame_time();
      on_frame(number);
    }
    now = std::max(now, then);
  }

  void fill(std::uint32_t index, int number) {
    std::vector<std::uint8_t> bytes = paint(number, chosen);
    bytes.resize(std::min(bytes.size(), buffers_[index].size()));
    std::ranges::copy(bytes, buffers_[index].begin());
    v4l2_buffer buffer{};
    buffer.index = index;
    buffer.bytesused = static_cast<std::uint32_t>(bytes.size());
    buffer.flags = stamp_flags | (is_damaged(number) ? V4L2_BUF_FLAG_ERROR : 0U);
    buffer.sequence = static_cast<std::uint32_t>(number);
    if ((stamp_flags & V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) != 0) {
      buffer.timestamp = {next_frame_ / std::chrono::seconds(1),
                          next_frame_ % std::chrono::seconds(1) / std::chrono::microseconds(1)};
    }
    filled_.push_back(buffer);
  }

  int poll(pollfd* waiting, int timeout_ms) {
    const Duration until = now + std::chrono::milliseconds(timeout_ms);
    if (waiting == nullptr) {
      pass_to(until);
      return 0;
    }
    if (!is_plugged_ || !is_streaming_) {
      waiting->revents = POLLERR | POLLHUP;
      return 1;
    }
    pass_to(now);
    while (is_streaming_ && filled_.empty() && now < until) {
      pass_to(is_silent ? until : std::min(until, next_frame_));
    }
    if (!is_plugged_) {
      waiting->revents = POLLERR | POLLHUP;
      return 1;
    }
    waiting->revents = filled_.empty() ? short{0} : short{POLLIN};
    return filled_.empty() ? 0 : 1;
  }

  const Size* size_of(std::uint32_t code, std::uint32_t width, std::uint32_t height) const {
    for (const Format& one : formats) {
      for (const Size& size : one.sizes) {
        if (one.code == code && size.width == width && size.height == height) return &size;
      }
    }
    return nullptr;
  }

  int answer(unsigned long request, void* argument) {
    if (!is_camera) return ENOTTY;
    if (const auto fault = faults.find(request); fault != faults.end()) return fault->second;
    switch (request) {
      case VIDIOC_QUERYCAP:
        static_cast<v4l2_capability*>(argument)->capabilities =
            V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_META_CAPTURE;
        static_cast<v4l2_capability*>(argument)->device_caps = capabilities;
        return 0;
      case VIDIOC_ENUM_FMT:
        return enumerate_format(*static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_ENUM_FRAMESIZES:
        return enumerate_size(*static_cast<v4l2_frmsizeenum*>(argument));
      case VIDIOC_ENUM_FRAMEINTERVALS:
        return enumerate_interval(*static_cast<v4l2_frmivalenum*>(argument));
      case VIDIOC_TRY_FMT:
      case VIDIOC_S_FMT:
        return set_format(static_cast<v4l2_format*>(argument)->fmt.pix, request == VIDIOC_S_FMT);
      case VIDIOC_S_PARM:
        interval = nearest(static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe);
        [[fallthrough]];
      case VIDIOC_G_PARM:
        static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe = interval;
        return 0;
      default:
        return answer_stream(request, argument);
    }
  }

  int answer_stream(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_REQBUFS:
        buffers_.assign(static_cast<v4l2_requestbuffers*>(argument)->count,
                        std::vector<std::uint8_t>(chosen.sizeimage));
        return 0;
      case VIDIOC_QUERYBUF: {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        buffer.length = chosen.sizeimage;
        buffer.m.offset = buffer.index * kPage;
        return 0;
      }
      case VIDIOC_QBUF:
        queued_.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return dequeue(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        is_streaming_ = true;
        next_frame_ = now + frame_time();
        return 0;
      case VIDIOC_STREAMOFF:
        end_stream();
        return 0;
      case VIDIOC_QUERYCTRL:
        return controls.contains(static_cast<v4l2_queryctrl*>(argument)->id) ? 0 : EINVAL;
      case VIDIOC_G_CTRL:
      case VIDIOC_S_CTRL:
        return answer_control(*static_cast<v4l2_control*>(argument), request == VIDIOC_S_CTRL);
      default:
        return ENOTTY;
    }
  }

  int answer_control(v4l2_control& control, bool is_set) {
    const auto known = controls.find(control.id);
    if (known == controls.end()) return EINVAL;
    if (is_set) {
      known->second = control.value;
      set_controls.emplace_back(control.id, control.value);
    }
    control.value = known->second;
    return 0;
  }

  int dequeue(v4l2_buffer& buffer) {
    if (filled_.empty()) return EAGAIN;
    const v4l2_buffer first = filled_.front();
    filled_.pop_front();
    if (is_failed(static_cast<int>(first.sequence))) {
      queued_.push_back(first.index);  // as uvcvideo does with what it could not fill
      return EIO;
    }
    buffer = first;
    return 0;
  }

  int enumerate_format(v4l2_fmtdesc& description) const {
    if (description.index >= formats.size()) return EINVAL;
    description.pixelformat = formats[description.index].code;
    return 0;
  }

  int enumerate_size(v4l2_frmsizeenum& size) const {
    if (!lists_sizes) return ENOTTY;
    for (const Format& one : formats) {
      if (one.code != size.pixel_format) continue;
      if (size.index >= one.sizes.size()) return EINVAL;
      size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
      size.discrete = {one.sizes[size.index].width, one.sizes[size.index].height};
      return 0;
    }
    return EINVAL;
  }

  int enumerate_interval(v4l2_frmivalenum& wanted) const {
    const Size* size = size_of(wanted.pixel_format, wanted.width, wanted.height);
    if (size == nullptr || wanted.index >= size->intervals.size()) return EINVAL;
    wanted.type = V4L2_FRMIVAL_TYPE_DISCRETE;
    wanted.discrete = size->intervals[wanted.index];
    return 0;
  }

  /// The first size of the format where it has not the wanted one.
  int set_format(v4l2_pix_format& pix, bool is_set) {
    if (is_set && is_streaming_) return EBUSY;
    if (size_of(pix.pixelformat, pix.width, pix.height) == nullptr) {
      const auto known = std::ranges::find(formats, pix.pixelformat, &Format::code);
      const Format& given = known != formats.end() ? *known : formats.front();
      pix.pixelformat = given.code;
      pix.width = given.sizes.front().width;
      pix.height = given.sizes.front().height;
    }
    const bool is_packed = pix.pixelformat == V4L2_PIX_FMT_YUYV;
    const bool is_raw = is_packed || pix.pixelformat == V4L2_PIX_FMT_GREY;
    pix.bytesperline = is_raw ? pix.width * (is_packed ? 2 : 1) + padding : 0;
    pix.sizeimage = is_raw ? pix.bytesperline * pix.height : 2 * pix.width * pix.height;
    pix.colorspace = colorspace;
    pix.quantization = quantization;
    if (is_set) chosen = pix;
    return 0;
  }

  v4l2_fract nearest(const v4l2_fract& wanted) const {
    const Size* size = size_of(chosen.pixelformat, chosen.width, chosen.height);
    if (size == nullptr || size->intervals.empty() || wanted.denominator == 0) return interval;
    const auto off = [&](const v4l2_fract& one) {
      const double asked = static_cast<double>(wanted.numerator) / wanted.denominator;
      const double given = static_cast<double>(one.numerator) / one.denominator;
      return std::max(asked / given, given / asked);
    };
    return *std::ranges::min_element(size->intervals, {}, off);
  }

  bool is_plugged_ = true;
  bool is_streaming_ = false;
  int frames_ = 0;
  Duration next_frame_{};  ///< when it is complete
  std::vector<std::vector<std::uint8_t>> buffers_;
  std::deque<std::uint32_t> queued_;
  std::deque<v4l2_buffer> filled_;
};

}  // namespace sinew::test
