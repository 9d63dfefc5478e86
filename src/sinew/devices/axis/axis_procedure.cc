// The first day of arms with a board per axis.
#include "sinew/core/units.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/model/left_out.h"
#include "sinew/program/procedures/step_list.h"

namespace sinew::program {
namespace {

/// Of each joint, on both of its shafts as far as there are sensors.
void list_magnets(StepList& list, const RobotModel& robot, const DeviceFact& fact) {
  if (!robot.device.settings.is<AxisLinkDevice>()) return;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    if (is_left_out(robot, j)) continue;
    list.add("magnet." + robot.joints[j].name, "The encoder magnets of " + robot.joints[j].name,
             CheckStep{[fact, j](const Procedure&) -> std::optional<Verdict> {
               if (!fact) return Verdict{true, "not reported here"};
               const auto motor = fact("motor_magnet", j);
               const auto joint = fact("joint_magnet", j);
               if (!motor || !joint) return std::nullopt;
               if (*motor == "unknown" && *joint == "unknown") {
                 return Verdict{true, "not reported here"};
               }
               const auto fine = [](const std::string& word) {
                 return word == "good" || word == "unknown";
               };
               std::string words = "motor: " + *motor;
               if (*joint != "unknown") words += ", joint: " + *joint;
               return Verdict{fine(*motor) && fine(*joint), words};
             }},
             "a magnet sits centred, 0.5 to 3 mm above its chip; no reply: the cable");
  }
}

void list_boards(StepList& list, const RobotModel& robot, const Homing& homing,
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
  list_magnets(list, robot, fact);
  ProcedurePlan found = homing_steps(robot, homing, fact);
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

extern const FirstDay kAxisRegistersDay;
const FirstDay kAxisRegistersDay{.protocol = "axis_registers", .list = list_boards};
extern const FirstDay kAxisLinkDay;
const FirstDay kAxisLinkDay{.protocol = "axis_link", .list = list_boards};

}  // namespace sinew::program
