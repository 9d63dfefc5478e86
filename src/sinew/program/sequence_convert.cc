#include "sinew/program/sequence_convert.h"

#include <cmath>
#include <optional>

#include "sinew/core/assert.h"
#include "sinew/core/number_text.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/row_planner.h"

namespace sinew::program {
namespace {

/// A motor's step is some hundredths of a degree: this many decimals give it back.
std::string degrees(double angle) {
  return number_text(to_deg(angle), 6) + "deg";
}

const BigRobotArmDevice& device_of(const RobotModel& robot) {
  const auto* device = std::get_if<BigRobotArmDevice>(&robot.device.settings);
  SINEW_ASSERT(device != nullptr);
  return *device;
}

class RowWriter {
 public:
  RowWriter(std::string_view file_name, const RobotModel& robot)
      : file_name_(file_name), robot_(robot), device_(device_of(robot)) {}

  void take(const sequence::Section& section) {
    if (section.block) out_ += "loop " + std::to_string(section.repeats) + "\n";
    for (const sequence::Step& step : section.steps) take(step, section.block);
    if (section.block) out_ += "end\n";
  }

  std::expected<std::string, std::vector<Complaint>> finish() {
    if (!complaints_.empty()) return std::unexpected(std::move(complaints_));
    return std::move(out_);
  }

 private:
  void complain(int line, std::string message) {
    if (complaints_.size() < sequence::kComplaintMax) {
      complaints_.push_back({file_name_, line, 1, "", std::move(message)});
    }
  }

  void take(const sequence::Step& step, bool block) {
    if (block) out_ += "  ";
    if (const auto* move = std::get_if<sequence::Move>(&step.command)) {
      if (!together_) {
        complain(step.line,
                 "here the joints do not arrive together, and those of a row always do; write S1 "
                 "before it if they may");
      }
      out_ += "joint";
      for (std::size_t i = 0; i < move->steps.count; ++i) {
        out_ += " " + robot_.joints[i].name + "=" +
                degrees(move->steps.words[i] / device_.joints[i].steps_per_rad);
      }
      out_ += "\n";
    } else if (std::holds_alternative<sequence::Home>(step.command)) {
      out_ += "joint";
      for (const Joint& joint : robot_.joints) out_ += " " + joint.name + "=0deg";
      out_ += "\n";
    } else if (const auto* gripper = std::get_if<sequence::Gripper>(&step.command)) {
      out_ += gripper->enabled ? "gripper " + std::to_string(gripper->position) + "deg\n"
                               : "gripper off\n";
    } else if (const auto* sync = std::get_if<sequence::Synchronise>(&step.command)) {
      together_ = sync->on;
      out_ += sync->on ? "# S1: joints arrive together, as those of a row do\n" : "# S0\n";
    } else if (std::holds_alternative<sequence::Reset>(step.command)) {
      complain(step.line, "G92 says that here is zero; no row of a program does");
    } else {
      complain(step.line,
               "M203 and M201 set each joint's speed; a row has one share of the limits for all "
               "(speed=50%)");
    }
  }

  std::string file_name_;
  const RobotModel& robot_;
  const BigRobotArmDevice& device_;
  bool together_ = false;
  std::string out_;
  std::vector<Complaint> complaints_;
};

class SequenceWriter {
 public:
  SequenceWriter(const Program& program, const RobotModel& robot)
      : program_(program), robot_(robot), device_(device_of(robot)), q_(home_joints(robot)) {
    sequence_.sections.push_back({false, 0, 1, {{0, sequence::Synchronise{true}}}});
  }

  void take(const Step& step) {
    if (const auto* joint = std::get_if<JointStep>(&step.what)) return take_joint(step, *joint);
    if (const auto* tool = std::get_if<ToolStep>(&step.what)) return take_gripper(step, *tool);
    if (const auto* loop = std::get_if<LoopStep>(&step.what)) return begin_loop(step, *loop);
    if (std::holds_alternative<EndStep>(step.what) && open_) {
      sequence_.sections.push_back(std::move(block_));
      block_ = {};
      open_ = false;
      return;
    }
    complain(step, "no command of a sequence says this row: it has joint, gripper and loop");
  }

  std::expected<sequence::Program, std::vector<Complaint>> finish() {
    if (!complaints_.empty()) return std::unexpected(std::move(complaints_));
    return std::move(sequence_);
  }

 private:
  void complain(const Step& step, std::string message) {
    if (complaints_.size() < sequence::kComplaintMax) {
      complaints_.push_back({program_.files[static_cast<std::size_t>(step.file)], step.line, 1, "",
                             std::move(message)});
    }
  }

  void add(const Step& step, sequence::Command command) {
    if (!open_) {
      sequence_.sections.push_back({false, step.line, 1, {{step.line, std::move(command)}}});
    } else if (block_.steps.size() < sequence::kBlockMax) {
      block_.steps.push_back({step.line, std::move(command)});
    } else {
      complain(step, "a block of the firmware holds 20 commands");
    }
  }

  void take_joint(const Step& step, const JointStep& joint) {
    const MotionOptions plain;
    const bool asks = joint.how.joint_share != plain.joint_share ||
                      joint.how.tool_speed != plain.tool_speed ||
                      joint.how.tool_acceleration != plain.tool_acceleration || joint.how.blends();
    if (asks) return complain(step, "G0 has no speed=, accel= or blend=");
    if (open_ && joint.relative != 0) {
      return complain(step, "a difference goes elsewhere in each round; G0 says places");
    }
    if (open_ && joint.given != (1U << kBigRobotArmJoints) - 1) {
      return complain(
          step,
          "in a loop a row names all joints: the others may stand elsewhere in the next "
          "round, and a G0 says them all");
    }
    q_ = resolved(joint, q_);
    sequence::Move move;
    for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
      const double steps = std::round(q_[i] * device_.joints[i].steps_per_rad);
      if (!(std::abs(steps) <= kStepsMax)) {
        return complain(step, robot_.joints[i].name + " would go beyond what a G0 counts");
      }
      move.steps.words[i] = static_cast<std::int32_t>(steps);
    }
    add(step, move);
  }

  void take_gripper(const Step& step, const ToolStep& tool) {
    const auto* gripper = std::get_if<GripperTo>(&tool.action);
    if (gripper == nullptr) return complain(step, "a sequence has no other tool than gripper");
    // A G1 always says where; the firmware's own first place is 90 degrees, which no row has said.
    if (gripper->enabled && !gripper->angle && !gripper_deg_) {
      return complain(step, "G1 says an angle, and no row before this one does");
    }
    if (open_ && gripper->enabled && !gripper->angle) {
      return complain(step, "in a loop gripper says its angle: the next round may begin elsewhere");
    }
    const double last = gripper->enabled ? gripper_deg_.value_or(0) : 0;
    const double angle = gripper->angle ? to_deg(*gripper->angle) : last;
    const double whole = std::round(angle);
    if (!(std::abs(whole) <= kStepsMax) || std::abs(whole - angle) > 1e-9) {
      return complain(step, "G1 takes whole degrees of the gripper");
    }
    if (gripper->angle) gripper_deg_ = whole;
    add(step, sequence::Gripper{gripper->enabled, static_cast<std::int32_t>(whole)});
  }

  void begin_loop(const Step& step, const LoopStep& loop) {
    if (open_) return complain(step, "blocks of a sequence are not nested");
    if (loop.rounds > sequence::kRepeatsMax) {
      complain(step, "a block of a sequence has 127 rounds at most");
    }
    open_ = true;
    block_ = {true, step.line, loop.rounds, {}};
  }

  static constexpr double kStepsMax = 1e6;

  const Program& program_;
  const RobotModel& robot_;
  const BigRobotArmDevice& device_;
  JointVector q_;
  bool open_ = false;
  sequence::Section block_;
  sequence::Program sequence_;
  std::optional<double> gripper_deg_;  ///< of the last row that said it
  std::vector<Complaint> complaints_;
};

}  // namespace

std::expected<std::string, std::vector<Complaint>> rows_of_sequence(
    const sequence::Program& sequence, std::string_view file_name, const RobotModel& robot) {
  RowWriter writer(file_name, robot);
  for (const sequence::Section& section : sequence.sections) writer.take(section);
  return writer.finish();
}

std::expected<sequence::Program, std::vector<Complaint>> sequence_of_rows(const Program& program,
                                                                          const RobotModel& robot) {
  SequenceWriter writer(program, robot);
  for (const Step& step : program.steps) writer.take(step);
  return writer.finish();
}

}  // namespace sinew::program
