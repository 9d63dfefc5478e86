#include "sinew/io/tcp_stream.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>

#include "sinew/io/clock.h"

namespace sinew::io {
namespace {

constexpr Duration kSlice = std::chrono::milliseconds(50);  // so soon the end is seen

struct FreeAddresses {
  void operator()(addrinfo* first) const { ::freeaddrinfo(first); }
};

/// Whether the descriptor is ready within this time, or has failed.
bool is_ready(int descriptor, short events, Duration timeout) {
  pollfd waiting{descriptor, events, 0};
  const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
  return ::poll(&waiting, 1, static_cast<int>(std::max<std::int64_t>(milliseconds, 0))) > 0;
}

/// 0 or an errno value, for a connection that is under way.
int wait_for_connection(int descriptor, Duration patience, const std::stop_token& ending) {
  const Clock clock;
  while (!is_ready(descriptor, POLLOUT, kSlice)) {
    if (ending.stop_requested()) return ECANCELED;
    if (clock.now() - Instant{} >= patience) return ETIMEDOUT;
  }
  int error = 0;
  socklen_t size = sizeof error;
  if (::getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size) != 0) return errno;
  return error;
}

/// A connected descriptor, or an errno value below zero.
int connected(const addrinfo& address, Duration patience, const std::stop_token& ending) {
  const int descriptor =
      ::socket(address.ai_family, address.ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor < 0) return -errno;
  int error = ::connect(descriptor, address.ai_addr, address.ai_addrlen) == 0 ? 0 : errno;
  if (error == EINPROGRESS) error = wait_for_connection(descriptor, patience, ending);
  if (error == 0) return descriptor;
  ::close(descriptor);
  return -error;
}

IoError connect_error(const std::string& name, int error) {
  IoError complaint = system_error(name, error);
  if (error == ECONNREFUSED) {
    complaint.sentence += "; start the camera's server there, and compare its port";
  } else if (error == EHOSTUNREACH || error == ENETUNREACH || error == ETIMEDOUT) {
    complaint.sentence +=
        "; switch the camera on, and compare its address and its network with this computer's";
  }
  return complaint;
}

}  // namespace

IoResult<TcpStream> TcpStream::connect(const std::string& host, std::uint16_t port,
                                       Duration patience, const std::stop_token& ending) {
  const std::string name = host + ":" + std::to_string(port);
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* first = nullptr;
  const int status = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &first);
  if (status != 0) {
    return std::unexpected(
        IoError{name + ": " + ::gai_strerror(status) + "; compare the camera's name or address"});
  }
  const std::unique_ptr<addrinfo, FreeAddresses> found(first);
  const Clock clock;
  int error = ECONNREFUSED;
  for (const addrinfo* one = found.get(); one != nullptr; one = one->ai_next) {
    const Duration left = patience - (clock.now() - Instant{});
    if (left <= Duration::zero() || ending.stop_requested()) break;
    // The first of several may be one that this network does not carry.
    const int descriptor = connected(*one, one->ai_next != nullptr ? left / 2 : left, ending);
    if (descriptor >= 0) return TcpStream(name, descriptor);
    error = -descriptor;
  }
  return std::unexpected(connect_error(name, error));
}

TcpStream::~TcpStream() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

IoResult<std::size_t> TcpStream::read(std::span<std::uint8_t> buffer, Duration timeout) {
  if (!is_ready(descriptor_, POLLIN, timeout)) return 0;
  const auto count = ::recv(descriptor_, buffer.data(), buffer.size(), 0);
  if (count > 0) return static_cast<std::size_t>(count);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  if (count < 0) return std::unexpected(system_error(name_, errno));
  return std::unexpected(IoError{name_ + ": the other side closed the connection"});
}

IoResult<void> TcpStream::write(std::span<const std::uint8_t> bytes, Duration patience) {
  while (!bytes.empty()) {
    if (!is_ready(descriptor_, POLLOUT, patience)) {
      return std::unexpected(IoError{name_ + ": the connection takes no bytes"});
    }
    const auto count = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    } else if (errno != EAGAIN && errno != EINTR) {
      return std::unexpected(system_error(name_, errno));
    }
  }
  return {};
}

}  // namespace sinew::io
