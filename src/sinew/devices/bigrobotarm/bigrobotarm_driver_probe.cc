#include "sinew/devices/bigrobotarm/bigrobotarm_driver_probe.h"

#include <algorithm>
#include <utility>

namespace sinew {

using namespace bigrobotarm;

namespace {

constexpr std::uint8_t kQuestion = static_cast<std::uint8_t>(RequestId::kStatus);
/// From the ordinary quiet time up to 8 times it.
constexpr int kPatienceDoublings = 3;

}  // namespace

void BigRobotArmProbe::open(Instant now) {
  *this = BigRobotArmProbe(timing_);
  wait(timing_.quiet, now);
}

void BigRobotArmProbe::wait(Duration pause, Instant now) {
  asked_ = false;
  deadline_ = now + pause;
}

void BigRobotArmProbe::receive(std::span<const std::uint8_t> bytes, Instant now) {
  if (found_ || bytes.empty()) return;
  last_byte_ = bytes.back();
  if (!asked_) {  // the rest of something that was said before
    unexpected_ += bytes.size();
    wait(timing_.quiet, now);
    return;
  }
  for (const std::uint8_t byte : bytes) {
    ++unread_;
    const auto answer = take_byte(byte);
    if (!answer) continue;
    unread_ = 0;
    if (first_ == answer) {
      found_ = answer;
      deadline_.reset();
      return;
    }
    first_ = answer;
    silent_ = 0;
    wait(timing_.quiet, now);
    return;
  }
}

std::optional<BigRobotArmFound> BigRobotArmProbe::take_byte(std::uint8_t byte) {
  if (const auto reply = byte_decoder_.push(byte);
      reply && *reply && std::holds_alternative<Status>(**reply)) {
    return BigRobotArmFound{};
  }
  if (byte != '\n') {
    if (line_.full()) line_.clear();
    line_.push_back(static_cast<char>(byte));
    return std::nullopt;
  }
  std::string_view line = text::view(line_);
  if (line.ends_with(text::kLineEnd)) line.remove_suffix(1);
  const auto answer = take_line(line);
  line_.clear();
  return answer;
}

std::optional<BigRobotArmFound> BigRobotArmProbe::take_line(std::string_view raw) {
  const auto line = text::decode_reply_line(raw);
  if (line && std::holds_alternative<text::Ready>(*line) && invalid_) {
    return BigRobotArmFound{BigRobotArmWire::kText,
                            echoed_ ? BigRobotArmDialect::k2021 : BigRobotArmDialect::k2026};
  }
  const auto* echo = line ? std::get_if<text::Echo>(&*line) : nullptr;
  invalid_ = line && std::holds_alternative<Invalid>(*line);
  if (invalid_) return std::nullopt;
  echoed_ = echo != nullptr && std::all_of(echo->line.begin(), echo->line.end(),
                                           [](char one) { return one == kQuestion; });
  return std::nullopt;
}

void BigRobotArmProbe::poll(Instant now) {
  if (!deadline_ || now < *deadline_) return;
  if (asked_) {
    first_.reset();
    unexpected_ += std::exchange(unread_, 0);
    silent_ = std::min(silent_ + 1, kPatienceDoublings);
    wait(timing_.quiet * (1 << silent_), now);
    return;
  }
  byte_decoder_.reset();
  line_.clear();
  echoed_ = invalid_ = false;
  output_ = {kQuestion, byte::kTerminator};
  asked_ = true;
  deadline_ = now + timing_.reply_timeout;
}

std::size_t BigRobotArmProbe::take_output(std::span<std::uint8_t> out) {
  return output_.take_front(out);
}

}  // namespace sinew
