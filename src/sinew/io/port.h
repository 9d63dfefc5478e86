#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "sinew/core/instant.h"
#include "sinew/io/io_error.h"

namespace sinew::io {

/// A byte stream to a device or, on a pseudo-terminal, to its host. Raw: no byte is changed,
/// swallowed or echoed on the way, XON and XOFF are data. Used by one thread.
class Port {
 public:
  Port(Port&&) noexcept;
  Port& operator=(Port&&) noexcept;
  ~Port();

  /// Opens a serial device (or a pseudo-terminal's path) for this process alone.
  ///
  /// @param baud  any rate that the device's driver can divide down to; ignored by a pty.
  /// @error  not there, no permission, used by another program, not a serial device, a rate that
  ///         it cannot do
  static IoResult<Port> open_serial(const std::string& path, std::uint32_t baud);

  /// The device's side of a new pseudo-terminal; `path()` is what a host opens.
  static IoResult<Port> open_pseudo_terminal();

  /// Any stream: a socket has one descriptor for both, a pair of pipes two. Takes them over.
  /// @error  a plain file, which no stream can be made of
  static IoResult<Port> from_descriptors(int reading, int writing, std::string name);

  /// What came, at least one byte, or 0 after `timeout`.
  /// @error  the other side went away
  IoResult<std::size_t> read(std::span<std::uint8_t> buffer, Duration timeout);

  /// All bytes, in one piece where the system takes it.
  /// @error  the other side went away, or took nothing for two seconds
  IoResult<void> write(std::span<const std::uint8_t> bytes);

  /// As many of the bytes as the system takes without waiting; how many these were.
  /// @error  the other side went away
  IoResult<std::size_t> write_now(std::span<const std::uint8_t> bytes);

  const std::string& path() const;

 private:
  struct Implementation;
  explicit Port(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sinew::io
