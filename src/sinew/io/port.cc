#include "sinew/io/port.h"

#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <cerrno>
#include <cstdlib>
#include <optional>

#include "sinew/io/baud_rate.h"

namespace sinew::io {
namespace {

namespace asio = boost::asio;

constexpr unsigned kPseudoTerminalMajor = 136;  // of the kernel's list of devices: 136..143
constexpr const char* kWhereToLook = "; ls /dev/serial/by-id shows what is plugged in";
constexpr const char* kInUse = ": another program is using this port";
constexpr Duration kWriteTimeout = std::chrono::seconds(2);

/// Raw, 8N1, no flow control, and no hang-up on close: dropping DTR resets many of these boards.
int make_raw(int descriptor) {
  termios settings{};
  if (tcgetattr(descriptor, &settings) != 0) return errno;
  cfmakeraw(&settings);
  settings.c_iflag |= IGNBRK;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | HUPCL);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  return tcsetattr(descriptor, TCSANOW, &settings) == 0 ? 0 : errno;
}

/// Kept to this process by the kernel too, where that ends with this process. A pseudo-terminal
/// would stay closed to others as long as its device's side holds it open.
bool keep_to_ourselves(int descriptor) {
  // Two programs on one arm would each see half of its answers.
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) return false;
  struct stat status{};
  if (fstat(descriptor, &status) != 0) return false;
  const bool pseudo = major(status.st_rdev) >= kPseudoTerminalMajor &&
                      major(status.st_rdev) < kPseudoTerminalMajor + 8;
  return pseudo || ioctl(descriptor, TIOCEXCL) == 0;
}

/// USB adapters collect bytes for 16 ms before they hand them over; this flag asks for 1 ms. Where
/// the driver does not know it, answers are that much later, and nothing else.
void make_prompt(int descriptor) {
  serial_struct settings{};
  if (ioctl(descriptor, TIOCGSERIAL, &settings) != 0) return;
  settings.flags |= ASYNC_LOW_LATENCY;
  static_cast<void>(ioctl(descriptor, TIOCSSERIAL, &settings));
}

/// What is no device that went away (EIO: an unplugged adapter) has a reason of its own: a full
/// disk.
IoError write_error(const std::string& path, const boost::system::error_code& error) {
  const int number = error.value();
  if (number == ENOSPC || number == EFBIG || number == EDQUOT || number == EBADF) {
    return system_error(path, number);
  }
  return {path + ": the other side closed the port"};
}

IoError open_error(const std::string& path, int errno_value) {
  if (errno_value == EBUSY) return {path + kInUse};
  IoError error = system_error(path, errno_value);
  if (errno_value == EACCES) {
    error.sentence +=
        "; on Debian the group 'dialout' may use serial ports: "
        "sudo adduser $USER dialout, then log in again";
  } else if (errno_value == ENOENT) {
    error.sentence += kWhereToLook;
  }
  return error;
}

}  // namespace

struct Port::Implementation {
  explicit Implementation(std::string path_of_port)
      : path(std::move(path_of_port)), stream(context), output(context) {}
  ~Implementation() {
    if (peer >= 0) ::close(peer);
  }

  asio::posix::stream_descriptor& writer() { return output.is_open() ? output : stream; }

  std::string path;
  asio::io_context context;
  asio::posix::stream_descriptor stream;
  /// Where bytes go; closed where that is `stream` too.
  asio::posix::stream_descriptor output;
  /// A pseudo-terminal's own other side: while it is open, hosts may come and go.
  int peer = -1;
};

Port::Port(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
Port::Port(Port&&) noexcept = default;
Port& Port::operator=(Port&&) noexcept = default;
Port::~Port() = default;

const std::string& Port::path() const {
  return implementation_->path;
}

IoResult<Port> Port::open_serial(const std::string& path, std::uint32_t baud) {
  auto port = std::make_unique<Implementation>(path);
  const int descriptor = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return std::unexpected(open_error(path, errno));
  port->stream.assign(descriptor);
  if (isatty(descriptor) == 0) {
    return std::unexpected(IoError{path + ": not a serial port" + kWhereToLook});
  }
  if (!keep_to_ourselves(descriptor)) return std::unexpected(IoError{path + kInUse});
  if (const int error = make_raw(descriptor); error != 0) {
    return std::unexpected(system_error(path, error));
  }
  if (const int error = set_baud_rate(descriptor, baud); error != 0) {
    return std::unexpected(system_error(path + ": " + std::to_string(baud) + " baud", error));
  }
  // A driver that cannot divide down to it takes another rate and calls that success. Between two
  // UARTs 2 % is what the last bit of a byte allows.
  const std::uint32_t rate = baud_rate(descriptor);
  if (std::abs(std::int64_t{rate} - std::int64_t{baud}) > std::int64_t{baud} / 50) {
    return std::unexpected(IoError{path + ": cannot do " + std::to_string(baud) +
                                   " baud; the nearest is " + std::to_string(rate)});
  }
  make_prompt(descriptor);
  tcflush(descriptor, TCIOFLUSH);
  return Port(std::move(port));
}

IoResult<Port> Port::open_pseudo_terminal() {
  const int descriptor = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return std::unexpected(system_error("pseudo-terminal", errno));
  std::array<char, 128> name{};
  if (grantpt(descriptor) != 0 || unlockpt(descriptor) != 0 ||
      ptsname_r(descriptor, name.data(), name.size()) != 0) {
    const int error = errno;
    ::close(descriptor);
    return std::unexpected(system_error("pseudo-terminal", error));
  }
  auto port = std::make_unique<Implementation>(name.data());
  port->stream.assign(descriptor);
  port->peer = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (port->peer < 0) return std::unexpected(system_error(port->path, errno));
  if (const int error = make_raw(port->peer); error != 0) {
    return std::unexpected(system_error(port->path, error));
  }
  return Port(std::move(port));
}

IoResult<Port> Port::from_descriptors(int reading, int writing, std::string name) {
  auto port = std::make_unique<Implementation>(std::move(name));
  boost::system::error_code in;
  boost::system::error_code out;
  static_cast<void>(port->stream.assign(reading, in));
  if (writing != reading) static_cast<void>(port->output.assign(writing, out));
  if (!in && !out) return Port(std::move(port));
  if (in) ::close(reading);
  if (out) ::close(writing);
  return std::unexpected(IoError{port->path + ": a plain file cannot be talked to; use a pipe"});
}

IoResult<std::size_t> Port::read(std::span<std::uint8_t> buffer, Duration timeout) {
  auto& [path, context, stream, output, peer] = *implementation_;
  std::optional<boost::system::error_code> result;
  std::size_t count = 0;
  stream.async_read_some(asio::buffer(buffer.data(), buffer.size()),
                         [&](const boost::system::error_code& error, std::size_t size) {
                           result = error;
                           count = size;
                         });
  context.restart();
  context.run_for(timeout);
  if (!result) {
    stream.cancel();
    context.restart();
    context.run();
  }
  if (*result == asio::error::operation_aborted) return 0;
  if (*result) return std::unexpected(IoError{path + ": the other side closed the port"});
  return count;
}

IoResult<std::size_t> Port::write_now(std::span<const std::uint8_t> bytes) {
  const std::string& path = implementation_->path;
  auto& stream = implementation_->writer();
  boost::system::error_code error;
  static_cast<void>(stream.non_blocking(true, error));
  std::size_t count = 0;
  do {
    count = stream.write_some(asio::buffer(bytes.data(), bytes.size()), error);
  } while (error == asio::error::interrupted);  // a signal, as SIGUSR1 to `sinew sim`
  if (!error) return count;
  if (error == asio::error::would_block || error == asio::error::try_again) return 0;
  return std::unexpected(write_error(path, error));
}

IoResult<void> Port::write(std::span<const std::uint8_t> bytes) {
  const std::string& path = implementation_->path;
  asio::io_context& context = implementation_->context;
  auto& stream = implementation_->writer();
  while (!bytes.empty()) {
    std::optional<boost::system::error_code> result;
    std::size_t count = 0;
    stream.async_write_some(asio::buffer(bytes.data(), bytes.size()),
                            [&](const boost::system::error_code& error, std::size_t size) {
                              result = error;
                              count = size;
                            });
    context.restart();
    context.run_for(kWriteTimeout);
    if (!result) {
      stream.cancel();
      context.restart();
      context.run();
      return std::unexpected(IoError{path + ": the port takes no bytes"});
    }
    if (*result) return std::unexpected(write_error(path, *result));
    bytes = bytes.subspan(count);
  }
  return {};
}

}  // namespace sinew::io
