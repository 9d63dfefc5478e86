#include "sinew/runtime/links/simulated_line.h"

#include <algorithm>
#include <array>

#include "sinew/core/assert.h"
#include "sinew/runtime/links/serial_lane.h"

namespace sinew::runtime {
namespace {

/// The control loop looks at a machine at least so often in its own time, however fast that is.
constexpr double kSlices = 10;
/// So often a driver and its device may make each other busy without time passing.
constexpr int kInstantMax = 10'000;

class SimulatedLine : public DriverLine {
 public:
  SimulatedLine(ByteDriver& driver, sim::ByteMachine& machine, std::uint32_t baud,
                const io::Clock& clock, ByteLog& log)
      : driver_(driver),
        machine_(machine),
        clock_(clock),
        log_(log),
        to_device_(baud),
        to_host_(baud) {
    SINEW_ASSERT(clock.is_simulated());
  }

  io::IoResult<void> turn(Duration wait) override {
    const Instant begin = clock_.now();
    const double slices = at_rest() ? clock_.scale() : std::min(clock_.scale(), kSlices);
    const Instant end = clock_.end_of_turn(from_seconds(to_seconds(wait) * slices));
    Instant last = begin;
    collect(begin);
    for (int busy = 0; busy < kInstantMax; ++busy) {
      const Instant now = std::clamp(next_event(end), last, end);
      if (now > last) busy = 0;
      last = now;
      clock_.pass_to(now);
      machine_.advance(now);
      deliver(now);
      driver_.poll(now);
      collect(now);
      if (now >= end && next_event(end) >= end) break;
    }
    clock_.pass_to(end);
    clock_.keep_pace();
    return {};
  }
  const ByteCount& count() const override { return count_; }

 private:
  Instant next_event(Instant end) const {
    Instant next = end;
    for (const auto& due :
         {to_device_.next(), to_host_.next(), driver_.next_deadline(), machine_.next_event()}) {
      if (due) next = std::min(next, *due);
    }
    return next;
  }

  void deliver(Instant now) {
    while (const auto one = to_device_.take(now)) machine_.receive({&one->byte, 1}, now);
    collect(now);
    while (const auto one = to_host_.take(now)) {
      log_.add(ByteLog::Direction::kToHost, {&one->byte, 1}, now);
      ++count_.to_host;
      driver_.receive({&one->byte, 1}, now);
    }
  }

  /// What either has to say begins its way over the wire.
  void collect(Instant now) {
    while (const std::size_t size = driver_.take_output(piece_)) {
      log_.add(ByteLog::Direction::kToDevice, std::span(piece_).first(size), now);
      count_.to_device += size;
      to_device_.push(std::span(piece_).first(size), now);
    }
    while (const std::size_t size = machine_.take_output(piece_)) {
      to_host_.push(std::span(piece_).first(size), now);
    }
  }

  ByteDriver& driver_;
  sim::ByteMachine& machine_;
  const io::Clock& clock_;
  ByteLog& log_;
  SerialLane to_device_;
  SerialLane to_host_;
  ByteCount count_;
  std::array<std::uint8_t, 256> piece_{};
};

}  // namespace

std::unique_ptr<DriverLine> simulated_line(ByteDriver& driver, sim::ByteMachine& machine,
                                           std::uint32_t baud, const io::Clock& clock,
                                           ByteLog& log) {
  return std::make_unique<SimulatedLine>(driver, machine, baud, clock, log);
}

}  // namespace sinew::runtime
