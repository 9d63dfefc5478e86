#include "sinew/devices/maxarm/maxarm_wire.h"

#include <algorithm>

#include "sinew/core/assert.h"

namespace sinew::maxarm {
namespace {

constexpr std::uint8_t kHead = 0xAA;
constexpr std::uint8_t kSecond = 0x55;
constexpr std::uint8_t kReplyData = 6;
constexpr std::size_t kAroundData = 5;

enum Function : std::uint8_t {
  kSetAngle = 0x01,
  kSetXyz = 0x03,
  kSetPwmServo = 0x05,
  kSetSuction = 0x07,
  kReadAngle = 0x11,
  kReadXyz = 0x13,
};

template <class... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};

/// Data bytes of a request; nothing for a function that does not exist.
constexpr std::optional<std::uint8_t> data_length(std::uint8_t function) {
  switch (function) {
    case kSetAngle:
    case kSetXyz:
      return std::uint8_t{8};
    case kSetPwmServo:
      return std::uint8_t{4};
    case kSetSuction:
      return std::uint8_t{1};
    case kReadAngle:
    case kReadXyz:
      return std::uint8_t{0};
    default:
      return std::nullopt;
  }
}

/// Of function, length and data.
std::uint8_t sum_of(std::span<const std::uint8_t> bytes) {
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  return static_cast<std::uint8_t>(~sum);
}

constexpr std::uint8_t sum_with_header(std::uint8_t spec) {
  return static_cast<std::uint8_t>(spec - kHead - kSecond);
}

void put_u16(FrameBytes& out, std::uint16_t word) {
  out.push_back(static_cast<std::uint8_t>(word & 0xFFU));
  out.push_back(static_cast<std::uint8_t>(word >> 8U));
}

void put_i16(FrameBytes& out, std::int16_t word) {
  put_u16(out, static_cast<std::uint16_t>(word));
}

std::uint16_t u16_at(std::span<const std::uint8_t> bytes, std::size_t word) {
  SINEW_ASSERT(2 * word + 1 < bytes.size());
  return static_cast<std::uint16_t>(bytes[2 * word] | bytes[2 * word + 1] << 8U);
}

std::array<std::int16_t, 3> three_i16(std::span<const std::uint8_t> bytes) {
  return {static_cast<std::int16_t>(u16_at(bytes, 0)), static_cast<std::int16_t>(u16_at(bytes, 1)),
          static_cast<std::int16_t>(u16_at(bytes, 2))};
}

FrameBytes begin(std::uint8_t function, std::uint8_t length) {
  return {kHead, kSecond, function, length};
}

Request parse_request(std::uint8_t function, std::span<const std::uint8_t> data) {
  switch (function) {
    case kSetAngle:
      return SetAngle{{u16_at(data, 0), u16_at(data, 1), u16_at(data, 2)}, u16_at(data, 3)};
    case kSetXyz:
      return SetXyz{three_i16(data), u16_at(data, 3)};
    case kSetPwmServo:
      return SetPwmServo{u16_at(data, 0), u16_at(data, 1)};
    case kSetSuction:
      return SetSuction{data[0]};
    case kReadAngle:
      return ReadAngle{};
    default:
      return ReadXyz{};
  }
}

}  // namespace

FrameBytes encode_request(const Request& request) {
  FrameBytes out;
  std::visit(Overload{[&](const SetAngle& m) {
                        out = begin(kSetAngle, 8);
                        for (const std::uint16_t pulse : m.pulses) put_u16(out, pulse);
                        put_u16(out, m.time_ms);
                      },
                      [&](const SetXyz& m) {
                        out = begin(kSetXyz, 8);
                        for (const std::int16_t mm : m.xyz_mm) put_i16(out, mm);
                        put_u16(out, m.time_ms);
                      },
                      [&](const SetPwmServo& m) {
                        out = begin(kSetPwmServo, 4);
                        put_u16(out, m.pulse_us);
                        put_u16(out, m.time_ms);
                      },
                      [&](const SetSuction& m) {
                        out = begin(kSetSuction, 1);
                        out.push_back(m.action);
                      },
                      [&](const ReadAngle&) { out = begin(kReadAngle, 0); },
                      [&](const ReadXyz&) { out = begin(kReadXyz, 0); }},
             request);
  out.push_back(sum_of(std::span<const std::uint8_t>(out).subspan(2)));
  return out;
}

FrameBytes encode_reply(const Reply& reply, Checksum checksum) {
  const auto* angles = std::get_if<Angles>(&reply);
  FrameBytes out = begin(angles != nullptr ? kReadAngle : kReadXyz, kReplyData);
  const auto& words = angles != nullptr ? angles->pulses : std::get<Position>(reply).xyz_mm;
  for (const std::int16_t word : words) put_i16(out, word);
  const std::uint8_t spec = sum_of(std::span<const std::uint8_t>(out).subspan(2));
  out.push_back(checksum == Checksum::kSpec ? spec : sum_with_header(spec));
  return out;
}

bool survives_one_fault(const FrameBytes& frame) {
  SINEW_ASSERT(frame.size() >= kAroundData);
  const std::uint8_t sum = frame.back();
  const auto inner = std::span<const std::uint8_t>(frame).subspan(3, frame.size() - 4);
  return std::ranges::none_of(inner, [&](std::uint8_t b) { return b == kHead || b == sum; });
}

bool survives_a_look(const FrameBytes& frame) {
  const FrameBytes question = encode_request(ReadAngle{});
  const FrameBytes mark = encode_request(ReadXyz{});
  constexpr std::array<std::uint8_t, 16> kZeros{};
  const auto mistaken = [](RequestDecoder& decoder, std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
      const auto request = decoder.push(byte);
      // Nothing of the frame is complete before its end, and what is cut is never itself again.
      if (request && request->index() < Request(ReadAngle{}).index()) return true;
    }
    return false;
  };
  const std::span<const std::uint8_t> bytes(frame);
  for (std::size_t cut = kAroundData; cut + 1 < frame.size(); ++cut) {
    RequestDecoder decoder;
    (void)mistaken(decoder, bytes.first(cut));
    decoder.begin_poll();
    if (mistaken(decoder, bytes.subspan(cut))) return false;
    for (const bool look_before_question : {false, true}) {
      RequestDecoder later = decoder;
      if (look_before_question) later.begin_poll();
      if (mistaken(later, question)) return false;
      later.begin_poll();
      RequestDecoder other = later;
      if (mistaken(later, kZeros) || mistaken(other, mark)) return false;
    }
  }
  return true;
}

std::optional<ReplyFrame> ReplyDecoder::push(std::uint8_t byte) {
  bytes_.push_back(byte);
  while (!bytes_.empty() && !is_beginning()) drop_first();
  if (bytes_.size() < kReplyFrame) return std::nullopt;
  const std::span<const std::uint8_t> all(bytes_);
  const std::uint8_t spec = sum_of(all.subspan(2, kReplyFrame - 3));
  const bool with_header = bytes_.back() == sum_with_header(spec);
  if (bytes_.back() != spec && !with_header) {
    do drop_first();
    while (!bytes_.empty() && !is_beginning());
    return std::nullopt;
  }
  const auto words = three_i16(all.subspan(4, kReplyData));
  const bool angles = bytes_[2] == kReadAngle;
  bytes_.clear();
  return ReplyFrame{angles ? Reply{Angles{words}} : Reply{Position{words}},
                    with_header ? Checksum::kWithHeader : Checksum::kSpec};
}

void ReplyDecoder::drop_first() {
  bytes_.drop_front(1);
  ++skipped_;
}

bool ReplyDecoder::is_beginning() const {
  if (bytes_[0] != kHead) return false;
  if (bytes_.size() > 1 && bytes_[1] != kSecond) return false;
  if (bytes_.size() > 2 && bytes_[2] != kReadAngle && bytes_[2] != kReadXyz) return false;
  return bytes_.size() <= 3 || bytes_[3] == kReplyData;
}

std::optional<Request> RequestDecoder::push(std::uint8_t byte) {
  switch (step_) {
    case Step::kHead:
      if (byte == kHead) step_ = Step::kSecond;
      return std::nullopt;
    case Step::kSecond:
      step_ = byte == kSecond ? Step::kFunction : Step::kHead;
      return std::nullopt;
    case Step::kFunction:
      function_ = byte;
      step_ = data_length(byte) ? Step::kLength : Step::kHead;
      return std::nullopt;
    case Step::kLength:
      length_ = byte;
      data_.clear();
      if (byte != data_length(function_)) {
        step_ = Step::kHead;
      } else {
        step_ = byte == 0 ? Step::kSum : Step::kData;
      }
      return std::nullopt;
    case Step::kData:
      data_.push_back(byte);
      if (data_.size() == length_) {
        // The sum may come with the next look at the port, which forgets the count, not the bytes.
        sum_due_ = static_cast<std::uint8_t>(sum_of(data_) - function_ - length_);
        request_ = parse_request(function_, data_);
        step_ = Step::kSum;
      }
      return std::nullopt;
    case Step::kSum:
      break;
  }
  step_ = Step::kHead;
  if (length_ == 0) {
    sum_due_ = static_cast<std::uint8_t>(~function_);
    request_ = parse_request(function_, {});
  }
  if (byte != sum_due_) return std::nullopt;
  return request_;
}

void RequestDecoder::reset() {
  *this = RequestDecoder{};
}

}  // namespace sinew::maxarm
