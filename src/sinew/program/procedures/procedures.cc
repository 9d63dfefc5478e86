#include "sinew/program/procedures/procedures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "sinew/core/units.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/model/hand.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"

namespace sinew::program {
namespace {

constexpr double kLegStep = from_mm(0.2);
constexpr const char* kMovedHint =
    "where it was moved by hand, add moved: and who did it, as in: home moved: lifted by hand";

bool has_boards(const RobotModel& robot) {
  return !boards_of(robot.device).empty();
}

bool searches(const RobotModel& robot) {
  return has_boards(robot) || robot.device.settings->searches_zeros();
}

/// A platform on legs can be lowered.
bool has_legs(const RobotModel& robot) {
  return std::holds_alternative<HexapodGeometry>(robot.geometry);
}

std::vector<PlaceStep::Place> places_of(const RobotModel& robot) {
  std::vector<PlaceStep::Place> places{{"home", home_joints(robot)}};
  if (!has_legs(robot)) return places;
  JointVector lowered;
  for (const Joint& joint : robot.joints) lowered.push_back(joint.lower);
  places.push_back({"lowered", lowered});
  return places;
}

/// Two searches for one zero that lie farther apart do not find the same switch: two full steps of
/// the motor, beyond which one may have been lost or the switch has moved.
constexpr double kShiftMax = 32;  // microsteps

/// How far two searches lie apart, joint by joint; nothing where the wire does not show it.
std::optional<Verdict> shifts_seen(const RobotModel& robot, const DeviceFact& fact) {
  std::string words;
  std::string far;
  std::string unseen;
  double most = 0;
  for (std::size_t j = 0; fact && j < robot.joints.size(); ++j) {
    if (is_left_out(robot, j)) continue;
    const auto steps = fact("zero_shift_steps", j);
    const auto degrees = fact("zero_shift_deg", j);
    const std::string& name = robot.joints[j].name;
    if (!steps || !degrees) {
      unseen += (unseen.empty() ? "" : ", ") + name;
      continue;
    }
    const double shift = std::abs(std::strtod(steps->c_str(), nullptr));
    words += (words.empty() ? "" : ", ") + name + " " + *steps + " (" + *degrees + " deg)";
    if (shift > kShiftMax) far += (far.empty() ? "" : ", ") + name;
    most = std::max(most, shift);
  }
  if (words.empty()) return std::nullopt;
  words = "apart by steps: " + words;
  if (!unseen.empty()) words += "; not measured, as an answer came too late: " + unseen;
  if (far.empty()) return Verdict{true, words, most};
  return Verdict{false,
                 words + ". More than " + std::to_string(static_cast<int>(kShiftMax)) +
                     " steps: " + far + ". Its switch is loose, or the motor loses steps",
                 most};
}

/// Told at the end of a homing: what was seen, and what nobody could see.
Verdict homing_seen(const Procedure& procedure, const DeviceFact& fact) {
  const RobotModel& robot = procedure.machine().robot();
  const auto positions = procedure.machine().positions();
  for (std::size_t j = 0; j < positions.size(); ++j) {
    if (positions[j].quality == PositionQuality::kLost && !is_left_out(robot, j)) {
      return {false, "a joint does not know where it is after the search"};
    }
  }
  const auto* again = procedure.result("again");
  const bool twice = again != nullptr && again->state == StepResult::State::kDone;
  const std::string found =
      twice ? "found twice" : "found once, so how far two searches lie apart is not known";
  const std::string switches =
      ". A switch that was pressed at the start is left first, and one "
      "that stays closed, or is not reached, would have failed";
  if (!twice) return {true, found + switches};
  if (auto shifts = shifts_seen(robot, fact)) {
    shifts->words = found + ", " + shifts->words + switches;
    return *shifts;
  }
  const bool link = robot.device.settings.is<AxisLinkDevice>();
  return {true, found + switches + ". How far the two searches lie apart is not measured: " +
                    (link ? "no answer came at the instant that shows it"
                          : "this wire does not say where a switch closed")};
}

ProcedureStep search(std::string id, std::string text, const Homing& homing) {
  return {.id = std::move(id),
          .text = std::move(text),
          .what = SearchStep{homing.times},
          .hint = "a joint that fails has a switch that is stuck, not reached, or not plugged in"};
}

ProcedurePlan homing_plan(const RobotModel& robot, const Homing& homing, const DeviceFact& fact) {
  ProcedurePlan plan{"home", "Homing of " + robot.title, {}};
  plan.steps.push_back({.id = "clear",
                        .text = "Nobody and nothing is within the arm's reach, and somebody has a "
                                "hand on the power switch.",
                        .what = TellStep{}});
  plan.steps.push_back(
      search("search", "Each joint looks for its end stop, one after the other.", homing));
  plan.steps.push_back(
      search("again", "Once more, to see that every joint finds it again.", homing));
  plan.steps.back().optional = true;
  // A board that does not say where its search ended knows it itself.
  plan.steps.push_back(
      {.id = "to_home",
       .text = "From where the search ended, which this wire does not tell, slowly to its home.",
       .what = FirstMoveStep{},
       .hint = {},
       .optional = false,
       .when = [](const Procedure& procedure) { return !procedure.machine().reference(); }});
  plan.steps.push_back({.id = "seen",
                        .text = "What the two searches show",
                        .what = CheckStep{[fact](const Procedure& procedure) {
                          return homing_seen(procedure, fact);
                        }},
                        .hint = "home it once more"});
  return plan;
}

}  // namespace

namespace {

/// Each joint rests beside its end stop then, a pose that nobody chose.
void add_way_home(ProcedurePlan& plan) {
  ProcedureStep step{.id = "home",
                     .text = "From where the search ended to its home.",
                     .what = HomeMoveStep{},
                     .hint = {},
                     .optional = true,
                     .when = [](const Procedure& procedure) {
                       const auto at = procedure.machine().reference();
                       return at && *at != home_joints(procedure.machine().robot());
                     }};
  plan.steps.push_back(std::move(step));
}

}  // namespace

ProcedurePlan homing_procedure(const RobotModel& robot, const Homing& homing,
                               const DeviceFact& fact) {
  if (searches(robot)) {
    ProcedurePlan plan = homing_plan(robot, homing, fact);
    add_way_home(plan);
    return plan;
  }
  ProcedurePlan plan{"home", robot.title + " to its home pose", {}};
  plan.steps.push_back(
      {.id = "clear", .text = "Nobody is within the arm's reach.", .what = TellStep{}});
  plan.steps.push_back(
      {.id = "home", .text = "All joints move to the home pose.", .what = HomeMoveStep{}});
  return plan;
}

ProcedurePlan recovery_procedure(const RobotModel& robot, const Homing& homing) {
  if (searches(robot)) {
    ProcedurePlan plan = homing_plan(robot, homing, {});
    plan.id = "recover";
    plan.title = "Recovery of " + robot.title;
    std::erase_if(plan.steps, [](const ProcedureStep& step) { return step.id == "again"; });
    plan.steps.pop_back();
    add_way_home(plan);
    return plan;
  }
  ProcedurePlan plan{"recover", "Recovery of " + robot.title, {}};
  if (!(robot.device.capability.nudge_max > 0)) {
    plan.steps.push_back({.id = "clear",
                          .text = "The arm is held by hand near its home, and its way is free.",
                          .what = TellStep{}});
    plan.steps.push_back({.id = "first_move",
                          .text = "A slow move to its home; a hand stays near the power switch.",
                          .what = FirstMoveStep{}});
    return plan;
  }
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const std::string& name = robot.joints[j].name;
    plan.steps.push_back({.id = "adjust." + name,
                          .text = name + " goes by hand to where you know it: by how much, which "
                                         "way? done where it stands right.",
                          .what = AdjustStep{j},
                          .hint = {},
                          .optional = false,
                          .when = {}});
  }
  plan.steps.push_back({.id = "place",
                        .text = "Where does it stand now?",
                        .what = PlaceStep{places_of(robot)},
                        .hint = kMovedHint});
  return plan;
}

// What the robots' lists have in common.

namespace {

/// Words for the two ways of a joint, as people see them.
struct Ways {
  const char* plus;
  const char* minus;
};

class Lister {
 public:
  Lister(const RobotModel& robot, const DeviceFact& fact) : robot_(robot), fact_(fact) {}

  ProcedureStep& add(std::string id, std::string text,
                     decltype(ProcedureStep::what) what = TellStep{}, std::string hint = {}) {
    steps_.push_back({std::move(id), std::move(text), std::move(what), std::move(hint)});
    return steps_.back();
  }
  void directions(double way, const std::vector<Ways>& ways) {
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const std::string& name = robot_.joints[j].name;
      add("direction." + name,
          name + " moves by a little and comes back. Which way does it go first?",
          MotionStep{j, way, ways[std::min(j, ways.size() - 1)].plus,
                     ways[std::min(j, ways.size() - 1)].minus},
          "look at its plug, and at the supply");
    }
  }
  /// All joints went; where one did not, what that means.
  void all_turn(std::string meaning) {
    add("all_move", "Every motor has moved", CheckStep{[meaning](const Procedure& procedure) {
          std::string still;
          for (const Joint& joint : procedure.machine().robot().joints) {
            const auto* one = procedure.result("direction." + joint.name);
            const bool moved = one != nullptr && one->number && *one->number != 0;
            if (!moved) still += (still.empty() ? "" : ", ") + joint.name;
          }
          if (still.empty()) return Verdict{true, "all of them"};
          return Verdict{false, "not moved as asked: " + still + ". " + meaning};
        }});
  }
  void answers(std::string text) {
    add("answers", std::move(text), CheckStep{[](const Procedure& procedure) {
          const auto& machine = procedure.machine();
          const bool ready = machine.state() == control::MachineState::kReady;
          return Verdict{ready, ready ? "it answers" : "it does not answer"};
        }});
  }
  void supply(double least) {
    add("supply_seen", "The board's supply", CheckStep{[fact = fact_, least](const Procedure&) {
          const auto volts = fact ? fact("supply", 0) : std::nullopt;
          if (!volts) return Verdict{true, "this board does not tell its supply"};
          const double measured = std::strtod(volts->c_str(), nullptr);
          return Verdict{measured >= least, *volts + " V", measured};
        }});
  }
  void told(std::string id, std::string text, std::string what) {
    add(std::move(id), std::move(text),
        CheckStep{[fact = fact_, what = std::move(what)](const Procedure&) {
          const auto word = fact ? fact(what, 0) : std::nullopt;
          return Verdict{true, word.value_or("not told here")};
        }});
  }
  std::vector<ProcedureStep> take() { return std::move(steps_); }

 private:
  const RobotModel& robot_;
  const DeviceFact& fact_;
  std::vector<ProcedureStep> steps_;
};

void list_hexapod(Lister& list, const RobotModel& robot, const DeviceFact& fact) {
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
           PlaceStep{places_of(robot)}, kMovedHint);
}

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

}  // namespace

double jaws_tried(const RobotModel& robot) {
  const double width = std::get<SerialGeometry>(robot.geometry).gripper->width_max;
  const auto* device = robot.device.settings.as<LscDevice>();
  if (device == nullptr) return width;
  const bool shut =
      std::abs(device->gripper.closed - kJawsMiddle) < std::abs(device->gripper.open - kJawsMiddle);
  return device->profile != LscProfile::kBus && shut ? 0 : width;
}

namespace {

void list_servos(Lister& list, const RobotModel& robot) {
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

void list_bigrobotarm(Lister& list, const RobotModel& robot) {
  list.add("supply",
           "The arm was put straight up by hand, and then its motors got their supply: "
           "it counts from where it stood at that moment.");
  list.answers("The board answers on this wire");
  list.told("firmware", "Which firmware it has", "wire");
  list.add("place", "Where does it stand? home is straight up.", PlaceStep{places_of(robot)},
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

void list_maxarm(Lister& list) {
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

/// Where a joint is that was put to its zero by hand.
std::optional<Verdict> zero_seen(const Procedure& procedure, std::size_t joint) {
  const JointPosition& at = procedure.machine().positions()[joint];
  if (at.quality != PositionQuality::kMeasured) return std::nullopt;
  char words[40];
  std::snprintf(words, sizeof words, "measured at %.1f deg", to_deg(at.q));
  return Verdict{true, words, at.q};
}

/// An arm that can be guided by hand.
void list_guided(Lister& list, const RobotModel& robot, const DeviceFact& fact) {
  list.add("supply",
           "The arm is held by hand: it falls when its motors are switched off. The servos have "
           "their supply, and a hand is on its switch.");
  list.answers("All servos reply, and their own settings fit the robot's file");
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    list.add("servo." + robot.joints[j].name, "The servo of " + robot.joints[j].name,
             CheckStep{[fact, j](const Procedure&) {
               return Verdict{true, (fact ? fact("servo", j) : std::nullopt).value_or("no facts")};
             }});
  }
  list.add("free", "The motors are switched off. Hold the arm.",
           GiveStep{control::Service{DeviceService::kFree}});
  list.add("zero",
           "Put every joint to its zero by hand, as the panel draws the arm with all joints at 0, "
           "and hold it there.")
      .optional = true;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    list.add("zero." + robot.joints[j].name, "Where the servo of " + robot.joints[j].name + " is",
             CheckStep{[j](const Procedure& procedure) { return zero_seen(procedure, j); }})
        .when = [](const Procedure& procedure) {
      const auto* put = procedure.result("zero");
      return put != nullptr && put->state == StepResult::State::kDone;
    };
  }
  list.add("hold", "The motors hold each joint where it is.",
           GiveStep{control::Service{DeviceService::kHold}});
  list.directions(from_deg(8), {{"plus", "minus"}});
  list.all_turn("A servo that stays still has another number, a loose plug, or no supply");
  if (jaws_of(robot) == nullptr) return;
  list.add("jaws", "The jaws open. Keep fingers away.",
           GiveStep{control::UseTool{JawsTo{jaws_tried(robot)}}});
  list.add("jaws_seen", "Are the jaws open or shut now?", ChoiceStep{{"open", "shut", "neither"}},
           "neither: look at the plug and the number of the gripper's servo");
}

/// Any device that moves one joint by a little.
void list_any(Lister& list, const RobotModel& robot) {
  list.add("supply",
           "The arm is held or stands safely, its motors have their supply, and a hand is on its "
           "switch.");
  list.answers("The board answers, and its own settings fit the robot's file");
  if (!searches(robot)) {
    list.add("place", "Where does it stand?", PlaceStep{places_of(robot)}, kMovedHint);
  }
  list.directions(from_deg(2), {{"plus", "minus"}});
  list.all_turn("A motor that only hums has a coil that is not connected, or too little current");
}

void list_boards(Lister& list, const RobotModel& robot, const Homing& homing,
                 const DeviceFact& fact) {
  list.add("supply",
           "The arm is held or hangs safely: it drops without power. The boards have "
           "their supply, and a hand is on its switch.");
  list.answers("The boards answer");
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    list.add("board." + robot.joints[j].name, "The board of " + robot.joints[j].name,
             CheckStep{[fact, j](const Procedure&) {
               const auto word = fact ? fact("axis", j) : std::nullopt;
               if (!word) return Verdict{true, "not told here"};
               return Verdict{*word == "fine", *word};
             }},
             "its cable, its chip select, its supply");
  }
  ProcedurePlan found = homing_plan(robot, homing, fact);
  for (ProcedureStep& step : found.steps) {
    if (step.id == "again") step.optional = false;
    list.add(step.id, step.text, step.what, step.hint).when = step.when;
  }
  list.directions(from_deg(5), {{"plus", "minus"}});
  list.all_turn("A motor that only hums has a coil that is not connected, or too little current");
  list.add(
      "senses", "Every axis turns as the model counts", CheckStep{[](const Procedure& procedure) {
        std::string other;
        for (const Joint& joint : procedure.machine().robot().joints) {
          const auto* one = procedure.result("direction." + joint.name);
          if (one == nullptr || !one->number || *one->number >= 0) continue;
          other += (other.empty() ? "" : ", ") + joint.name;
        }
        if (other.empty()) return Verdict{true, "all of them"};
        return Verdict{false, "against the model: " + other +
                                  ". A board turns its motor as it is set up itself: change it "
                                  "there, or at the motor's plug, and home again"};
      }});
  list.add("encoders", "The encoders followed", CheckStep{[](const Procedure& procedure) {
             const auto& device = procedure.machine().robot().device.settings;
             const bool link = device.is<AxisLinkDevice>();
             return Verdict{true, link ? "each motion ended where its encoder was sent; one that "
                                         "counts the wrong way would have been a fault"
                                       : "this wire tells what a board was sent, not what its "
                                         "encoder says"};
           }});
}

}  // namespace

std::expected<ProcedurePlan, std::string> commissioning_procedure(const RobotModel& robot,
                                                                  const Homing& homing,
                                                                  const DeviceFact& fact) {
  ProcedurePlan plan{"commission", "Commissioning of " + robot.title, {}};
  Lister list(robot, fact);
  const auto& settings = robot.device.settings;
  if (settings.is<IcpDevice>()) {
    list_hexapod(list, robot, fact);
  } else if (settings.is<LscDevice>()) {
    list_servos(list, robot);
  } else if (settings.is<BigRobotArmDevice>()) {
    list_bigrobotarm(list, robot);
  } else if (settings.is<MaxArmDevice>()) {
    list_maxarm(list);
  } else if (has_boards(robot)) {
    list_boards(list, robot, homing, fact);
  } else if (robot.device.capability.free_drive) {
    list_guided(list, robot, fact);
  } else if (robot.device.capability.nudge_max > 0) {
    list_any(list, robot);
  } else {
    return std::unexpected(robot.id + " has a device on which there is nothing to commission");
  }
  plan.steps = list.take();
  return plan;
}

}  // namespace sinew::program
