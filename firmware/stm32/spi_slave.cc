#include "firmware/stm32/spi_slave.h"

#include <algorithm>

#include "firmware/stm32/pins.h"

namespace sinew::stm32 {
namespace {

constexpr std::uint32_t kOn = 1U << 6;       // CR1: SPE; all else 0: slave, mode 0, NSS by its pin
constexpr std::uint32_t kBothByDma = 0b11U;  // CR2: TXDMAEN, RXDMAEN

}  // namespace

void SpiSlave::start() {
  for (const board::Place pin : {board::kSelect, board::kClock, board::kMosi}) {
    chip::set_pin(pin.port, pin.pin, chip::Pin::kFunctionInput, chip::kSpiFunction);
  }
  chip::set_pin(board::kMiso.port, board::kMiso.pin, chip::Pin::kFunction, chip::kSpiFunction);
  chip::choose_interrupt(board::kSelect.pin, board::kSelect.port);
  chip::exti().rtsr |= 1U << board::kSelect.pin;
  chip::exti().imr |= 1U << board::kSelect.pin;
  arm();
  enable(Line::kExti4, 2);
}

/// A byte that waits to be sent can only be taken back by resetting the whole block.
void SpiSlave::arm() {
  chip::SpiDma::stop();
  chip::spi_reset() |= chip::kSpiResetBit;
  chip::spi_reset() &= ~chip::kSpiResetBit;
  spi1().cr2 = kBothByDma;
  chip::SpiDma::start(in_.data(), out_.data(), kTransferMax);
  spi1().cr1 = kOn;
}

void SpiSlave::on_deselect() {
  chip::exti().pr = 1U << board::kSelect.pin;
  const auto size = static_cast<std::uint8_t>(kTransferMax - chip::SpiDma::left_to_take());
  // A queue that is full loses the newest: the host hears no answer to it, as to a lost frame.
  if (size > 0 && head_ - tail_ < kQueue) {
    Transfer& transfer = queue_[head_ % kQueue];
    transfer.bytes = in_;
    transfer.size = size;
    head_ = head_ + 1;
  }
  arm();
}

std::span<const std::uint8_t> SpiSlave::received() const {
  const InterruptsOff off;
  if (head_ == tail_) return {};
  const Transfer& transfer = queue_[tail_ % kQueue];
  return {transfer.bytes.data(), transfer.size};
}

void SpiSlave::taken() {
  const InterruptsOff off;
  tail_ = tail_ + 1;
}

void SpiSlave::offer(std::span<const std::uint8_t, kTransferMax> answer) {
  const InterruptsOff off;
  if (std::ranges::equal(answer, out_)) return;
  // A transfer that runs, or one that has just ended and was not put aside yet, has the old one.
  const bool selected = !level(board::kSelect);
  if (selected || chip::SpiDma::left_to_take() != kTransferMax) return;
  std::ranges::copy(answer, out_.begin());
  arm();
}

}  // namespace sinew::stm32
