#include "sinew/io/local_socket.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "sinew/io/file.h"

namespace sinew::io {
namespace {

/// For an answer to a connection.
constexpr time_t kConnectSeconds = 3;

IoResult<sockaddr_un> address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return std::unexpected(IoError{"'" + path + "': a socket's name has 1 to " +
                                   std::to_string(sizeof address.sun_path - 1) + " bytes"});
  }
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

IoResult<int> connected(const std::string& path) {
  const auto address = address_of(path);
  if (!address) return std::unexpected(address.error());
  const int descriptor = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return std::unexpected(system_error(path, errno));
  if (::connect(descriptor, reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0) {
    const int error = errno;
    ::close(descriptor);
    return std::unexpected(system_error(path, error));
  }
  return descriptor;
}

bool is_socket(const std::string& path) {
  struct stat status{};
  return ::lstat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode);
}

}  // namespace

LocalListener::LocalListener(LocalListener&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

LocalListener::~LocalListener() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(path_.c_str());
}

IoResult<std::string> socket_folder() {
  // Below /tmp everybody may make folders: there it carries the user's number.
  std::string path = runtime_folder();
  path += path == "/tmp" ? "/sinew-" + std::to_string(::getuid()) : "/sinew";
  if (::mkdir(path.c_str(), 0700) != 0 && errno != EEXIST) {
    return std::unexpected(system_error(path, errno));
  }
  struct stat status{};
  if (::lstat(path.c_str(), &status) != 0) return std::unexpected(system_error(path, errno));
  const bool ours =
      S_ISDIR(status.st_mode) && status.st_uid == ::getuid() && (status.st_mode & 0077) == 0;
  if (!ours) {
    return std::unexpected(
        IoError{path + ": is no folder of this user alone, so no server can be reached there"});
  }
  return path;
}

IoResult<LocalListener> LocalListener::create(const std::string& path, int waiting) {
  const auto address = address_of(path);
  if (!address) return std::unexpected(address.error());
  if (is_socket(path)) {
    if (const auto other = connected(path)) {
      ::close(*other);
      return std::unexpected(IoError{path + ": another program listens there"});
    }
    ::unlink(path.c_str());
  }
  const int descriptor = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor < 0) return std::unexpected(system_error(path, errno));
  // Before it has a name, so that nobody is quicker.
  if (::fchmod(descriptor, S_IRUSR | S_IWUSR) != 0 ||
      ::bind(descriptor, reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0 ||
      ::listen(descriptor, waiting) != 0) {
    const int error = errno;
    ::close(descriptor);
    if (error == EADDRINUSE) {
      return std::unexpected(IoError{path + ": is there already, and is no socket"});
    }
    return std::unexpected(system_error(path, error));
  }
  return LocalListener(path, descriptor);
}

int LocalListener::accept_descriptor() const {
  return ::accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
}

IoResult<std::optional<Port>> LocalListener::accept(Duration timeout) {
  pollfd waiting{descriptor_, POLLIN, 0};
  const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
  if (::poll(&waiting, 1, static_cast<int>(milliseconds)) <= 0) return std::optional<Port>();
  const int client = accept_descriptor();
  if (client < 0) return std::optional<Port>();  // it went away again
  auto port = Port::from_descriptors(client, client, path_);
  if (!port) return std::unexpected(port.error());
  return std::optional<Port>(std::move(*port));
}

IoResult<Port> connect_local(const std::string& path) {
  const auto descriptor = connected(path);
  if (!descriptor) return std::unexpected(descriptor.error());
  return Port::from_descriptors(*descriptor, *descriptor, path);
}

IoResult<Port> connect_tcp(const std::string& host_and_port) {
  const std::size_t colon = host_and_port.rfind(':');
  if (colon == std::string::npos) {
    return std::unexpected(IoError{host_and_port + ": write HOST:PORT"});
  }
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int status = ::getaddrinfo(host_and_port.substr(0, colon).c_str(),
                                   host_and_port.substr(colon + 1).c_str(), &wanted, &found);
  if (status != 0) return std::unexpected(IoError{host_and_port + ": " + gai_strerror(status)});
  int error = ECONNREFUSED;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    const int descriptor = ::socket(one->ai_family, one->ai_socktype | SOCK_CLOEXEC, 0);
    if (descriptor < 0) continue;
    // A host that is switched off says nothing.
    const timeval patience{kConnectSeconds, 0};
    ::setsockopt(descriptor, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (::connect(descriptor, one->ai_addr, one->ai_addrlen) == 0) {
      ::freeaddrinfo(found);
      // Short lines, each waited for: collecting them would cost 40 ms apiece.
      const int on = 1;
      ::setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      return Port::from_descriptors(descriptor, descriptor, host_and_port);
    }
    error = errno == EINPROGRESS ? ETIMEDOUT : errno;
    ::close(descriptor);
  }
  ::freeaddrinfo(found);
  return std::unexpected(system_error(host_and_port, error));
}

IoResult<Port> standard_port() {
  const int in = ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
  const int out = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  if (in < 0 || out < 0) return std::unexpected(system_error("stdin and stdout", errno));
  return Port::from_descriptors(in, out, "stdin and stdout");
}

}  // namespace sinew::io
