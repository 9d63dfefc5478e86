#include "sinew/runtime/links/driver_line.h"

#include <algorithm>

namespace sinew::runtime {
namespace {

/// The control loop looks at boards at least so often in their own time, however fast that is.
constexpr double kSlices = 5;
/// s of real time between two polls at rest; 5 ms of theirs at most, a quarter of any deadline.
constexpr double kRestStep = 0.001;

class SerialLine : public DriverLine {
 public:
  SerialLine(ByteDriver& driver, io::Port& port, const io::Clock& clock, ByteLog& log)
      : driver_(driver), clock_(clock), line_(driver, port, clock, log) {}

  io::IoResult<void> turn(Duration wait) override {
    auto result = line_.send();
    if (result) result = line_.receive(wait);
    // An answer often asks for the next request: it goes out at once.
    if (result) result = line_.send();
    if (!result) driver_.close(clock_.now());
    return result;
  }
  const ByteCount& count() const override { return line_.count(); }

 private:
  ByteDriver& driver_;
  const io::Clock& clock_;
  ByteLine<ByteDriver> line_;
};

class SpiLine : public DriverLine {
 public:
  SpiLine(SpiDriver& driver, io::SpiBus& bus, const io::Clock& clock, ByteLog& log)
      : driver_(driver), bus_(bus), clock_(clock), log_(log) {}

  io::IoResult<void> turn(Duration wait) override {
    const bool simulated = clock_.is_simulated();
    const double slices = at_rest() ? clock_.scale() : std::min(clock_.scale(), kSlices);
    const Duration own = from_seconds(to_seconds(wait) * slices);
    const Instant end = simulated ? clock_.end_of_turn(own) : clock_.now() + clock_.stretched(wait);
    const DriverState state = driver_.state();
    const bool wanted = driver_.wants_move(clock_.now());
    // One exchange; simulated as many as the controller need not see one by one.
    do {
      driver_.poll(clock_.now());
      if (const auto transfer = driver_.take_transfer(clock_.now())) {
        if (auto exchanged = exchange(*transfer); !exchanged) return exchanged;
      } else {
        const auto deadline = driver_.next_deadline();
        const Instant next = deadline ? std::min(end, *deadline) : end;
        if (!simulated) {
          clock_.pause_until(next);
          return {};
        }
        const Instant now = clock_.now();
        clock_.pass_to(std::max(next, std::min(end, now + rest_step())));
        if (clock_.now() == now) break;
      }
    } while (simulated && clock_.now() < end && driver_.state() == state &&
             driver_.wants_move(clock_.now()) == wanted);
    if (simulated) clock_.keep_pace();
    return {};
  }
  const ByteCount& count() const override { return count_; }

 private:
  /// Where nothing moves and time runs faster, the boards are polled less often in their time.
  Duration rest_step() const {
    const bool rests = at_rest() && driver_.state() == DriverState::kReady;
    return rests && clock_.scale() > 1 ? from_seconds(kRestStep * std::min(clock_.scale(), kSlices))
                                       : Duration::zero();
  }

  io::IoResult<void> exchange(const spi::Transfer& transfer) {
    miso_.resize(transfer.mosi.size());
    const std::span mosi(transfer.mosi.begin(), transfer.mosi.size());
    const std::span miso(miso_.begin(), miso_.size());
    log_.add(ByteLog::Direction::kToDevice, mosi, clock_.now(), transfer.select);
    auto exchanged = bus_.exchange(transfer.select, mosi, miso, transfer.setup, transfer.clock_hz);
    const Instant now = clock_.now();
    if (!exchanged) {
      driver_.close(now);
      return exchanged;
    }
    log_.add(ByteLog::Direction::kToHost, miso, now, transfer.select);
    count_.to_device += mosi.size();
    count_.to_host += miso.size();
    driver_.exchanged(miso, now);
    return {};
  }

  SpiDriver& driver_;
  io::SpiBus& bus_;
  const io::Clock& clock_;
  ByteLog& log_;
  ByteCount count_;
  spi::Bytes miso_;
};

}  // namespace

std::unique_ptr<DriverLine> line_over(ByteDriver& driver, io::Port& port, const io::Clock& clock,
                                      ByteLog& log) {
  return std::make_unique<SerialLine>(driver, port, clock, log);
}

std::unique_ptr<DriverLine> line_over(SpiDriver& driver, io::SpiBus& bus, const io::Clock& clock,
                                      ByteLog& log) {
  return std::make_unique<SpiLine>(driver, bus, clock, log);
}

}  // namespace sinew::runtime
