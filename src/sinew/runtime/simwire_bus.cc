#include "sinew/runtime/simwire_bus.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace sinew::runtime {
namespace {

using namespace simwire;

constexpr Duration kReplyMax = std::chrono::seconds(2);
constexpr Duration kSlice = std::chrono::milliseconds(50);

/// Lines out of a port, one at a time.
class LineSource {
 public:
  explicit LineSource(io::Port& port) : port_(port) {}

  /// A whole line, `kTooLong`, or kMore where none came within `wait`.
  io::IoResult<LineReader::Result> next(Duration wait) {
    while (true) {
      while (place_ < size_) {
        const auto result = reader_.push(static_cast<char>(buffer_[place_++]));
        if (result != LineReader::Result::kMore) return result;
      }
      const auto size = port_.read(buffer_, wait);
      if (!size) return std::unexpected(size.error());
      if (*size == 0) return LineReader::Result::kMore;
      place_ = 0;
      size_ = *size;
    }
  }
  std::string_view line() const { return reader_.line(); }

 private:
  io::Port& port_;
  LineReader reader_;
  std::array<std::uint8_t, 4096> buffer_{};
  std::size_t place_ = 0;
  std::size_t size_ = 0;
};

std::vector<std::uint8_t> bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

io::IoResult<void> write_line(io::Port& port, const Line& line) {
  std::vector<std::uint8_t> bytes(line.begin(), line.end());
  bytes.push_back('\n');
  return port.write(bytes);
}

class SimwireBus : public io::SpiBus {
 public:
  SimwireBus(io::Port port, std::span<const AxisBoard> boards, const io::Clock& clock)
      : port_(std::move(port)),
        lines_(port_),
        boards_(boards.begin(), boards.end()),
        clock_(clock) {}

  /// HELLO, selects high, one bus open for each that a board sits on.
  io::IoResult<void> begin() {
    auto greeted = ask(Hello{});
    if (!greeted) return std::unexpected(greeted.error());
    std::vector<std::pair<int, int>> opened;
    for (const AxisBoard& board : boards_) {
      // The latch is 0 at power-on: for a moment every board is selected. No byte is clocked.
      if (auto done = expect_ok(Direction{board.select_gpio, true, Pull::kOff}); !done) return done;
      if (auto done = expect_ok(SetPin{board.select_gpio, true}); !done) return done;
      if (auto done = expect_ok(Direction{board.ready_gpio, false, Pull::kUp}); !done) return done;
      const std::pair<int, int> bus{board.spi_bus, board.spi_device};
      if (std::find(opened.begin(), opened.end(), bus) != opened.end()) continue;
      opened.push_back(bus);
      if (auto done = expect_ok(Open{settings_of(board, 500'000)}); !done) return done;
    }
    return {};
  }

  io::IoResult<void> exchange(std::uint8_t select, std::span<const std::uint8_t> mosi,
                              std::span<std::uint8_t> miso, Duration setup,
                              std::uint32_t clock_hz) override {
    if (auto low = set_selects(select, false); !low) return low;
    if (clock_.is_simulated()) {
      clock_.pass_to(clock_.now() + setup);
    } else if (setup > Duration::zero()) {
      clock_.pause(real(setup));
    }
    std::ranges::fill(miso, 0xFF);
    io::IoResult<void> result;
    std::vector<std::pair<int, int>> served;
    for (std::size_t i = 0; i < boards_.size() && result; ++i) {
      const std::pair<int, int> bus{boards_[i].spi_bus, boards_[i].spi_device};
      if ((select >> i & 1) == 0) continue;
      if (std::find(served.begin(), served.end(), bus) != served.end()) continue;
      served.push_back(bus);
      result = transfer(boards_[i], mosi, miso, clock_hz);
      if (!clock_.is_simulated()) continue;
      const spi::Transfer clocked{select, spi::Bytes(mosi), Duration::zero(), clock_hz};
      clock_.pass_to(clock_.now() + spi::wire_time(clocked));
      clock_.keep_pace();
    }
    const auto high = set_selects(select, true);
    return result ? high : result;
  }

  io::IoResult<bool> ready(std::size_t board) override {
    const auto reply = ask(GetPin{boards_[board].ready_gpio});
    if (!reply) return std::unexpected(reply.error());
    if (const auto* level = std::get_if<Level>(&*reply)) return level->high;
    return std::unexpected(io::IoError{port_.path() + ": no level of a pin"});
  }

 private:
  static BusSettings settings_of(const AxisBoard& board, std::uint32_t clock_hz) {
    return {board.spi_bus, board.spi_device, clock_hz, 0};
  }
  Duration real(Duration duration) const {
    return from_seconds(to_seconds(duration) / clock_.scale());
  }

  io::IoResult<void> set_selects(std::uint8_t select, bool high) {
    for (std::size_t i = 0; i < boards_.size(); ++i) {
      if ((select >> i & 1) == 0) continue;
      if (auto done = expect_ok(SetPin{boards_[i].select_gpio, high}); !done) return done;
    }
    return {};
  }

  io::IoResult<void> transfer(const AxisBoard& board, std::span<const std::uint8_t> mosi,
                              std::span<std::uint8_t> miso, std::uint32_t clock_hz) {
    Exchange request{settings_of(board, clock_hz), Bytes(mosi)};
    const auto reply = ask(request);
    if (!reply) return std::unexpected(reply.error());
    const auto* received = std::get_if<Miso>(&*reply);
    if (received == nullptr || received->bytes.size() != miso.size()) {
      return std::unexpected(io::IoError{port_.path() + ": no answer to a transfer"});
    }
    for (std::size_t i = 0; i < miso.size(); ++i) miso[i] &= received->bytes[i];
    return {};
  }

  io::IoResult<Reply> ask(const Action& action) {
    const auto stamp = clock_.now().time_since_epoch() / std::chrono::microseconds(1);
    if (auto sent = write_line(port_, encode_request({static_cast<std::uint64_t>(stamp), action}));
        !sent) {
      return std::unexpected(sent.error());
    }
    const auto read = lines_.next(kReplyMax);
    if (!read) return std::unexpected(read.error());
    const auto reply =
        *read == LineReader::Result::kLine ? decode_reply(lines_.line()) : std::nullopt;
    if (!reply) {
      return std::unexpected(io::IoError{port_.path() + (*read == LineReader::Result::kMore
                                                             ? ": no answer; is it simwire?"
                                                             : ": the answer is not simwire")});
    }
    if (const auto* why = std::get_if<Refused>(&*reply)) {
      return std::unexpected(
          io::IoError{port_.path() + ": refused: " + std::string(view(why->text))});
    }
    return *reply;
  }

  io::IoResult<void> expect_ok(const Action& action) {
    const auto reply = ask(action);
    if (!reply) return std::unexpected(reply.error());
    if (std::holds_alternative<Ok>(*reply)) return {};
    return std::unexpected(io::IoError{port_.path() + ": the answer does not fit"});
  }

  io::Port port_;
  LineSource lines_;
  std::vector<AxisBoard> boards_;
  const io::Clock& clock_;
};

class MachineBus : public io::SpiBus {
 public:
  MachineBus(sim::SpiMachine& machine, const io::Clock& clock) : machine_(machine), clock_(clock) {}

  io::IoResult<void> exchange(std::uint8_t select, std::span<const std::uint8_t> mosi,
                              std::span<std::uint8_t> miso, Duration setup,
                              std::uint32_t clock_hz) override {
    const spi::Transfer transfer{select, spi::Bytes(mosi), setup, clock_hz};
    // The machine's time never runs back, and a transfer's own time lies ahead of the clock.
    const Instant start = std::max(clock_.now(), machine_time_);
    const spi::Bytes received = machine_.exchange(transfer, start);
    machine_time_ = start + setup + spi::wire_time(transfer);
    std::ranges::copy(received, miso.begin());
    clock_.pause_until(machine_time_);
    return {};
  }
  io::IoResult<bool> ready(std::size_t board) override { return machine_.ready_pin(board); }

 private:
  sim::SpiMachine& machine_;
  const io::Clock& clock_;
  Instant machine_time_{};
};

}  // namespace

io::IoResult<std::unique_ptr<io::SpiBus>> connect_simwire(io::Port port,
                                                          std::span<const AxisBoard> boards,
                                                          const io::Clock& clock) {
  auto bus = std::make_unique<SimwireBus>(std::move(port), boards, clock);
  if (const auto begun = bus->begin(); !begun) return std::unexpected(begun.error());
  return bus;
}

std::unique_ptr<io::SpiBus> bus_of(sim::SpiMachine& machine, const io::Clock& clock) {
  return std::make_unique<MachineBus>(machine, clock);
}

io::IoResult<void> serve_simwire(sim::SimwireServer& server, io::Port& port, ByteLog& log,
                                 const std::function<bool()>& stop) {
  LineSource lines(port);
  while (!stop() && !server.finished()) {
    const auto read = lines.next(kSlice);
    if (!read) return {};
    if (*read == LineReader::Result::kMore) continue;
    const Line reply = encode_reply(*read == LineReader::Result::kLine
                                        ? server.answer(lines.line())
                                        : Reply{Refused{text_of("the line is too long")}});
    log.add(ByteLog::Direction::kToDevice, bytes_of(lines.line()), server.now());
    log.add(ByteLog::Direction::kToHost, bytes_of(view(reply)), server.now());
    if (auto written = write_line(port, reply); !written) return written;
  }
  return {};
}

}  // namespace sinew::runtime
