#include <fmt/format.h>

#include <array>

#include "sinew/cli/cells/device_verb.h"
#include "sinew/core/error_code.h"
#include "sinew/model/left_out.h"

/// What a person may ask of axis boards: to take back a latched emergency stop, and to test
/// themselves.
namespace sinew::cli {
namespace {

/// Each board of itself; the first that fails is the complaint.
Outcome self_test(const DeviceRequest& /*request*/, LocalCell& cell) {
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

constexpr std::array<DeviceAction, 2> kBoardsAll{
    {{.name = "release", .note = "a latched emergency stop, nothing moves", .run = release},
     {.name = "test",
      .note = "each board of itself; a homed motor turns a full step and back",
      .run = self_test}}};

}  // namespace

extern const DeviceActions kAxisActions;
constexpr DeviceActions kAxisActions{
    .whose = "the boards of robot-arm-2",
    .are_of = [](const Device& device) { return !boards_of(device).empty(); },
    .all = kBoardsAll};

}  // namespace sinew::cli
