#include "sinew/program/language/conditions.h"

#include <array>
#include <cmath>

#include "sinew/core/number_text.h"
#include "sinew/core/spelling.h"
#include "sinew/model/hand.h"
#include "sinew/model/joint_lookup.h"

namespace sinew::program {
namespace {

using Subject = Condition::Subject;
using Test = Condition::Test;

constexpr double kLargest = 1e3;  // rad, m or V: beyond it nothing is measured

struct Named {
  std::string_view name;
  Subject subject;
};
constexpr std::array<Named, 5> kSubjects{{{"x", Subject::kToolX},
                                          {"y", Subject::kToolY},
                                          {"z", Subject::kToolZ},
                                          {"supply", Subject::kSupply},
                                          {"jaws", Subject::kJaws}}};

bool has(const RobotModel& robot, Subject subject) {
  return subject != Subject::kJaws || jaws_of(robot) != nullptr;
}

Measure measure_of(const Condition& condition, const RobotModel& robot) {
  if (condition.subject == Subject::kSupply) return Measure::kVoltage;
  const bool turns = condition.subject == Subject::kJoint &&
                     robot.joints[condition.joint].kind == JointKind::kRevolute;
  return turns ? Measure::kAngle : Measure::kLength;
}

/// Whom it is about; J1.. means a joint also where its name is one of the others.
bool take_subject(std::string_view name, const RobotModel& robot, Condition& condition) {
  for (const Named& one : kSubjects) {
    if (one.name != name || !has(robot, one.subject)) continue;
    condition.subject = one.subject;
    return true;
  }
  const auto joint = joint_named(robot, name);
  condition.joint = joint.value_or(0);
  return joint.has_value();
}

std::string unknown_subject(std::string_view name, const RobotModel& robot) {
  std::vector<std::string_view> known;
  std::string all;
  for (const Joint& joint : robot.joints) known.push_back(joint.name);
  for (const Named& one : kSubjects) {
    if (has(robot, one.subject)) known.push_back(one.name);
  }
  for (const std::string_view one : known) all += " " + std::string(one);
  const std::string_view meant = nearest_spelling(name, known);
  return in_quotes(name) + " is nothing that is measured" +
         (meant.empty() ? "; there are" + all : "; did you mean " + std::string(meant) + "?");
}

/// "seen", "seen color=red": the words behind `first`.
std::optional<Condition> read_seen(RowReader& row, std::size_t first, std::size_t last) {
  Condition condition{.subject = Subject::kSeen};
  if (last == first + 1) return condition;
  const Word& at = row.words()[first + 1];
  if (last > first + 2 || !at.text.starts_with(kColorKey)) {
    row.complain(at, "write seen, or seen color=red");
    return std::nullopt;
  }
  condition.color = read_color(row, at);
  return condition.color ? std::optional(condition) : std::nullopt;
}

}  // namespace

std::optional<Condition> read_condition(RowReader& row, const RobotModel& robot, std::size_t first,
                                        std::size_t last) {
  if (first < row.words().size() && row.words()[first].text == "seen") {
    return read_seen(row, first, last);
  }
  std::string text;
  for (std::size_t w = first; w < last; ++w) text += row.words()[w].text;
  const Word& at = row.words()[first < row.words().size() ? first : 0];
  const std::size_t sign = text.find_first_of("<>=!");
  const bool plain = sign != std::string::npos && (text[sign] == '<' || text[sign] == '>');
  if (!plain || sign == 0) {
    row.complain(at, in_quotes(text) +
                         ": a condition is one number that is measured, above or below "
                         "one that the row says, as in " +
                         robot.joints[0].name +
                         (robot.joints[0].kind == JointKind::kRevolute ? ">20deg" : ">250mm") +
                         " or z<100mm");
    return std::nullopt;
  }
  Condition condition;
  condition.test = text[sign] == '>' ? Test::kAbove : Test::kBelow;
  const std::string_view name = std::string_view(text).substr(0, sign);
  std::string_view value = std::string_view(text).substr(sign + 1);
  if (value.starts_with('=')) value.remove_prefix(1);
  if (!take_subject(name, robot, condition)) {
    row.complain(at, unknown_subject(name, robot));
    return std::nullopt;
  }
  const auto number = row.quantity(at, value, measure_of(condition, robot));
  if (!number) return std::nullopt;
  condition.value = *number;
  if (std::abs(*number) <= kLargest) return condition;
  row.complain(at, in_quotes(value) + " is beyond what any machine measures");
  return std::nullopt;
}

std::optional<vision::ColorName> read_color(RowReader& row, const Word& word) {
  const std::string_view name = word.text.substr(kColorKey.size());
  const auto color = vision::color_named(name);
  if (color) return color;
  row.complain(word, in_quotes(name) + " is no color of a cube; there are " + vision::color_list());
  return std::nullopt;
}

std::string condition_text(const Condition& condition, const RobotModel& robot) {
  if (condition.subject == Subject::kSeen) {
    return "seen" +
           (condition.color ? " color=" + std::string(vision::name(*condition.color)) : "");
  }
  std::string name;
  for (const Named& one : kSubjects) {
    if (one.subject == condition.subject) name = one.name;
  }
  if (condition.subject == Subject::kJoint) name = robot.joints[condition.joint].name;
  const Measure measure = measure_of(condition, robot);
  const double shown = measure == Measure::kVoltage ? condition.value
                       : measure == Measure::kAngle ? to_deg(condition.value)
                                                    : to_mm(condition.value);
  const char* unit = measure == Measure::kVoltage ? "V" : measure == Measure::kAngle ? "deg" : "mm";
  return name + (condition.test == Test::kAbove ? " > " : " < ") + number_text(shown) + " " + unit;
}

}  // namespace sinew::program
