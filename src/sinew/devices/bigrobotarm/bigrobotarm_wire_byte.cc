#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "sinew/core/assert.h"

namespace sinew::bigrobotarm::byte {
namespace {

constexpr std::uint8_t kReady = 0xC8;
constexpr std::uint8_t kInvalid = 0xC9;
constexpr std::uint8_t kStatus = 0xCA;
constexpr std::array<std::uint8_t, 3> kReadyBytes{kReady, 0x0D, 0x0A};
constexpr std::size_t kHeadSize = 3;  // head 0D 0A
constexpr std::size_t kWordsSize = 4 * kJoints;

template <class... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};

template <std::size_t N>
void put_word(FixedVector<std::uint8_t, N>& out, std::int32_t word) {
  const auto bits = static_cast<std::uint32_t>(word);
  for (unsigned shift = 0; shift < 32; shift += 8) {
    out.push_back(static_cast<std::uint8_t>(bits >> shift));
  }
}

template <std::size_t N>
void put_words(FixedVector<std::uint8_t, N>& out, const Words& words) {
  for (const std::int32_t word : words) put_word(out, word);
}

Words take_words(std::span<const std::uint8_t> bytes) {
  SINEW_ASSERT(bytes.size() >= kWordsSize);
  Words words{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    std::uint32_t bits = 0;
    for (std::size_t k = 4; k-- > 0;) bits = bits << 8 | bytes[4 * i + k];
    words[i] = static_cast<std::int32_t>(bits);
  }
  return words;
}

/// Bytes of a request, 0 for an unknown id.
constexpr std::size_t request_length(std::uint8_t id) {
  constexpr std::array<std::size_t, 9> kLengths{0, 21, 1, 1, 21, 21, 3, 2, 1};
  return id < kLengths.size() ? kLengths[id] : 0;
}

Request parse_request(std::span<const std::uint8_t> bytes) {
  const auto payload = bytes.subspan(1);
  switch (static_cast<RequestId>(bytes[0])) {
    case RequestId::kGoto:
      return Goto{take_words(payload)};
    case RequestId::kHome:
      return Home{};
    case RequestId::kReset:
      return Reset{};
    case RequestId::kSpeeds:
      return SetSpeeds{take_words(payload)};
    case RequestId::kAccelerations:
      return SetAccelerations{take_words(payload)};
    case RequestId::kGripper:
      return SetGripper{payload[0] == 1, payload[1]};
    case RequestId::kSync:
      return SetSync{payload[0] != 0};
    case RequestId::kStatus:
      break;
  }
  return ReadStatus{};
}

/// Bytes of a reply by its head, 0 for an unknown one.
constexpr std::size_t reply_length(std::uint8_t head) {
  switch (head) {
    case 1:
    case 2:
    case 3:
    case 4:
    case 5:
      return kHeadSize + kWordsSize + 2 + kReadyBytes.size();
    case 6:
      return kHeadSize + 2 + 2 + kReadyBytes.size();
    case 7:
      return kHeadSize + 1 + 2 + kReadyBytes.size();
    case kStatus:
      return kHeadSize + 3 * kWordsSize + 3 + 2 + kReadyBytes.size();
    case kInvalid:
      return kHeadSize + kReadyBytes.size();
    default:
      return 0;
  }
}

/// The byte that must stand at `place` of a reply of `length`, where the frame leaves no choice.
constexpr std::optional<std::uint8_t> fixed_byte(std::size_t place, std::size_t length) {
  if (place == 1) return std::uint8_t{0x0D};
  if (place == 2) return std::uint8_t{0x0A};
  if (place + kReadyBytes.size() >= length) return kReadyBytes[place + 3 - length];
  // Data has a line end of its own; Invalid carries no data.
  if (length > kHeadSize + kReadyBytes.size() && place + 5 >= length) {
    return place + 5 == length ? std::uint8_t{0x0D} : std::uint8_t{0x0A};
  }
  return std::nullopt;
}

/// True where `place` holds a flag, which is 0 or 1.
constexpr bool is_flag(std::uint8_t head, std::size_t place) {
  constexpr std::size_t kStatusFlags = kHeadSize + 3 * kWordsSize;
  if (head == 6 || head == 7) return place == kHeadSize;
  return head == kStatus && (place == kStatusFlags || place == kStatusFlags + 2);
}

Reply parse_reply(std::span<const std::uint8_t> bytes) {
  const auto data = bytes.subspan(kHeadSize);
  switch (bytes[0]) {
    case 1:
      return GotoDone{take_words(data)};
    case 2:
      return HomeDone{take_words(data)};
    case 3:
      return ResetDone{take_words(data)};
    case 4:
      return Speeds{take_words(data)};
    case 5:
      return Accelerations{take_words(data)};
    case 6:
      return Gripper{data[0] != 0, data[1]};
    case 7:
      return Sync{data[0] != 0};
    case kStatus: {
      const auto flags = data.subspan(3 * kWordsSize);
      return Status{.positions = take_words(data),
                    .accelerations = take_words(data.subspan(kWordsSize)),
                    .speeds = take_words(data.subspan(2 * kWordsSize)),
                    .gripper = Gripper{flags[0] != 0, flags[1]},
                    .sync = flags[2] != 0};
    }
    default:
      return Invalid{};
  }
}

void put_head(ReplyBytes& out, std::uint8_t head) {
  out.push_back(head);
  out.push_back(0x0D);
  out.push_back(0x0A);
}

void put_head(ReplyBytes& out, RequestId id) {
  put_head(out, static_cast<std::uint8_t>(id));
}

void put_data_end(ReplyBytes& out) {
  out.push_back(0x0D);
  out.push_back(0x0A);
  for (const std::uint8_t byte : kReadyBytes) out.push_back(byte);
}

void put_words_reply(ReplyBytes& out, RequestId id, const Words& words) {
  put_head(out, id);
  put_words(out, words);
  put_data_end(out);
}

void put_motion_done(ReplyBytes& out, const Words& positions) {
  put_words(out, positions);
  put_data_end(out);
}

void put_status(ReplyBytes& out, const Status& status) {
  SINEW_ASSERT(status.gripper.has_value());
  put_head(out, kStatus);
  put_words(out, status.positions);
  put_words(out, status.accelerations);
  put_words(out, status.speeds);
  out.push_back(status.gripper->enabled ? 1 : 0);
  out.push_back(status.gripper->position);
  out.push_back(status.sync ? 1 : 0);
  put_data_end(out);
}

}  // namespace

RequestBytes encode_request(const Request& request) {
  RequestBytes out;
  out.push_back(static_cast<std::uint8_t>(id_of(request)));
  std::visit(Overload{[&](const Goto& m) { put_words(out, m.positions); },
                      [&](const SetSpeeds& m) { put_words(out, m.speeds); },
                      [&](const SetAccelerations& m) { put_words(out, m.accelerations); },
                      [&](const SetGripper& m) {
                        out.push_back(m.enabled ? 1 : 0);
                        out.push_back(m.position);
                      },
                      [&](const SetSync& m) { out.push_back(m.on ? 1 : 0); }, [](const Home&) {},
                      [](const Reset&) {}, [](const ReadStatus&) {}},
             request);
  SINEW_ASSERT(out.size() == request_length(out[0]));
  return out;
}

bool sendable(const Request& request) {
  const RequestBytes bytes = encode_request(request);
  return std::find(bytes.begin(), bytes.end(), kTerminator) == bytes.end();
}

bool sendable(std::int32_t word) {
  FixedVector<std::uint8_t, 4> bytes;
  put_word(bytes, word);
  return std::find(bytes.begin(), bytes.end(), kTerminator) == bytes.end();
}

ReplyBytes encode_reply(const Reply& reply) {
  ReplyBytes out;
  std::visit(
      Overload{[&](const MotionStarted& m) { put_head(out, m.id); },
               [&](const GotoDone& m) { put_motion_done(out, m.positions); },
               [&](const HomeDone& m) { put_motion_done(out, m.positions); },
               [&](const ResetDone& m) { put_words_reply(out, RequestId::kReset, m.positions); },
               [&](const Speeds& m) { put_words_reply(out, RequestId::kSpeeds, m.speeds); },
               [&](const Accelerations& m) {
                 put_words_reply(out, RequestId::kAccelerations, m.accelerations);
               },
               [&](const Gripper& m) {
                 put_head(out, RequestId::kGripper);
                 out.push_back(m.enabled ? 1 : 0);
                 out.push_back(m.position);
                 put_data_end(out);
               },
               [&](const Sync& m) {
                 put_head(out, RequestId::kSync);
                 out.push_back(m.on ? 1 : 0);
                 put_data_end(out);
               },
               [&](const Status& m) { put_status(out, m); },
               [&](const Invalid&) {
                 put_head(out, kInvalid);
                 for (const std::uint8_t byte : kReadyBytes) out.push_back(byte);
               },
               [](const auto&) {}},
      reply);
  SINEW_ASSERT(!out.empty());
  return out;
}

std::optional<std::expected<Reply, Garbage>> ReplyDecoder::push(std::uint8_t byte) {
  if (hunting_) {
    hunt(byte);
    return std::nullopt;
  }
  bytes_.push_back(byte);
  const std::uint8_t head = bytes_[0];
  const std::size_t length = reply_length(head);
  if (length == 0) return lose(byte, static_cast<std::uint8_t>(RequestId::kGoto));
  const std::size_t place = bytes_.size() - 1;
  const auto due = fixed_byte(place, length);
  if (due && byte != *due) return lose(byte, *due);
  if (is_flag(head, place) && byte > 1) return lose(byte, 1);
  if (place + 1 == kHeadSize && head <= static_cast<std::uint8_t>(RequestId::kHome)) {
    return MotionStarted{static_cast<RequestId>(head)};
  }
  if (bytes_.size() < length) return std::nullopt;
  const Reply reply = parse_reply(bytes_);
  bytes_.clear();
  return reply;
}

void ReplyDecoder::reset() {
  bytes_.clear();
  hunting_ = false;
  ready_matched_ = 0;
}

std::optional<std::expected<Reply, Garbage>> ReplyDecoder::lose(std::uint8_t seen,
                                                                std::uint8_t expected) {
  reset();
  hunting_ = true;
  hunt(seen);
  return std::unexpected(Garbage{seen, expected});
}

void ReplyDecoder::hunt(std::uint8_t byte) {
  if (byte == kReadyBytes[ready_matched_]) {
    ++ready_matched_;
  } else {
    ready_matched_ = byte == kReady ? 1 : 0;
  }
  if (ready_matched_ == kReadyBytes.size()) reset();
}

std::optional<std::expected<Request, Invalid>> RequestDecoder::push(std::uint8_t byte) {
  if (terminator_due_) {
    terminator_due_ = false;
    if (byte == kTerminator) return std::nullopt;
  }
  if (unknown_ || (bytes_.empty() && request_length(byte) == 0)) {
    unknown_ = byte != kTerminator;
    if (unknown_) return std::nullopt;
    return std::unexpected(Invalid{});
  }
  bytes_.push_back(byte);
  if (bytes_.size() < request_length(bytes_[0])) return std::nullopt;
  const Request request = parse_request(bytes_);
  bytes_.clear();
  terminator_due_ = true;
  return request;
}

std::optional<std::expected<Request, Invalid>> CutRequestDecoder::push(std::uint8_t byte) {
  if (byte != kTerminator) {
    if (size_ < kBuffer) bytes_[size_++] = byte;
    return std::nullopt;
  }
  const bool known = size_ > 0 && request_length(bytes_[0]) != 0;
  const auto result =
      known ? std::expected<Request, Invalid>(parse_request(bytes_)) : std::unexpected(Invalid{});
  bytes_ = {};
  size_ = 0;
  return result;
}

}  // namespace sinew::bigrobotarm::byte
