#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "sinew/model/joint_lookup.h"
#include "sinew/program/procedures/procedures.h"

/// What the first days of all kinds of devices have in common.
namespace sinew::program {

/// Places that a person may name: home and, of a platform on legs, lowered.
std::vector<PlaceStep::Place> named_places(const RobotModel& robot);

inline constexpr const char* kMovedHint =
    "where it was moved by hand, add moved: and who did it, as in: home moved: lifted by hand";

/// Words for the two ways of a joint, as people see them.
struct JointWays {
  const char* plus;
  const char* minus;
};

class StepList {
 public:
  StepList(const RobotModel& robot, const DeviceFact& fact) : robot_(robot), fact_(fact) {}

  ProcedureStep& add(std::string id, std::string text,
                     decltype(ProcedureStep::what) what = TellStep{}, std::string hint = {}) {
    steps_.push_back({std::move(id), std::move(text), std::move(what), std::move(hint)});
    return steps_.back();
  }
  /// @param way  rad, of legs m; an arm's joint that slides goes by 2 mm
  void directions(double way, const std::vector<JointWays>& ways) {
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const std::string& name = robot_.joints[j].name;
      add("direction." + name,
          name + " moves by a little and comes back. Which way does it go first?",
          MotionStep{j, slides_in_arm(robot_, j) ? from_mm(2) : way,
                     ways[std::min(j, ways.size() - 1)].plus,
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

/// The steps of a search for all zeros, twice.
ProcedurePlan homing_steps(const RobotModel& robot, const Homing& homing, const DeviceFact& fact);

/// The first day of one kind of device: devices/KIND/KIND_procedure.cc has it, and first_days.cc
/// the list. What may be nullptr says so.
struct FirstDay {
  std::string_view protocol;
  void (*list)(StepList& list, const RobotModel& robot, const Homing& homing,
               const DeviceFact& fact) = nullptr;
  /// Adds what only this kind can have found; nullptr: nothing.
  void (*find)(const Procedure& procedure, FoundSettings& found) = nullptr;
  /// jaws_tried() of procedures.h; nullptr: open.
  double (*jaws_tried)(const RobotModel& robot) = nullptr;
};
/// nullptr: the one of any device that does the same.
const FirstDay* first_day_of(const Device& device);

/// The result of a step that was done and has a number; else nullptr.
const StepResult* numbered(const Procedure& procedure, const std::string& step);
/// As the settings of a robot have it.
std::string setting_text(double value);

}  // namespace sinew::program
