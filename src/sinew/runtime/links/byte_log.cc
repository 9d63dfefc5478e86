#include "sinew/runtime/links/byte_log.h"

#include <fmt/format.h>

#include <iterator>

namespace sinew::runtime {

io::IoResult<ByteLog> ByteLog::create(const std::string& path) {
  auto file = io::LineFile::create(path);
  if (!file) return std::unexpected(file.error());
  ByteLog log;
  log.file_.emplace(std::move(*file));
  log.file_->add("# seconds  direction  bytes (hex)  text");
  return log;
}

void ByteLog::add(Direction direction, std::span<const std::uint8_t> bytes, Instant now,
                  std::uint8_t select) {
  if (ring_ != nullptr) ring_->add(direction, bytes, now, select);
  if (!file_ || bytes.empty()) return;
  std::string line =
      fmt::format("{:12.6f}  {}  ", to_seconds(now.time_since_epoch()),
                  direction == Direction::kToDevice ? "host -> device" : "device -> host");
  std::string text;
  for (const std::uint8_t byte : bytes) {
    fmt::format_to(std::back_inserter(line), "{:02x} ", byte);
    text += byte >= 0x20 && byte < 0x7f ? static_cast<char>(byte) : '.';
  }
  file_->add(line + " " + text);
}

}  // namespace sinew::runtime
