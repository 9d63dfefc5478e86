#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/cli/cells/local_cell.h"
#include "sinew/cli/images/board_updates.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct DeviceRequest {
  RobotOptions robot;  ///< with a port
  std::string action;
  std::optional<std::int64_t> leg;    ///< from 1
  std::optional<std::int64_t> steps;  ///< positive is longer
  std::string images;                 ///< firmware: folder of images; empty: beside this program
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
  /// Which image runs on each of its boards, asked below driver and controller, with a port of its
  /// own; nothing moves. nullptr: they do not say, or DeviceKind::image does.
  std::expected<std::vector<BoardSaid>, Outcome> (*images)(const RobotOptions& where,
                                                           const RobotModel& model) = nullptr;
};

/// What a command that did not come to its end ends with.
Outcome not_done(const LocalCell& cell, const control::ControlEvent& end);
/// Where the joints are, as the controller knows them.
void tell_positions(const runtime::Station& station, Outcome& outcome);

/// Which image runs on each of a robot's boards; nothing moves.
/// @param cell  of that robot, enabled; ended where its boards are to be asked below it
/// @return none where this device does not say
std::expected<std::vector<BoardSaid>, Outcome> boards_of_robot(const RobotOptions& where,
                                                               const RobotModel& model,
                                                               std::unique_ptr<LocalCell>& cell);

/// Adds that and whether an update is due; nothing where this device does not say, or the question
/// failed.
void add_boards(const RobotOptions& where, const RobotModel& model,
                std::unique_ptr<LocalCell>& cell, Outcome& outcome);

/// The action `firmware`: boards_of_robot() for people.
Outcome tell_firmware(const DeviceRequest& request, const RobotModel& model);

/// `sinew device`: asked for by a person and by nothing else; through the controller, recorded in
/// the journal.
Outcome run_device_action(const DeviceRequest& request);

void add_device(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
