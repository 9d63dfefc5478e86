#include "faults/fault_cell.h"

#include <algorithm>
#include <array>

#include "sinew/sim/spi_faults.h"
#include "support/trace_hash.h"

namespace sinew::test {
namespace {

using sim::LinkDirection;

void add_byte(TraceHash& trace, LinkDirection direction, std::uint8_t byte) {
  trace.add_byte(static_cast<std::uint8_t>(direction));
  trace.add_byte(byte);
}

/// A flip that waits for its byte.
struct PendingFlip {
  bool due = false;
  std::uint64_t bytes_first = 0;
  unsigned bit = 0;

  std::uint8_t apply(std::uint8_t byte, std::uint64_t& faults) {
    if (!due) return byte;
    if (bytes_first > 0) {
      --bytes_first;
      return byte;
    }
    due = false;
    ++faults;
    return static_cast<std::uint8_t>(byte ^ 1U << bit);
  }
};

std::uint64_t faults_of(const sim::LinkCounts& counts) {
  // A cut is one fault, however long it is.
  return counts.dropped + counts.duplicated + counts.flipped + counts.delayed +
         (counts.cut > 0 ? 1 : 0);
}

std::uint64_t faults_of(const sim::LinkFaults& link) {
  return faults_of(link.counts(LinkDirection::kToDevice)) +
         faults_of(link.counts(LinkDirection::kToHost));
}

class ByteLine final : public FaultLine {
 public:
  ByteLine(ByteDriver& driver, sim::ByteMachine& machine, Duration byte_time, Instant now)
      : driver_(driver), machine_(machine), byte_time_(byte_time) {
    set_faults({}, now);
  }

  Instant turn(Instant now) override {
    std::array<std::uint8_t, 256> piece;
    collect(now);
    move_through(LinkDirection::kToDevice, now);
    while (const std::size_t size = arrived(LinkDirection::kToDevice, now, piece)) {
      machine_.receive(std::span(piece).first(size), now);
    }
    collect(now);
    move_through(LinkDirection::kToHost, now);
    while (const std::size_t size = arrived(LinkDirection::kToHost, now, piece)) {
      driver_.receive(std::span(piece).first(size), now);
    }
    retire();
    collect(now);
    return now;
  }

  std::optional<Instant> next_event() const override {
    std::optional<Instant> next;
    const auto at_least = [&](std::optional<Instant> due) {
      if (due) next = next ? std::min(*next, *due) : due;
    };
    for (const Lane& lane : lanes_) {
      if (!lane.flying.empty()) at_least(lane.flying.front().arrives);
    }
    at_least(links_.front()->next_event());
    return next;
  }

  void set_faults(const sim::LinkFaultSpec& spec, Instant now) override {
    links_.push_back(std::make_unique<sim::LinkFaults>(spec, now));
    retire();
  }

  void clear(Instant now) override {
    for (Lane& lane : lanes_) lane.flying.clear();
    for (const auto& link : links_) faults_ += faults_of(*link);
    links_.clear();
    links_.push_back(std::make_unique<sim::LinkFaults>(sim::LinkFaultSpec{}, now));
  }

  void flip_once(LinkDirection direction, std::uint64_t bytes_first, unsigned bit) override {
    lane(direction).flip = {true, bytes_first, bit};
  }
  bool flip_pending() const override { return lanes_[0].flip.due || lanes_[1].flip.due; }
  void cancel_flips() override {
    for (Lane& lane : lanes_) lane.flip.due = false;
  }

  LineCounts counts() const override {
    std::uint64_t faults = faults_;
    for (const auto& link : links_) faults += faults_of(*link);
    return {bytes_, trace_.value(), faults};
  }

 private:
  struct Flying {
    Instant arrives{};
    std::uint8_t byte = 0;
  };
  struct Lane {
    std::deque<Flying> flying;
    Instant free{};
    PendingFlip flip;
  };

  Lane& lane(LinkDirection direction) { return lanes_[static_cast<std::size_t>(direction)]; }

  void send(LinkDirection direction, std::span<const std::uint8_t> bytes, Instant now) {
    Lane& it = lane(direction);
    for (const std::uint8_t byte : bytes) {
      const Instant begins = std::max(it.free, now);
      it.free = begins + byte_time_;
      if (tap && direction == LinkDirection::kToDevice) tap({&byte, 1}, begins, it.free);
      it.flying.push_back({it.free, it.flip.apply(byte, faults_)});
      ++bytes_;
      add_byte(trace_, direction, byte);
    }
  }

  void collect(Instant now) {
    std::array<std::uint8_t, 256> piece;
    while (const std::size_t size = driver_.take_output(piece)) {
      send(LinkDirection::kToDevice, std::span(piece).first(size), now);
    }
    while (const std::size_t size = machine_.take_output(piece)) {
      send(LinkDirection::kToHost, std::span(piece).first(size), now);
    }
  }

  /// What the wire has carried gets its faults as it arrives.
  void move_through(LinkDirection direction, Instant now) {
    Lane& it = lane(direction);
    while (!it.flying.empty() && it.flying.front().arrives <= now) {
      links_.back()->push(direction, {&it.flying.front().byte, 1}, it.flying.front().arrives);
      it.flying.pop_front();
    }
  }

  /// An older link's bytes go before those of a newer one.
  std::size_t arrived(LinkDirection direction, Instant now, std::span<std::uint8_t> out) {
    for (const auto& link : links_) {
      if (const std::size_t size = link->take(direction, now, out)) return size;
      if (link->next_event()) return 0;
    }
    return 0;
  }

  void retire() {
    while (links_.size() > 1 && !links_.front()->next_event()) {
      faults_ += faults_of(*links_.front());
      links_.pop_front();
    }
  }

  ByteDriver& driver_;
  sim::ByteMachine& machine_;
  Duration byte_time_;
  std::array<Lane, 2> lanes_;
  std::deque<std::unique_ptr<sim::LinkFaults>> links_;
  std::uint64_t bytes_ = 0;
  TraceHash trace_;
  std::uint64_t faults_ = 0;  ///< of links that are gone, and single flips
};

/// Flips single bits between the boards and whatever else befalls them.
class FlippingBus : public sim::SpiMachine {
 public:
  explicit FlippingBus(sim::SpiMachine& machine) : machine_(machine) {}

  void advance(Instant now) override { machine_.advance(now); }
  std::optional<Instant> next_event() const override { return machine_.next_event(); }
  sim::Truth truth() const override { return machine_.truth(); }
  void disturb(const sim::Disturbance& what) override { machine_.disturb(what); }
  void select(std::uint8_t mask, Instant now) override { machine_.select(mask, now); }
  void shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
             std::uint32_t clock_hz, Instant now) override {
    spi::Bytes spoiled;
    for (const std::uint8_t byte : mosi) spoiled.push_back(flips[0].apply(byte, faults));
    machine_.shift({spoiled.data(), spoiled.size()}, miso, clock_hz, now);
    for (std::uint8_t& byte : miso) byte = flips[1].apply(byte, faults);
  }
  bool ready_pin(std::size_t axis) const override { return machine_.ready_pin(axis); }

  std::array<PendingFlip, 2> flips;
  std::uint64_t faults = 0;

 private:
  sim::SpiMachine& machine_;
};

class SpiLine final : public FaultLine {
 public:
  /// What the host's system call costs beside the clocks.
  static constexpr Duration kCall = std::chrono::microseconds(20);

  SpiLine(SpiDriver& driver, sim::SpiMachine& machine, Instant now)
      : driver_(driver), bus_(machine) {
    set_faults({}, now);
  }

  Instant turn(Instant now) override {
    const auto transfer = driver_.take_transfer(now);
    if (!transfer) return now;
    const Instant begins = now + transfer->setup;
    if (tap) {
      tap({transfer->mosi.data(), transfer->mosi.size()}, begins,
          begins + spi::wire_time(*transfer));
    }
    const spi::Bytes miso = faulty_->exchange(*transfer, now);
    bytes_ += 2 * miso.size();
    for (const std::uint8_t byte : transfer->mosi) add_byte(trace_, LinkDirection::kToDevice, byte);
    for (const std::uint8_t byte : miso) add_byte(trace_, LinkDirection::kToHost, byte);
    const Instant end = now + transfer->setup + spi::wire_time(*transfer) + kCall;
    faulty_->advance(end);
    driver_.exchanged({miso.data(), miso.size()}, end);
    return end;
  }

  std::optional<Instant> next_event() const override { return std::nullopt; }

  void set_faults(const sim::LinkFaultSpec& spec, Instant now) override {
    faults_ += faulty_ ? faulty_->flipped() : 0;
    sim::FaultPlan plan;
    plan.link = spec;
    for (sim::ByteFaults& faults : plan.link.bytes) faults = {.flip = faults.flip};
    faults_ += plan.link.cuts.size();
    faulty_ = std::move(*sim::SpiFaults::create(bus_, plan));
    faulty_->advance(now);
  }

  void clear(Instant) override {}

  void flip_once(LinkDirection direction, std::uint64_t bytes_first, unsigned bit) override {
    bus_.flips[static_cast<std::size_t>(direction)] = {true, bytes_first, bit};
  }
  bool flip_pending() const override { return bus_.flips[0].due || bus_.flips[1].due; }
  void cancel_flips() override {
    for (PendingFlip& flip : bus_.flips) flip.due = false;
  }

  LineCounts counts() const override {
    return {bytes_, trace_.value(), faults_ + bus_.faults + faulty_->flipped()};
  }

 private:
  SpiDriver& driver_;
  FlippingBus bus_;
  std::unique_ptr<sim::SpiFaults> faulty_;
  std::uint64_t bytes_ = 0;
  TraceHash trace_;
  std::uint64_t faults_ = 0;
};

constexpr double kBitsPerByte = 10;  // start, eight, stop

}  // namespace

std::unique_ptr<FaultLine> byte_line(ByteDriver& driver, sim::ByteMachine& machine,
                                     Duration byte_time, Instant now) {
  return std::make_unique<ByteLine>(driver, machine, byte_time, now);
}

std::unique_ptr<FaultLine> spi_line(SpiDriver& driver, sim::SpiMachine& machine, Instant now) {
  return std::make_unique<SpiLine>(driver, machine, now);
}

FaultCell::FaultCell(const RobotModel& robot, const MachineVariant& options, Duration warm_up)
    : FaultCell(robot, *make_machine(robot, options, Instant{}), warm_up) {}

FaultCell::FaultCell(const RobotModel& robot, RobotMachine machine_of_robot, Duration warm_up)
    : robot_(robot), machine_(std::move(machine_of_robot)), now_(warm_up) {
  machine().advance(now_);
  replace_driver();
}

void FaultCell::replace_driver() {
  line_.reset();
  driver_ = make_driver(robot_);
  if (driver_.spi) {
    line_ = spi_line(*driver_.spi, *machine_.spi, now_);
  } else {
    const Duration byte_time = from_seconds(kBitsPerByte / robot_.device.baud);
    line_ = byte_line(*driver_.byte, *machine_.byte, byte_time, now_);
  }
}

void FaultCell::turn() {
  driver().poll(now_);
  now_ = line_->turn(now_);
  if (!look) return;
  while (const auto event = driver().take_event()) look(event);
  look(std::nullopt);
}

bool FaultCell::run_to(Instant end, Duration longest, const std::function<bool()>& done) {
  constexpr int kTurnsAtOnce = 10'000;
  int turns = 0;
  turn();
  while (now_ < end && !done()) {
    Instant next = std::min(end, now_ + longest);
    for (const auto& due :
         {driver().next_deadline(), machine().next_event(), line_->next_event()}) {
      if (due) next = std::min(next, *due);
    }
    turns = next <= now_ ? turns + 1 : 0;
    if (turns > kTurnsAtOnce) return false;
    now_ = std::max(now_, next);
    machine().advance(now_);
    turn();
  }
  return true;
}

}  // namespace sinew::test
