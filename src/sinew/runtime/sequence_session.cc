#include "sinew/runtime/sequence_session.h"

#include <algorithm>
#include <array>

namespace sinew::runtime {
namespace {

constexpr Duration kSliceMax = std::chrono::milliseconds(50);

}  // namespace

io::IoResult<SessionEnd> run_sequence(sequence::Run& run, BigRobotArmDriver& driver, io::Port& port,
                                      const io::Clock& clock, ByteLog& log,
                                      const SessionHooks& hooks) {
  SessionEnd end;
  ByteCount current;
  std::array<std::uint8_t, 512> buffer;
  const auto send = [&]() -> io::IoResult<void> {
    while (const std::size_t size = driver.take_output(buffer)) {
      const std::span bytes(buffer.data(), size);
      log.add(ByteLog::Direction::kToDevice, bytes, clock.now());
      if (auto written = port.write(bytes); !written) return written;
      current.to_device += size;
      end.total.to_device += size;
    }
    return {};
  };

  run.start(clock.now());
  bool opening = true;
  while (true) {
    const std::size_t done_before = run.records().size();
    run.poll(clock.now());
    if (opening && run.phase() != sequence::Run::Phase::kOpening) {
      // What it took to find the device belongs to the total, not to the first order.
      opening = false;
      current = {};
    }
    if (run.records().size() > done_before) {
      end.bytes.push_back(current);
      current = {};
    }
    if (const auto sent = send(); !sent) return std::unexpected(sent.error());
    if (hooks.progress) hooks.progress({run, clock.now()});
    if (run.finished()) return end;
    const int interrupts = hooks.interrupts ? hooks.interrupts() : 0;
    if (interrupts > 1) {
      end.left_at_once = true;
      return end;
    }
    if (interrupts == 1) run.stop();

    Duration wait = kSliceMax;
    if (const auto deadline = driver.next_deadline()) {
      wait = std::min(wait, clock.until(*deadline));
    }
    const auto count = port.read(buffer, wait);
    if (!count) {
      driver.close();
      return std::unexpected(count.error());
    }
    const Instant now = clock.now();
    if (*count > 0) {
      const std::span bytes(buffer.data(), *count);
      log.add(ByteLog::Direction::kToHost, bytes, now);
      current.to_host += *count;
      end.total.to_host += *count;
      driver.receive(bytes, now);
    }
    driver.poll(now);
  }
}

}  // namespace sinew::runtime
