#include "sinew/devices/icp/icp_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>

#include "sinew/cli/cells/robot_verb_options.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/program_report.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/verb_options.h"
#include "sinew/core/error_code.h"
#include "sinew/core/spelling.h"
#include "sinew/devices/icp/icp_driver_facts.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/devices/icp/tmc222_wire_words.h"
#include "sinew/io/interrupt.h"
#include "sinew/model/left_out.h"

namespace sinew::cli {
namespace {

constexpr std::array<std::string_view, 4> kHexapodActions{"status", "wake", "kill", "jog"};
constexpr std::array<std::string_view, 2> kBoardActions{"release", "test"};
/// Microsteps of one leg in one call; 1 mm.
constexpr std::int64_t kStepsMax = 4571;

std::string flags_text(const tmc222::Flags& flags) {
  std::string text;
  for (const tmc222::FlagWord& word : tmc222::kFlagWords) {
    if (flags.*word.flag) text += (text.empty() ? "" : ", ") + std::string(word.text);
  }
  return text.empty() ? "none" : text;
}

Outcome status_outcome(const runtime::Station& station) {
  const RobotModel& model = station.robot();
  const auto facts = station.view().facts;
  const auto* heard = facts.as<IcpFacts>();
  SINEW_ASSERT(heard != nullptr);
  const auto& legs = heard->legs;
  Outcome outcome;
  outcome.json["legs"] = Json::array();
  Table table({"leg", "motion", "last step", "flags", "the 12 bytes"});
  table.left(1).left(3).left(4);
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    if (!legs[leg].status) continue;
    const icp::Status& status = legs[leg].status->what;
    std::string bytes;
    for (const std::uint8_t byte : icp::encode_status(status)) {
      bytes += fmt::format("{}{:02X}", bytes.empty() ? "" : " ", byte);
    }
    const std::string flags = flags_text(status.one.flags);
    const std::string motion(tmc222::words(status.one.motion).text);
    table.add({model.joints[leg].name, motion, fmt::format("{}", status.two.target), flags, bytes});
    outcome.json["legs"].push_back({{"joint", model.joints[leg].name},
                                    {"motion", motion},
                                    {"target_units", status.two.target},
                                    {"actual_units", status.two.actual},
                                    {"flags", flags},
                                    {"bytes", bytes}});
  }
  outcome.text = table.text();
  return outcome;
}

/// What the modules reported when the port was opened, also where that is why it is not ready:
/// asked once more, they would have forgotten their flags.
Outcome status(LocalCell& cell) {
  const auto why = cell.enable();
  Outcome outcome = status_outcome(cell.station());
  if (!why) return outcome;
  if (outcome.json["legs"].empty()) outcome.text.clear();
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint = cell.sentence(*why);
  outcome.json["error"] = {{"sentence", outcome.complaint}};
  return outcome;
}

/// What a command that did not come to its end ends with.
Outcome not_done(const LocalCell& cell, const control::ControlEvent& end) {
  if (end.kind != control::ControlEvent::Kind::kStopped) return could_not(cell.sentence(end.error));
  return could_not(cell.station().port_name() + ": stopped");
}

Outcome service(const DeviceRequest& request, LocalCell& cell) {
  if (const auto why = cell.enable()) return could_not(cell.sentence(*why));
  const bool wakes = request.action == "wake";
  const control::ControlEvent end =
      cell.carry_out(control::Service{wakes ? DeviceService::kWake : DeviceService::kShutDown});
  if (end.kind != control::ControlEvent::Kind::kDone) return not_done(cell, end);
  Outcome outcome;
  outcome.text = wakes ? "all motors are awake\n"
                       : "the controller is shut down; it hears nothing until its power was cut\n";
  outcome.json["done"] = request.action;
  return outcome;
}

/// Where the joints are, as the controller knows them.
void tell_positions(const runtime::Station& station, Outcome& outcome) {
  const runtime::StationView view = station.view();
  const std::span positions(view.positions.data(), view.positions.size());
  outcome.text += "  known: " + standing_text(positions, station.robot()) + "\n";
  outcome.json["positions"] = positions_json(positions, station.robot());
}

/// In steps as large as the robot's file allows.
Outcome jog_leg(const DeviceRequest& request, LocalCell& cell) {
  const RobotModel& model = cell.station().robot();
  if (const auto why = cell.enable()) return could_not(cell.sentence(*why));
  const auto leg = static_cast<std::uint8_t>(*request.leg - 1);
  const auto& device = model.device.settings.get<IcpDevice>();
  const double unit = (*request.steps < 0 ? device.units_per_down : 1) / device.units_per_m;
  const auto most = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(model.device.capability.nudge_max / unit));
  for (std::int64_t left = *request.steps; left != 0;) {
    const std::int64_t part = std::clamp(left, -most, most);
    const control::ControlEvent end =
        cell.carry_out(control::Nudge{leg, static_cast<double>(part) * unit});
    if (end.kind != control::ControlEvent::Kind::kDone) return not_done(cell, end);
    left -= part;
  }
  Outcome outcome;
  outcome.text = fmt::format("{}: {} microsteps\n", model.joints[leg].name, *request.steps);
  outcome.json["done"] = request.action;
  tell_positions(cell.station(), outcome);
  return outcome;
}

/// Each board of itself; the first that fails is the complaint.
Outcome self_test(LocalCell& cell) {
  if (const auto why = cell.enable()) return could_not(cell.sentence(*why));
  const RobotModel& model = cell.station().robot();
  const runtime::StationView before = cell.station().view();
  const control::ControlEvent end = cell.carry_out(control::Service{DeviceService::kSelfTest});
  if (end.error.code == ErrorCode::kNoSuchService) {
    return could_not(cell.sentence(end.error) +
                     "; boards of the profile as-built tell nothing of themselves");
  }
  if (end.kind != control::ControlEvent::Kind::kDone) return not_done(cell, end);
  Outcome outcome;
  outcome.json = {{"done", "test"}, {"boards", Json::array()}};
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const bool asked = !is_left_out(model, j);
    const bool turned = asked && before.positions[j].quality != PositionQuality::kLost;
    const char* what = turned  ? "passed; its motor turned a full step and back"
                       : asked ? "passed; a motor turns only where its joint is known"
                               : "left out";
    outcome.text += fmt::format("  {}: {}\n", model.joints[j].name, what);
    outcome.json["boards"].push_back(
        {{"joint", model.joints[j].name}, {"tested", asked}, {"turned", turned}});
  }
  tell_positions(cell.station(), outcome);
  return outcome;
}

bool is_latched_stop(ErrorCode code) {
  return code == ErrorCode::kEmergencyStop || code == ErrorCode::kStopLatched;
}

/// The latch of an emergency stop is taken back, and nothing moves.
Outcome release(const DeviceRequest& request, LocalCell& cell) {
  const auto why = cell.enable();
  Outcome outcome;
  outcome.text = "no emergency stop is latched\n";
  if (why && !is_latched_stop(why->code)) return could_not(cell.sentence(*why));
  if (why) {
    const control::ControlEvent end = cell.carry_out(control::Acknowledge{});
    if (end.kind != control::ControlEvent::Kind::kDone) return not_done(cell, end);
    const bool own = why->code == ErrorCode::kStopLatched;
    outcome.text = own ? "released: an earlier run on this computer had set the latch; nothing has "
                         "moved\n"
                       : "released; no record says that this computer had set the latch. Nothing "
                         "has moved\n";
    outcome.json["set_by"] = own ? "this computer" : "unknown";
  }
  outcome.json["done"] = request.action;
  tell_positions(cell.station(), outcome);
  return outcome;
}

/// Whether this robot's device has such a command.
std::expected<void, Outcome> check_action(const DeviceRequest& request, const RobotModel& model) {
  const bool hexapod = model.device.settings.is<IcpDevice>();
  if (!hexapod && boards_of(model.device).empty()) {
    return std::unexpected(
        could_not(model.id +
                  ": only the hexapod's controller and the boards of robot-arm-2 have commands of "
                  "their own; sinew doctor --robot " +
                  model.id + " --port DEVICE queries the others"));
  }
  const auto known = hexapod ? std::span<const std::string_view>(kHexapodActions)
                             : std::span<const std::string_view>(kBoardActions);
  if (std::ranges::find(known, request.action) != known.end()) return {};
  std::string all;
  for (const std::string_view one : known) all += (all.empty() ? "" : ", ") + std::string(one);
  return std::unexpected(bad_input("'" + printable(request.action) + "' is none of " + all));
}

std::expected<void, Outcome> check_options(const DeviceRequest& request) {
  if (request.action == "jog") {
    if (!request.leg || *request.leg < 1 || *request.leg > static_cast<std::int64_t>(kLegs)) {
      return std::unexpected(bad_input("--leg: jog needs one of 1 to 6"));
    }
    if (!request.steps || *request.steps == 0 || std::abs(*request.steps) > kStepsMax) {
      return std::unexpected(bad_input(fmt::format(
          "--steps: jog needs a number of microsteps up to {}, positive to lengthen the leg",
          kStepsMax)));
    }
    return {};
  }
  const char* option = request.leg ? "--leg" : "--steps";
  if (!request.leg && !request.steps) return {};
  const std::string whole =
      request.action == "kill" ? "shuts the whole controller down" : "asks all of them";
  return std::unexpected(bad_input(std::string(option) + ": " + request.action + " " + whole +
                                   " and takes no such option; only jog does"));
}

}  // namespace

Outcome run_device_action(const DeviceRequest& request) {
  const auto chosen = choose_robot(request.robot);
  if (!chosen) return chosen.error();
  if (const auto fine = check_action(request, chosen->model); !fine) return fine.error();
  if (const auto fine = check_options(request); !fine) return fine.error();
  io::catch_interrupts();
  // Through a cell of its own: controller, journal and settings as of any other motion.
  auto cell = LocalCell::start(chosen->model, request.robot);
  if (!cell) return cell.error();
  Outcome outcome;
  if (request.action == "release") {
    outcome = release(request, **cell);
  } else if (request.action == "test") {
    outcome = self_test(**cell);
  } else if (request.action == "jog") {
    outcome = jog_leg(request, **cell);
  } else {
    outcome = request.action == "status" ? status(**cell) : service(request, **cell);
  }
  tell_settings(chosen->settings, outcome);
  return outcome;
}

void add_device(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<DeviceRequest>();
  DeviceRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "device", "what only one kind of device can be asked for",
                            "sinew device hexapod status --port /dev/ttyUSB0");
  verb->add_option("ROBOT", request.robot.name, "id or .toml file: the hexapod's or robot-arm-2's")
      ->required();
  verb->add_option(
          "ACTION", request.action,
          "hexapod: status, wake, kill (until its power is cut), jog (one leg, wherever "
          "it is); robot-arm-2: release (a latched emergency stop, nothing moves), test (each "
          "board of itself; a homed motor turns a full step and back)")
      ->required();
  verb->add_option("--port", request.robot.port, kPorts)->required();
  add_variant(*verb, request.robot);
  add_journal(*verb, request.robot);
  add_settings(*verb, request.robot);
  verb->add_option("--leg", request.leg, "jog: 1 to 6");
  verb->add_option("--steps", request.steps, "jog: microsteps, positive to lengthen the leg");
  add_time_scale(*verb, request.robot);
  verb->callback([&call, own] { call.verb = [own] { return run_device_action(*own); }; });
}

}  // namespace sinew::cli
