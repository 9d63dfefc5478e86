#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/cli/cells/device_verb.h"
#include "sinew/cli/output/table.h"
#include "sinew/devices/icp/icp_driver_facts.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/devices/icp/tmc222_wire_words.h"

/// What a person may ask of the platform's controller: it can be waked and killed, the twelve
/// status bytes of each motor read, and a leg jogged while its position is unknown.
namespace sinew::cli {
namespace {

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
Outcome status(const DeviceRequest& /*request*/, LocalCell& cell) {
  const auto why = cell.enable();
  Outcome outcome = status_outcome(cell.station());
  if (!why) return outcome;
  if (outcome.json["legs"].empty()) outcome.text.clear();
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint = cell.sentence(*why);
  outcome.json["error"] = {{"sentence", outcome.complaint}};
  return outcome;
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

std::expected<void, Outcome> check_jog(const DeviceRequest& request) {
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

constexpr std::array<DeviceAction, 4> kIcpAll{
    {{.name = "status", .note = {}, .run = status},
     {.name = "wake", .note = {}, .run = service},
     {.name = "kill", .note = "until its power is cut", .run = service},
     {.name = "jog", .note = "one leg, wherever it is", .run = jog_leg, .check = check_jog}}};

}  // namespace

extern const DeviceActions kIcpActions;
constexpr DeviceActions kIcpActions{
    .whose = "a hexapod",
    .are_of = [](const Device& device) { return device.settings.is<IcpDevice>(); },
    .all = kIcpAll};

}  // namespace sinew::cli
