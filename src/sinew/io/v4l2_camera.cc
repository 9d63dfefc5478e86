#include "sinew/io/v4l2_camera.h"

#include <linux/videodev2.h>
#include <poll.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "sinew/io/v4l2_device.h"

namespace sinew::io {
namespace {

constexpr std::uint32_t kBuffers = 4;
constexpr int kPollMs = 50;  // so soon the end of the run is seen
/// Failed transfers in a row after which a driver is opened anew.
constexpr int kFailuresMax = 20;
/// For drivers that do not say how often their frames come.
constexpr Duration kUsualInterval = std::chrono::milliseconds(100);
constexpr Duration kSpacingMax = std::chrono::milliseconds(500);
constexpr Duration kSettleTime = std::chrono::seconds(1);
constexpr int kSettleFrames = 20;

struct Buffer {
  void* address = nullptr;
  std::size_t length = 0;
};

/// A filled buffer, until it is queued again.
struct Filled {
  std::uint32_t index = 0;
  std::span<const std::uint8_t> bytes;
  bool is_damaged = false;
  std::uint32_t sequence = 0;  ///< counts the frames of the driver
  Duration stamp{};
};

v4l2_buffer buffer_request(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

struct V4l2Camera::Stream {
  explicit Stream(V4l2Device of) : device(std::move(of)) {}
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream();

  IoResult<void> start();
  IoResult<void> map_buffers();
  int queue(std::uint32_t index) const;
  /// Waits for a frame; nothing where none came.
  std::expected<std::optional<Filled>, VideoLoss> wait(int timeout_ms);
  std::expected<std::optional<Filled>, VideoLoss> dequeue();
  /// Frames that lie ready, and were taken before.
  std::expected<void, VideoLoss> drain();
  bool is_whole(const Filled& filled) const;
  /// From the beginning of a frame's exposure to its stamp, at most.
  Duration stamp_delay() const;

  V4l2Device device;
  V4l2Device::Format format;
  std::vector<Buffer> buffers;
  int failures = 0;            ///< transfers that failed, one after the other
  std::optional<Filled> last;  ///< its bytes are gone
  Duration spacing{};          ///< between two frames, as seen last
  bool is_streaming = false;
};

V4l2Camera::Stream::~Stream() {
  if (is_streaming) {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    static_cast<void>(device.request(VIDIOC_STREAMOFF, &type));
  }
  for (const Buffer& buffer : buffers) device.calls().munmap(buffer.address, buffer.length);
}

IoResult<void> V4l2Camera::Stream::map_buffers() {
  v4l2_requestbuffers wanted{};
  wanted.count = kBuffers;
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  wanted.memory = V4L2_MEMORY_MMAP;
  if (const int number = device.request(VIDIOC_REQBUFS, &wanted); number != 0) {
    return std::unexpected(device.error(number));
  }
  for (std::uint32_t i = 0; i < wanted.count; ++i) {
    v4l2_buffer buffer = buffer_request(i);
    if (const int number = device.request(VIDIOC_QUERYBUF, &buffer); number != 0) {
      return std::unexpected(device.error(number));
    }
    void* address = device.calls().mmap(buffer.length, device.descriptor(), buffer.m.offset);
    if (address == MAP_FAILED) return std::unexpected(device.error(errno));
    buffers.push_back({address, buffer.length});
  }
  if (buffers.empty()) return std::unexpected(device.error(ENOMEM));
  return {};
}

IoResult<void> V4l2Camera::Stream::start() {
  if (auto mapped = map_buffers(); !mapped) return mapped;
  for (std::uint32_t i = 0; i < buffers.size(); ++i) {
    if (const int number = queue(i); number != 0) return std::unexpected(device.error(number));
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int number = device.request(VIDIOC_STREAMON, &type); number != 0) {
    return std::unexpected(device.error(number));
  }
  is_streaming = true;
  return {};
}

int V4l2Camera::Stream::queue(std::uint32_t index) const {
  v4l2_buffer buffer = buffer_request(index);
  return device.request(VIDIOC_QBUF, &buffer);
}

std::expected<std::optional<Filled>, VideoLoss> V4l2Camera::Stream::dequeue() {
  v4l2_buffer buffer = buffer_request(0);
  const int number = device.request(VIDIOC_DQBUF, &buffer);
  if (number == EAGAIN) return std::optional<Filled>();
  // A transfer failed, and the next one may not: a loose contact, a bus under load.
  if (number == EIO && ++failures < kFailuresMax) return std::optional<Filled>();
  if (number != 0 || buffer.index >= buffers.size()) return std::unexpected(VideoLoss::kGone);
  failures = 0;
  const Buffer& mapped = buffers[buffer.index];
  Filled filled{buffer.index,
                {static_cast<const std::uint8_t*>(mapped.address),
                 std::min<std::size_t>(buffer.bytesused, mapped.length)},
                (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0,
                buffer.sequence,
                std::chrono::seconds(buffer.timestamp.tv_sec) +
                    std::chrono::microseconds(buffer.timestamp.tv_usec)};
  // A stamp by another clock says nothing; what is no leftover came just now.
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
    filled.stamp = device.calls().now();
  }
  if (last && filled.sequence == last->sequence + 1) {
    spacing = std::clamp(filled.stamp - last->stamp, Duration::zero(), kSpacingMax);
  }
  last = filled;
  return filled;
}

Duration V4l2Camera::Stream::stamp_delay() const {
  // Stamps are of the moment when a frame's first or last bytes came; its exposure began up to
  // a frame before. In the dark webcams take longer than they say.
  const bool is_said = format.interval > Duration::zero();
  return std::max(is_said ? format.interval : kUsualInterval, spacing);
}

std::expected<std::optional<Filled>, VideoLoss> V4l2Camera::Stream::wait(int timeout_ms) {
  pollfd waiting{device.descriptor(), POLLIN, 0};
  const int ready = device.calls().poll(&waiting, timeout_ms);
  if (ready < 0 && errno != EINTR) return std::unexpected(VideoLoss::kGone);
  if (ready <= 0) return std::optional<Filled>();
  auto filled = dequeue();
  // Nothing is ready and nothing will be: without this the wait would spin.
  const bool is_broken = (waiting.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0;
  if (is_broken && filled && !*filled) return std::unexpected(VideoLoss::kGone);
  return filled;
}

std::expected<void, VideoLoss> V4l2Camera::Stream::drain() {
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const auto filled = wait(0);
    if (!filled) return std::unexpected(filled.error());
    if (!*filled) break;
    if (queue((*filled)->index) != 0) return std::unexpected(VideoLoss::kGone);
  }
  return {};
}

bool V4l2Camera::Stream::is_whole(const Filled& filled) const {
  if (filled.is_damaged || filled.bytes.empty()) return false;
  if (format.stride == 0) return true;  // a JPEG says itself where it ends
  const auto rows = static_cast<std::size_t>(format.mode.height);
  const auto columns = static_cast<std::size_t>(format.mode.width);
  const std::size_t row =
      format.mode.format == VideoFormat::kYuyv ? 4 * ((columns + 1) / 2) : columns;
  return filled.bytes.size() >= format.stride * (rows - 1) + row;
}

V4l2Camera::V4l2Camera(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}
V4l2Camera::V4l2Camera(V4l2Camera&&) noexcept = default;
V4l2Camera& V4l2Camera::operator=(V4l2Camera&&) noexcept = default;
V4l2Camera::~V4l2Camera() = default;

IoResult<V4l2Camera> V4l2Camera::open(const std::string& path, const VideoWanted& wanted,
                                      const V4l2Calls& calls) {
  auto device = V4l2Device::open(path, calls);
  if (!device) return std::unexpected(device.error());
  auto stream = std::make_unique<Stream>(std::move(*device));
  const auto format = stream->device.set_format(wanted);
  if (!format) return std::unexpected(format.error());
  stream->format = *format;
  if (auto started = stream->start(); !started) return std::unexpected(started.error());
  return V4l2Camera(std::move(stream));
}

const VideoMode& V4l2Camera::mode() const {
  return stream_->format.mode;
}

std::expected<VideoFrame, VideoLoss> V4l2Camera::next(Duration from, Duration until,
                                                      const std::stop_token& ending) {
  Stream& stream = *stream_;
  const V4l2Device::Format& format = stream.format;
  if (auto drained = stream.drain(); !drained) return std::unexpected(drained.error());
  while (!ending.stop_requested() && stream.device.calls().now() < until) {
    const auto filled = stream.wait(kPollMs);
    if (!filled) return std::unexpected(filled.error());
    if (!*filled) continue;
    VideoFrame frame{format.mode, format.stride, format.is_full_range, {}};
    const bool is_good =
        (*filled)->stamp >= from + stream.stamp_delay() && stream.is_whole(**filled);
    if (is_good) frame.bytes.assign((*filled)->bytes.begin(), (*filled)->bytes.end());
    if (stream.queue((*filled)->index) != 0) return std::unexpected(VideoLoss::kGone);
    if (is_good) return frame;
  }
  return std::unexpected(VideoLoss::kNoFrame);
}

std::expected<std::vector<VideoControl>, VideoLoss> V4l2Camera::settle(
    const std::stop_token& ending) {
  Stream& stream = *stream_;
  start_automatics(stream.device);
  const Duration until = stream.device.calls().now() + kSettleTime;
  for (int frames = 0; frames < kSettleFrames && stream.device.calls().now() < until;) {
    if (ending.stop_requested()) return std::unexpected(VideoLoss::kNoFrame);
    const auto filled = stream.wait(kPollMs);
    if (!filled) return std::unexpected(filled.error());
    if (!*filled) continue;
    if (stream.queue((*filled)->index) != 0) return std::unexpected(VideoLoss::kGone);
    ++frames;
  }
  std::vector<VideoControl> chosen = chosen_controls(stream.device);
  set_controls(stream.device, chosen);
  return chosen;
}

void V4l2Camera::keep(std::span<const VideoControl> controls) {
  set_controls(stream_->device, controls);
}

}  // namespace sinew::io
