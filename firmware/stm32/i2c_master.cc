#include "firmware/stm32/i2c_master.h"

#include "firmware/stm32/pins.h"

namespace sinew::stm32 {
namespace {

// CR1
constexpr std::uint32_t kOn = 1;
constexpr std::uint32_t kStart = 1U << 8;
constexpr std::uint32_t kStop = 1U << 9;
constexpr std::uint32_t kAcknowledge = 1U << 10;
constexpr std::uint32_t kReset = 1U << 15;
// SR1
constexpr std::uint32_t kStarted = 1;
constexpr std::uint32_t kAddressSent = 1U << 1;
constexpr std::uint32_t kByteDone = 1U << 2;
constexpr std::uint32_t kReceived = 1U << 6;
constexpr std::uint32_t kEmpty = 1U << 7;
constexpr std::uint32_t kFailed = 0b111U << 8;  // BERR, ARLO, AF

/// Turns of a waiting loop, of some ten cycles each: 0.5 ms and more. A byte takes 23 us.
constexpr int kPatience = 4000;
constexpr std::uint32_t kHalfClock = chip::kClockHz / 200'000 / 4;  // turns of 5 us

void pause() {
  for (std::uint32_t i = 0; i < kHalfClock; ++i) asm volatile("nop");
}

}  // namespace

void I2cMaster::start() {
  free_bus();
  for (const Pin& pin : {clock_, data_}) {
    chip::set_pin(pin.place.port, pin.place.pin, chip::Pin::kFunctionOpenDrain, pin.function);
  }
  i2c().cr1 = kReset;
  i2c().cr1 = 0;
  i2c().cr2 = chip::kSlowBusHz / 1'000'000;
  constexpr std::uint32_t kFast = 1U << 15;
  i2c().ccr = kFast | (chip::kSlowBusHz + 3 * 400'000 - 1) / (3 * 400'000);
  i2c().trise = chip::kSlowBusHz / 1'000'000 * 300 / 1000 + 1;
  i2c().cr1 = kOn;
}

/// A chip that lost count in the middle of a byte releases the data line after nine clocks.
void I2cMaster::free_bus() {
  const board::Place clock = clock_.place;
  chip::set_pin(data_.place.port, data_.place.pin, chip::Pin::kInputPullUp);
  for (int i = 0; i < 9 && !level(data_.place); ++i) {
    set_output(clock, false);
    pause();
    chip::set_pin(clock.port, clock.pin, chip::Pin::kInputPullUp);
    pause();
  }
}

bool I2cMaster::wait(std::uint32_t flag) {
  for (int i = 0; i < kPatience; ++i) {
    const std::uint32_t status = i2c().sr1;
    if ((status & kFailed) != 0) return false;
    if ((status & flag) != 0) return true;
  }
  stuck_ = true;
  return false;
}

bool I2cMaster::give_up() {
  i2c().sr1 = 0;
  i2c().cr1 |= kStop;
  return false;
}

bool I2cMaster::begin(std::uint8_t address_byte) {
  if (stuck_) {
    start();
    stuck_ = false;
  }
  // The stop of the transaction before is still under way.
  for (int i = 0; (i2c().cr1 & kStop) != 0; ++i) {
    if (i > kPatience) {
      stuck_ = true;
      return false;
    }
  }
  i2c().cr1 |= kStart | kAcknowledge;
  if (!wait(kStarted)) return false;
  i2c().dr = address_byte;
  if (!wait(kAddressSent)) return false;
  static_cast<void>(i2c().sr2);  // which takes the flag back
  return true;
}

bool I2cMaster::write(std::uint8_t address, std::span<const std::uint8_t> bytes) {
  if (!begin(static_cast<std::uint8_t>(address << 1))) return give_up();
  for (const std::uint8_t byte : bytes) {
    if (!wait(kEmpty)) return give_up();
    i2c().dr = byte;
  }
  if (!wait(kByteDone)) return give_up();
  i2c().cr1 |= kStop;
  return true;
}

/// The last three bytes as RM0008 26.3.3 has it: the chip takes a byte ahead of the program.
bool I2cMaster::read(std::uint8_t address, std::span<std::uint8_t> out) {
  if (!begin(static_cast<std::uint8_t>(address << 1 | 1))) return give_up();
  std::uint8_t bytes[8];
  if (out.size() < 3 || out.size() > sizeof bytes) return give_up();
  const std::size_t last = out.size() - 1;
  for (std::size_t i = 0; i + 3 < out.size(); ++i) {
    if (!wait(kReceived)) return give_up();
    bytes[i] = static_cast<std::uint8_t>(i2c().dr);
  }
  if (!wait(kByteDone)) return give_up();
  i2c().cr1 &= ~kAcknowledge;
  bytes[last - 2] = static_cast<std::uint8_t>(i2c().dr);
  if (!wait(kByteDone)) return give_up();
  i2c().cr1 |= kStop;
  bytes[last - 1] = static_cast<std::uint8_t>(i2c().dr);
  if (!wait(kReceived)) return give_up();
  bytes[last] = static_cast<std::uint8_t>(i2c().dr);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = bytes[i];
  return true;
}

}  // namespace sinew::stm32
