#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "sinew/core/instant.h"
#include "sinew/io/file.h"

namespace sinew::runtime {

/// Every byte of a wire, both ways, one line a piece: seconds since the start, direction, hex, and
/// the same as text where it can be shown. Made without a file it writes nothing.
class ByteLog {
 public:
  enum class Direction : std::uint8_t { kToDevice, kToHost };

  ByteLog() = default;
  static io::IoResult<ByteLog> create(const std::string& path);

  void add(Direction direction, std::span<const std::uint8_t> bytes, Instant now);
  /// Why the log is not whole.
  std::optional<io::IoError> failure() const {
    return file_ ? file_->failure() : std::optional<io::IoError>();
  }

 private:
  std::optional<io::LineFile> file_;
};

}  // namespace sinew::runtime
