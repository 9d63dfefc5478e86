#include "sinew/runtime/links/machine_server.h"

#include <algorithm>
#include <array>

#include "sinew/core/stable_sort.h"
#include "sinew/runtime/links/serial_lane.h"

namespace sinew::runtime {
namespace {

using Direction = sim::LinkDirection;

class Server {
 public:
  Server(sim::ByteMachine& machine, io::Port& port, const io::Clock& clock,
         const SimulatedCable& cable, ByteLog& log, Duration slice)
      : machine_(machine),
        port_(port),
        clock_(clock),
        log_(log),
        slice_(slice),
        to_device_(cable.baud),
        to_host_(cable.baud),
        start_(clock.now()),
        faults_(cable.faults.link, start_),
        blows_(cable.faults.disturbances) {
    stable_sort_by(blows_, &sim::TimedDisturbance::at);
  }

  io::IoResult<void> turn() {
    const auto count = port_.read(buffer_, until_next());
    if (!count) return std::unexpected(count.error());
    const Instant now = clock_.now();
    const std::span received(buffer_.data(), *count);
    log_.add(ByteLog::Direction::kToDevice, received, now);
    faults_.push(Direction::kToDevice, received, now);
    while (const std::size_t size = faults_.take(Direction::kToDevice, now, buffer_)) {
      to_device_.push({buffer_.data(), size}, now);
    }
    run_machine(now);
    return send(now);
  }

  Instant now() const { return clock_.now(); }
  std::array<sim::LinkCounts, 2> counts() const {
    return {faults_.counts(Direction::kToDevice), faults_.counts(Direction::kToHost)};
  }

 private:
  Duration until_next() const {
    Duration wait = slice_;
    for (const auto& next :
         {machine_.next_event(), faults_.next_event(), to_device_.next(), to_host_.next()}) {
      if (next) wait = std::min(wait, clock_.until(*next));
    }
    if (next_blow_ < blows_.size()) {
      wait = std::min(wait, clock_.until(start_ + blows_[next_blow_].at));
    }
    return wait;
  }

  /// Bytes and blows reach the machine at their own instants, in their order.
  void run_machine(Instant now) {
    while (true) {
      const bool blow =
          next_blow_ < blows_.size() && start_ + blows_[next_blow_].at <= now &&
          (!to_device_.next() || start_ + blows_[next_blow_].at <= *to_device_.next());
      if (blow) {
        machine_.advance(std::max(last_, start_ + blows_[next_blow_].at));
        machine_.disturb(blows_[next_blow_++].what);
        continue;
      }
      const auto byte = to_device_.take(now);
      if (!byte) break;
      last_ = std::max(last_, byte->arrives);
      machine_.receive({&byte->byte, 1}, last_);
      collect(last_);
    }
    last_ = std::max(last_, now);
    machine_.advance(last_);
    collect(last_);
  }

  void collect(Instant at) {
    while (const std::size_t size = machine_.take_output(answers_)) {
      faults_.push(Direction::kToHost, {answers_.data(), size}, at);
    }
  }

  io::IoResult<void> send(Instant now) {
    while (const std::size_t size = faults_.take(Direction::kToHost, now, answers_)) {
      to_host_.push({answers_.data(), size}, now);
    }
    std::size_t size = 0;
    while (const auto byte = to_host_.take(now)) {
      answers_[size++] = byte->byte;
      if (size < answers_.size()) continue;
      if (auto sent = write({answers_.data(), size}, now); !sent) return sent;
      size = 0;
    }
    return write({answers_.data(), size}, now);
  }

  io::IoResult<void> write(std::span<const std::uint8_t> bytes, Instant now) {
    if (bytes.empty()) return {};
    // A serial line does not wait for its reader: what finds no room is lost.
    const auto sent = port_.write_now(bytes);
    if (!sent) return std::unexpected(sent.error());
    log_.add(ByteLog::Direction::kToHost, bytes.first(*sent), now);
    return {};
  }

  sim::ByteMachine& machine_;
  io::Port& port_;
  const io::Clock& clock_;
  ByteLog& log_;
  Duration slice_;
  SerialLane to_device_;
  SerialLane to_host_;
  Instant start_;
  Instant last_{};
  sim::LinkFaults faults_;
  std::vector<sim::TimedDisturbance> blows_;
  std::size_t next_blow_ = 0;
  std::array<std::uint8_t, 512> buffer_{};
  std::array<std::uint8_t, 512> answers_{};
};

}  // namespace

io::IoResult<std::array<sim::LinkCounts, 2>> serve_machine(sim::ByteMachine& machine,
                                                           io::Port& port, const io::Clock& clock,
                                                           const SimulatedCable& cable,
                                                           ByteLog& log, const ServeHooks& hooks) {
  Server server(machine, port, clock, cable, log, hooks.slice);
  while (!hooks.stop()) {
    if (const auto turned = server.turn(); !turned) return std::unexpected(turned.error());
    if (hooks.look) hooks.look(server.now());
  }
  return server.counts();
}

}  // namespace sinew::runtime
