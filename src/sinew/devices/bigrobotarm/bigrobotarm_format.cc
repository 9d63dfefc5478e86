#include "sinew/devices/bigrobotarm/bigrobotarm_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "sinew/core/assert.h"
#include "sinew/core/number_text.h"
#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/limit_reach.h"
#include "sinew/program/formats/text_form.h"
#include "sinew/program/plans/row_planner.h"

namespace sinew::program {
namespace {

/// A motor's step is some hundredths of a degree: this many decimals give it back.
std::string degrees(double angle) {
  return number_text(to_deg(angle), 6) + "deg";
}

/// Steps of the motors, and what is known of them while a sequence is read.
class RowWriter {
 public:
  explicit RowWriter(const RobotModel& robot)
      : robot_(robot), device_(*big_robot_arm_of(*robot.device.settings)) {}

  void take(const sequence::Section& section) {
    const bool differs = std::ranges::any_of(section.steps, [](const sequence::Step& step) {
      return std::holds_alternative<sequence::Reset>(step.command) ||
             std::holds_alternative<sequence::Speeds>(step.command) ||
             std::holds_alternative<sequence::Accelerations>(step.command);
    });
    const bool unrolled = differs || std::ranges::count(relative_, true) > 0;
    const int rounds = section.block && unrolled ? section.repeats : 1;
    indent_ = section.block && !unrolled ? "  " : "";
    if (section.block && !unrolled) {
      rows_.add(section.line, "loop " + std::to_string(section.repeats));
    }
    for (int round = 0; round < rounds; ++round) {
      for (const sequence::Step& step : section.steps) {
        std::visit([&](const auto& command) { take(step.line, command); }, step.command);
      }
    }
    if (!indent_.empty())
      rows_.add(section.steps.empty() ? section.line : section.steps.back().line, "end");
  }

  Rows finish() { return std::move(rows_); }

 private:
  static constexpr std::size_t kJoints = kBigRobotArmJoints;

  void add(int line, const std::string& row) { rows_.add(line, indent_ + row); }
  void note(int line, std::string sentence) {
    for (const ProgramNote& one : rows_.notes) {
      if (one.line == line && one.sentence == sentence) return;
    }
    add(line, "# " + sentence);
    rows_.notes.push_back({line, std::move(sentence)});
  }

  void go(int line, const sequence::GivenWords& steps) {
    std::string row = "joint";
    for (std::size_t i = 0; i < steps.count; ++i) {
      const std::int32_t to = steps.words[i];
      const std::int32_t counts =
          relative_[i] ? to - at_[i].value_or(0) : sendable(line, i, zero_[i] + to);
      row += (relative_[i] ? " d." : " ") + robot_.joints[i].name + "=" +
             degrees(counts / device_.joints[i].steps_per_rad);
      at_[i] = to;
    }
    add(line, row);
  }

  /// Counts that the byte wire would cut go to the step beside them, as the driver does it.
  std::int32_t sendable(int line, std::size_t joint, std::int32_t counts) {
    if (device_.wire != BigRobotArmWire::kByte || bigrobotarm::byte::sendable(counts))
      return counts;
    for (const std::int32_t near : {counts - 1, counts + 1}) {
      if (!bigrobotarm::byte::sendable(near)) continue;
      constexpr const char* kWords[] = {"B", "S", "E", "WR", "W"};
      note(line, std::string(kWords[joint]) + std::to_string(counts) +
                     " cannot be sent on this wire; " + std::to_string(near) + " instead");
      return near;
    }
    return counts;  // the plan refuses it
  }

  void take(int line, const sequence::Move& move) {
    if (!together_ && !told_) {
      told_ = true;
      note(line,
           "without S1 each joint of the arm's own firmware arrives in its own time; here the "
           "joints arrive together");
    }
    go(line, move.steps);
  }
  void take(int line, const sequence::Home&) { go(line, {{}, kJoints}); }
  void take(int, const sequence::Reset&) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      if (at_[i]) {
        zero_[i] += *at_[i];
      } else {
        relative_[i] = true;  // where it is, nothing before has said
      }
      at_[i] = 0;
    }
  }
  void take(int line, const sequence::Gripper& gripper) {
    add(line,
        gripper.enabled ? "gripper " + std::to_string(gripper.position) + "deg" : "gripper off");
  }
  void take(int, const sequence::Synchronise& sync) { together_ = sync.on; }
  void take(int line, const sequence::Speeds& speeds) {
    limit(line, "velocity", "M203", speeds.multipliers, &Joint::velocity_max);
  }
  void take(int line, const sequence::Accelerations& accelerations) {
    limit(line, "acceleration", "M201", accelerations.multipliers, &Joint::acceleration_max);
  }

  /// Hundredths of a motor's revolution per s (s^2) as shares of the joints' limits.
  void limit(int line, const std::string& row, const std::string& command,
             const sequence::GivenWords& multipliers, double Joint::* limit) {
    std::string words;
    for (std::size_t i = 0; i < multipliers.count; ++i) {
      const BigRobotArmJoint& motor = device_.joints[i];
      const double asked =
          multipliers.words[i] * (motor.steps_per_motor_rev / 100) / std::abs(motor.steps_per_rad);
      const double most = robot_.joints[i].*limit;
      const LimitReach own = limit_reach(robot_, i);
      const double reach = row == "velocity" ? own.velocity : own.acceleration;
      constexpr double kLeast = 0.01;
      // Limits in files are rounded to four digits.
      if (asked > 1.001 * most) {
        const std::string unit = row == "velocity" ? " deg/s" : " deg/s2";
        note(line, command + " " + std::to_string(multipliers.words[i]) + " is " +
                       number_text(to_deg(asked), 1) + unit + " of " + robot_.joints[i].name +
                       ", more than the " + number_text(to_deg(most), 1) +
                       " of the robot's file: no board has shown it");
      }
      const double share = std::clamp(asked / most, kLeast, reach);
      words += " " + robot_.joints[i].name + "=" + number_text(100 * share, 2) + "%";
    }
    if (!words.empty()) add(line, row + words);
  }

  const RobotModel& robot_;
  const BigRobotArmDevice& device_;
  bool together_ = false;
  bool told_ = false;  ///< that joints do not arrive together there
  std::string indent_;
  /// Counted from the last G92; nothing: no command has said.
  std::array<std::optional<std::int32_t>, kJoints> at_{};
  sequence::Words zero_{};                ///< where the last G92 was, from the model's zero
  std::array<bool, kJoints> relative_{};  ///< where it was is not known
  Rows rows_;
};

class SequenceWriter {
 public:
  SequenceWriter(const Program& program, const RobotModel& robot)
      : program_(program),
        robot_(robot),
        device_(*big_robot_arm_of(*robot.device.settings)),
        q_(home_joints(robot)) {
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
                      joint.how.tool_acceleration != plain.tool_acceleration ||
                      joint.how.time > 0 || joint.how.blends();
    if (asks) return complain(step, "G0 has no speed=, accel=, blend= or time=");
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

Rows rows_of_sequence(const sequence::Program& sequence, const RobotModel& robot) {
  RowWriter writer(robot);
  for (const sequence::Section& section : sequence.sections) writer.take(section);
  return writer.finish();
}

std::expected<sequence::Program, std::vector<Complaint>> sequence_of_rows(const Program& program,
                                                                          const RobotModel& robot) {
  SequenceWriter writer(program, robot);
  for (const Step& step : program.steps) writer.take(step);
  return writer.finish();
}

namespace {

bool is_own(const RobotModel& robot) {
  return big_robot_arm_of(*robot.device.settings) != nullptr;
}

std::string is_none(const RobotModel& robot) {
  return "sequences are the BigRobotArm's; " + robot.id + " is none";
}

std::expected<Rows, NoForm> read_sequence(std::string_view text, const std::string& file_name,
                                          const RobotModel& robot) {
  const BigRobotArmDevice* device = big_robot_arm_of(*robot.device.settings);
  if (device == nullptr) return no_form(is_none(robot));
  const auto sequence = sequence::parse(text, file_name, *device);
  if (!sequence) return no_form(sequence.error());
  return rows_of_sequence(*sequence, robot);
}

std::expected<std::string, NoForm> write_sequence(const Program& program, const RobotModel& robot,
                                                  DecimalMark /*mark*/) {
  // A row that cannot be carried out is said before one that a sequence has no command for.
  const auto plan = make_plan(program, robot, home_joints(robot));
  if (!plan) return std::unexpected(NoForm{{}, {}, plan.error()});
  if (!is_own(robot)) return no_form(is_none(robot));
  const auto sequence = sequence_of_rows(program, robot);
  if (!sequence) return no_form(sequence.error());
  return sequence::to_text(*sequence);
}

constexpr std::array<std::string_view, 1> kEndings{".txt"};

}  // namespace

extern const TextForm kSequenceForm;
constexpr TextForm kSequenceForm{.name = "sequence",
                                 .endings = kEndings,
                                 .is_own = is_own,
                                 .rows = read_sequence,
                                 .text = write_sequence};

}  // namespace sinew::program
