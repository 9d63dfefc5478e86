#include "sinew/program/procedures/procedures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "sinew/core/units.h"
#include "sinew/model/hand.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "sinew/program/procedures/step_list.h"

namespace sinew::program {

std::vector<PlaceStep::Place> named_places(const RobotModel& robot) {
  std::vector<PlaceStep::Place> places{{"home", home_joints(robot)}};
  if (!std::holds_alternative<HexapodGeometry>(robot.geometry)) return places;
  JointVector lowered;
  for (const Joint& joint : robot.joints) lowered.push_back(joint.lower);
  places.push_back({"lowered", lowered});
  return places;
}

namespace {

bool has_boards(const RobotModel& robot) {
  return !boards_of(robot.device).empty();
}

bool searches(const RobotModel& robot) {
  return has_boards(robot) || robot.device.settings->searches_zeros();
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
  const bool shows = fact && fact("shows_zero_shift", 0);
  return {true, found + switches + ". How far the two searches lie apart is not measured: " +
                    (shows ? "no answer came at the instant that shows it"
                           : "this wire does not say where a switch closed")};
}

ProcedureStep search(std::string id, std::string text, const Homing& homing) {
  return {.id = std::move(id),
          .text = std::move(text),
          .what = SearchStep{homing.times},
          .hint = "a joint that fails has a switch that is stuck, not reached, or not plugged in"};
}

}  // namespace

ProcedurePlan homing_steps(const RobotModel& robot, const Homing& homing, const DeviceFact& fact) {
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
    ProcedurePlan plan = homing_steps(robot, homing, fact);
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
    ProcedurePlan plan = homing_steps(robot, homing, {});
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
                        .what = PlaceStep{named_places(robot)},
                        .hint = kMovedHint});
  return plan;
}

namespace {

/// Where a joint is that was put to its zero by hand.
std::optional<Verdict> zero_seen(const Procedure& procedure, std::size_t joint) {
  const JointPosition& at = procedure.machine().positions()[joint];
  if (at.quality != PositionQuality::kMeasured) return std::nullopt;
  char words[40];
  std::snprintf(words, sizeof words, "measured at %.1f deg", to_deg(at.q));
  return Verdict{true, words, at.q};
}

/// An arm that can be guided by hand.
void list_guided(StepList& list, const RobotModel& robot, const DeviceFact& fact) {
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
void list_any(StepList& list, const RobotModel& robot) {
  list.add("supply",
           "The arm is held or stands safely, its motors have their supply, and a hand is on its "
           "switch.");
  list.answers("The board answers, and its own settings fit the robot's file");
  if (!searches(robot)) {
    list.add("place", "Where does it stand?", PlaceStep{named_places(robot)}, kMovedHint);
  }
  list.directions(from_deg(2), {{"plus", "minus"}});
  list.all_turn("A motor that only hums has a coil that is not connected, or too little current");
}

}  // namespace

double jaws_tried(const RobotModel& robot) {
  const FirstDay* day = first_day_of(robot.device);
  if (day != nullptr && day->jaws_tried != nullptr) return day->jaws_tried(robot);
  return std::get<SerialGeometry>(robot.geometry).gripper->width_max;
}

std::expected<ProcedurePlan, std::string> commissioning_procedure(const RobotModel& robot,
                                                                  const Homing& homing,
                                                                  const DeviceFact& fact) {
  ProcedurePlan plan{"commission", "Commissioning of " + robot.title, {}};
  StepList list(robot, fact);
  if (const FirstDay* day = first_day_of(robot.device)) {
    day->list(list, robot, homing, fact);
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
