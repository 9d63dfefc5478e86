#include "web/web_cell.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "sinew/server/web/http_head.h"

namespace sinew::test {
namespace {

constexpr int kPatience = 20'000;  // ms

server::WebOptions with_tokens(server::WebOptions options) {
  options.listen = options.listen == server::WebOptions{}.listen ? "127.0.0.1:0" : options.listen;
  options.operator_token = kOperatorToken;
  options.viewer_token = kViewerToken;
  return options;
}

}  // namespace

WebCell::WebCell(const std::vector<CellRobot>& robots, server::WebOptions options)
    : cell_(robots), loop_(cell_.api()) {
  auto web = server::WebServer::listen(with_tokens(std::move(options)), loop_);
  if (!web) {
    ADD_FAILURE() << web.error().sentence;
    std::abort();
  }
  web_ = std::move(*web);
  thread_ = std::thread([this] { loop_.run([this] { return stop_.load(); }); });
}

WebCell::~WebCell() {
  stop_ = true;
  thread_.join();
}

std::string Answered::field(std::string_view name) const {
  const std::string lower = server::lower_case(head);
  const std::size_t found = lower.find("\r\n" + server::lower_case(name) + ": ");
  if (found == std::string::npos) return {};
  const std::size_t begin = found + name.size() + 4;
  return head.substr(begin, head.find("\r\n", begin) - begin);
}

RawConnection::RawConnection(std::uint16_t port, const std::string& from)
    : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in here{};
  here.sin_family = AF_INET;
  ::inet_pton(AF_INET, from.c_str(), &here.sin_addr);
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(port);
  there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int on = 1;
  ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&here), sizeof here), 0);
  EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&there), sizeof there), 0);
}

RawConnection::RawConnection(RawConnection&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), received_(std::move(other.received_)) {}

RawConnection::~RawConnection() {
  if (socket_ >= 0) ::close(socket_);
}

bool RawConnection::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

bool RawConnection::more() {
  pollfd wait{socket_, POLLIN, 0};
  if (::poll(&wait, 1, kPatience) <= 0) return false;
  std::array<char, 65536> buffer;
  const ssize_t count = ::recv(socket_, buffer.data(), buffer.size(), 0);
  if (count <= 0) return false;
  received_.append(buffer.data(), static_cast<std::size_t>(count));
  return true;
}

std::string RawConnection::receive(std::size_t count) {
  while (received_.size() < count && more()) {
  }
  const std::string taken = received_.substr(0, count);
  received_.erase(0, taken.size());
  return taken;
}

bool RawConnection::ends() {
  pollfd wait{socket_, POLLIN, 0};
  std::array<char, 65536> buffer;
  while (::poll(&wait, 1, kPatience) > 0) {
    if (::recv(socket_, buffer.data(), buffer.size(), 0) <= 0) return true;
  }
  return false;
}

Answered RawConnection::answer(bool head_only) {
  Answered answered;
  std::size_t end = 0;
  while ((end = received_.find("\r\n\r\n")) == std::string::npos) {
    if (!more()) return answered;
  }
  answered.head = receive(end + 4);
  std::from_chars(answered.head.data() + 9, answered.head.data() + 12, answered.status);
  std::size_t length = 0;
  const std::string text = answered.field("content-length");
  std::from_chars(text.data(), text.data() + text.size(), length);
  if (!head_only) answered.body = receive(length);
  return answered;
}

int RawConnection::Frame::close_code() const {
  if (opcode != 8 || payload.size() < 2) return 0;
  return (static_cast<unsigned char>(payload[0]) << 8) | static_cast<unsigned char>(payload[1]);
}

RawConnection::Frame RawConnection::frame() {
  const std::string head = receive(2);
  if (head.size() < 2) return {};
  std::size_t size = static_cast<unsigned char>(head[1]) & 127U;
  if (size > 125) {
    const std::string more_size = receive(size == 126 ? 2 : 8);
    size = 0;
    for (const char c : more_size) size = size << 8U | static_cast<unsigned char>(c);
  }
  Frame frame{head[0] & 15, receive(size)};
  return frame.payload.size() == size ? frame : Frame{};
}

bool RawConnection::send_frame(std::string_view payload, unsigned char first) {
  constexpr std::array<char, 4> kMask{'\x12', '\x34', '\x56', '\x78'};
  std::string bytes{static_cast<char>(first)};
  const auto size = payload.size();
  const auto put = [&](int shift) { bytes += static_cast<char>(size >> shift & 255U); };
  if (size < 126) {
    bytes += static_cast<char>(0x80 | size);
  } else if (size < 65536) {
    bytes += static_cast<char>(0x80 | 126);
    for (int shift = 8; shift >= 0; shift -= 8) put(shift);
  } else {
    bytes += static_cast<char>(0x80 | 127);
    for (int shift = 56; shift >= 0; shift -= 8) put(shift);
  }
  bytes.append(kMask.data(), kMask.size());
  for (std::size_t k = 0; k < size; ++k) {
    bytes += static_cast<char>(payload[k] ^ kMask[k % kMask.size()]);
  }
  return send(bytes);
}

std::string upgrade_text(std::uint16_t port, std::string_view token) {
  std::string protocols = "sinew.v1";
  if (!token.empty()) protocols += ", bearer." + std::string(token);
  return "GET /ws HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
         "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " +
         protocols + "\r\n\r\n";
}

WebClient::WebClient(std::uint16_t port, const char* token) : raw_(port) {
  raw_.send(upgrade_text(port, token));
  open_ = raw_.answer(true).status == 101;
}

void WebClient::send(std::string_view method, const server::Json& params) {
  raw_.send_frame(server::request_text(++last_, method, params));
}

server::Json WebClient::next() {
  while (true) {
    const RawConnection::Frame frame = raw_.frame();
    if (frame.opcode == 9) {
      raw_.send_frame(frame.payload, 0x8a);
    } else if (frame.opcode == 1) {
      return server::Json::parse(frame.payload);
    } else {
      return nullptr;
    }
  }
}

server::Json WebClient::call(std::string_view method, const server::Json& params) {
  send(method, params);
  while (true) {
    server::Json message = next();
    if (message.is_null() || (message.contains("id") && message["id"] == last_)) return message;
  }
}

}  // namespace sinew::test
