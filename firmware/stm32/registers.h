#pragma once

#include <cstdint>

/// Register blocks that the STM32F103 (RM0008) and the STM32F401 (RM0368) share, named as the
/// manuals name them; what differs between the two stands in chip_f103.h and chip_f401.h.
namespace sinew::stm32 {

using Register = volatile std::uint32_t;

struct Timer {
  Register cr1, cr2, smcr, dier, sr, egr, ccmr1, ccmr2, ccer, cnt, psc, arr, rcr, ccr1, ccr2, ccr3,
      ccr4, bdtr;
};
struct Spi {
  Register cr1, cr2, sr, dr;
};
struct I2c {
  Register cr1, cr2, oar1, oar2, dr, sr1, sr2, ccr, trise;
};
struct Usart {
  Register sr, dr, brr, cr1, cr2, cr3;
};
struct Power {
  Register cr, csr;
};
struct ExternalInterrupts {
  Register imr, emr, rtsr, ftsr, swier, pr;
};
struct Watchdog {
  Register kr, pr, rlr, sr;
};

template <class Block>
Block& at(std::uint32_t address) {
  return *reinterpret_cast<Block*>(address);
}

inline Timer& tim2() {
  return at<Timer>(0x4000'0000);
}
inline Timer& tim3() {
  return at<Timer>(0x4000'0400);
}
inline Timer& tim4() {
  return at<Timer>(0x4000'0800);
}
inline Power& power() {
  return at<Power>(0x4000'7000);
}
inline Watchdog& iwdg() {
  return at<Watchdog>(0x4000'3000);
}
inline constexpr std::uint32_t kI2c1 = 0x4000'5400;
inline constexpr std::uint32_t kI2c2 = 0x4000'5800;
inline Usart& usart2() {
  return at<Usart>(0x4000'4400);
}
inline Spi& spi1() {
  return at<Spi>(0x4001'3000);
}

/// Lines of the interrupt controller, the same on both.
enum class Line : std::uint8_t {
  kSupply = 1,
  kExti4 = 10,
  kTim4 = 30,
  kUsart2 = 38,
  kExti15To10 = 40
};

/// @param priority  0 (first) to 15
inline void enable(Line line, std::uint8_t priority) {
  const auto number = static_cast<std::uint32_t>(line);
  at<volatile std::uint8_t>(0xE000'E400 + number) = static_cast<std::uint8_t>(priority << 4);
  at<Register>(0xE000'E100 + 4 * (number / 32)) = 1U << number % 32;
}

/// As the reset pin does it: whatever timers make ends.
[[noreturn]] inline void restart() {
  at<Register>(0xE000'ED0C) = 0x05FA'0004;
  for (;;) {
  }
}

/// No interrupt comes while one of these lives.
class InterruptsOff {
 public:
  InterruptsOff() { asm volatile("mrs %0, primask\n cpsid i" : "=r"(before_)::"memory"); }
  ~InterruptsOff() { asm volatile("msr primask, %0" ::"r"(before_) : "memory"); }
  InterruptsOff(const InterruptsOff&) = delete;
  InterruptsOff& operator=(const InterruptsOff&) = delete;

 private:
  std::uint32_t before_;
};

}  // namespace sinew::stm32
