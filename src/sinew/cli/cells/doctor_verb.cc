#include "sinew/cli/cells/doctor_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "sinew/cli/cells/device_verb.h"
#include "sinew/cli/cells/robot_verb_options.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/verb_options.h"
#include "sinew/devices/encoder/encoder_verb.h"
#include "sinew/driver/quality_name.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/machine_check.h"

namespace sinew::cli {
namespace {

constexpr double kWatchMax = 600;  // s
/// For what boards report beside positions, such as their encoders' magnets.
constexpr Duration kListen = std::chrono::milliseconds(500);

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

std::string healthy_text(const RobotModel& model, const runtime::StationView& view) {
  std::string text;
  for (std::size_t i = 0; i < view.positions.size(); ++i) {
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", model.joints[i].name,
                        quality_name(view.positions[i].quality));
  }
  const DriverHealth& health = view.health;
  if (health.supply_volts) text += fmt::format("; supply {:.2f} V", *health.supply_volts);
  if (health.temperature_c) text += fmt::format("; {:.0f} deg C", *health.temperature_c);
  return text;
}

Outcome ask_robot(const DoctorRequest& request) {
  const auto chosen = choose_robot(request.robot);
  if (!chosen) return chosen.error();
  const RobotModel& model = chosen->model;
  const std::string& port = *request.robot.port;
  Outcome outcome;
  add_devices(outcome);
  io::catch_interrupts();
  const auto refuse = [&](const std::string& why) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint = why;
    outcome.json["answer"] = {{"ok", false}, {"sentence", why}};
    return outcome;
  };
  // As a run: what the device forgets by telling is recorded in the journal of its position.
  auto cell = LocalCell::start(model, request.robot);
  if (!cell) return refuse(cell.error().complaint);
  if (const auto trouble = (*cell)->enable()) return refuse((*cell)->sentence(*trouble));
  const io::Clock& clock = (*cell)->station().clock();
  const Instant end = clock.now() + kListen;
  while (clock.now() < end && io::interrupts() == 0) (*cell)->turn();
  const std::string answer = healthy_text(model, (*cell)->station().view());
  outcome.text += fmt::format("\n  {} answers on {}: {}\n", model.id, port, answer);
  tell_settings(chosen->settings, outcome);
  const std::string suspicion = (*cell)->station().suspicion();
  // What a board does not say is no trouble of the robot.
  add_boards(request.robot, model, *cell, outcome);
  outcome.json["answer"] = {{"ok", suspicion.empty()},
                            {"sentence", suspicion.empty() ? answer : suspicion}};
  if (suspicion.empty()) return outcome;
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint = port + ": " + suspicion;
  return outcome;
}

}  // namespace

Outcome examine(const DoctorRequest& request) {
  const RobotOptions& robot = request.robot;
  const bool more =
      robot.wire || robot.profile || robot.journal || robot.settings || !robot.without.empty();
  if (request.encoder) {
    if (!robot.name.empty() || robot.port || more) {
      return bad_input(
          "--encoder: a node by itself; --robot, --port and what belongs to them ask a robot");
    }
    if (!(request.watch_s >= 0 && request.watch_s <= kWatchMax)) {
      return bad_input(fmt::format("--watch: 0 to {:.0f} s", kWatchMax));
    }
    return examine_encoder({.port = *request.encoder, .watch_s = request.watch_s});
  }
  if (request.watch_s != 0) return bad_input("--watch belongs to an encoder node: --encoder PORT");
  if (robot.name.empty() != !robot.port) {
    return bad_input("--robot and --port belong together: which robot, and where it is plugged in");
  }
  if (!robot.port && more) {
    return bad_input(
        "--wire, --profile, --without, --journal and --settings belong to a robot: --robot ROBOT "
        "--port DEVICE");
  }
  if (robot.port) return ask_robot(request);
  Outcome outcome;
  add_devices(outcome);
  outcome.text +=
      "\n  sinew doctor --robot ROBOT --port DEVICE asks a robot whether it is there; nothing "
      "moves.\n  sinew doctor --encoder DEVICE asks an encoder node.\n";
  return outcome;
}

void add_doctor(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<DoctorRequest>();
  DoctorRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "doctor", "what this computer offers, and what answers",
                            "sinew doctor --robot learm --port /dev/ttyUSB0");
  RobotOptions& robot = request.robot;
  verb->add_option("--robot", robot.name, "id or .toml file");
  verb->add_option("--port", robot.port, kPorts + "; asked questions that move nothing");
  verb->add_option("--encoder", request.encoder,
                   "serial device of an RS-485 adapter with an encoder node, instead of a robot");
  verb->add_option("--watch", request.watch_s,
                   "with --encoder: seconds to turn the shaft by hand, which shows its direction");
  add_variant(*verb, robot);
  add_journal(*verb, robot);
  add_settings(*verb, robot);
  verb->callback([&call, own] { call.verb = [own] { return examine(*own); }; });
}

}  // namespace sinew::cli
