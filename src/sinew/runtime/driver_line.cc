#include "sinew/runtime/driver_line.h"

#include <algorithm>
#include <array>

namespace sinew::runtime {
namespace {

Duration until_deadline(const Driver& driver, const io::Clock& clock, Duration wait) {
  const auto deadline = driver.next_deadline();
  return deadline ? std::min(wait, clock.until(*deadline)) : wait;
}

class ByteLine : public DriverLine {
 public:
  ByteLine(ByteDriver& driver, io::Port& port, const io::Clock& clock, ByteLog& log)
      : driver_(driver), port_(port), clock_(clock), log_(log) {}

  io::IoResult<void> turn(Duration wait) override {
    auto result = send();
    if (result) result = receive(until_deadline(driver_, clock_, wait));
    // An answer often asks for the next request: it goes out at once.
    if (result) result = send();
    if (!result) driver_.close(clock_.now());
    return result;
  }
  const ByteCount& count() const override { return count_; }

 private:
  io::IoResult<void> send() {
    while (const std::size_t size = driver_.take_output(buffer_)) {
      const std::span bytes(buffer_.data(), size);
      log_.add(ByteLog::Direction::kToDevice, bytes, clock_.now());
      if (auto written = port_.write(bytes); !written) return written;
      count_.to_device += size;
    }
    return {};
  }

  io::IoResult<void> receive(Duration wait) {
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

  ByteDriver& driver_;
  io::Port& port_;
  const io::Clock& clock_;
  ByteLog& log_;
  ByteCount count_;
  std::array<std::uint8_t, 512> buffer_{};
};

class SpiLine : public DriverLine {
 public:
  SpiLine(SpiDriver& driver, io::SpiBus& bus, const io::Clock& clock, ByteLog& log)
      : driver_(driver), bus_(bus), clock_(clock), log_(log) {}

  io::IoResult<void> turn(Duration wait) override {
    driver_.poll(clock_.now());
    const auto transfer = driver_.take_transfer(clock_.now());
    if (!transfer) {
      clock_.pause(until_deadline(driver_, clock_, wait));
      return {};
    }
    miso_.resize(transfer->mosi.size());
    const std::span mosi(transfer->mosi.begin(), transfer->mosi.size());
    const std::span miso(miso_.begin(), miso_.size());
    log_.add(ByteLog::Direction::kToDevice, mosi, clock_.now());
    auto exchanged =
        bus_.exchange(transfer->select, mosi, miso, transfer->setup, transfer->clock_hz);
    const Instant now = clock_.now();
    if (!exchanged) {
      driver_.close(now);
      return exchanged;
    }
    log_.add(ByteLog::Direction::kToHost, miso, now);
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
  return std::make_unique<ByteLine>(driver, port, clock, log);
}

std::unique_ptr<DriverLine> line_over(SpiDriver& driver, io::SpiBus& bus, const io::Clock& clock,
                                      ByteLog& log) {
  return std::make_unique<SpiLine>(driver, bus, clock, log);
}

}  // namespace sinew::runtime
