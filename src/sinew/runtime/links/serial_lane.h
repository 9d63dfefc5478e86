#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "sinew/core/instant.h"

namespace sinew::runtime {

/// One direction of a simulated serial line: bytes follow each other at the baud rate, 8N1.
class SerialLane {
 public:
  static constexpr std::size_t kBacklogMax = 1U << 16U;  ///< bytes under way; more are lost

  struct Byte {
    Instant arrives{};
    std::uint8_t byte = 0;
  };

  /// @param baud  0: no time at all
  explicit SerialLane(std::uint32_t baud)
      : byte_time_(baud == 0 ? Duration::zero() : Duration{10'000'000'000 / baud}) {}

  void push(std::span<const std::uint8_t> bytes, Instant now) {
    for (const std::uint8_t byte : bytes) {
      if (waiting_.size() >= kBacklogMax) return;
      last_ = std::max(last_, now) + byte_time_;
      waiting_.push_back({last_, byte});
    }
  }
  /// When the next byte has arrived.
  std::optional<Instant> next() const {
    return waiting_.empty() ? std::nullopt : std::optional(waiting_.front().arrives);
  }
  std::optional<Byte> take(Instant now) {
    if (waiting_.empty() || waiting_.front().arrives > now) return std::nullopt;
    const Byte front = waiting_.front();
    waiting_.pop_front();
    return front;
  }

 private:
  Duration byte_time_;
  Instant last_{};
  std::deque<Byte> waiting_;
};

}  // namespace sinew::runtime
