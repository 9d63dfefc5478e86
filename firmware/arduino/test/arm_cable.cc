#include "arm_cable.h"

#include <algorithm>
#include <cmath>

namespace sinew::arduino {

using emulation::AvrBoard;
using emulation::AvrChip;
namespace {

constexpr double kBit = AvrBoard::kHertz / 9600.0;  // cycles
constexpr int kBits = 10;                           // start, data, stop

std::uint64_t cycles(double bits) {
  return static_cast<std::uint64_t>(std::llround(bits * kBit));
}

}  // namespace

PinCable::PinCable(AvrBoard& board, char port, int tx, int rx)
    : board_(board), port_(port), rx_(rx) {
  board_.set_pin(port_, rx_, true);
  board_.on_pin(port_, tx, [this](bool level) { on_edge(level); });
}

void PinCable::on_edge(bool level) {
  if (level == level_) return;
  level_ = level;
  if (in_byte_) {
    const double at = static_cast<double>(board_.cycle() - start_) / kBit;
    edge_error_max_ = std::max(edge_error_max_, std::abs(at - std::round(at)));
    return;
  }
  if (level) return;
  in_byte_ = true;
  start_ = board_.cycle();
  bit_ = 0;
  bits_ = 0;
  board_.at_cycle(start_ + cycles(1.5), [this] { return sample(); });
}

std::optional<std::uint64_t> PinCable::sample() {
  if (bit_ < 8) {
    bits_ |= (level_ ? 1U : 0U) << bit_;
    ++bit_;
    return start_ + cycles(1.5 + bit_);
  }
  in_byte_ = false;
  if (!level_) {
    ++framing_errors_;
  } else if (received) {
    received(static_cast<std::uint8_t>(bits_));
  }
  return std::nullopt;
}

void PinCable::send(std::uint8_t byte) {
  queue_.push_back(byte);
  if (driving_) return;
  driving_ = true;
  out_bit_ = 0;
  out_start_ = board_.cycle() + 1;
  board_.at_cycle(out_start_, [this] { return drive(); });
}

std::optional<std::uint64_t> PinCable::drive() {
  if (out_bit_ == kBits) {
    queue_.pop_front();
    out_bit_ = 0;
    out_start_ += cycles(kBits);
    driving_ = !queue_.empty();
    if (!driving_) return std::nullopt;
  }
  const unsigned frame = 0x200U | static_cast<unsigned>(queue_.front()) << 1U;
  board_.set_pin(port_, rx_, ((frame >> out_bit_) & 1U) != 0);
  ++out_bit_;
  return out_start_ + cycles(out_bit_);
}

UartCable::UartCable(AvrBoard& board, char uart) : board_(board), uart_(uart) {
  board_.on_uart(uart_, [this](std::uint8_t byte) {
    if (received) received(byte);
  });
}

void UartCable::send(std::uint8_t byte) {
  queue_.push_back(byte);
  if (delivering_) return;
  delivering_ = true;
  board_.at_cycle(board_.cycle() + cycles(kBits), [this] { return deliver(); });
}

std::optional<std::uint64_t> UartCable::deliver() {
  board_.send_uart(uart_, queue_.front());
  queue_.pop_front();
  delivering_ = !queue_.empty();
  if (!delivering_) return std::nullopt;
  return board_.cycle() + cycles(kBits);
}

}  // namespace sinew::arduino
