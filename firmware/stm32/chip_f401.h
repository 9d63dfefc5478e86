#pragma once

#include "firmware/stm32/registers.h"

/// What only the STM32F401 has in this way; addresses and bits from RM0368.
namespace sinew::stm32::chip {

inline constexpr std::uint32_t kClockHz = 84'000'000;    ///< of the core, and of all timers
inline constexpr std::uint32_t kSlowBusHz = 42'000'000;  ///< APB1: I2C, USART2

inline Timer& tim1() {
  return at<Timer>(0x4001'0000);
}
inline ExternalInterrupts& exti() {
  return at<ExternalInterrupts>(0x4001'3C00);
}

struct Gpio {
  Register moder, otyper, ospeedr, pupdr, idr, odr, bsrr, lckr, afr[2];
};
inline Gpio& gpio(char port) {
  return at<Gpio>(0x4002'0000 + 0x400 * static_cast<std::uint32_t>(port - 'A'));
}

struct ClockControl {
  Register cr, pllcfgr, cfgr, cir, ahb1rstr, ahb2rstr, unused1[2], apb1rstr, apb2rstr, unused2[2],
      ahb1enr, ahb2enr, unused3[2], apb1enr, apb2enr;
};
inline ClockControl& rcc() {
  return at<ClockControl>(0x4002'3800);
}
inline Register& spi_reset() {
  return rcc().apb2rstr;
}
inline constexpr std::uint32_t kSpiResetBit = 1 << 12;

/// Pins can be set, and nothing else: before the clocks.
inline void start_pins() {
  rcc().ahb1enr |= 0b111U;  // GPIO A to C
}

/// 84 MHz from the inner 16 MHz oscillator, two wait states, all that the board uses switched on.
inline void start_clocks() {
  at<Register>(0x4002'3C00) = 0x702;  // FLASH_ACR: caches, prefetch, 2 wait states
  rcc().pllcfgr = 7U << 24 | 1U << 16 | 336U << 6 | 16U;
  rcc().cr |= 1U << 24;
  while ((rcc().cr & 1U << 25) == 0) {
  }
  rcc().cfgr = 0b100U << 10 | 0b10U;
  while ((rcc().cfgr & 0b1100U) != 0b1000U) {
  }
  rcc().ahb1enr |= 1U << 22;                         // DMA2
  rcc().apb1enr |= 0b111U | 0b11U << 21 | 1U << 28;  // TIM2 to TIM4, I2C1, I2C2, PWR
  rcc().apb2enr |= 1U << 0 | 1U << 12 | 1U << 14;    // TIM1, SPI1, SYSCFG
}

enum class Pin : std::uint8_t {
  kInput,
  kInputPullUp,
  kOutput,
  kFunction,
  kFunctionOpenDrain,
  kFunctionInput,  ///< a peripheral listens there
};

/// @param function  number of the alternate function
inline void set_pin(char port, unsigned pin, Pin kind, unsigned function = 0) {
  Gpio& block = gpio(port);
  const auto two_bits = [&](Register& where, unsigned value) {
    where = (where & ~(0b11U << 2 * pin)) | value << 2 * pin;
  };
  two_bits(block.ospeedr, 0b10);
  const bool driven = kind == Pin::kOutput || kind == Pin::kFunction || kind == Pin::kInput;
  two_bits(block.pupdr, driven ? 0 : 0b01);
  if (kind == Pin::kFunctionOpenDrain) block.otyper |= 1U << pin;
  block.afr[pin / 8] = (block.afr[pin / 8] & ~(0xFU << 4 * (pin % 8))) | function << 4 * (pin % 8);
  const bool plain = kind == Pin::kInput || kind == Pin::kInputPullUp;
  two_bits(block.moder, plain ? 0 : kind == Pin::kOutput ? 0b01 : 0b10);
}
inline constexpr unsigned kTimer1Function = 1;
inline constexpr unsigned kTimer2Function = 1;
inline constexpr unsigned kI2cFunction = 4;
inline constexpr unsigned kJointDataFunction = 9;
inline constexpr char kJointDataPort = 'B';
inline constexpr unsigned kJointDataPin = 3;
inline constexpr unsigned kSpiFunction = 5;
inline constexpr unsigned kSerialFunction = 7;

/// The port whose pin `pin` interrupts.
inline void choose_interrupt(unsigned pin, char port) {
  Register& where = at<Register>(0x4001'3808 + 4 * (pin / 4));
  where = (where & ~(0xFU << 4 * (pin % 4))) | static_cast<std::uint32_t>(port - 'A')
                                                   << 4 * (pin % 4);
}

struct DmaStream {
  Register cr, ndtr, par, m0ar, m1ar, fcr;
};
inline DmaStream& dma2(unsigned stream) {
  return at<DmaStream>(0x4002'6410 + 0x18 * stream);
}

/// The two streams of SPI1: 0 takes what comes, 3 gives what goes, both on channel 3.
class SpiDma {
 public:
  static void stop() {
    dma2(0).cr = 0;
    dma2(3).cr = 0;
    while (((dma2(0).cr | dma2(3).cr) & 1) != 0) {
    }
    at<Register>(0x4002'6408) = 0x0F40'003D;  // LIFCR: flags of streams 0 and 3
  }
  static void start(std::uint8_t* in, const std::uint8_t* out, std::uint32_t size) {
    constexpr std::uint32_t kChannel3 = 3U << 25;
    constexpr std::uint32_t kCountUp = 1U << 10;
    constexpr std::uint32_t kOutwards = 1U << 6;
    const auto data = reinterpret_cast<std::uint32_t>(&spi1().dr);
    dma2(0).par = data;
    dma2(0).m0ar = reinterpret_cast<std::uint32_t>(in);
    dma2(0).ndtr = size;
    dma2(0).cr = kChannel3 | kCountUp | 2U << 16 | 1;
    dma2(3).par = data;
    dma2(3).m0ar = reinterpret_cast<std::uint32_t>(out);
    dma2(3).ndtr = size;
    dma2(3).cr = kChannel3 | kCountUp | kOutwards | 2U << 16 | 1;
  }
  static std::uint32_t left_to_take() { return dma2(0).ndtr; }
};

/// Registers that keep their value over a reset, not without power. @param number  0..9
inline Register& backup(unsigned number) {
  power().cr |= 1U << 8;  // DBP
  return at<Register>(0x4000'2850 + 4 * number);
}

/// Flash that the program writes, RM0368 3.6: words, into an erased sector.
class Flash {
 public:
  using Unit = std::uint32_t;

  static void unlock() {
    registers().keyr = 0x4567'0123;
    registers().keyr = 0xCDEF'89AB;
  }
  static void lock() {
    registers().cr = 1U << 31;
    // The data cache may hold what stood there before.
    registers().acr &= ~(1U << 10);
    registers().acr |= 1U << 12;
    registers().acr &= ~(1U << 12);
    registers().acr |= 1U << 10;
  }
  static bool erase(int which, std::uint32_t /*address*/) {
    const std::uint32_t sector = which == 0 ? 4 : 5;
    registers().cr = kWords | 1U << 1 | sector << 3;
    registers().cr = kWords | 1U << 1 | sector << 3 | 1U << 16;
    return wait();
  }
  static bool write(std::uint32_t address, Unit unit) {
    registers().cr = kWords | 1;
    at<volatile Unit>(address) = unit;
    return wait();
  }

 private:
  static constexpr std::uint32_t kWords = 0b10U << 8;
  struct Registers {
    Register acr, keyr, optkeyr, sr, cr;
  };
  static Registers& registers() { return at<Registers>(0x4002'3C00); }
  static bool wait() {
    while ((registers().sr & 1U << 16) != 0) {
    }
    constexpr std::uint32_t kErrors = 0b1111U << 4;  // WRPERR, PGAERR, PGPERR, PGSERR
    const bool failed = (registers().sr & kErrors) != 0;
    registers().sr = kErrors | 1;
    return !failed;
  }
};
inline constexpr std::uint32_t kSetupPlaces[] = {0x0801'0000, 0x0802'0000};

}  // namespace sinew::stm32::chip
