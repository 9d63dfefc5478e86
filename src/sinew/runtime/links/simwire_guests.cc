#include "sinew/runtime/links/simwire_guests.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

namespace sinew::runtime {
namespace {

constexpr std::string_view kAnswer =
    "ERR another host is connected to these boards; one at a time\n";

void turn_away(io::Port& port) {
  std::array<std::uint8_t, kAnswer.size()> bytes{};
  std::ranges::copy(kAnswer, bytes.begin());
  // Whoever went away again needs no answer.
  static_cast<void>(port.write_now(bytes));
}

/// A line, or the end: answering before the request has come would close the connection under a
/// host that still writes, and it would not read why.
bool has_spoken(io::Port& port) {
  std::array<std::uint8_t, 256> buffer{};
  while (true) {
    const auto size = port.read(buffer, Duration::zero());
    if (!size) return true;
    if (*size == 0) return false;
    const auto end = buffer.begin() + static_cast<std::ptrdiff_t>(*size);
    if (std::find(buffer.begin(), end, std::uint8_t{'\n'}) != end) return true;
  }
}

}  // namespace

std::size_t SimwireGuests::look() {
  while (waiting_.size() < kWaitingMax) {
    auto guest = listener_.accept(Duration::zero());
    if (!guest || !*guest) break;
    waiting_.push_back({std::move(**guest), clock_.now()});
  }
  return std::erase_if(waiting_, [&](Guest& guest) {
    const bool due = has_spoken(guest.port) || clock_.now() - guest.since > kPatience;
    if (due) turn_away(guest.port);
    return due;
  });
}

}  // namespace sinew::runtime
