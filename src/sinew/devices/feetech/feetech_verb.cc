#include "sinew/devices/feetech/feetech_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "sinew/cli/output/table.h"
#include "sinew/devices/feetech/feetech_driver_bus.h"
#include "sinew/devices/feetech/feetech_driver_setup.h"
#include "sinew/io/clock.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/port.h"

namespace sinew::cli {
namespace {

constexpr Duration kReplyTimeout = std::chrono::milliseconds(20);
constexpr Duration kBehindWrite = std::chrono::milliseconds(20);  // a setting is slow to be kept

/// A real port, waited for.
class PortLine final : public FeetechLine {
 public:
  PortLine(io::Port port, std::uint32_t baud)
      : port_(std::move(port)), bus_({.baud = baud, .reply_timeout = kReplyTimeout}) {}

  std::optional<feetech::Reply> ask(const feetech::Read& read) override {
    bus_.reset(clock_.now());
    health_ = {};
    bus_.ask(read, clock_.now());
    flush();
    while (bus_.asking() && !lost_) {
      if (!bus_.give_up(clock_.now()).empty()) return std::nullopt;
      std::array<std::uint8_t, 64> buffer{};
      const auto count = port_.read(buffer, std::chrono::milliseconds(1));
      if (!count) {
        lost_ = count.error().sentence;
        break;
      }
      for (std::size_t i = 0; i < *count; ++i) {
        if (auto reply = bus_.receive(buffer[i], clock_.now(), health_)) return reply;
      }
    }
    return std::nullopt;
  }
  void write(const feetech::Request& request) override {
    bus_.reset(clock_.now());
    bus_.write(request, clock_.now());
    flush();
    clock_.pause(kBehindWrite);
    std::array<std::uint8_t, 64> buffer{};
    static_cast<void>(port_.read(buffer, std::chrono::milliseconds(1)));
  }
  bool garbled() const override { return health_.unexpected > 0; }
  /// Why the port is gone.
  const std::optional<std::string>& lost() const { return lost_; }

 private:
  void flush() {
    std::array<std::uint8_t, feetech::kPacketMax> bytes{};
    const std::size_t count = bus_.take_output(bytes);
    const auto written = port_.write(std::span(bytes).first(count));
    if (!written) lost_ = written.error().sentence;
  }

  io::Port port_;
  FeetechBus bus_;
  io::Clock clock_;
  DriverHealth health_;
  std::optional<std::string> lost_;
};

std::string series_name(FeetechSeries series) {
  return series == FeetechSeries::kSts ? "sts" : "scs";
}

Json servo_json(const FoundServo& servo) {
  return {{"servo", servo.id},
          {"series", series_name(servo.series)},
          {"model", servo.model},
          {"firmware", fmt::format("{}.{}", servo.firmware_major, servo.firmware_minor)},
          {"position_units", servo.position},
          {"lowest_units", servo.lowest},
          {"highest_units", servo.highest},
          {"offset_units", servo.offset},
          {"holds_positions", servo.holds_positions},
          {"motor_on", servo.motor_on},
          {"load", servo.load},
          {"volts", servo.volts},
          {"temperature_c", servo.heat},
          {"trouble", servo.trouble}};
}

Outcome table_of(const std::vector<FoundServo>& servos) {
  Outcome outcome;
  outcome.json["servos"] = Json::array();
  Table table({"servo", "series", "model", "firmware", "position", "limits", "offset", "motor",
               "load", "V", "deg C"});
  table.left(1).left(7);
  for (const FoundServo& servo : servos) {
    table.add({fmt::format("{}", servo.id), series_name(servo.series),
               fmt::format("{}", servo.model),
               fmt::format("{}.{}", servo.firmware_major, servo.firmware_minor),
               fmt::format("{}", servo.position),
               servo.holds_positions ? fmt::format("{}..{}", servo.lowest, servo.highest) : "wheel",
               fmt::format("{}", servo.offset), servo.motor_on ? "on" : "off",
               fmt::format("{:.0f} %", 100 * std::abs(servo.load)),
               fmt::format("{:.1f}", servo.volts), fmt::format("{:.0f}", servo.heat)});
    outcome.json["servos"].push_back(servo_json(servo));
  }
  outcome.text = table.text();
  return outcome;
}

bool may_go_on(std::uint8_t /*number*/) {
  return io::interrupts() == 0;
}

Outcome list(PortLine& line, const ServosRequest& request) {
  const FoundServos found = find_servos(line, static_cast<std::uint8_t>(request.last), may_go_on);
  Outcome outcome = table_of(found.servos);
  outcome.json["garbled"] = found.garbled;
  for (const std::uint8_t number : found.garbled) {
    outcome.text += fmt::format(
        "  {}: garbled replies; two servos have this number. Leave one of them on the bus\n",
        number);
  }
  if (found.servos.empty() && found.garbled.empty()) {
    outcome = could_not(fmt::format(
        "no servo from 0 to {} replies on {} at {} baud: have the servos their own supply? "
        "--last 253 asks all numbers, --baud another rate",
        request.last, request.port, request.baud));
  }
  if (io::interrupts() > 0) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint = "stopped before all numbers were asked";
  }
  return outcome;
}

std::optional<Outcome> refusal(const ServosRequest& request) {
  const auto is_number = [](std::int64_t id) { return id >= 0 && id <= FeetechDevice::kIdMax; };
  if (!is_number(request.last)) return bad_input("--last: a servo's number is 0 to 253");
  if (request.id && !is_number(*request.id)) return bad_input("--id: a servo's number is 0 to 253");
  if (request.new_id && !is_number(*request.new_id)) {
    return bad_input("--new-id: a servo's number is 0 to 253");
  }
  if (request.baud < 9600 || request.baud > 1'000'000) {
    return bad_input("--baud: 9600 to 1000000");
  }
  if ((request.new_id || request.middle) && !request.id) {
    return bad_input("--id: which servo? sinew servos PORT lists them");
  }
  if (request.new_id && request.middle) {
    return bad_input("--new-id and --middle: one at a time");
  }
  return std::nullopt;
}

}  // namespace

Outcome servos(const ServosRequest& request) {
  if (const auto refused = refusal(request)) return *refused;
  const auto baud = static_cast<std::uint32_t>(request.baud);
  auto port = io::Port::open_serial(request.port, baud);
  if (!port) return could_not(port.error().sentence);
  io::catch_interrupts();
  PortLine line(std::move(*port), baud);
  Outcome outcome;
  if (!request.id) {
    outcome = list(line, request);
  } else {
    const auto id = static_cast<std::uint8_t>(*request.id);
    const auto servo = request.new_id
                           ? change_id(line, id, static_cast<std::uint8_t>(*request.new_id))
                       : request.middle ? set_middle(line, id)
                                        : find_servo(line, id);
    outcome = servo ? table_of({*servo}) : could_not(servo.error());
  }
  return line.lost() ? could_not(*line.lost()) : outcome;
}

void add_servos(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<ServosRequest>();
  ServosRequest& request = *own;
  CLI::App* verb =
      add_verb(app, call, "servos", "Feetech bus servos: which reply, and their numbers",
               "sinew servos /dev/ttyACM0 --id 1 --new-id 4");
  verb->add_option("PORT", request.port, "serial device of the servos' adapter")->required();
  verb->add_option("--baud", request.baud, "baud rate (default 1000000)");
  verb->add_option("--last", request.last, "highest number to ask (default 20)");
  verb->add_option("--id", request.id, "one servo instead");
  verb->add_option("--new-id", request.new_id, "with --id: its new number, kept without power");
  verb->add_flag("--middle", request.middle,
                 "with --id: where it is becomes its middle (2048), kept without power; STS");
  verb->callback([&call, own] { call.verb = [own] { return servos(*own); }; });
}

}  // namespace sinew::cli
