#include "firmware/emulation_avr/avr_board.h"

#include <gtest/gtest.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

/// libsimavr 1.6 never frees its interrupt requests. Read by LeakSanitizer only.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libsimavr";
}

namespace sinew::emulation {
namespace {

constexpr std::uint8_t kUntouched = 0xC5;
constexpr std::size_t kRamStart = 0x200;  // of the ATmega2560; behind that of the ATmega328P

}  // namespace

/// Parameter of callbacks in C.
struct AvrBoard::Hook {
  std::function<void(std::uint32_t)> notified;
  std::function<std::optional<std::uint64_t>()> task;

  static void notify(avr_irq_t*, std::uint32_t value, void* self) {
    static_cast<Hook*>(self)->notified(value);
  }
  static avr_cycle_count_t run(avr_t*, avr_cycle_count_t, void* self) {
    return static_cast<Hook*>(self)->task().value_or(0);
  }
};

AvrBoard::AvrBoard(AvrChip chip, const std::string& image) {
  std::ifstream file(image, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.empty()) throw std::runtime_error("no image " + image);
  avr_ = avr_make_mcu_by_name(chip == AvrChip::kAtmega328p ? "atmega328p" : "atmega2560");
  if (avr_ == nullptr) throw std::runtime_error("libsimavr does not know the chip");
  avr_init(avr_);
  avr_->log = LOG_NONE;
  avr_->frequency = kHertz;
  if (bytes.size() > avr_->flashend + 1) throw std::runtime_error(image + " is too large");
  std::ranges::copy(bytes, reinterpret_cast<char*>(avr_->flash));
  avr_->codeend = static_cast<avr_flashaddr_t>(bytes.size());
  std::fill(avr_->data + kRamStart, avr_->data + avr_->ramend + 1, kUntouched);
  // No sleep while a sketch polls the port: every cycle runs.
  std::uint32_t flags = 0;
  for (const char port : {'0', '1'}) {
    avr_ioctl(avr_, static_cast<std::uint32_t>(AVR_IOCTL_UART_SET_FLAGS(port)), &flags);
  }
  on_uart('0', [this](std::uint8_t byte) { printed_ += static_cast<char>(byte); });
}

AvrBoard::~AvrBoard() {
  avr_terminate(avr_);
  // libsimavr allocates the chip with malloc and frees all but itself.
  std::free(avr_);  // NOLINT(cppcoreguidelines-no-malloc)
}

Duration AvrBoard::now() const {
  return Duration{static_cast<std::int64_t>(cycle() * 125 / 2)};
}

std::uint64_t AvrBoard::cycle() const {
  return avr_->cycle;
}

std::size_t AvrBoard::untouched_ram() const {
  std::size_t longest = 0;
  std::size_t run = 0;
  for (std::size_t at = kRamStart; at <= avr_->ramend; ++at) {
    run = avr_->data[at] == kUntouched ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return longest;
}

void AvrBoard::run_until(Duration time) {
  while (now() < time) {
    const int state = avr_run(avr_);
    if (avr_->pc == avr_->reset_pc) {
      ++restarts_;
      if (restarted_) restarted_();
    }
    if (state == cpu_Done || state == cpu_Crashed) {
      ADD_FAILURE() << "the chip crashed; it had printed: " << printed_;
      return;
    }
  }
}

void AvrBoard::reset() {
  avr_reset(avr_);
  avr_->pc = avr_->reset_pc;
}

void AvrBoard::fill_ram(const std::function<std::uint8_t()>& noise) {
  for (std::size_t at = kRamStart; at <= avr_->ramend; ++at) avr_->data[at] = noise();
}

void AvrBoard::hang() {
  const std::uint32_t place = avr_->flashend - 1;
  // A jump to itself.
  avr_->flash[place] = 0xFF;
  avr_->flash[place + 1] = 0xCF;
  avr_->pc = place;
}

bool AvrBoard::drives_low(char port, int pin) const {
  avr_ioport_state_t state{};
  avr_ioctl(avr_, static_cast<std::uint32_t>(AVR_IOCTL_IOPORT_GETSTATE(port)), &state);
  const unsigned bit = 1U << pin;
  return (state.ddr & bit) != 0 && (state.port & bit) == 0;
}

avr_irq_t* AvrBoard::uart_irq(char port, int index) {
  return avr_io_getirq(avr_, static_cast<std::uint32_t>(AVR_IOCTL_UART_GETIRQ(port)), index);
}

void AvrBoard::on_uart(char port, std::function<void(std::uint8_t)> sent) {
  auto hook = std::make_unique<Hook>();
  hook->notified = [sent = std::move(sent)](std::uint32_t value) {
    sent(static_cast<std::uint8_t>(value));
  };
  avr_irq_register_notify(uart_irq(port, UART_IRQ_OUTPUT), &Hook::notify, hook.get());
  hooks_.push_back(std::move(hook));
}

void AvrBoard::send_uart(char port, std::uint8_t byte) {
  avr_raise_irq(uart_irq(port, UART_IRQ_INPUT), byte);
}

void AvrBoard::on_pin(char port, int pin, std::function<void(bool)> changed) {
  auto hook = std::make_unique<Hook>();
  hook->notified = [changed = std::move(changed)](std::uint32_t value) {
    changed((value & 1U) != 0);
  };
  avr_irq_register_notify(
      avr_io_getirq(avr_, static_cast<std::uint32_t>(AVR_IOCTL_IOPORT_GETIRQ(port)), pin),
      &Hook::notify, hook.get());
  hooks_.push_back(std::move(hook));
}

void AvrBoard::set_pin(char port, int pin, bool level) {
  avr_raise_irq(avr_io_getirq(avr_, static_cast<std::uint32_t>(AVR_IOCTL_IOPORT_GETIRQ(port)), pin),
                level ? 1 : 0);
}

void AvrBoard::at_cycle(std::uint64_t cycle, std::function<std::optional<std::uint64_t>()> task) {
  auto hook = std::make_unique<Hook>();
  hook->task = std::move(task);
  avr_cycle_timer_register(avr_, cycle - avr_->cycle, &Hook::run, hook.get());
  hooks_.push_back(std::move(hook));
}

}  // namespace sinew::emulation
