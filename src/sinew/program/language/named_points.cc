// How rows of motion use taught points.
#include <algorithm>

#include "sinew/core/spelling.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/language/motion_rows.h"
#include "sinew/program/language/tool_goal.h"

namespace sinew::program {

const TaughtPoint* MotionRows::named_point(const Word& word, std::string_view name) {
  if (points_ == nullptr) {
    row_.complain(word, in_quotes(name) + ": there is no points.toml beside the program");
    return nullptr;
  }
  std::vector<std::string_view> known;
  for (const TaughtPoint& point : *points_) {
    if (!point.wrong.empty() && (point.name.empty() || point.name == name)) {
      row_.complain(word, in_quotes(name) + " cannot be used: " + point.wrong);
      return nullptr;
    }
    if (point.name != name) {
      if (point.robot == robot_.id) known.push_back(point.name);
      continue;
    }
    if (point.robot != robot_.id) {
      row_.complain(word, in_quotes(name) + " is a point of " + printable(point.robot) +
                              ", not of " + robot_.id);
      return nullptr;
    }
    const std::string misfit = misfit_of_joints(point, robot_);
    if (misfit.empty()) return &point;
    row_.complain(word, misfit);
    return nullptr;
  }
  const std::string_view meant = nearest_spelling(name, known);
  std::string all;
  for (std::size_t i = 0; i < std::min<std::size_t>(known.size(), 10); ++i) {
    all += " " + std::string(known[i]);
  }
  row_.complain(
      word, in_quotes(name) + " is no taught point" +
                (!meant.empty()  ? "; did you mean " + std::string(meant) + "?"
                 : known.empty() ? "; there is none of this robot"
                                 : "; there are" + all + (known.size() > 10 ? " and more" : "")));
  return nullptr;
}

std::optional<ToolGoal> MotionRows::tool_goal(const Word& word, const TaughtPoint& point) {
  const auto complain = [&](const std::string& why) {
    row_.complain(word, in_quotes(point.name) + why);
    return std::nullopt;
  };
  using planning::TaskSpace;
  if (const auto* place = std::get_if<ToolPlace>(&point.place)) {
    if (place->pitch && task_ != TaskSpace::kPitchRoll) {
      return complain(" has a pitch and a roll, which this robot's tool does not take");
    }
    if (place->R_BT && task_ == TaskSpace::kPoint) {
      return complain(" has an orientation; this robot's tool turns with its base and takes none");
    }
    return goal_of(*place);
  }
  const auto& q = std::get<JointVector>(point.place);
  const auto X_BT = space_.forward({q.data(), q.size()}, space_.home());
  if (!X_BT) return complain(": its legs give no place of the platform");
  ToolGoal goal = goal_of({X_BT->p, X_BT->R, {}, {}});
  goal.of_joints = true;
  if (task_ == TaskSpace::kPoint) goal.R_BT.reset();
  return goal;
}

std::optional<Vec3> MotionRows::position(const Word& word, std::string_view text) {
  const bool numbers = text.find(',') != std::string_view::npos ||
                       (!text.empty() && (text[0] >= '0' && text[0] <= '9'));
  if (numbers || points_ == nullptr) return row_.point(word, text);
  const TaughtPoint* point = named_point(word, text);
  if (point == nullptr) return std::nullopt;
  const auto goal = tool_goal(word, *point);
  if (!goal) return std::nullopt;
  return Vec3{*goal->p_BT[0], *goal->p_BT[1], *goal->p_BT[2]};
}

}  // namespace sinew::program
