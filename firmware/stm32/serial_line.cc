#include "firmware/stm32/serial_line.h"

#include <algorithm>

#include "firmware/stm32/pins.h"

// Bits from RM0008 27.6 and RM0368 19.6.

namespace sinew::stm32 {
namespace {

constexpr std::uint32_t kBaud = 115'200;
// SR
constexpr std::uint32_t kBadByte = 0b111U;  // parity, framing, noise
constexpr std::uint32_t kOverrun = 1U << 3;
constexpr std::uint32_t kReceived = 1U << 5;
constexpr std::uint32_t kAllSent = 1U << 6;
constexpr std::uint32_t kEmpty = 1U << 7;
// CR1: the interrupt of a flag has the flag's number.
constexpr std::uint32_t kListening = 1U << 13 | 1U << 3 | 1U << 2 | kReceived;

}  // namespace

void SerialLine::start() {
  chip::rcc().apb1enr |= 1U << 17;
  set_output(board::kLineDriver, false);
  chip::set_pin(board::kLineOut.port, board::kLineOut.pin, chip::Pin::kFunction,
                chip::kSerialFunction);
  chip::set_pin(board::kLineIn.port, board::kLineIn.pin, chip::Pin::kFunctionInput,
                chip::kSerialFunction);
  usart2().brr = (chip::kSlowBusHz + kBaud / 2) / kBaud;
  usart2().cr1 = kListening;
  enable(Line::kUsart2, 3);
}

void SerialLine::send(std::span<const std::uint8_t> bytes) {
  const InterruptsOff off;
  std::ranges::copy(bytes, out_.begin());
  out_size_ = static_cast<std::uint8_t>(bytes.size());
  sent_ = 0;
  sending_ = true;
  set_level(board::kLineDriver, true);
  usart2().cr1 = kListening | kEmpty;
}

std::size_t SerialLine::take(std::span<std::uint8_t> out) {
  const InterruptsOff off;
  std::size_t size = 0;
  for (; tail_ != head_ && size < out.size(); ++tail_) out[size++] = in_[tail_ % kRing];
  return size;
}

void SerialLine::on_interrupt() {
  const std::uint32_t status = usart2().sr;
  if ((status & (kReceived | kOverrun)) != 0) {
    const auto byte = static_cast<std::uint8_t>(usart2().dr);
    const bool full = static_cast<std::uint8_t>(head_ - tail_) == kRing;
    if (!sending_ && !full && (status & kBadByte) == 0) in_[head_++ % kRing] = byte;
  }
  if (!sending_) return;
  if (sent_ < out_size_) {
    if ((status & kEmpty) == 0) return;
    usart2().dr = out_[sent_++];
    if (sent_ == out_size_) usart2().cr1 = kListening | kAllSent;
  } else if ((status & kAllSent) != 0) {
    usart2().cr1 = kListening;
    set_level(board::kLineDriver, false);
    sending_ = false;
  }
}

}  // namespace sinew::stm32
