#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/emulation_stm8/ucsim.h"

namespace sinew::emulation {

using Bytes = std::vector<std::uint8_t>;

/// What an image does with its chip, in the order in which it does it.
enum class Act : std::uint8_t {
  kReading = 1,      ///< the AS5600 begins to send: STATUS << 12 | angle
  kBusControl = 2,   ///< I2C_CR2 was written
  kSends = 3,        ///< UART1_DR was written
  kReceives = 4,     ///< UART1_DR was read
  kPortD = 5,        ///< PD_ODR was written: the driver's enable line
  kPortB = 6,        ///< PB_ODR was written: the I2C lines, with the peripheral off
  kWatchdogKey = 7,  ///< IWDG_KR was written
  kPortA = 8,        ///< PA_ODR was written: the lamp
  kTick = 9,         ///< TIM4_SR was written: 1 by the timer, 0 by its interrupt
  kBite = 10,        ///< the watchdog was not fed in time
};

struct Event {
  Act act{};
  std::uint32_t value = 0;
  std::uint64_t clock = 0;
};

/// The encoder node's board: an emulated STM8S103 that runs the image which is flashed, with an
/// AS5600 on its I2C.
///
/// uCsim knows neither the chip's I2C nor its watchdog. Breakpoints of its console that run on by
/// themselves are both: they move the I2C's flags as RM0016 21.4.2 has it, at 381 kHz, and note
/// what the image does. What only silicon can tell: the levels of the lines, the oscillator, and
/// whether the I2C cell does what RM0016 says. uCsim's UART hears nothing while it sends, so there
/// is no echo of the line here.
class EncoderBoard {
 public:
  static constexpr std::uint64_t kClocksPerMs = 16'000;
  static constexpr std::uint32_t kMagnet = 0x20;

  /// Power has just come on.
  EncoderBoard();

  /// From now on, in ticks of the sensor and ticks/s.
  void set_shaft(int position, double speed = 0);
  void set_chip_status(std::uint32_t bits);
  void set_chip_present(bool present);
  /// Something holds the data line low: no start comes onto the bus.
  void hold_bus(bool held);

  void run_ms(double ms);
  /// A request of three bytes, and so much time for its answer.
  Bytes ask(std::uint8_t name, double ms = 3);
  void send(const Bytes& bytes);
  Bytes take_output();

  const std::vector<Event>& events() const { return events_; }
  std::uint64_t clock();
  /// Steps of a reading that RM0016 21.4.2 or the chip's errata forbid.
  std::uint32_t bus_faults() { return value_of("m_fault"); }
  /// Bytes of RAM between variables and stack that were never written.
  std::size_t untouched_ram();
  std::uint32_t peek(std::uint32_t address);

  /// The program goes round in a loop from here on.
  void hang();
  /// Reset as the watchdog does it: memory and the AS5600 are what they were. Events begin anew.
  void reset();

 private:
  std::uint32_t value_of(const std::string& expression);
  void take_events(const std::string& text);

  Ucsim chip_;
  std::vector<Event> events_;
  std::size_t output_taken_ = 0;  ///< events
};

/// Path of the image that is flashed, without its ending.
std::string encoder_image();

}  // namespace sinew::emulation
