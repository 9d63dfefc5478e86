#include "firmware/emulation/stm32.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace sinew::emulation {
namespace {

constexpr std::uint32_t kSelectPort = 0;
constexpr unsigned kSelectPin = 4;
constexpr unsigned kStepPin = 8;  // of port A: channel 1 of TIM1

// Lines of the interrupt controller for the pins' interrupts.
int line_of_pin(unsigned pin) {
  if (pin <= 4) return 6 + static_cast<int>(pin);
  return pin <= 9 ? 23 : 40;
}

}  // namespace

CortexM::Settings Stm32::core_settings(Stm32Chip chip) {
  if (chip == Stm32Chip::kF103) return {};
  return {.flash_size = 256 * 1024, .ram_size = 64 * 1024, .clock_hz = 84'000'000};
}

Stm32::Stm32(Stm32Chip chip, std::span<const std::uint8_t> image)
    : chip_(chip),
      core_(core_settings(chip)),
      timers_(core_),
      spi_(core_),
      i2c1_(core_),
      i2c2_(core_),
      usart2_(core_, core_.clock_hz() / 2),
      flash_(core_, chip == Stm32Chip::kF103),
      interrupts_(*this),
      dma_(*this),
      watchdog_(*this) {
  const bool f1 = chip == Stm32Chip::kF103;
  core_.flash(image);
  for (unsigned i = 0; i < 3; ++i) ports_.emplace_back(*this, i);
  for (unsigned i = 0; i < 3; ++i) {
    core_.map((f1 ? 0x4001'0800 : 0x4002'0000) + 0x400 * i, ports_[i]);
  }
  core_.map(f1 ? 0x4001'2C00 : 0x4001'0000, timers_.tim1());
  core_.map(0x4000'0000, timers_.tim2());
  core_.map(0x4000'0400, timers_.tim3());
  core_.map(0x4000'0800, timers_.tim4());
  core_.map(0x4001'3000, spi_);
  core_.map(0x4000'5400, i2c1_);
  core_.map(0x4000'5800, i2c2_);
  core_.map(0x4000'4400, usart2_);
  core_.map(0x4000'3000, watchdog_);
  core_.map(0x4000'7000, power_);
  core_.map(f1 ? 0x4000'6C00 : 0x4000'2800, backup_);
  core_.map(f1 ? 0x4002'1000 : 0x4002'3800, clocks_);
  core_.map(f1 ? 0x4002'2000 : 0x4002'3C00, flash_);
  core_.map(f1 ? 0x4001'0000 : 0x4001'3800, multiplexer_);
  core_.map(f1 ? 0x4001'0400 : 0x4001'3C00, interrupts_);
  core_.map(f1 ? 0x4002'0000 : 0x4002'6400, dma_);
  clocks_.on_write = [this, f1](std::uint32_t offset, std::uint32_t value) {
    // An oscillator that is switched on is ready, a clock that is chosen is used.
    std::uint32_t& control = clocks_.word[0];
    control |= control << 1 & (1U << 25 | 1U << 17);
    std::uint32_t& choice = clocks_.word[f1 ? 1 : 2];
    choice = (choice & ~0b1100U) | (choice & 0b11U) << 2;
    if (offset == (f1 ? 0x0C : 0x24) && (value & 1U << 12) != 0) spi_.reset();
  };
  reset();
}

void Stm32::reset() {
  timers_.reset();
  spi_.reset();
  i2c1_.reset();
  i2c2_.reset();
  usart2_.reset();
  flash_.reset();
  for (Port& port : ports_) port.word = {}, port.driven = 0;
  for (Plain* plain : {&clocks_, &multiplexer_, &power_}) plain->word = {};
  interrupts_.word = {};
  dma_.word = {};
  spi_.in = spi_.out = {};
  watchdog_.word = {};
  watchdog_.bites_at.reset();
  core_.reset();
}

void Stm32::power_cycle() {
  core_.spoil_memory();
  backup_.word = {};
  reset();
}

std::optional<std::string> Stm32::run_until(Cycles cycles) {
  while (core_.now() < cycles) {
    if (const auto broken = core_.run_until(cycles)) return broken;
    if (flash_.power_cut()) return "the supply failed";
    if (!bitten_ && !core_.reset_wanted()) continue;
    bitten_ = false;
    reset();
  }
  return std::nullopt;
}

std::optional<std::string> Stm32::run_for(double seconds) {
  return run_until(core_.now() + static_cast<Cycles>(std::llround(seconds * core_.clock_hz())));
}

void Stm32::set_input(char port, unsigned pin, bool high) {
  const auto number = static_cast<unsigned>(port - 'A');
  Port& block = ports_[number];
  const bool was = (block.outside >> pin & 1) != 0;
  if (was == high) return;
  block.outside ^= 1U << pin;
  interrupts_.edge(number, pin, high);
  core_.look_again();
}

void Stm32::set_supply_low(bool low) {
  constexpr std::uint32_t kOutput = 1U << 2, kOn = 1U << 4, kEvent = 1U << 16;
  constexpr int kLine = 1;
  const bool was = (power_.word[1] & kOutput) != 0;
  power_.word[1] = low ? kOutput : 0;
  const bool rises = low && !was && (power_.word[0] & kOn) != 0;
  if (!rises || (interrupts_.word[2] & kEvent) == 0) return;
  interrupts_.word[5] |= kEvent;
  if ((interrupts_.word[0] & kEvent) != 0) core_.raise(kLine);
}

bool Stm32::output(char port, unsigned pin) const {
  return (ports_[static_cast<std::size_t>(port - 'A')].driven >> pin & 1) != 0;
}

std::vector<std::uint8_t> Stm32::transfer(std::span<const std::uint8_t> mosi,
                                          std::uint32_t clock_hz, double setup_s) {
  set_input('A', kSelectPin, false);
  static_cast<void>(run_for(setup_s));
  clock_spi(mosi, clock_hz);
  static_cast<void>(run_for(8.0 * static_cast<double>(mosi.size()) / clock_hz + 1e-7));
  set_input('A', kSelectPin, true);
  return {spi_.miso().begin(), spi_.miso().end()};
}

void Stm32::clock_spi(std::span<const std::uint8_t> mosi, std::uint32_t clock_hz) {
  spi_.begin(mosi, Cycles{8} * core_.clock_hz() / clock_hz);
}

void Stm32::Plain::write(std::uint32_t offset, std::uint32_t value) {
  word[offset / 4] = value;
  on_write(offset, value);
}

std::uint32_t Stm32::Port::read(std::uint32_t offset) {
  const std::uint32_t input = chip_.chip_ == Stm32Chip::kF103 ? 0x08 : 0x10;
  if (offset == input && number_ == 0) {
    return (outside & ~(1U << kStepPin)) | (chip_.timers_.step_level() ? 1U << kStepPin : 0);
  }
  if (offset == input) return outside;
  if (offset == input + 4) return driven;
  return word[offset / 4];
}

void Stm32::Port::write(std::uint32_t offset, std::uint32_t value) {
  const std::uint32_t set = chip_.chip_ == Stm32Chip::kF103 ? 0x10 : 0x18;
  if (offset == set) {
    driven = (driven & ~(value >> 16)) | (value & 0xFFFF);
    return;
  }
  word[offset / 4] = value;
}

void Stm32::Interrupts::write(std::uint32_t offset, std::uint32_t value) {
  constexpr std::uint32_t kPending = 0x14;
  if (offset == kPending) {
    word[kPending / 4] &= ~value;
  } else {
    word[offset / 4] = value;
  }
}

std::uint32_t Stm32::pin_port(unsigned pin) const {
  return multiplexer_.word[2 + pin / 4] >> 4 * (pin % 4) & 0xF;
}

void Stm32::Interrupts::edge(unsigned port, unsigned pin, bool high) {
  const std::uint32_t sides = word[high ? 2 : 3];  // RTSR, FTSR
  if ((sides >> pin & 1) == 0 || chip_.pin_port(pin) != port) return;
  word[5] |= 1U << pin;
  if ((word[0] >> pin & 1) != 0) chip_.core_.raise(line_of_pin(pin));
}

std::uint32_t Stm32::Dma::read(std::uint32_t offset) {
  const bool f1 = chip_.chip_ == Stm32Chip::kF103;
  if (offset == (f1 ? 0x20U : 0x14U)) return chip_.spi_.in.left;
  if (offset == (f1 ? 0x34U : 0x5CU)) return chip_.spi_.out.left;
  return word[offset / 4];
}

/// F103: channel 2 takes, channel 3 gives. F401: stream 0 takes, stream 3 gives.
void Stm32::Dma::write(std::uint32_t offset, std::uint32_t value) {
  const bool f1 = chip_.chip_ == Stm32Chip::kF103;
  word[offset / 4] = value;
  const std::uint32_t control[] = {f1 ? 0x1CU : 0x10U, f1 ? 0x30U : 0x58U};
  Stm32SpiSlave::Direction* sides[] = {&chip_.spi_.in, &chip_.spi_.out};
  for (int i = 0; i < 2; ++i) {
    Stm32SpiSlave::Direction& side = *sides[i];
    if (offset == control[i] + 4) side.left = value & 0xFFFF;
    if (offset == control[i] + 12) side.memory = value;
    if (offset == control[i]) {
      // The F1 keeps the memory's address apart from where it stands; a start takes it over.
      side.enabled = (value & 1) != 0;
      if (side.enabled) side.memory = word[(control[i] + 12) / 4];
    }
  }
  chip_.spi_.fetch();
}

void Stm32::Watchdog::write(std::uint32_t offset, std::uint32_t value) {
  word[offset / 4] = value;
  if (offset != 0) return;
  const bool starts = value == 0xCCCC;
  if (!starts && !(value == 0xAAAA && bites_at)) return;
  constexpr double kOscillator = 32e3;
  const double seconds = (word[2] + 1) * std::exp2(2 + word[1]) / kOscillator;
  bites_at = chip_.core_.now() + static_cast<Cycles>(seconds * chip_.core_.clock_hz());
}

void Stm32::Watchdog::advance(Cycles now) {
  if (!bites_at || now < *bites_at) return;
  bites_at.reset();
  ++chip_.bites_;
  chip_.bitten_ = true;
  chip_.core_.stop();
}

std::vector<std::uint8_t> read_image(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    std::fprintf(stderr, "no image %s: make firmware builds it\n", path.c_str());
    std::exit(1);
  }
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace sinew::emulation
