#include "sinew/runtime/driver_line.h"

#include <algorithm>

namespace sinew::runtime {
namespace {

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
    driver_.poll(clock_.now());
    const auto transfer = driver_.take_transfer(clock_.now());
    if (!transfer) {
      Instant end = clock_.now() + clock_.stretched(wait);
      if (const auto deadline = driver_.next_deadline()) end = std::min(end, *deadline);
      clock_.pause_until(end);
      return {};
    }
    miso_.resize(transfer->mosi.size());
    const std::span mosi(transfer->mosi.begin(), transfer->mosi.size());
    const std::span miso(miso_.begin(), miso_.size());
    log_.add(ByteLog::Direction::kToDevice, mosi, clock_.now(), transfer->select);
    auto exchanged =
        bus_.exchange(transfer->select, mosi, miso, transfer->setup, transfer->clock_hz);
    const Instant now = clock_.now();
    if (!exchanged) {
      driver_.close(now);
      return exchanged;
    }
    log_.add(ByteLog::Direction::kToHost, miso, now, transfer->select);
    count_.to_device += mosi.size();
    count_.to_host += miso.size();
    driver_.exchanged(miso, now);
    return {};
  }
  const ByteCount& count() const override { return count_; }

 private:
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
