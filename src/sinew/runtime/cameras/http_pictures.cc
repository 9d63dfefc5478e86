#include "sinew/runtime/cameras/http_pictures.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/io/clock.h"
#include "sinew/io/tcp_stream.h"
#include "sinew/runtime/cameras/http_address.h"
#include "sinew/vision/camera_jpeg.h"
#include "sinew/vision/picture_file.h"
#include "sinew/vision/picture_stream.h"

namespace sinew::runtime {
namespace {

constexpr Duration kReadSlice = std::chrono::milliseconds(50);  // so soon the end is seen
constexpr Duration kBetweenConnects = std::chrono::milliseconds(250);
constexpr Duration kConnectPatience = std::chrono::seconds(3);
/// A stream that was not read for longer has old pictures in it, in the buffers of both sides,
/// more than can be read past in kPictureDelay.
constexpr Duration kUnreadMax = std::chrono::milliseconds(200);
constexpr std::size_t kReadBytes = std::size_t{64} << 10U;

vision::Picture decoded(const std::vector<std::uint8_t>& file) {
  const bool is_jpeg = file.size() > 1 && file[0] == 0xFF && file[1] == 0xD8;
  auto picture = is_jpeg ? vision::decode_camera_jpeg(file) : vision::decode_picture(file);
  return picture ? std::move(*picture) : vision::Picture{};
}

/// One camera in the network, for one thread.
class HttpCamera {
 public:
  HttpCamera(HttpAddress address, const io::Clock& clock)
      : address_(std::move(address)), clock_(clock) {}

  /// Connects, and reads until the reply promises pictures.
  std::expected<void, std::string> probe();
  Expected<vision::Picture> next(const std::stop_token& ending);

 private:
  struct Connection {
    io::TcpStream stream;
    vision::PictureStream reply;
    Instant read;  ///< last
  };
  using Parts = std::vector<vision::StreamedPicture>;

  std::expected<void, std::string> connect(Duration patience, const std::stop_token& ending);
  std::expected<Parts, std::string> read();
  bool is_stale(Instant from) const;

  HttpAddress address_;
  io::Clock clock_;
  std::optional<Connection> connection_;
  bool is_single_ = false;  ///< each picture needs a request of its own
};

std::expected<void, std::string> HttpCamera::connect(Duration patience,
                                                     const std::stop_token& ending) {
  connection_.reset();
  auto stream = io::TcpStream::connect(address_.host, address_.port, patience, ending);
  if (!stream) return std::unexpected(stream.error().sentence);
  const std::string request = address_.request();
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(request.data()), request.size());
  if (auto written = stream->write(bytes, patience); !written) {
    return std::unexpected(written.error().sentence);
  }
  connection_.emplace(Connection{std::move(*stream), {}, clock_.now()});
  return {};
}

/// What has come within a slice of time. The connection is gone after an error, and where the
/// reply has ended.
std::expected<HttpCamera::Parts, std::string> HttpCamera::read() {
  std::array<std::uint8_t, kReadBytes> buffer;
  const auto count = connection_->stream.read(buffer, kReadSlice);
  if (!count) {
    Parts last = connection_->reply.end();
    connection_.reset();
    if (last.empty()) return std::unexpected(count.error().sentence);
    return last;
  }
  connection_->read = clock_.now();
  if (*count == 0) return Parts();
  auto parts = connection_->reply.feed(std::span(buffer).first(*count), connection_->read);
  is_single_ = connection_->reply.is_single();
  const bool is_over = connection_->reply.is_over();
  if (!parts) {
    connection_.reset();
    return std::unexpected(address_.shown() + " " + parts.error());
  }
  if (is_over) connection_.reset();
  return parts;
}

std::expected<void, std::string> HttpCamera::probe() {
  const Instant until = clock_.now() + kPicturePatience;
  if (auto connected = connect(kPicturePatience, {}); !connected) return connected;
  while (clock_.now() < until) {
    const auto parts = read();
    if (!parts) return std::unexpected(parts.error());
    if (!parts->empty() || (connection_ && connection_->reply.has_begun())) return {};
  }
  connection_.reset();
  return std::unexpected(address_.shown() + ": no reply within 5 s; restart the camera's server");
}

bool HttpCamera::is_stale(Instant from) const {
  return connection_ && from - connection_->read > kUnreadMax;
}

Expected<vision::Picture> HttpCamera::next(const std::stop_token& ending) {
  const Instant begun = clock_.now();
  const Instant counts = begun + kPictureDelay;
  const Instant until = begun + kPicturePatience;
  if (is_stale(begun) || is_single_) connection_.reset();
  // What is requested earlier is taken too early.
  if (is_single_) clock_.pause_until(counts);
  Instant connect_at = begun;
  while (!ending.stop_requested() && clock_.now() < until) {
    if (!connection_) {
      clock_.pause_until(std::min(connect_at, until));
      connect_at = clock_.now() + kBetweenConnects;
      const Duration patience = std::min(kConnectPatience, until - clock_.now());
      if (!connect(patience, ending)) continue;
    }
    auto parts = read();
    if (!parts) continue;
    for (const vision::StreamedPicture& part : *parts) {
      if (part.begun < counts) continue;
      vision::Picture picture = decoded(part.file);
      if (picture.width > 0) return picture;
    }
  }
  connection_.reset();  // a phone that sleeps leaves it open and silent
  return std::unexpected(Error{ErrorCode::kCameraLost, -1, to_seconds(kPicturePatience)});
}

}  // namespace

std::expected<CameraSource, std::string> http_pictures(const std::string& text,
                                                       const io::Clock& clock) {
  auto address = read_http_address(text);
  // Behind the '@', if there is one: what stands before it may be a password.
  if (!address) return std::unexpected(text.substr(text.rfind('@') + 1) + ": " + address.error());
  auto camera = std::make_shared<HttpCamera>(std::move(*address), clock);
  if (auto probed = camera->probe(); !probed) return std::unexpected(probed.error());
  return [camera](const std::stop_token& ending) { return camera->next(ending); };
}

}  // namespace sinew::runtime
