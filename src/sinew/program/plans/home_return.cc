#include "sinew/program/plans/home_return.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>

#include "sinew/control/governor.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"

namespace sinew::program {
namespace {

using planning::Clearance;
using planning::CollisionModel;

/// Of the joints' limits, out of an overlap.
constexpr double kSlow = control::Governor::kLeavingShare;
/// Places of a leg where it is asked whether it has come clear.
constexpr int kLooks = 400;

/// A robot at one pose, and what is nearer there than its margin.
struct Stand {
  JointVector q;
  std::vector<LinkPair> near;  ///< pairs of links, as excuse() has them
  std::optional<Clearance> nearest;
  RobotModel lenient;  ///< the robot with these pairs excused
};

/// Two links that are too near, and with them those below the one and those that the other carries:
/// an arm that is folded into itself cannot unfold without its hand, which passes by the root of
/// the upper arm. The stand and the table are never meant.
void excuse(LinkPair pair, const RobotModel& robot, std::vector<LinkPair>& near) {
  if (pair.first > pair.second) std::swap(pair.first, pair.second);
  if (holds(near, pair.first, pair.second)) return;
  near.push_back(pair);
  if (pair.first == 0 || pair.second == kTableLink) return;
  for (const CollisionShape& below : robot.collision.shapes) {
    if (below.link == 0 || below.link > pair.first) continue;
    for (const CollisionShape& carried : robot.collision.shapes) {
      if (carried.link < pair.second || holds(near, below.link, carried.link)) continue;
      near.push_back({below.link, carried.link});
    }
  }
}

Stand stand_at(const RobotModel& robot, const JointVector& q) {
  Stand stand{q, {}, std::nullopt, robot};
  while (true) {
    const Clearance nearest = CollisionModel(stand.lenient).distance({q.data(), q.size()});
    if (nearest.distance >= robot.collision.margin || !std::isfinite(nearest.distance)) {
      return stand;
    }
    const std::size_t before = stand.near.size();
    if (!stand.nearest) stand.nearest = nearest;
    excuse({planning::link_of(robot, nearest.first), planning::link_of(robot, nearest.second)},
           robot, stand.near);
    if (stand.near.size() == before) return stand;
    for (std::size_t i = before; i < stand.near.size(); ++i) {
      stand.lenient.collision.ignored.push_back(stand.near[i]);
    }
  }
}

/// Whether a path, once nothing is too near any more but what is so at its end, keeps to that.
bool stays_clear(const planning::JointPath& path, const Stand& end) {
  const CollisionModel model(end.lenient);
  planning::PathPoint at;
  for (int k = 0; k <= kLooks; ++k) {
    path.sample(path.length() * k / kLooks, at);
    if (!model.clear({at.q.data(), end.q.size()}, model.margin())) continue;
    // From the next look on: right here it is at its margin.
    const double behind = std::min(path.length(), path.length() * (k + 1) / kLooks);
    return !model.check_path(path, model.margin(), behind, path.length());
  }
  return false;
}

std::expected<HomeLeg, Refusal> plan_leg(const RobotModel& robot, const JointVector& q_start,
                                         const JointVector& q_end, double share, int line) {
  JointStep step{.q = q_end, .given = 0, .how = {}};
  step.given = static_cast<std::uint8_t>((1U << robot.joints.size()) - 1);
  step.how.joint_share = share;
  const Step row{line, step};
  RowPlanner planner(robot);
  auto motion = planner.plan(q_start, {}, std::span(&row, 1));
  if (!motion) return std::unexpected(motion.error());
  const bool slow = share < 1 && robot.device.capability.takes_speed;
  return HomeLeg{std::move(*motion), planner.motion(), {}, slow};
}

/// A leg out of what is too near at its begin; nothing where it would not lead out.
std::optional<HomeLeg> leg_out(const Stand& from, const Stand& to, int line) {
  for (const LinkPair& pair : to.near) {
    if (!holds(from.near, pair.first, pair.second)) return std::nullopt;
  }
  auto leg = plan_leg(from.lenient, from.q, to.q, from.near.empty() ? 1 : kSlow, line);
  if (!leg || !stays_clear(leg->planned.path.joints, to)) return std::nullopt;
  leg->overlaps = from.near;
  return std::move(*leg);
}

/// A pose on the way, and the legs that lead there.
struct Node {
  std::shared_ptr<const Stand> stand;
  unsigned homed = 0;  ///< bit i: joint i is at its home
  std::vector<HomeLeg> legs;
};

HomeReturn told(std::vector<HomeLeg> legs, const Stand& start, const JointVector& q_end) {
  HomeReturn back{std::move(legs), 0, start.nearest, start.q, q_end};
  for (const HomeLeg& leg : back.legs) back.duration += leg.motion.duration;
  return back;
}

}  // namespace

std::expected<HomeReturn, Refusal> home_return(const RobotModel& robot, const JointVector& q,
                                               int line) {
  const JointVector home = home_joints(robot);
  if (q == home) return HomeReturn{{}, 0, std::nullopt, q, q};
  const auto start = std::make_shared<const Stand>(stand_at(robot, q));
  std::vector<bool> seen(std::size_t{1} << q.size());
  std::deque<Node> open;
  open.push_back({start, 0, {}});
  // Breadth first: the fewer legs the better.
  for (; !open.empty(); open.pop_front()) {
    const Node& node = open.front();
    const Stand& here = *node.stand;
    if (here.near.empty()) {
      if (auto rest = plan_leg(robot, here.q, home, 1, line)) {
        std::vector<HomeLeg> legs = node.legs;
        legs.push_back(std::move(*rest));
        return told(std::move(legs), *start, home);
      }
    }
    for (std::size_t j = 0; j < q.size(); ++j) {
      const unsigned homed = node.homed | 1U << j;
      if (seen[homed] || here.q[j] == home[j]) continue;
      JointVector next = here.q;
      next[j] = home[j];
      const auto there = std::make_shared<const Stand>(stand_at(robot, next));
      auto leg = leg_out(here, *there, line);
      if (!leg) continue;
      seen[homed] = true;
      Node more{there, homed, node.legs};
      more.legs.push_back(std::move(*leg));
      open.push_back(std::move(more));
    }
  }
  // In the words of the straight way, which was tried first or is what anybody would try.
  auto straight = plan_leg(robot, q, home, 1, line);
  if (straight) return told({std::move(*straight)}, *start, home);
  // Of links that may be anywhere hardly a way is clear: the zeros are found all the same.
  if (first_left_out(robot)) return told({}, *start, q);
  return std::unexpected(straight.error());
}

}  // namespace sinew::program
