#include "firmware/emulation/stm32_usart.h"

#include <algorithm>

namespace sinew::emulation {
namespace {

constexpr std::uint32_t kStatus = 0x00;
constexpr std::uint32_t kData = 0x04;
constexpr std::uint32_t kDivider = 0x08;
constexpr std::uint32_t kCr1 = 0x0C;
constexpr std::uint32_t kOverrun = 1U << 3;
constexpr std::uint32_t kReceived = 1U << 5;
constexpr std::uint32_t kAllSent = 1U << 6;
constexpr std::uint32_t kEmpty = 1U << 7;
constexpr std::uint32_t kOn = 1U << 13;
constexpr std::uint32_t kSends = 1U << 3;
constexpr std::uint32_t kReceives = 1U << 2;
constexpr int kLine = 38;
constexpr Cycles kBits = 10;  // of a byte on the line

}  // namespace

void Stm32Usart::reset() {
  status_ = kAllSent | kEmpty;
  brr_ = cr1_ = 0;
  waits_ = false;
  sent_at_.reset();
  arrivals_.clear();
}

double Stm32Usart::baud() const {
  return brr_ == 0 ? 0 : static_cast<double>(bus_hz_) / brr_;
}

Cycles Stm32Usart::byte_time() const {
  return kBits * brr_ * (core_.clock_hz() / bus_hz_);
}

/// An interrupt whose flag is up and whose bit in CR1 is set, which has the same number.
void Stm32Usart::raise_due() {
  const bool overrun = (status_ & kOverrun) != 0 && (cr1_ & kReceived) != 0;
  if (overrun || (status_ & cr1_ & (kReceived | kAllSent | kEmpty)) != 0) core_.raise(kLine);
}

void Stm32Usart::begin_byte() {
  shifting_ = waiting_;
  waits_ = false;
  status_ |= kEmpty;
  sent_at_ = core_.now() + byte_time();
}

std::uint32_t Stm32Usart::read(std::uint32_t offset) {
  if (offset == kStatus) return status_;
  if (offset == kDivider) return brr_;
  if (offset == kCr1) return cr1_;
  if (offset != kData) return 0;
  status_ &= ~(kReceived | kOverrun);
  return received_;
}

void Stm32Usart::write(std::uint32_t offset, std::uint32_t value) {
  if (offset == kDivider) brr_ = value;
  if (offset == kCr1) cr1_ = value;
  if (offset == kData && (cr1_ & (kOn | kSends)) == (kOn | kSends) && brr_ != 0) {
    waiting_ = static_cast<std::uint8_t>(value);
    waits_ = true;
    status_ &= ~(kEmpty | kAllSent);
    if (!sent_at_) begin_byte();
  }
  raise_due();
  core_.look_again();
}

void Stm32Usart::arrive(std::uint8_t byte) {
  const Cycles from = std::max(core_.now(), arrivals_.empty() ? 0 : arrivals_.back().at);
  arrivals_.push_back({from + byte_time(), byte});
  core_.look_again();
}

std::optional<Cycles> Stm32Usart::next_event() const {
  std::optional<Cycles> next = sent_at_;
  if (!arrivals_.empty()) next = std::min(next.value_or(arrivals_[0].at), arrivals_[0].at);
  return next;
}

void Stm32Usart::advance(Cycles now) {
  if (sent_at_ && *sent_at_ <= now) {
    const std::uint8_t byte = shifting_;
    const Cycles at = *sent_at_;
    sent_at_.reset();
    if (waits_) begin_byte();
    if (!sent_at_) status_ |= kAllSent;
    on_byte(at, byte);
  }
  while (!arrivals_.empty() && arrivals_[0].at <= now) {
    const std::uint8_t byte = arrivals_[0].byte;
    arrivals_.pop_front();
    if ((cr1_ & (kOn | kReceives)) != (kOn | kReceives)) continue;
    // What was not read in time stays, and the new one is lost.
    status_ |= (status_ & kReceived) != 0 ? kOverrun : kReceived;
    if ((status_ & kOverrun) == 0) received_ = byte;
  }
  raise_due();
}

}  // namespace sinew::emulation
