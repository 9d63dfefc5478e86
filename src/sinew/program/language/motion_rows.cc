#include "sinew/program/language/motion_rows.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/spelling.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "sinew/model/limit_reach.h"
#include "sinew/planning/paths/moves.h"

namespace sinew::program {
namespace {

using planning::TaskSpace;
using Way = ToolMoveStep::Way;

constexpr std::array<std::string_view, 5> kRows{"joint", "move", "line", "arc", "spline"};
constexpr std::array<std::string_view, 4> kOptions{"speed", "accel", "blend", "time"};
constexpr double kJointShareMin = 0.01;
constexpr double kToolMax = 100;    // m/s, m/s^2: beyond what any of these arms can do
constexpr double kToolMin = 1e-6;   // m/s, m/s^2
constexpr double kBlendMax = 1;     // m
constexpr double kTimeMax = 86400;  // s
constexpr double kBlendAngleMax = from_deg(60);
constexpr double kTurnMax = 4 * kPi;  // rad
/// What a row adds to a place; the first three are lengths.
constexpr std::array<std::string_view, 8> kOffsets{"dx",  "dy",  "dz",     "drx",
                                                   "dry", "drz", "dpitch", "droll"};
/// A joint's difference: no joint's name has a dot in it.
constexpr std::string_view kDifference = "d.";

}  // namespace

MotionRows::MotionRows(const RobotModel& robot, RowReader& row, const Surroundings& around)
    : robot_(robot),
      row_(row),
      points_(around.points),
      table_(around.table.get()),
      space_(robot),
      task_(space_.task()) {
  for (const Joint& joint : robot.joints) names_.push_back(joint.name);
}

std::optional<std::variant<JointStep, ToolMoveStep, BasketGoal>> MotionRows::read_place() {
  if (const auto name = basket_word()) {
    auto goal = basket_row(*name);
    if (!goal) return std::nullopt;
    return std::move(*goal);
  }
  auto step = tool_row(Way::kJoints);
  if (!step) return std::nullopt;
  if (motion_of(*step)->blends()) {
    row_.complain(row_.words()[0], "place stops where it lets go: without blend=");
    return std::nullopt;
  }
  if (auto* joints = std::get_if<JointStep>(&step->what)) return std::move(*joints);
  return std::get<ToolMoveStep>(std::move(step->what));
}

bool MotionRows::known(std::string_view name) {
  return std::ranges::find(kRows, name) != kRows.end();
}

std::optional<Step> MotionRows::read() {
  const std::string_view name = row_.words()[0].text;
  auto step = name == "joint"    ? joint_row()
              : name == "spline" ? spline_row()
                                 : tool_row(name == "move"   ? Way::kJoints
                                            : name == "line" ? Way::kLine
                                                             : Way::kArc);
  if (!step) return step;
  const MotionOptions& how = *motion_of(*step);
  if (how.time > 0 && (how.joint_share != 1 || std::isfinite(how.tool_speed) ||
                       std::isfinite(how.tool_acceleration) || how.blends())) {
    row_.complain(
        row_.words()[0],
        "time= is of the whole motion, from stop to stop: without speed=, accel=, blend=");
    return std::nullopt;
  }
  if (!limits_) return step;
  std::visit(
      [&](auto& what) {
        if constexpr (requires { what.how; }) what.how.limits = limits_;
      },
      step->what);
  return step;
}

void MotionRows::take_limits() {
  const auto& words = row_.words();
  const bool velocity = words[0].text == "velocity";
  JointShares shares;
  if (limits_) shares = *limits_;
  while (shares.velocity.size() < names_.size()) shares.velocity.push_back(1);
  while (shares.acceleration.size() < names_.size()) shares.acceleration.push_back(1);
  JointVector& of = velocity ? shares.velocity : shares.acceleration;
  const std::string example = std::string(words[0].text) + " " + names_[0] + "=50%";
  if (words.size() == 1) return row_.complain(words[0], "a joint is missing; write " + example);
  for (const Word& word : std::span(words).subspan(1)) {
    const auto one = argument(word, example);
    if (!one) continue;
    const bool all = one->name == "all";
    const auto joint = all ? std::optional<std::size_t>(0) : joint_named(robot_, one->name);
    if (!joint) {
      std::vector<std::string> known = names_;
      known.emplace_back("all");
      unknown(*one, known, "no joint of this robot");
      continue;
    }
    const auto share = row_.quantity(word, one->value, Measure::kShare);
    const std::size_t end = all ? names_.size() : *joint + 1;
    for (std::size_t j = *joint; share && j < end; ++j) {
      if (!takes_share(word, j, velocity, *share)) break;
      of[j] = *share;
    }
  }
  const auto is_whole = [](double share) { return share == 1; };
  const bool none = std::ranges::all_of(shares.velocity, is_whole) &&
                    std::ranges::all_of(shares.acceleration, is_whole);
  limits_ = none ? nullptr : std::make_shared<const JointShares>(std::move(shares));
}

/// Complains where a joint's limit cannot be asked for so.
bool MotionRows::takes_share(const Word& word, std::size_t joint, bool velocity, double share) {
  const LimitReach reach = limit_reach(robot_, joint);
  // Limits in files are rounded to three digits, and so is what is told.
  const double most = std::round(100 * (velocity ? reach.velocity : reach.acceleration)) / 100;
  constexpr double kRounding = 0.005;
  if (share >= kJointShareMin && share <= most + (most > 1 ? kRounding : 0)) return true;
  const std::string percent = std::to_string(std::lround(100 * most)) + "%";
  row_.complain(word, most > 1 ? "a share of " + names_[joint] + "'s limit is 1% to " + percent
                               : "a share of the joint's limit is 1% to 100%");
  return false;
}

std::optional<MotionRows::Argument> MotionRows::argument(const Word& word,
                                                         std::string_view example) {
  const std::size_t equals = word.text.find('=');
  if (equals != std::string_view::npos) {
    return Argument{word, word.text.substr(0, equals), word.text.substr(equals + 1)};
  }
  if (row_.words()[0].text == "place") return Argument{word, "to", word.text};
  row_.complain(word, in_quotes(word.text) + ": write NAME=VALUE, as in " + std::string(example));
  return std::nullopt;
}

void MotionRows::unknown(const Argument& argument, const std::vector<std::string>& names,
                         std::string_view what) {
  std::vector<std::string_view> known;
  for (const std::string& name : names) {
    // Who writes rx does not mean dx.
    const bool difference = std::ranges::find(kOffsets, name) != kOffsets.end();
    if (!difference || argument.name.starts_with('d')) known.push_back(name);
  }
  const std::string_view meant = nearest_spelling(argument.name, known);
  row_.complain(argument.word, in_quotes(argument.name) + " is " + std::string(what) +
                                   (meant.empty() ? "; it has " + listed(names)
                                                  : "; did you mean " + std::string(meant) + "?"));
}

std::optional<bool> MotionRows::option(const Argument& argument, MotionOptions& how, Given& given) {
  if (argument.name == "speed") return take_speed(argument, how, given);
  if (std::ranges::find(kOptions, argument.name) == kOptions.end()) return std::nullopt;
  bool& before = argument.name == "accel"   ? given.acceleration
                 : argument.name == "blend" ? given.blend
                                            : given.time;
  if (before) {
    row_.complain(argument.word, in_quotes(argument.name) + " is named twice");
    return false;
  }
  before = true;
  if (argument.name == "blend") return take_blend(argument, how);
  if (argument.name == "time") {
    const auto time = motion_time(argument.word);
    how.time = time.value_or(0);
    return time.has_value();
  }
  const auto value = row_.quantity(argument.word, argument.value, Measure::kAcceleration);
  if (!value) return false;
  how.tool_acceleration = *value;
  if (*value >= kToolMin && *value <= kToolMax) return true;
  row_.complain(argument.word, "accel is 0.001 mm/s2 to 100 m/s2");
  return false;
}

std::optional<double> MotionRows::motion_time(const Word& word) {
  constexpr std::string_view kName = "time=";
  if (!word.text.starts_with(kName)) {
    row_.complain(word, "write how long it takes, as in time=2s");
    return std::nullopt;
  }
  const auto time = row_.quantity(word, word.text.substr(kName.size()), Measure::kTime);
  if (!time || (*time > 0 && *time <= kTimeMax)) return time;
  row_.complain(word, "time is above 0 and at most 24 h");
  return std::nullopt;
}

/// In percent it is the joints', as a length per second the tool's; a row may have both.
bool MotionRows::take_speed(const Argument& argument, MotionOptions& how, Given& given) {
  const bool of_tool = argument.value.ends_with("/s");
  bool& before = of_tool ? given.tool_speed : given.speed;
  const bool again = before;
  before = true;
  if (of_tool) {
    const auto value = row_.quantity(argument.word, argument.value, Measure::kSpeed);
    if (again) {
      row_.complain(argument.word, "'speed' of the tool is named twice");
      return false;
    }
    if (value && !(*value >= kToolMin && *value <= kToolMax)) {
      row_.complain(argument.word, "a tool's speed is 0.001 mm/s to 100 m/s");
      return false;
    }
    how.tool_speed = value.value_or(0);
    return value.has_value();
  }
  const auto share = row_.quantity(argument.word, argument.value, Measure::kShare);
  if (again) {
    row_.complain(argument.word, "'speed' of the joints is named twice");
    return false;
  }
  if (share && !(*share >= kJointShareMin && *share <= 1)) {
    row_.complain(argument.word, "speed is 1% to 100%");
    return false;
  }
  how.joint_share = share.value_or(1);
  return share.has_value();
}

/// As a length it is the tool's distance from the corner, as an angle the joints'.
bool MotionRows::take_blend(const Argument& argument, MotionOptions& how) {
  const bool angle = argument.value.ends_with("deg") || argument.value.ends_with("rad");
  const auto value =
      row_.quantity(argument.word, argument.value, angle ? Measure::kAngle : Measure::kLength);
  if (!value) return false;
  if (!(*value > 0 && *value <= (angle ? kBlendAngleMax : kBlendMax))) {
    row_.complain(argument.word, std::string("blend is above 0 and at most ") +
                                     (angle ? "60 deg of the joints" : "1 m of the tool"));
    return false;
  }
  (angle ? how.blend_joints : how.blend_radius) = *value;
  return true;
}

std::optional<Step> MotionRows::joint_row() {
  const auto& words = row_.words();
  JointStep step;
  step.q.resize(robot_.joints.size());
  bool good = words.size() > 1;
  const std::string example =
      names_[0] + (robot_.joints[0].kind == JointKind::kRevolute ? "=10deg" : "=200mm");
  if (!good) row_.complain(words[0], "a joint is missing; write joint " + example);
  Given given;
  Differences differences;
  for (std::size_t w = 1; w < words.size(); ++w) {
    const auto one = argument(words[w], example);
    if (!one) {
      good = false;
      continue;
    }
    const auto taken = option(*one, step.how, given);
    good = (taken ? *taken : take_joint(*one, step, differences)) && good;
  }
  if (!good) return std::nullopt;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (!differences[i]) continue;
    const auto bit = static_cast<std::uint8_t>(1U << i);
    if ((step.given & bit) == 0) step.relative = static_cast<std::uint8_t>(step.relative | bit);
    step.given = static_cast<std::uint8_t>(step.given | bit);
    step.q[i] += *differences[i];
  }
  if (step.given != 0) return Step{row_.line(), step};
  row_.complain(words[0], "a joint is missing: options alone move nothing");
  return std::nullopt;
}

bool MotionRows::take_joint_point(const Argument& argument, JointStep& step) {
  const TaughtPoint* point = named_point(argument.word, argument.value);
  if (point == nullptr) return false;
  const auto* q = std::get_if<JointVector>(&point->place);
  if (q == nullptr) {
    row_.complain(argument.word, in_quotes(point->name) +
                                     " is a place of the tool; write move to=" + point->name +
                                     ", which finds the joints");
    return false;
  }
  if (step.given != 0) {
    row_.complain(argument.word,
                  "to= names all joints; beside it a joint takes a difference, as in d." +
                      names_[0] + "=" + (robot_.joints[0].slides() ? "1mm" : "5deg"));
    return false;
  }
  step.q = *q;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (!is_left_out(robot_, i)) step.given = static_cast<std::uint8_t>(step.given | 1U << i);
  }
  return true;
}

bool MotionRows::take_joint(const Argument& argument, JointStep& step, Differences& differences) {
  if (argument.name == "to") return take_joint_point(argument, step);
  const bool difference = argument.name.starts_with(kDifference);
  const auto joint =
      joint_named(robot_, difference ? argument.name.substr(kDifference.size()) : argument.name);
  if (!joint) {
    std::vector<std::string> known = names_;
    known.insert(known.end(), kOptions.begin(), kOptions.end());
    if (difference) {
      for (std::string& name : known) name.insert(0, kDifference);
      known.resize(names_.size());
    }
    unknown(argument, known, "no joint of this robot");
    return false;
  }
  const bool again = difference ? differences[*joint].has_value() : (step.given >> *joint & 1) != 0;
  if (again) {
    row_.complain(argument.word, in_quotes(argument.name) + " is named twice");
    return false;
  }
  const bool revolute = robot_.joints[*joint].kind == JointKind::kRevolute;
  const auto value =
      row_.quantity(argument.word, argument.value, revolute ? Measure::kAngle : Measure::kLength);
  if (!value) return false;
  if (difference) {
    differences[*joint] = *value;
    return true;
  }
  step.q[*joint] = *value;
  step.given = static_cast<std::uint8_t>(step.given | 1U << *joint);
  return true;
}

std::optional<Step> MotionRows::tool_row(Way way) {
  const auto& words = row_.words();
  ToolMoveStep step;
  step.way = way;
  Given given;
  Collected collected;
  bool good = true;
  for (std::size_t w = 1; w < words.size(); ++w) {
    const auto one = argument(words[w], "x=200mm");
    if (!one) {
      good = false;
    } else if (way == Way::kArc && one->name == "via") {
      good = take_via(*one, step, collected) && good;
    } else {
      const auto taken = option(*one, step.how, given);
      good = (taken ? *taken : take_goal(*one, step, collected)) && good;
    }
  }
  if (!good || !goal_is_whole(step, collected)) return std::nullopt;
  return finished(step, collected);
}

std::optional<Step> MotionRows::finished(ToolMoveStep step, const Collected& collected) {
  const auto& offset = collected.offset;
  const bool moved =
      std::ranges::any_of(offset, [](const auto& value) { return value.has_value(); });
  if (collected.point != nullptr) {
    const auto* q = std::get_if<JointVector>(&collected.point->place);
    if (q != nullptr && !moved && step.way == Way::kJoints) {
      JointStep joints{.q = *q, .given = 0, .how = step.how};
      joints.given = static_cast<std::uint8_t>((1U << names_.size()) - 1);
      return Step{row_.line(), joints};
    }
    const auto goal = tool_goal(row_.words()[0], *collected.point);
    if (!goal) return std::nullopt;
    step.to = *goal;
  }
  if (const Rotations& turn = collected.rotations; turn[0]) {
    step.to.R_BT = rotation_from_fixed_xyz({*turn[0], *turn[1], *turn[2]});
  } else if (turn[2]) {
    step.to.R_BT = space_.scara()->turned(*turn[2]);
  }
  if (moved) {
    const auto of = [&](std::size_t which) { return offset[which].value_or(0); };
    step.to.offset =
        GoalOffset{{of(0), of(1), of(2)}, {of(3), of(4), of(5)}, of(6), of(7), collected.in_tool};
  }
  return Step{row_.line(), step};
}

bool MotionRows::goal_is_whole(const ToolMoveStep& step, const Collected& collected) {
  const Word& row = row_.words()[0];
  const auto named = [](const auto& value) { return value.has_value(); };
  const bool turned = std::ranges::any_of(collected.rotations, named);
  const bool moved = std::ranges::any_of(collected.offset, named);
  const bool placed =
      std::ranges::any_of(step.to.p_BT, named) || turned || step.to.pitch || step.to.roll;
  const auto complain = [&](const std::string& message) {
    row_.complain(row, message);
    return false;
  };
  const bool upright = space_.scara() != nullptr;
  const bool whole = std::ranges::all_of(collected.rotations, named);
  if (turned && !whole &&
      !(upright && collected.rotations[2] && !collected.rotations[0] && !collected.rotations[1])) {
    if (upright)
      return complain("rz alone turns this tool; rx, ry and rz together name an orientation");
    return complain("rx, ry and rz belong together: an orientation needs all three");
  }
  if (step.way == Way::kArc && !collected.via) {
    return complain("an arc needs a point on its way; write via=200mm,0mm,180mm");
  }
  if (collected.point != nullptr && placed) {
    return complain("to= names the place already; beside it write differences, as in dz=50mm");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (step.to.p_BT[i] && collected.offset[i] && !collected.in_tool) {
      const std::string name(kOffsets[i]);
      return complain(name.substr(1) + " and " + name + " are one number: write their sum");
    }
  }
  if (collected.frame && !moved) {
    return complain("frame= says along whose axes differences count; it needs one, as in dz=20mm");
  }
  if (placed || moved || collected.point != nullptr) return true;
  return complain("a target is missing; it has " + listed(goal_names(step.way == Way::kArc)));
}

std::vector<std::string> MotionRows::goal_names(bool arc) const {
  std::vector<std::string> names{"x", "y", "z"};
  if (task_ == TaskSpace::kPitchRoll) names.insert(names.end(), {"pitch", "roll"});
  if (task_ != TaskSpace::kPoint) names.insert(names.end(), {"rx", "ry", "rz"});
  names.insert(names.end(), {"to", "dx", "dy", "dz"});
  if (task_ == TaskSpace::kPitchRoll) names.insert(names.end(), {"dpitch", "droll"});
  if (task_ != TaskSpace::kPoint) names.insert(names.end(), {"drx", "dry", "drz"});
  names.emplace_back("frame");
  if (arc) names.emplace_back("via");
  names.insert(names.end(), kOptions.begin(), kOptions.end());
  return names;
}

bool MotionRows::take_via(const Argument& argument, ToolMoveStep& step, Collected& collected) {
  if (collected.via) {
    row_.complain(argument.word, "'via' is named twice");
    return false;
  }
  collected.via = true;
  const auto p = position(argument.word, argument.value);
  step.p_via_BT = p.value_or(Vec3{});
  return p.has_value();
}

bool MotionRows::take_frame(const Argument& argument, Collected& collected) {
  if (collected.frame) {
    row_.complain(argument.word, "'frame' is named twice");
    return false;
  }
  collected.frame = true;
  collected.in_tool = argument.value == "tool";
  if (argument.value == "tool" || argument.value == "base") return true;
  row_.complain(argument.word, in_quotes(argument.value) + ": a frame is base or tool");
  return false;
}

bool MotionRows::take_offset(const Argument& argument, std::size_t which, Collected& collected) {
  auto& value = collected.offset[which];
  return which < 3 ? take_length(argument, value) : take_angle(argument, value);
}

bool MotionRows::take_goal(const Argument& argument, ToolMoveStep& step, Collected& collected) {
  const auto names = goal_names(step.way == Way::kArc);
  if (std::ranges::find(names, argument.name) == names.end()) {
    unknown(argument, names, "nothing that this row takes");
    return false;
  }
  constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  if (const auto axis = std::ranges::find(kAxes, argument.name); axis != kAxes.end()) {
    return take_length(argument, step.to.p_BT[static_cast<std::size_t>(axis - kAxes.begin())]);
  }
  if (const auto one = std::ranges::find(kOffsets, argument.name); one != kOffsets.end()) {
    return take_offset(argument, static_cast<std::size_t>(one - kOffsets.begin()), collected);
  }
  if (argument.name == "frame") return take_frame(argument, collected);
  if (argument.name == "to") {
    if (collected.point != nullptr) {
      row_.complain(argument.word, "'to' is named twice");
      return false;
    }
    collected.point = named_point(argument.word, argument.value);
    return collected.point != nullptr;
  }
  if (argument.name == "pitch") return take_angle(argument, step.to.pitch);
  if (argument.name == "roll") return take_angle(argument, step.to.roll);
  // What is left is rx, ry or rz.
  return take_angle(argument, collected.rotations[argument.name == "rx"   ? 0
                                                  : argument.name == "ry" ? 1
                                                                          : 2]);
}

/// @param length  set already where the row named it before
bool MotionRows::take_length(const Argument& argument, std::optional<double>& length) {
  const bool again = length.has_value();
  const auto value = row_.quantity(argument.word, argument.value, Measure::kLength);
  length = value.value_or(0);
  if (value && (again || !(std::abs(*value) <= kFarAway))) {
    row_.complain(argument.word, in_quotes(argument.name) +
                                     (again ? " is named twice" : " is farther away than 100 m"));
    return false;
  }
  return value.has_value();
}

/// @param angle  set already where the row named it before
bool MotionRows::take_angle(const Argument& argument, std::optional<double>& angle) {
  if (angle) {
    row_.complain(argument.word, in_quotes(argument.name) + " is named twice");
    return false;
  }
  angle = row_.quantity(argument.word, argument.value, Measure::kAngle);
  if (!angle) return false;
  if (std::abs(*angle) <= kTurnMax) return true;
  row_.complain(argument.word, in_quotes(argument.name) + " is two turns at most");
  return false;
}

std::optional<Step> MotionRows::spline_row() {
  const auto& words = row_.words();
  std::vector<Vec3> through;
  MotionOptions how;
  Given given;
  bool good = true;
  for (std::size_t w = 1; w < words.size(); ++w) {
    if (words[w].text.find('=') == std::string_view::npos) {
      const auto p = position(words[w], words[w].text);
      good = good && p;
      through.push_back(p.value_or(Vec3{}));
      continue;
    }
    const auto one = argument(words[w], "");
    const auto taken = option(*one, how, given);
    if (!taken) unknown(*one, {kOptions.begin(), kOptions.end()}, "nothing that this row takes");
    good = taken.value_or(false) && good;
  }
  if (!good) return std::nullopt;
  if (through.empty() || through.size() > planning::MoveSpline::kPointsMax) {
    row_.complain(words[0], "a spline has 1 to 256 points, as in 200mm,0mm,150mm");
    return std::nullopt;
  }
  return Step{row_.line(),
              SplineStep{std::make_shared<const std::vector<Vec3>>(std::move(through)), how}};
}

}  // namespace sinew::program
