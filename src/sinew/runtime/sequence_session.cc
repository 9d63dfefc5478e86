#include "sinew/runtime/sequence_session.h"

#include <algorithm>
#include <array>

namespace sinew::runtime {
namespace {

constexpr Duration kSliceMax = std::chrono::milliseconds(50);

/// One session's port and log, with the bytes that went through them counted.
class Line {
 public:
  Line(BigRobotArmDriver& driver, io::Port& port, const io::Clock& clock, ByteLog& log)
      : driver_(driver), port_(port), clock_(clock), log_(log) {}

  /// Everything that the driver has to say.
  io::IoResult<void> send() {
    while (const std::size_t size = driver_.take_output(buffer_)) {
      const std::span bytes(buffer_.data(), size);
      log_.add(ByteLog::Direction::kToDevice, bytes, clock_.now());
      if (auto written = port_.write(bytes); !written) return written;
      count_.to_device += size;
    }
    return {};
  }

  /// Waits for bytes, or for the driver's next deadline, and hands both to the driver.
  io::IoResult<void> receive() {
    Duration wait = kSliceMax;
    if (const auto deadline = driver_.next_deadline()) {
      wait = std::min(wait, clock_.until(*deadline));
    }
    const auto size = port_.read(buffer_, wait);
    if (!size) return std::unexpected(size.error());
    const Instant now = clock_.now();
    if (*size > 0) {
      const std::span bytes(buffer_.data(), *size);
      log_.add(ByteLog::Direction::kToHost, bytes, now);
      count_.to_host += *size;
      driver_.receive(bytes, now);
    }
    driver_.poll(now);
    return {};
  }

  const ByteCount& count() const { return count_; }

 private:
  BigRobotArmDriver& driver_;
  io::Port& port_;
  const io::Clock& clock_;
  ByteLog& log_;
  ByteCount count_;
  std::array<std::uint8_t, 512> buffer_{};
};

}  // namespace

SessionEnd run_sequence(sequence::Run& run, BigRobotArmDriver& driver, io::Port& port,
                        const io::Clock& clock, ByteLog& log, const SessionHooks& hooks) {
  SessionEnd end;
  Line line(driver, port, clock, log);
  ByteCount before;  // the order under way
  bool opening = true;
  const auto fail = [&](const io::IoError& error) {
    driver.close();
    run.poll(clock.now());
    end.port_failure = error;
  };

  run.start(clock.now());
  while (true) {
    const std::size_t done_before = run.records().size();
    run.poll(clock.now());
    const ByteCount& count = line.count();
    if (run.records().size() > done_before) {
      end.bytes.push_back({count.to_device - before.to_device, count.to_host - before.to_host});
    }
    // What it took to find the device belongs to the total, not to the first order.
    if (opening || run.records().size() > done_before) before = count;
    opening = run.phase() == sequence::Run::Phase::kOpening;
    const auto sent = line.send();
    end.total = count;
    if (!sent) fail(sent.error());
    if (hooks.progress) hooks.progress({run, clock.now()});
    if (run.finished()) return end;
    const int interrupts = hooks.interrupts ? hooks.interrupts() : 0;
    end.left_at_once = interrupts > 1;
    if (end.left_at_once) return end;
    if (interrupts == 1) run.stop();
    const auto received = line.receive();
    end.total = count;
    if (!received) fail(received.error());
  }
}

}  // namespace sinew::runtime
