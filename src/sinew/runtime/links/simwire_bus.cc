#include "sinew/runtime/links/simwire_bus.h"

#include <algorithm>
#include <array>
#include <optional>
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
      if (const auto result = next_read(); result != LineReader::Result::kMore) return result;
      const auto size = port_.read(buffer_, wait);
      if (!size) return std::unexpected(size.error());
      if (*size == 0) return LineReader::Result::kMore;
      place_ = 0;
      size_ = *size;
    }
  }
  /// The same of what has been read already.
  LineReader::Result next_read() {
    while (place_ < size_) {
      const auto result = reader_.push(static_cast<char>(buffer_[place_++]));
      if (result != LineReader::Result::kMore) return result;
    }
    return LineReader::Result::kMore;
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

void append_line(const Line& line, std::vector<std::uint8_t>& bytes) {
  bytes.insert(bytes.end(), line.begin(), line.end());
  bytes.push_back('\n');
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
    std::ranges::fill(miso, 0xFF);
    post_selects(select, false);
    if (auto waited = wait(setup); !waited) return waited;
    std::vector<std::pair<int, int>> served;
    for (std::size_t i = 0; i < boards_.size(); ++i) {
      const std::pair<int, int> bus{boards_[i].spi_bus, boards_[i].spi_device};
      if ((select >> i & 1) == 0) continue;
      if (std::find(served.begin(), served.end(), bus) != served.end()) continue;
      served.push_back(bus);
      post(Exchange{settings_of(boards_[i], clock_hz), Bytes(mosi)});
      const spi::Transfer clocked{select, spi::Bytes(mosi), Duration::zero(), clock_hz};
      if (clock_.is_simulated()) clock_.pass_to(clock_.now() + spi::wire_time(clocked));
    }
    post_selects(select, true);
    const auto done = collect();
    if (clock_.is_simulated()) clock_.keep_pace();
    if (!done) return done;
    std::size_t answered = 0;
    for (const Reply& reply : replies_) {
      if (std::holds_alternative<Ok>(reply)) continue;
      const auto* received = std::get_if<Miso>(&reply);
      if (received == nullptr || received->bytes.size() != miso.size()) return misfit();
      for (std::size_t i = 0; i < miso.size(); ++i) miso[i] &= received->bytes[i];
      ++answered;
    }
    if (answered != served.size()) return misfit();
    return {};
  }

  io::IoResult<bool> ready(std::size_t board) override {
    const auto reply = ask(GetPin{boards_[board].ready_gpio});
    if (!reply) return std::unexpected(reply.error());
    if (const auto* level = std::get_if<Level>(&*reply)) return level->high;
    return misfit();
  }

 private:
  static BusSettings settings_of(const AxisBoard& board, std::uint32_t clock_hz) {
    return {board.spi_bus, board.spi_device, clock_hz, 0};
  }

  void post_selects(std::uint8_t select, bool high) {
    for (std::size_t i = 0; i < boards_.size(); ++i) {
      if ((select >> i & 1) != 0) post(SetPin{boards_[i].select_gpio, high});
    }
  }

  /// What has been posted has been done when the wait begins.
  io::IoResult<void> wait(Duration time) {
    if (time <= Duration::zero()) return {};
    if (clock_.is_simulated()) {
      clock_.pass_to(clock_.now() + time);
      return {};
    }
    if (auto done = collect(); !done) return done;
    clock_.pause(time);
    return {};
  }

  /// Goes with the next collect(): a request at a time costs two changes of process each.
  void post(const Action& action) {
    const auto stamp = clock_.now().time_since_epoch() / std::chrono::microseconds(1);
    append_line(encode_request({static_cast<std::uint64_t>(stamp), action}), posted_);
    ++open_;
  }

  /// One reply for each that was posted, in replies_; all are read, and the first refusal is told.
  io::IoResult<void> collect() {
    replies_.clear();
    // What is still to come would be taken for the answer to something later.
    if (broken_) return std::unexpected(*broken_);
    io::IoResult<void> result = port_.write(posted_);
    posted_.clear();
    if (!result) return given_up(result.error());
    for (; open_ > 0; --open_) {
      auto reply = next_reply();
      if (!reply) return given_up(reply.error());
      if (const auto* why = std::get_if<Refused>(&*reply); why != nullptr && result) {
        result = said("refused: " + std::string(view(why->text)));
      }
      replies_.push_back(std::move(*reply));
    }
    return result;
  }

  io::IoResult<Reply> next_reply() {
    const auto read = lines_.next(kReplyMax);
    if (!read) return std::unexpected(read.error());
    if (*read == LineReader::Result::kMore) return said("no answer; is it simwire?");
    auto reply = *read == LineReader::Result::kLine ? decode_reply(lines_.line()) : std::nullopt;
    if (!reply) return said("the answer is not simwire");
    return std::move(*reply);
  }

  io::IoResult<Reply> ask(const Action& action) {
    post(action);
    if (const auto done = collect(); !done) return std::unexpected(done.error());
    return replies_.front();
  }

  io::IoResult<void> expect_ok(const Action& action) {
    const auto reply = ask(action);
    if (!reply) return std::unexpected(reply.error());
    if (std::holds_alternative<Ok>(*reply)) return {};
    return misfit();
  }

  std::unexpected<io::IoError> said(const std::string& what) const {
    return std::unexpected(io::IoError{port_.path() + ": " + what});
  }
  std::unexpected<io::IoError> given_up(const io::IoError& error) {
    broken_ = error;
    return std::unexpected(error);
  }
  std::unexpected<io::IoError> misfit() const { return said("the answer does not fit"); }

  io::Port port_;
  LineSource lines_;
  std::vector<std::uint8_t> posted_;  ///< not written yet
  std::size_t open_ = 0;              ///< requests that have no reply yet
  std::vector<Reply> replies_;
  std::optional<io::IoError> broken_;
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
    clock_.pass_to(machine_time_);
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
  std::vector<std::uint8_t> replies;
  while (!stop() && !server.finished()) {
    auto read = lines.next(kSlice);
    if (!read) return {};
    // What came together is answered together.
    for (; *read != LineReader::Result::kMore && !server.finished(); *read = lines.next_read()) {
      const Line reply = encode_reply(*read == LineReader::Result::kLine
                                          ? server.answer(lines.line())
                                          : Reply{Refused{text_of("the line is too long")}});
      log.add(ByteLog::Direction::kToDevice, bytes_of(lines.line()), server.now());
      log.add(ByteLog::Direction::kToHost, bytes_of(view(reply)), server.now());
      append_line(reply, replies);
    }
    if (auto written = port.write(replies); !written) return written;
    replies.clear();
  }
  return {};
}

}  // namespace sinew::runtime
