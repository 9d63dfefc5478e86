#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/mcu/arm_link.h"
#include "sinew/wire/cobs.h"

namespace sinew::arm_link {

using mcu::arm_link::Kind;
using mcu::arm_link::Reply;
using mcu::arm_link::Request;

/// One request at a time, until its reply has come: what is lost is sent again, with the same
/// number, so that nothing is carried out twice. Each frame has a tag of its own that its reply
/// repeats: a reply that comes late is never taken for that of another request. @rt
class Channel {
 public:
  struct Timing {
    Duration reply = std::chrono::milliseconds(40);
    int tries = 6;
    /// A hello is sent again later, and only its last reply counts: each one opens a session.
    Duration hello = std::chrono::milliseconds(300);
  };

  explicit Channel(const Timing& timing) : timing_(timing) {}

  /// Nothing of before counts.
  void reset();
  bool busy() const { return request_.has_value(); }
  /// @pre not busy()  Its session, number and tag are put in here.
  void send(Request request, Instant now);
  void receive(std::span<const std::uint8_t> bytes, Instant now);
  /// Of the request that is under way its reply counts no more.
  void abandon();
  /// Sends again what was not answered in time.
  void poll(Instant now);
  std::optional<Instant> next_deadline() const { return due_; }
  std::size_t take_output(std::span<std::uint8_t> out) { return output_.take_front(out); }

  /// The request that was answered last, and how; until taken.
  struct Answered {
    Request request;
    Reply reply;
    Instant asked;  ///< when the frame was sent that this replies to
  };
  std::optional<Answered> take_answer() { return std::exchange(answered_, std::nullopt); }
  /// Tried as often as it may be.
  bool silent() const { return silent_; }
  /// Of the session that the last hello opened; 0: none.
  std::uint8_t session() const { return session_; }
  /// The reply says that the request was carried out.
  static bool carried_out(const Answered& answered) {
    return answered.reply.sequence == answered.request.sequence;
  }

  std::uint64_t requests = 0;
  std::uint64_t retries = 0;
  std::uint64_t timeouts = 0;
  std::uint64_t unexpected = 0;

 private:
  static constexpr std::size_t kTriesMax = 16;

  void put(Instant now);
  std::optional<Instant> sent_with(std::uint8_t tag) const;

  Timing timing_;
  cobs::Decoder decoder_;
  FixedVector<std::uint8_t, 2 * cobs::kStreamMax> output_;
  std::optional<Request> request_;
  std::optional<Answered> answered_;
  std::optional<Instant> due_;
  struct Sent {
    std::uint8_t tag = 0;
    Instant at{};
  };
  FixedVector<Sent, kTriesMax> sent_;  ///< frames of this request
  std::uint8_t tag_ = 0;               ///< of the last frame
  bool silent_ = false;
  std::uint8_t session_ = 0;
  std::uint16_t sequence_ = 0;  ///< carried out last
};

}  // namespace sinew::arm_link
