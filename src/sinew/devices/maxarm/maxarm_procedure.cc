// The first day of a MaxArm.
#include "sinew/core/units.h"
#include "sinew/program/procedures/step_list.h"

namespace sinew::program {
namespace {

void list_maxarm(StepList& list, const RobotModel& /*robot*/, const Homing& /*homing*/,
                 const DeviceFact& /*fact*/) {
  list.add("supply",
           "The arm has its 7.5 V supply, is switched on, and stands where nothing is in "
           "its way.");
  list.answers("The arm answers");
  list.told("replies", "How its replies are summed", "checksum");
  list.add("firmware", "Which firmware has it? The MicroPython one moves by itself after power-up.",
           ChoiceStep{{"arduino", "micropython"}});
  list.directions(from_deg(6), {{"left", "right"}, {"forward", "backward"}, {"up", "down"}});
  list.all_turn("A servo that stays still has a loose plug, or is overloaded");
  list.add("suction", "The pump runs: hold something flat below the nozzle.",
           GiveStep{control::UseTool{Suction{Suction::State::kOn}}});
  list.add("suction_seen", "Is it held?", ChoiceStep{{"held", "nothing"}},
           "the hose, the pump's plug, the nozzle");
  list.add("suction_off", "The valve opens, and it is let go of.",
           GiveStep{control::UseTool{Suction{Suction::State::kRelease}}});
}

}  // namespace

extern const FirstDay kMaxArmDay;
const FirstDay kMaxArmDay{.protocol = "maxarm", .list = list_maxarm};

}  // namespace sinew::program
