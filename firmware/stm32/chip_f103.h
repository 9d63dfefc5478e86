#pragma once

#include "firmware/stm32/registers.h"

/// What only the STM32F103 has in this way; addresses and bits from RM0008.
namespace sinew::stm32::chip {

inline constexpr std::uint32_t kClockHz = 72'000'000;    ///< of the core, and of all timers
inline constexpr std::uint32_t kSlowBusHz = 36'000'000;  ///< APB1: I2C, USART2

inline Timer& tim1() {
  return at<Timer>(0x4001'2C00);
}
inline ExternalInterrupts& exti() {
  return at<ExternalInterrupts>(0x4001'0400);
}

struct Gpio {
  Register crl, crh, idr, odr, bsrr, brr, lckr;
};
inline Gpio& gpio(char port) {
  return at<Gpio>(0x4001'0800 + 0x400 * static_cast<std::uint32_t>(port - 'A'));
}

struct ClockControl {
  Register cr, cfgr, cir, apb2rstr, apb1rstr, ahbenr, apb2enr, apb1enr;
};
inline ClockControl& rcc() {
  return at<ClockControl>(0x4002'1000);
}
inline Register& spi_reset() {
  return rcc().apb2rstr;
}
inline constexpr std::uint32_t kSpiResetBit = 1 << 12;

/// Pins can be set, and nothing else: before the clocks, which may not come.
inline void start_pins() {
  rcc().apb2enr |= 1U << 0 | 0b111U << 2;  // AFIO, GPIO A to C
}

/// 72 MHz from the crystal of 8 MHz, two wait states, all that the board uses switched on. Without
/// its crystal it stays here, and the watchdog begins anew.
inline void start_clocks() {
  at<Register>(0x4002'2000) = 0b1'0010;  // FLASH_ACR: prefetch, 2 wait states
  rcc().cr |= 1U << 16;
  while ((rcc().cr & 1U << 17) == 0) {
  }
  rcc().cfgr = 7U << 18 | 1U << 16 | 0b100U << 8;  // x 9 from the crystal; APB1 at half
  rcc().cr |= 1U << 24;
  while ((rcc().cr & 1U << 25) == 0) {
  }
  rcc().cfgr |= 0b10U;
  while ((rcc().cfgr & 0b1100U) != 0b1000U) {
  }
  rcc().ahbenr |= 1;                                 // DMA1
  rcc().apb2enr |= 1U << 11 | 1U << 12;              // TIM1, SPI1
  rcc().apb1enr |= 0b111U | 0b11U << 21 | 1U << 28;  // TIM2 to TIM4, I2C1, I2C2, PWR
}

enum class Pin : std::uint8_t {
  kInput,
  kInputPullUp,
  kOutput,
  kFunction,
  kFunctionOpenDrain,
  kFunctionInput,  ///< a peripheral listens there
};

/// An alternate function needs no number here.
inline void set_pin(char port, unsigned pin, Pin kind, unsigned /*function*/ = 0) {
  constexpr std::uint32_t kModes[] = {0b0100, 0b1000, 0b0001, 0b1011, 0b1101, 0b1000};
  Gpio& block = gpio(port);
  Register& where = pin < 8 ? block.crl : block.crh;
  const unsigned shift = 4 * (pin % 8);
  if (kind == Pin::kInputPullUp || kind == Pin::kFunctionInput) block.bsrr = 1U << pin;
  where = (where & ~(0xFU << shift)) | kModes[static_cast<int>(kind)] << shift;
}
inline constexpr unsigned kTimer1Function = 0;
inline constexpr unsigned kTimer2Function = 0;
inline constexpr unsigned kI2cFunction = 0;
inline constexpr unsigned kJointDataFunction = 0;
inline constexpr char kJointDataPort = 'B';
inline constexpr unsigned kJointDataPin = 11;
inline constexpr unsigned kSpiFunction = 0;
inline constexpr unsigned kSerialFunction = 0;

/// The port whose pin `pin` interrupts.
inline void choose_interrupt(unsigned pin, char port) {
  Register& where = at<Register>(0x4001'0008 + 4 * (pin / 4));
  where = (where & ~(0xFU << 4 * (pin % 4))) | static_cast<std::uint32_t>(port - 'A')
                                                   << 4 * (pin % 4);
}

struct DmaChannel {
  Register ccr, cndtr, cpar, cmar;
};
/// @param channel  1..7
inline DmaChannel& dma1(unsigned channel) {
  return at<DmaChannel>(0x4002'0008 + 0x14 * (channel - 1));
}

/// The two channels of SPI1: 2 takes what comes, 3 gives what goes.
class SpiDma {
 public:
  static void stop() {
    dma1(2).ccr = 0;
    dma1(3).ccr = 0;
    at<Register>(0x4002'0004) = 0xFF0;  // IFCR
  }
  static void start(std::uint8_t* in, const std::uint8_t* out, std::uint32_t size) {
    constexpr std::uint32_t kCountUp = 1U << 7;
    constexpr std::uint32_t kOutwards = 1U << 4;
    const auto data = reinterpret_cast<std::uint32_t>(&spi1().dr);
    dma1(2).cpar = data;
    dma1(2).cmar = reinterpret_cast<std::uint32_t>(in);
    dma1(2).cndtr = size;
    dma1(2).ccr = kCountUp | 2U << 12 | 1;
    dma1(3).cpar = data;
    dma1(3).cmar = reinterpret_cast<std::uint32_t>(out);
    dma1(3).cndtr = size;
    dma1(3).ccr = kCountUp | kOutwards | 2U << 12 | 1;
  }
  static std::uint32_t left_to_take() { return dma1(2).cndtr; }
};

/// Registers that keep their value over a reset, not without power. @param number  0..9
inline Register& backup(unsigned number) {
  rcc().apb1enr |= 1U << 27;  // BKP
  power().cr |= 1U << 8;      // DBP
  return at<Register>(0x4000'6C04 + 4 * number);
}

/// Flash that the program writes, RM0008 and PM0075: half words, into an erased page.
class Flash {
 public:
  using Unit = std::uint16_t;

  static void unlock() {
    registers().keyr = 0x4567'0123;
    registers().keyr = 0xCDEF'89AB;
  }
  static void lock() { registers().cr = 1U << 7; }
  static bool erase(int /*which*/, std::uint32_t address) {
    registers().cr = 1U << 1;
    registers().ar = address;
    registers().cr = 1U << 1 | 1U << 6;
    return wait();
  }
  static bool write(std::uint32_t address, Unit unit) {
    registers().cr = 1;
    at<volatile Unit>(address) = unit;
    return wait();
  }

 private:
  struct Registers {
    Register acr, keyr, optkeyr, sr, cr, ar;
  };
  static Registers& registers() { return at<Registers>(0x4002'2000); }
  static bool wait() {
    while ((registers().sr & 1) != 0) {
    }
    const bool failed = (registers().sr & (1U << 2 | 1U << 4)) != 0;  // PGERR, WRPRTERR
    registers().sr = 1U << 2 | 1U << 4 | 1U << 5;
    return !failed;
  }
};
inline constexpr std::uint32_t kSetupPlaces[] = {0x0800'F800, 0x0800'FC00};

}  // namespace sinew::stm32::chip
