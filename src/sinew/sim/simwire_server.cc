#include "sinew/sim/simwire_server.h"

#include <algorithm>
#include <charconv>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"

namespace sinew::sim {

using namespace simwire;

namespace {

constexpr std::uint64_t kJumpUs = 3'600'000'000;
constexpr std::uint32_t kClockMax = 50'000'000;  // Hz

Reply refused(std::string_view why) {
  return Refused{text_of(why)};
}

void put(Line& line, std::string_view text) {
  for (const char c : text) {
    if (!line.full()) line.push_back(c);
  }
}

void put(Line& line, std::string_view key, std::size_t axis, double value) {
  char digits[32];
  const auto end =
      std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed, 6).ptr;
  put(line, " ");
  put(line, key);
  put(line, std::string_view("12345678").substr(axis, 1));
  put(line, "=");
  put(line, {digits, static_cast<std::size_t>(end - digits)});
}

void put(Line& line, const Figure& figure, std::optional<std::size_t> axis) {
  put(line, " ");
  put(line, figure.name);
  if (axis) {
    put(line, "_");
    put(line, std::string_view("12345678").substr(*axis, 1));
  }
  put(line, "=");
  if (const auto* word = std::get_if<std::string_view>(&figure.value)) return put(line, *word);
  if (const auto* count = std::get_if<std::uint64_t>(&figure.value)) {
    char digits[24];
    const auto end = std::to_chars(digits, digits + sizeof digits, *count).ptr;
    return put(line, {digits, static_cast<std::size_t>(end - digits)});
  }
  constexpr std::string_view kHex = "0123456789abcdef";
  for (const std::uint8_t byte : std::get<FixedVector<std::uint8_t, 16>>(figure.value)) {
    put(line, kHex.substr(byte >> 4U, 1));
    put(line, kHex.substr(byte & 15U, 1));
  }
}

}  // namespace

SimwireServer::SimwireServer(SpiMachine& machine, std::span<const AxisBoard> boards,
                             std::string_view name)
    : machine_(machine), boards_(boards), name_(text_of(name)) {
  for (const AxisBoard& board : boards) {
    SINEW_ASSERT(board.select_gpio < kPins && board.ready_gpio < kPins);
  }
}

void SimwireServer::restart() {
  pins_ = {};
  open_.clear();
  greeted_ = false;
  finished_ = false;
  last_us_.reset();
  update_selects();
}

Reply SimwireServer::answer(std::string_view line) {
  const auto request = decode_request(line);
  if (!request) return refused(request.error());
  const bool greets = std::holds_alternative<Hello>(request->action);
  // A host that begins may have another clock; the machine's own goes on from where it stands.
  if (greets) last_us_.reset();
  if (const auto why = advance_to(request->time_us)) return refused(*why);
  if (!greeted_ && !greets) return refused("say HELLO 1 first");
  return std::visit([this](const auto& action) { return act(action); }, request->action);
}

std::optional<std::string_view> SimwireServer::advance_to(std::uint64_t time_us) {
  if (last_us_ && time_us < *last_us_) return "the time ran back";
  const std::uint64_t passed = last_us_ ? time_us - *last_us_ : 0;
  // A stamp that is wrong must not be what all later ones are measured by.
  if (passed > kJumpUs) return "the time jumped by more than an hour; HELLO begins a new clock";
  last_us_ = time_us;
  // Time that a transfer took may already lie ahead of the host's stamp.
  const Instant stamp = stamp_ + std::chrono::microseconds(passed);
  stamp_ = stamp;
  now_ = std::max(now_, stamp);
  machine_.advance(now_);
  return std::nullopt;
}

Reply SimwireServer::act(const Hello& hello) {
  if (hello.version != kVersion) return refused("this speaks simwire 1");
  greeted_ = true;
  Text text = text_of("simwire 1 ");
  for (const char c : name_) {
    if (!text.full()) text.push_back(c);
  }
  return Ok{text};
}

Reply SimwireServer::act(const Direction& direction) {
  if (direction.pin >= kPins) return refused("no such pin");
  Pin& pin = pins_[direction.pin];
  pin.output = direction.output;
  pin.pull = direction.pull;
  update_selects();
  return Ok{};
}

Reply SimwireServer::act(const SetPin& set) {
  if (set.pin >= kPins) return refused("no such pin");
  if (!pins_[set.pin].output) return refused("the pin is no output");
  pins_[set.pin].latch = set.high;
  update_selects();
  return Ok{};
}

Reply SimwireServer::act(const GetPin& get) {
  if (get.pin >= kPins) return refused("no such pin");
  const Pin& pin = pins_[get.pin];
  if (pin.output) return Level{pin.latch};
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    if (boards_[i].ready_gpio == get.pin) return Level{machine_.ready_pin(i)};
  }
  return Level{pin.pull == Pull::kUp};
}

/// An output drives its latch; a line that nobody drives is pulled up on the board.
void SimwireServer::update_selects() {
  std::uint8_t mask = 0;
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    const Pin& pin = pins_[boards_[i].select_gpio];
    if (pin.output && !pin.latch) mask = static_cast<std::uint8_t>(mask | 1U << i);
  }
  machine_.select(mask, now_);
}

SimwireServer::OpenDevice* SimwireServer::find_open(std::uint32_t bus, std::uint32_t device) {
  auto* const found = std::ranges::find_if(
      open_, [&](const OpenDevice& one) { return one.bus == bus && one.device == device; });
  return found == open_.end() ? nullptr : found;
}

Reply SimwireServer::act(const Open& open) {
  if (OpenDevice* const again = find_open(open.settings.bus, open.settings.device)) {
    ++again->users;
    return Ok{};
  }
  if (open_.full()) return refused("too many buses are open");
  open_.push_back({open.settings.bus, open.settings.device, 1});
  return Ok{};
}

Reply SimwireServer::act(const Close& close) {
  OpenDevice* const device = find_open(close.bus, close.device);
  if (device == nullptr) return refused("this bus is not open");
  if (--device->users == 0) {
    *device = open_.back();
    open_.pop_back();
  }
  return Ok{};
}

Reply SimwireServer::act(const Exchange& exchange) {
  const BusSettings& settings = exchange.settings;
  if (find_open(settings.bus, settings.device) == nullptr) return refused("this bus is not open");
  if (settings.clock_hz == 0 || settings.clock_hz > kClockMax) {
    return refused("the clock is 1 Hz to 50 MHz");
  }
  miso_.resize(exchange.mosi.size());
  std::ranges::fill(miso_, std::uint8_t{0});
  const bool has_boards = std::ranges::any_of(boards_, [&](const AxisBoard& board) {
    return board.spi_bus == settings.bus && board.spi_device == settings.device;
  });
  // In another mode the boards sample the wrong edge; what they hear is not worth simulating.
  if (has_boards && settings.mode == 0) {
    machine_.shift({exchange.mosi.data(), exchange.mosi.size()}, {miso_.data(), miso_.size()},
                   settings.clock_hz, now_);
  }
  now_ += Duration{static_cast<std::int64_t>(exchange.mosi.size()) * 8 * 1'000'000'000 /
                   settings.clock_hz};
  return Miso{miso_};
}

Report SimwireServer::report(bool dump) const {
  Report report{dump, {}};
  const Truth truth = machine_.truth();
  put(report.text, "time_s");
  put(report.text, "=");
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits,
                                 to_seconds(now_.time_since_epoch()), std::chars_format::fixed, 6)
                       .ptr;
  put(report.text, {digits, static_cast<std::size_t>(end - digits)});
  for (std::size_t i = 0; i < truth.joints.size(); ++i) {
    put(report.text, "q_deg_", i, to_deg(truth.joints[i].q));
    for (const Figure& figure : machine_.figures(i)) put(report.text, figure, i);
    if (!dump) continue;
    put(report.text, "believed_deg_", i, to_deg(truth.joints[i].believed));
    put(report.text, "qd_deg_s_", i, to_deg(truth.joints[i].qd));
    put(report.text, {"lost_steps", std::uint64_t{truth.joints[i].lost_steps ? 1U : 0U}}, i);
  }
  for (const Figure& figure : machine_.figures(std::nullopt)) {
    put(report.text, figure, std::nullopt);
  }
  put(report.text, truth.moving ? " moving=1" : " moving=0");
  return report;
}

Reply SimwireServer::act(const Statistics& /*none*/) {
  return report(false);
}

Reply SimwireServer::act(const Dump& /*none*/) {
  return report(true);
}

Reply SimwireServer::act(const Poke& /*none*/) {
  return refused("nothing is poked here: what differs from the belief has a physical cause");
}

Reply SimwireServer::act(const Fault& /*none*/) {
  return refused("faults are given when the simulation starts: --fault");
}

Reply SimwireServer::act(const Bye& /*none*/) {
  finished_ = true;
  return Ok{};
}

}  // namespace sinew::sim
