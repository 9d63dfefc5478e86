#include "firmware/emulation_stm8/encoder_board.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "firmware/emulation_stm8/chip_model.h"

namespace sinew::emulation {
namespace {

/// A line that is an event has this bit, then 4 bits of Act and 24 of value; the clock follows.
constexpr std::uint32_t kEventBit = 1U << 28;
constexpr std::uint32_t kUntouched = 0xC5;
constexpr std::size_t kRam = 0x400;

}  // namespace

std::string encoder_image() {
  return SINEW_STM8_IMAGES "/encoder-stm8s103";
}

EncoderBoard::EncoderBoard() : chip_(encoder_image() + ".hex") {
  // Only a reset gives the UART its clock.
  chip_.command("reset\nfill rom 0 0x3ff " + std::to_string(kUntouched));
  chip_.command(model_commands());
  chip_.command(model_start_commands());
}

void EncoderBoard::set_shaft(int position, double speed) {
  const double rate = std::round(std::abs(speed) * (1 << 20) / (kClocksPerMs * 1000.0));
  std::ostringstream text;
  text << "m_since=sim_ticks\nm_base=" << position << "\nm_ahead=" << (speed > 0 ? rate : 0)
       << "\nm_back=" << (speed < 0 ? rate : 0);
  chip_.command(text.str());
}

void EncoderBoard::set_chip_status(std::uint32_t bits) {
  chip_.command("m_status=" + std::to_string(bits));
}

void EncoderBoard::set_chip_present(bool present) {
  chip_.command(present ? "m_present=1" : "m_present=0");
}

void EncoderBoard::hold_bus(bool held) {
  chip_.command(held ? "m_held=1" : "m_held=0");
}

void EncoderBoard::run_ms(double ms) {
  take_events(chip_.run(static_cast<std::uint64_t>(ms * kClocksPerMs)));
}

Bytes EncoderBoard::ask(std::uint8_t name, double ms) {
  send({0xAA, name, 0x55});
  run_ms(ms);
  return take_output();
}

void EncoderBoard::send(const Bytes& bytes) {
  chip_.send_uart({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

Bytes EncoderBoard::take_output() {
  Bytes bytes;
  for (; output_taken_ < events_.size(); ++output_taken_) {
    const Event& event = events_[output_taken_];
    if (event.act == Act::kSends) bytes.push_back(static_cast<std::uint8_t>(event.value));
  }
  return bytes;
}

std::uint64_t EncoderBoard::clock() {
  return value_of("sim_ticks");
}

std::size_t EncoderBoard::untouched_ram() {
  // As `hole` finds them: address and length.
  std::istringstream text(chip_.command("hole rom 16 " + std::to_string(kUntouched)));
  std::size_t longest = 0;
  for (std::string line; std::getline(text, line);) {
    std::size_t at = 0;
    std::size_t count = 0;
    if (std::sscanf(line.c_str(), "0x%zx %zu", &at, &count) == 2 && at < kRam) {
      longest = std::max(longest, count);
    }
  }
  return longest;
}

std::uint32_t EncoderBoard::peek(std::uint32_t address) {
  return value_of("rom[" + std::to_string(address) + "]");
}

void EncoderBoard::hang() {
  // A jump to itself in the last two bytes of the flash.
  chip_.command("flash_chip[0x1ffe]=0x20\nflash_chip[0x1fff]=0xfe\nPC=0x9ffe");
}

void EncoderBoard::reset() {
  chip_.command("reset\n" + model_start_commands());
  events_.clear();
  output_taken_ = 0;
}

std::uint32_t EncoderBoard::value_of(const std::string& expression) {
  // The first line that is a number; the console prints the command too.
  std::istringstream text(chip_.command("0+" + expression));
  for (std::string line; std::getline(text, line);) {
    std::uint32_t value = 0;
    const char* const end = line.data() + line.size();
    if (!line.empty() && std::from_chars(line.data(), end, value).ptr == end) return value;
  }
  throw std::runtime_error("no value of " + expression + ": " + text.str());
}

void EncoderBoard::take_events(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::uint32_t number = 0;
    const char* const end = line.data() + line.size();
    if (std::from_chars(line.data(), end, number).ptr != end || (number & kEventBit) == 0) continue;
    std::string clock;
    std::getline(lines, clock);
    events_.push_back(
        {static_cast<Act>(number >> 24 & 0xF), number & 0xFF'FFFF, std::stoull(clock)});
  }
}

}  // namespace sinew::emulation
