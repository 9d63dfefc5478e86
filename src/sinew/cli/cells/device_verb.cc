#include "sinew/cli/cells/device_verb.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "sinew/cli/cells/robot_verb_options.h"
#include "sinew/cli/output/program_report.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/verb_options.h"
#include "sinew/core/spelling.h"
#include "sinew/devices/kinds.h"
#include "sinew/io/interrupt.h"

namespace sinew::cli {

// One line for each kind, in each of the two lists.
extern const DeviceActions kIcpActions;
extern const DeviceActions kAxisActions;
extern const DeviceActions kArmLinkActions;

namespace {

constexpr std::array kKinds{&kIcpActions, &kAxisActions, &kArmLinkActions};

std::vector<std::string_view> names_of(std::span<const DeviceAction> actions) {
  std::vector<std::string_view> names;
  for (const DeviceAction& action : actions) names.push_back(action.name);
  return names;
}

/// The robots that have actions.
std::string whose_actions() {
  std::vector<std::string_view> whose;
  for (const DeviceActions* kind : kKinds) whose.push_back(kind->whose);
  return joined(whose, " and ");
}

/// "hexapod: status, kill (until its power is cut); robot-arm-2: test (...)".
std::string help_of_actions() {
  std::vector<std::string> kinds;
  for (const DeviceActions* kind : kKinds) {
    std::vector<std::string> actions;
    for (const DeviceAction& action : kind->all) {
      const std::string note = action.note.empty() ? "" : " (" + std::string(action.note) + ")";
      actions.push_back(std::string(action.name) + note);
    }
    kinds.push_back(std::string(kind->whose) + ": " + joined(actions, ", "));
  }
  return joined(kinds, "; ");
}

/// Of this device; nullptr: it has none.
const DeviceActions* actions_of(const Device& device) {
  const auto kind =
      std::ranges::find_if(kKinds, [&](const DeviceActions* one) { return one->are_of(device); });
  return kind != kKinds.end() ? *kind : nullptr;
}

/// The one that this robot's device has by that name.
std::expected<const DeviceAction*, Outcome> action_of(const DeviceRequest& request,
                                                      const RobotModel& model) {
  const DeviceActions* const kind = actions_of(model.device);
  if (kind == nullptr) {
    return std::unexpected(could_not(model.id + ": only " + whose_actions() +
                                     " have commands of their own; sinew doctor --robot " +
                                     model.id + " --port DEVICE queries the others"));
  }
  const auto& actions = kind->all;
  const auto found = std::ranges::find(actions, request.action, &DeviceAction::name);
  if (found != actions.end()) return &*found;
  return std::unexpected(bad_input("'" + printable(request.action) + "' is none of " +
                                   joined(names_of(actions), ", ")));
}

std::expected<void, Outcome> check_options(const DeviceRequest& request,
                                           const DeviceAction& action) {
  if (action.check != nullptr) return action.check(request);
  if (!request.leg && !request.steps) return {};
  std::vector<std::string_view> takers;
  for (const DeviceActions* kind : kKinds) {
    for (const DeviceAction& one : kind->all) {
      if (one.check != nullptr) takers.push_back(one.name);
    }
  }
  return std::unexpected(bad_input(std::string(request.leg ? "--leg: " : "--steps: ") +
                                   request.action + " takes no such option; only " +
                                   joined(takers, ", ") + " does"));
}

}  // namespace

Outcome not_done(const LocalCell& cell, const control::ControlEvent& end) {
  if (end.kind != control::ControlEvent::Kind::kStopped) return could_not(cell.sentence(end.error));
  return could_not(cell.station().port_name() + ": stopped");
}

void tell_positions(const runtime::Station& station, Outcome& outcome) {
  const runtime::StationView view = station.view();
  const std::span positions(view.positions.data(), view.positions.size());
  outcome.text += "  known: " + standing_text(positions, station.robot()) + "\n";
  outcome.json["positions"] = positions_json(positions, station.robot());
}

std::expected<std::vector<BoardSaid>, Outcome> boards_of_robot(const RobotOptions& where,
                                                               const RobotModel& model,
                                                               std::unique_ptr<LocalCell>& cell) {
  const DeviceKind& kind = kind_of(model.device);
  if (kind.image != nullptr && cell) {
    const DeviceFacts facts = cell->station().view().facts;
    return std::vector{BoardSaid{{}, facts.empty() ? std::nullopt : kind.image(facts)}};
  }
  const DeviceActions* const actions = actions_of(model.device);
  if (actions == nullptr || actions->images == nullptr) return std::vector<BoardSaid>();
  cell.reset();
  return actions->images(where, model);
}

void add_boards(const RobotOptions& where, const RobotModel& model,
                std::unique_ptr<LocalCell>& cell, Outcome& outcome) {
  const auto boards = boards_of_robot(where, model, cell);
  if (boards && !boards->empty()) tell_boards(*boards, {}, outcome);
}

Outcome tell_firmware(const DeviceRequest& request, const RobotModel& model) {
  std::unique_ptr<LocalCell> cell;
  if (kind_of(model.device).image != nullptr) {
    auto started = LocalCell::start(model, request.robot);
    if (!started) return started.error();
    cell = std::move(*started);
    if (const auto why = cell->enable()) return could_not(cell->sentence(*why));
  }
  const auto boards = boards_of_robot(request.robot, model, cell);
  if (!boards) return boards.error();
  Outcome outcome;
  outcome.json["done"] = request.action;
  tell_boards(*boards, request.images, outcome);
  return outcome;
}

Outcome run_device_action(const DeviceRequest& request) {
  const auto chosen = choose_robot(request.robot);
  if (!chosen) return chosen.error();
  const auto action = action_of(request, chosen->model);
  if (!action) return action.error();
  if (const auto fine = check_options(request, **action); !fine) return fine.error();
  io::catch_interrupts();
  if ((*action)->alone != nullptr) return (*action)->alone(request, chosen->model);
  // Through a cell of its own: controller, journal and settings as of any other motion.
  auto cell = LocalCell::start(chosen->model, request.robot);
  if (!cell) return cell.error();
  Outcome outcome = (*action)->run(request, **cell);
  tell_settings(chosen->settings, outcome);
  return outcome;
}

void add_device(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<DeviceRequest>();
  DeviceRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "device", "what only one kind of device can be asked for",
                            "sinew device hexapod status --port /dev/ttyUSB0");
  verb->add_option("ROBOT", request.robot.name, "id or .toml file of " + whose_actions())
      ->required();
  verb->add_option("ACTION", request.action, help_of_actions())->required();
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
