#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "sinew/core/instant.h"
#include "sinew/driver/wire_ring.h"
#include "sinew/io/file.h"

namespace sinew::runtime {

/// Every byte of a wire, both ways, one line a piece: seconds since the start, direction, hex, and
/// the same as text where it can be shown. Made without a file it writes nothing.
class ByteLog {
 public:
  using Direction = WireWay;

  ByteLog() = default;
  static io::IoResult<ByteLog> create(const std::string& path);

  /// From now on also here. @param ring  outlives the log
  void keep_in(WireRing& ring) { ring_ = &ring; }
  /// @param select  SPI: bit i is axis i
  void add(Direction direction, std::span<const std::uint8_t> bytes, Instant now,
           std::uint8_t select = 0);
  /// Why the log is not whole.
  std::optional<io::IoError> failure() const {
    return file_ ? file_->failure() : std::optional<io::IoError>();
  }

 private:
  std::optional<io::LineFile> file_;
  WireRing* ring_ = nullptr;
};

}  // namespace sinew::runtime
