#include "sinew/runtime/device_server.h"

#include <algorithm>
#include <array>

namespace sinew::runtime {
namespace {

constexpr Duration kSliceMax = std::chrono::milliseconds(50);

}  // namespace

io::IoResult<void> serve_device(BigRobotArmFirmware& firmware, io::Port& port,
                                const io::Clock& clock, ByteLog& log,
                                const std::function<bool()>& stop) {
  std::array<std::uint8_t, 512> buffer;
  while (!stop()) {
    Duration wait = kSliceMax;
    if (const auto next = firmware.next_event()) wait = std::min(wait, clock.until(*next));
    const auto count = port.read(buffer, wait);
    if (!count) return std::unexpected(count.error());
    const Instant now = clock.now();
    // What ends before these bytes came is over before they are looked at.
    firmware.advance(now);
    const std::span received(buffer.data(), *count);
    log.add(ByteLog::Direction::kToDevice, received, now);
    if (!received.empty()) firmware.receive(received, now);
    while (const std::size_t size = firmware.take_output(buffer)) {
      // A serial line does not wait for its reader: what finds no room is lost.
      const auto sent = port.write_now(std::span(buffer.data(), size));
      if (!sent) return std::unexpected(sent.error());
      log.add(ByteLog::Direction::kToHost, std::span(buffer.data(), *sent), now);
    }
  }
  return {};
}

}  // namespace sinew::runtime
