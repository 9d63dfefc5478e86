// The first day of a platform with ICP motor modules.
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/program/procedures/step_list.h"

namespace sinew::program {
namespace {

constexpr double kLegStep = from_mm(0.2);

void list_legs(StepList& list, const RobotModel& robot, const Homing& /*homing*/,
               const DeviceFact& fact) {
  list.add("supply",
           "The motor modules get 12 V (8 to 24 V) from a supply that is strong enough "
           "for six motors of 0.8 A.");
  list.add("cables",
           "With the supply off: motors to their modules, modules to the I2C switch, the "
           "switch to the controller, the controller to this computer. Never plug a motor "
           "while it has current.");
  list.add("power_cycle",
           "The supply was switched off for some seconds and on again, last of all. "
           "A controller that was shut down answers only after that.");
  list.answers("The controller answers");
  list.directions(kLegStep, {{"longer", "shorter"}});
  list.all_turn("Where not all motors spin the supply is too weak, or a plug is loose");
  list.add("minus_one", "What a step down really is, from the target position of a motor module",
           CheckStep{[fact](const Procedure&) {
             const auto word = fact ? fact("minus_one", 0) : std::nullopt;
             if (!word) return Verdict{true, "not told here"};
             const bool known = *word == "FFFF" || *word == "FFFE";
             return Verdict{known, "TagPos " + *word + (*word == "FFFE" ? ": two units" : ""),
                            *word == "FFFE" ? 2.0 : 1.0};
           }});
  list.add("go_far", "leg1 goes 2 mm, to be measured: put a calliper beside it first.",
           MotionStep{0, from_mm(2), "longer", "shorter", false})
      .optional = true;
  // A unit of another scale may be many times as long or short: all that the leg itself can go.
  const double stroke = robot.joints[0].upper - robot.joints[0].lower;
  list.add("went", "How far did leg1 go?", NumberStep{Measure::kLength, from_mm(0.01), stroke})
      .when = [](const Procedure& procedure) {
    const auto* far = procedure.result("go_far");
    return far != nullptr && far->state == StepResult::State::kDone;
  };
  list.add("place", "Where does the platform stand now? lowered: every leg at its shortest.",
           PlaceStep{named_places(robot)}, kMovedHint);
}

/// What a step down really is, and how far a leg really goes.
void find_units(const Procedure& procedure, FoundSettings& found) {
  const auto& device = procedure.machine().robot().device.settings.get<IcpDevice>();
  const auto* down = numbered(procedure, "minus_one");
  if (down != nullptr && *down->number != device.units_per_down) {
    found["units_per_down"] = setting_text(*down->number);
  }
  const auto* sent = numbered(procedure, "go_far");
  const auto* went = numbered(procedure, "went");
  if (sent != nullptr && went != nullptr) {
    found["way_factor"] = setting_text(*went->number / std::abs(*sent->number));
  }
}

}  // namespace

extern const FirstDay kIcpDay;
const FirstDay kIcpDay{.protocol = "icp", .list = list_legs, .find = find_units};

}  // namespace sinew::program
