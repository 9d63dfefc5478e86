#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>

#include "sinew/io/clock.h"
#include "sinew/io/port.h"
#include "sinew/runtime/links/byte_log.h"

namespace sinew::runtime {

/// Bytes that went over a wire.
struct ByteCount {
  std::size_t to_device = 0;
  std::size_t to_host = 0;
};

/// A driver of bytes and its port: what it has to say goes out, what comes goes in, and all of it
/// is logged and counted.
/// @tparam Driver  take_output, receive, poll and next_deadline of the drivers
template <class Driver>
class ByteLine {
 public:
  /// @param driver, port, clock, log  outlive the line
  ByteLine(Driver& driver, io::Port& port, const io::Clock& clock, ByteLog& log)
      : driver_(driver), port_(port), clock_(clock), log_(log) {}

  /// Everything that the driver has to say.
  io::IoResult<void> send() {
    while (const std::size_t size = driver_.take_output(buffer_)) {
      const std::span bytes(buffer_.data(), size);
      log_.add(ByteLog::Direction::kToDevice, bytes, clock_.now());
      if (auto written = port_.write(bytes); !written) return written;
      count_.to_device += size;
    }
    return {};
  }

  /// Waits for bytes, or for the driver's next deadline, `wait` at most, and hands both to the
  /// driver.
  io::IoResult<void> receive(Duration wait) {
    if (const auto due = driver_.next_deadline()) wait = std::min(wait, clock_.until(*due));
    auto size = port_.read(buffer_, wait);
    if (!size) return std::unexpected(size.error());
    const Instant now = clock_.now();
    const auto deadline = driver_.next_deadline();
    if (*size == 0 && deadline && now >= *deadline) {
      // This process may have been kept from looking: what came before now was no silence.
      size = port_.read(buffer_, Duration{});
      if (!size) return std::unexpected(size.error());
    }
    if (*size > 0) {
      const std::span bytes(buffer_.data(), *size);
      log_.add(ByteLog::Direction::kToHost, bytes, now);
      count_.to_host += *size;
      driver_.receive(bytes, now);
    }
    driver_.poll(now);
    return {};
  }

  const ByteCount& count() const { return count_; }

 private:
  Driver& driver_;
  io::Port& port_;
  const io::Clock& clock_;
  ByteLog& log_;
  ByteCount count_;
  std::array<std::uint8_t, 512> buffer_{};
};

}  // namespace sinew::runtime
