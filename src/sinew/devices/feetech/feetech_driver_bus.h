#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/instant.h"
#include "sinew/devices/feetech/feetech_wire.h"
#include "sinew/driver/driver.h"

namespace sinew {

struct FeetechBusTiming {
  std::uint32_t baud = 1'000'000;
  /// Until the last reply to a question, behind what its bytes take: USB adapters keep bytes for up
  /// to 16 ms, and a computer is late.
  Duration reply_timeout = std::chrono::milliseconds(40);
  /// Between a question and its reply, for each servo (register 7: 0.5 ms at most).
  Duration turn_round = std::chrono::microseconds(510);
};

/// The host's end of a bus that one wire carries both ways: one question at a time, and nothing is
/// sent while a servo may be replying. @rt
class FeetechBus {
 public:
  explicit FeetechBus(const FeetechBusTiming& timing) : timing_(timing) {}

  /// Nothing is out and nothing waits to leave.
  void reset(Instant now);
  /// Whether the wire is free for bytes of ours. @pre for write() and ask()
  bool may_send(Instant now) const { return output_.empty() && now >= wire_free_; }
  /// .. and for a question: none is out, and what answers an older one has had its time to come.
  bool may_ask(Instant now) const { return may_send(now) && !asking() && now >= late_until_; }
  /// A question is out.
  bool asking() const { return !waiting_.empty(); }
  /// Whom it waits for.
  const feetech::Ids& waiting() const { return waiting_; }
  /// When the question that waits was sent.
  Instant asked_at() const { return asked_at_; }
  /// To servos that do not reply to it.
  void write(const feetech::Request& request, Instant now);
  /// @pre !asking()
  void ask(const feetech::Read& read, Instant now);
  void ask(const feetech::SyncRead& read, Instant now);
  /// How long a question for so many bytes of each takes, and a write of so many.
  Duration ask_time(std::size_t servos, std::size_t count) const;
  Duration write_time(std::size_t servos, std::size_t count) const;

  /// One byte in. @return  a reply that was asked for, once
  std::optional<feetech::Reply> receive(std::uint8_t byte, Instant now, DriverHealth& health);
  /// The question is given up if its time is over: whom nothing was heard of.
  feetech::Ids give_up(Instant now);
  std::optional<Instant> deadline() const { return asking() ? std::optional(due_) : std::nullopt; }
  Instant wire_free() const { return wire_free_; }
  Instant late_until() const { return late_until_; }
  std::size_t take_output(std::span<std::uint8_t> out) { return output_.take_front(out); }

 private:
  void wait_for(const feetech::Ids& ids, std::uint8_t count, Instant now);
  Duration bytes_time(std::size_t bytes) const;

  FeetechBusTiming timing_;
  feetech::PacketDecoder decoder_;
  feetech::Ids waiting_;
  std::uint8_t count_ = 0;  ///< bytes of each reply
  Instant asked_at_{};
  Instant due_{};
  Instant wire_free_{};
  Instant late_until_{};
  FixedVector<std::uint8_t, 4 * feetech::kPacketMax> output_;
};

}  // namespace sinew
