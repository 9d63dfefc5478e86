#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sinew/core/instant.h"

struct avr_t;
struct avr_irq_t;

namespace sinew::emulation {

enum class AvrChip : std::uint8_t { kAtmega328p, kAtmega2560 };

/// A board with an AVR chip: libsimavr runs the image as it would be flashed, cycle by cycle, at
/// 16 MHz.
///
/// What only silicon can tell: an oscillator that is off by a percent, levels between high and low,
/// what a boot loader does before the image.
class AvrBoard {
 public:
  static constexpr std::uint32_t kHertz = 16'000'000;

  /// @param image  a .bin file
  AvrBoard(AvrChip chip, const std::string& image);
  ~AvrBoard();
  AvrBoard(const AvrBoard&) = delete;
  AvrBoard& operator=(const AvrBoard&) = delete;

  /// Since power-up.
  Duration now() const;
  std::uint64_t cycle() const;
  /// Runs up to that time. A chip that crashed fails the test.
  void run_until(Duration time);

  /// Bytes that USART `port` sends, when the sketch writes them.
  void on_uart(char port, std::function<void(std::uint8_t)> sent);
  void send_uart(char port, std::uint8_t byte);
  /// Level of a pin, at each change.
  void on_pin(char port, int pin, std::function<void(bool)> changed);
  void set_pin(char port, int pin, bool level);
  /// Calls `task` at a later cycle; the task returns the next cycle, or nothing.
  void at_cycle(std::uint64_t cycle, std::function<std::optional<std::uint64_t>()> task);

  /// As the reset pin does it: memory is what it was. Inputs are to be set again.
  void reset();
  /// Power was off: memory holds `noise`.
  void fill_ram(const std::function<std::uint8_t()>& noise);
  /// The program goes round in a loop from here on, until the next reset.
  void hang();
  /// Resets by the chip itself: of its watchdog.
  int restarts() const { return restarts_; }
  void on_restart(std::function<void()> restarted) { restarted_ = std::move(restarted); }
  /// The program drives the pin to low.
  bool drives_low(char port, int pin) const;

  /// Bytes of RAM between variables and stack that were never written.
  std::size_t untouched_ram() const;
  /// What was sent over USART 0.
  const std::string& printed() const { return printed_; }

 private:
  struct Hook;

  avr_irq_t* uart_irq(char port, int index);

  avr_t* avr_ = nullptr;
  std::vector<std::unique_ptr<Hook>> hooks_;
  std::string printed_;
  int restarts_ = 0;
  std::function<void()> restarted_;
};

}  // namespace sinew::emulation
