#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "sinew/cli/cells/local_cell.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct DeviceRequest {
  RobotOptions robot;  ///< with a port
  std::string action;
  std::optional<std::int64_t> leg;    ///< from 1
  std::optional<std::int64_t> steps;  ///< positive is longer
};

/// What one kind of device can be asked for and no other.
struct DeviceAction {
  std::string_view name;
  std::string_view note;  ///< behind its name in the help
  Outcome (*run)(const DeviceRequest& request, LocalCell& cell) = nullptr;
  /// In place of it: below driver and controller, with a port of its own; nothing moves.
  Outcome (*alone)(const DeviceRequest& request, const RobotModel& model) = nullptr;
  /// That takes --leg and --steps, checked before anything is opened; nullptr: takes neither.
  std::expected<void, Outcome> (*check)(const DeviceRequest& request) = nullptr;
};

/// Those of one kind: devices/KIND/KIND_verb.cc has them, and device_verb.cc the list.
struct DeviceActions {
  std::string_view whose;  ///< robots, for people
  bool (*are_of)(const Device& device);
  std::span<const DeviceAction> all;
};

/// What a command that did not come to its end ends with.
Outcome not_done(const LocalCell& cell, const control::ControlEvent& end);
/// Where the joints are, as the controller knows them.
void tell_positions(const runtime::Station& station, Outcome& outcome);

/// `sinew device`: asked for by a person and by nothing else; through the controller, recorded in
/// the journal.
Outcome run_device_action(const DeviceRequest& request);

void add_device(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
