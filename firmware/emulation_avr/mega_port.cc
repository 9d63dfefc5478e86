#include "firmware/emulation_avr/mega_port.h"

#include <fcntl.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>

namespace sinew::emulation {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

MegaPort::MegaPort() {
  std::array<char, 128> name{};
  termios raw{};
  cfmakeraw(&raw);
  if (openpty(&own_, &other_, name.data(), &raw, nullptr) == 0) name_ = name.data();
  fcntl(own_, F_SETFL, O_NONBLOCK);
  thread_ = std::thread([this] { serve(); });
}

MegaPort::~MegaPort() {
  ends_ = true;
  thread_.join();
  close(own_);
  close(other_);
}

std::int64_t MegaPort::steps(std::size_t axis) const {
  const std::scoped_lock lock(mutex_);
  return board_.steps(axis);
}

void MegaPort::serve() {
  constexpr auto kSlice = std::chrono::milliseconds(1);
  constexpr auto kBehindMost = std::chrono::milliseconds(50);
  auto due = Clock::now();
  std::array<std::uint8_t, 256> bytes{};
  while (!ends_) {
    due = std::max(due + kSlice, Clock::now() - kBehindMost);
    std::this_thread::sleep_until(due);
    const std::scoped_lock lock(mutex_);
    const ssize_t heard = read(own_, bytes.data(), bytes.size());
    if (heard > 0) board_.send({bytes.data(), static_cast<std::size_t>(heard)});
    board_.run_ms(1);
    const mcu::Bytes said = board_.take_output();
    if (!said.empty() && write(own_, said.data(), said.size()) < 0) return;
  }
}

}  // namespace sinew::emulation
