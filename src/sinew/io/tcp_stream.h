#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <string>
#include <utility>

#include "sinew/core/instant.h"
#include "sinew/io/io_error.h"

namespace sinew::io {

/// A connection to a server in the network that never waits longer than it may. For one thread.
class TcpStream {
 public:
  /// Connects to the first address of the host that answers. Looking up a name takes as long as the
  /// system gives it; numbers need no look-up.
  /// @param patience  for connecting
  /// @error  a sentence with host and port: no such host, nothing listens there, no answer
  static IoResult<TcpStream> connect(const std::string& host, std::uint16_t port, Duration patience,
                                     const std::stop_token& ending);
  TcpStream(TcpStream&& other) noexcept
      : name_(std::move(other.name_)), descriptor_(std::exchange(other.descriptor_, -1)) {}
  TcpStream& operator=(TcpStream&& other) noexcept {
    std::swap(name_, other.name_);
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~TcpStream();

  /// What came, at least one byte, or 0 after `timeout`.
  /// @error  the other side closed the connection, or it broke
  IoResult<std::size_t> read(std::span<std::uint8_t> buffer, Duration timeout);

  /// All bytes. @error  it broke, or took nothing for `patience`
  IoResult<void> write(std::span<const std::uint8_t> bytes, Duration patience);

 private:
  TcpStream(std::string name, int descriptor) : name_(std::move(name)), descriptor_(descriptor) {}
  std::string name_;
  int descriptor_;
};

}  // namespace sinew::io
