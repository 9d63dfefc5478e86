#include "sinew/cli/doctor_verb.h"

#include <fmt/format.h>

#include "sinew/cli/device_argument.h"
#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/table.h"
#include "sinew/driver/quality_name.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/machine_check.h"
#include "sinew/runtime/robot_link.h"
#include "sinew/runtime/robot_variant.h"
#include "sinew/runtime/session_pace.h"

namespace sinew::cli {
namespace {

const char* kind_name(io::FoundDevice::Kind kind) {
  constexpr const char* kNames[] = {"serial port", "SPI bus", "GPIO chip"};
  return kNames[static_cast<int>(kind)];
}

void add_devices(Outcome& outcome) {
  Json list = Json::array();
  Table table({"device", "what", "name", "usable"});
  table.left(1).left(2).left(3);
  for (const io::FoundDevice& device : io::find_devices()) {
    const bool usable = device.trouble.empty();
    table.add({device.path, kind_name(device.kind), device.name, usable ? "yes" : device.trouble});
    list.push_back({{"path", device.path},
                    {"kind", kind_name(device.kind)},
                    {"name", device.name},
                    {"usable", usable},
                    {"trouble", device.trouble}});
  }
  if (!list.empty()) outcome.text += table.text() + "\n";
  outcome.json["devices"] = list;
  outcome.json["missing"] = Json::array();
  for (const std::string& missing : io::missing_interfaces()) {
    outcome.text += "  missing: " + missing + "\n";
    outcome.json["missing"].push_back(missing);
  }
}

/// Opens the driver and lets it ask its harmless questions until it is ready or gives up.
std::optional<Error> first_answer(runtime::RobotLink& link, const io::Clock& clock, Duration limit,
                                  std::optional<io::IoError>& wire_failure) {
  Driver& driver = link.driver();
  Error trouble{.code = ErrorCode::kDeviceSilent, .limit = to_seconds(limit)};
  driver.open(clock.now());
  while (clock.now() < Instant{} + limit && io::interrupts() == 0) {
    while (const auto event = driver.take_event()) {
      if (event->kind == DriverEvent::Kind::kReady) return std::nullopt;
      if (event->kind == DriverEvent::Kind::kFailed) trouble = event->error;
    }
    if (driver.state() == DriverState::kFault) return driver.fault();
    if (const auto turned = link.line().turn(runtime::kSliceMax); !turned) {
      wire_failure = turned.error();
      return trouble;
    }
  }
  return trouble;
}

std::string healthy_text(const RobotModel& model, const Driver& driver) {
  std::string text;
  const auto positions = driver.positions();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", model.joints[i].name,
                        quality_name(positions[i].quality));
  }
  const DriverHealth health = driver.health();
  if (health.supply_volts) text += fmt::format("; supply {:.2f} V", *health.supply_volts);
  if (health.temperature_c) text += fmt::format("; {:.0f} deg C", *health.temperature_c);
  return text;
}

Outcome ask_robot(const DoctorRequest& request) {
  const auto file = find_robot(*request.robot);
  if (!file) return file.error();
  if (const auto fine = check_has_device(file->model); !fine) return fine.error();
  const auto model = runtime::variant_of(file->model, request.profile, request.wire);
  if (!model) return bad_input(model.error());
  Outcome outcome;
  add_devices(outcome);
  io::catch_interrupts();
  const io::Clock clock;
  runtime::ByteLog log;
  auto link = runtime::RobotLink::open(*model, *request.port, clock, log);
  if (!link) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint = link.error().sentence;
    outcome.json["answer"] = {{"ok", false}, {"sentence", outcome.complaint}};
    return outcome;
  }
  std::optional<io::IoError> wire_failure;
  const auto trouble = first_answer(*link, clock, runtime::opening_of(*model).limit, wire_failure);
  if (trouble) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint =
        *request.port + ": " +
        (wire_failure ? wire_failure->sentence
                      : error_text(*trouble, *model) +
                            silence_hint(*model, *trouble, link->driver().health()));
    outcome.json["answer"] = {{"ok", false}, {"sentence", outcome.complaint}};
    return outcome;
  }
  const std::string answer = healthy_text(*model, link->driver());
  outcome.text += fmt::format("\n  {} answers on {}: {}\n", model->id, *request.port, answer);
  const std::string suspicion = runtime::suspicion(link->driver());
  outcome.json["answer"] = {{"ok", suspicion.empty()},
                            {"sentence", suspicion.empty() ? answer : suspicion}};
  if (suspicion.empty()) return outcome;
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint = *request.port + ": " + suspicion;
  return outcome;
}

}  // namespace

Outcome examine(const DoctorRequest& request) {
  if (request.robot.has_value() != request.port.has_value()) {
    return bad_input("--robot and --port belong together: which robot, and where it is plugged in");
  }
  if (!request.robot && (request.wire || request.profile)) {
    return bad_input("--wire and --profile belong to a robot: --robot ROBOT --port DEVICE");
  }
  if (request.robot) return ask_robot(request);
  Outcome outcome;
  add_devices(outcome);
  outcome.text +=
      "\n  sinew doctor --robot ROBOT --port DEVICE asks a robot whether it is there; nothing "
      "moves.\n";
  return outcome;
}

}  // namespace sinew::cli
