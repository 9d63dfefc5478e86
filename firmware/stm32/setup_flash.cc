#include "firmware/stm32/setup_flash.h"

#include "firmware/stm32/chip.h"

namespace sinew::stm32 {
namespace {

constexpr std::uint32_t kPlaceSize = 1024;

// Of an oscillator of 32 kHz: 1 ms and 8 ms a count.
void set_watchdog(std::uint32_t prescaler, std::uint32_t counts) {
  iwdg().kr = 0x5555;
  iwdg().pr = prescaler;
  iwdg().rlr = counts;
  // Both values cross into the clock of 32 kHz first.
  for (int i = 0; i < 10'000 && iwdg().sr != 0; ++i) {
  }
  feed_watchdog();
}
void expect_the_loop() {
  set_watchdog(3, 100);
}
void expect_the_flash() {
  set_watchdog(6, 0xFFF);
}

std::uint32_t address_of(int which) {
  return chip::kSetupPlaces[which == 0 ? 0 : 1];
}

}  // namespace

void start_watchdog() {
  iwdg().kr = 0xCCCC;
  expect_the_loop();
}

void feed_watchdog() {
  iwdg().kr = 0xAAAA;
}

std::span<const std::uint8_t> SetupFlash::place(int which) const {
  return {reinterpret_cast<const std::uint8_t*>(address_of(which)), kPlaceSize};
}

bool SetupFlash::erase(int which) {
  steps_.stop();
  expect_the_flash();
  chip::Flash::unlock();
  const bool done = chip::Flash::erase(which, address_of(which));
  chip::Flash::lock();
  expect_the_loop();
  return done;
}

bool SetupFlash::append(int which, std::span<const std::uint8_t> bytes) {
  steps_.stop();
  chip::Flash::unlock();
  bool done = true;
  constexpr std::size_t kUnit = sizeof(chip::Flash::Unit);
  for (std::size_t i = 0; done && i < bytes.size(); i += kUnit) {
    chip::Flash::Unit unit = 0;
    for (std::size_t k = 0; k < kUnit && i + k < bytes.size(); ++k) {
      unit = static_cast<chip::Flash::Unit>(unit | chip::Flash::Unit{bytes[i + k]} << 8 * k);
    }
    done = chip::Flash::write(address_of(which) + static_cast<std::uint32_t>(i), unit);
  }
  chip::Flash::lock();
  return done;
}

}  // namespace sinew::stm32
