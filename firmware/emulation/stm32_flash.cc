#include "firmware/emulation/stm32_flash.h"

namespace sinew::emulation {
namespace {

constexpr std::uint32_t kKeys = 0x04;
constexpr std::uint32_t kStatus = 0x0C;
constexpr std::uint32_t kControl = 0x10;
constexpr std::uint32_t kAddress = 0x14;  // F103
constexpr std::uint32_t kFlash = 0x0800'0000;
constexpr std::uint32_t kPage = 1024;  // F103
constexpr double kPageErase = 0.03;    // s, F103 data sheet: 20 to 40 ms
constexpr double kSectorErase = 1.0;   // s, F401 data sheet: 0.55 to 2 s
constexpr double kProgram = 60e-6;     // s, both

}  // namespace

Stm32Flash::Stm32Flash(CortexM& core, bool is_f103) : core_(core), is_f103_(is_f103) {
  core_.on_flash_write = [this](std::uint32_t address, std::uint32_t value, unsigned size) {
    program(address, value, size);
  };
  reset();
}

void Stm32Flash::reset() {
  word_ = {};
  word_[kControl / 4] = is_f103_ ? 1U << 7 : 1U << 31;
  keys_ = 0;
  power_cut_ = false;
}

bool Stm32Flash::locked() const {
  return (word_[kControl / 4] & (is_f103_ ? 1U << 7 : 1U << 31)) != 0;
}

bool Stm32Flash::cut_now() {
  ++operations_;
  if (!cut_in_ || (*cut_in_)-- > 0) return false;
  cut_in_.reset();
  power_cut_ = true;
  core_.stop();
  return true;
}

void Stm32Flash::write(std::uint32_t offset, std::uint32_t value) {
  if (offset == kStatus) return;  // flags of errors that never happen here
  if (offset == kKeys) {
    constexpr std::uint32_t kSequence[] = {0x4567'0123, 0xCDEF'89AB};
    keys_ = value == kSequence[keys_ % 2] ? keys_ + 1 : 0;
    if (keys_ == 2) word_[kControl / 4] = 0, keys_ = 0;
    return;
  }
  if (offset == kControl && locked()) return;
  word_[offset / 4] = value;
  if (offset != kControl) return;
  if (is_f103_ && (value & 0b100'0010) == 0b100'0010) {
    erase(word_[kAddress / 4] / kPage * kPage, kPage, kPageErase);
  }
  if (!is_f103_ && (value & (1U << 16 | 1U << 1)) == (1U << 16 | 1U << 1)) {
    const std::uint32_t sector = value >> 3 & 0xF;
    constexpr std::uint32_t kKilobyte = 1024;
    const std::uint32_t begin = sector < 4    ? 16 * kKilobyte * sector
                                : sector == 4 ? 64 * kKilobyte
                                              : 128 * kKilobyte * (sector - 4);
    const std::uint32_t size = (sector < 4 ? 16 : sector == 4 ? 64 : 128) * kKilobyte;
    erase(kFlash + begin, size, kSectorErase);
  }
}

/// One that is cut short has erased the first half.
void Stm32Flash::erase(std::uint32_t address, std::uint32_t size, double seconds) {
  const bool cut = cut_now();
  for (std::uint32_t i = 0; i < (cut ? size / 2 : size); ++i) core_.store_byte(address + i, 0xFF);
  core_.stall(static_cast<Cycles>(seconds * core_.clock_hz()));
}

/// Called before the write itself; one that is cut short leaves the upper byte as it was.
void Stm32Flash::program(std::uint32_t address, std::uint32_t value, unsigned size) {
  if (locked() || (word_[kControl / 4] & 1) == 0) return core_.fail("the flash was locked");
  if (size != (is_f103_ ? 2U : 4U)) return core_.fail("the flash takes another width");
  for (unsigned i = 0; i < size; ++i) {
    if (core_.load_byte(address + i) != 0xFF) return core_.fail("the flash was not erased");
  }
  core_.stall(static_cast<Cycles>(kProgram * core_.clock_hz()));
  if (!cut_now()) return;
  core_.after_stop([this, address, value, size] {
    for (unsigned i = 0; i < size; ++i) {
      const bool made = i + 1 < size;
      core_.store_byte(address + i, made ? static_cast<std::uint8_t>(value >> 8 * i) : 0xFF);
    }
  });
}

}  // namespace sinew::emulation
