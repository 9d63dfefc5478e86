// The first day of arms with LSC boards.
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/program/procedures/step_list.h"

namespace sinew::program {
namespace {

/// Whose servo has this number already. Those that were said to have another one are asked in their
/// turn.
std::optional<std::string> who_has(const Procedure& procedure, const std::string& asked,
                                   double number) {
  const RobotModel& robot = procedure.machine().robot();
  const auto& device = robot.device.settings.get<LscDevice>();
  if (number == device.gripper.id) return "is the gripper's";
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const std::string& name = robot.joints[j].name;
    if (name == asked) continue;
    const auto* direction = procedure.result("direction." + name);
    const auto* other = procedure.result("id." + name);
    const bool moved = direction != nullptr && direction->answer == "other";
    const bool told = moved && other != nullptr && other->number;
    if (told ? *other->number != number : moved || device.servos[j].id != number) continue;
    return "is " + name + "'s";
  }
  return std::nullopt;
}

/// At 1500 us one kit's jaws are open and the other's shut, and neither servo is driven against its
/// end; a bus servo opens.
double middle_of_jaws(const RobotModel& robot) {
  const auto& device = robot.device.settings.get<LscDevice>();
  const bool shut =
      std::abs(device.gripper.closed - kJawsMiddle) < std::abs(device.gripper.open - kJawsMiddle);
  if (device.profile != LscProfile::kBus && shut) return 0;
  return std::get<SerialGeometry>(robot.geometry).gripper->width_max;
}

void list_servos(StepList& list, const RobotModel& robot, const Homing& /*homing*/,
                 const DeviceFact& /*fact*/) {
  list.add("supply",
           "The board gets 6 to 7.4 V from a supply that is strong enough for six "
           "servos (5 A and more), and its switch is on.");
  list.answers("The board answers, or is one that cannot be asked");
  list.supply(6.4);
  list.told("board", "Which board it is", "board");
  list.add("clear", "The arm is held by hand near its home, and its way is free.");
  list.add("first_move", "A slow move to its home; a hand stays near the power switch.",
           FirstMoveStep{});
  list.directions(from_deg(8), {{"left", "right"},
                                {"forward", "backward"},
                                {"forward", "backward"},
                                {"forward", "backward"},
                                {"left", "right"}});
  for (const Joint& joint : robot.joints) {
    const auto other = [id = "direction." + joint.name](const Procedure& procedure) {
      const auto* one = procedure.result(id);
      return one != nullptr && one->answer == "other";
    };
    list.add("id." + joint.name, "Which servo number has " + joint.name + "?",
             NumberStep{Measure::kShare, 1, 253,
                        [name = joint.name](const Procedure& procedure, double number) {
                          return who_has(procedure, name, number);
                        }})
        .when = other;
  }
  list.all_turn("A servo that stays still has another number, a loose plug, or no supply");
  list.add("jaws", "The jaws go to where both kits' servos may be. Keep fingers away.",
           GiveStep{control::UseTool{JawsTo{jaws_tried(robot)}}});
  list.add("jaws_seen", "Are the jaws open or shut now?", ChoiceStep{{"open", "shut", "neither"}},
           "neither: look at the plug of the gripper's servo, and at its horn");
  for (const Joint& joint : robot.joints) {
    list.add("trim." + joint.name,
             "By how much must " + joint.name +
                 " be corrected so that its zero is where the model has it? Plus as it counts.",
             NumberStep{Measure::kAngle, -kTrimMax, kTrimMax})
        .optional = true;
  }
}

}  // namespace

extern const FirstDay kLscDay;
const FirstDay kLscDay{.protocol = "lsc", .list = list_servos, .jaws_tried = middle_of_jaws};

}  // namespace sinew::program
