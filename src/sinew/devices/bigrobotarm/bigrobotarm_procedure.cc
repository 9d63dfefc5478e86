// The first day of a BigRobotArm.
#include "sinew/core/units.h"
#include "sinew/program/procedures/step_list.h"

namespace sinew::program {
namespace {

void list_arm(StepList& list, const RobotModel& robot, const Homing& /*homing*/,
              const DeviceFact& /*fact*/) {
  list.add("supply",
           "The arm was put straight up by hand, and then its motors got their supply: "
           "it counts from where it stood at that moment.");
  list.answers("The board answers on this wire");
  list.told("firmware", "Which firmware it has", "wire");
  list.add("place", "Where does it stand? home is straight up.", PlaceStep{named_places(robot)},
           kMovedHint);
  list.directions(from_deg(2), {{"left", "right"},
                                {"forward", "backward"},
                                {"forward", "backward"},
                                {"left", "right"},
                                {"forward", "backward"}});
  list.all_turn("A motor that only hums has a coil that is not connected, or too little current");
  list.add("gripper", "The gripper's servo goes to 60 deg.",
           GiveStep{control::UseTool{GripperTo{true, from_deg(60)}}});
  list.add("gripper_seen", "What did the gripper do?", ChoiceStep{{"closed", "opened", "nothing"}});
}

}  // namespace

extern const FirstDay kBigRobotArmDay;
const FirstDay kBigRobotArmDay{.protocol = "bigrobotarm", .list = list_arm};
extern const FirstDay kArmLinkDay;
const FirstDay kArmLinkDay{.protocol = "arm_link", .list = list_arm};

}  // namespace sinew::program
