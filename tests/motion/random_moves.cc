#include "motion/random_moves.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/units.h"

namespace sinew::planning {
namespace {

using test::Random;

double ten_to(Random& random, double lower, double upper) {
  return std::pow(10, random.uniform(lower, upper));
}

/// The targets of a move, each of which may be spoilt; none of a joint move.
std::vector<ToolTarget*> targets_of(Move& move) {
  if (auto* to = std::get_if<MoveTo>(&move.way)) return {&to->to};
  if (auto* line = std::get_if<MoveL>(&move.way)) return {&line->to};
  if (auto* arc = std::get_if<MoveC>(&move.way)) return {&arc->to};
  std::vector<ToolTarget*> all;
  if (auto* spline = std::get_if<MoveSpline>(&move.way)) {
    for (ToolTarget& target : spline->through) all.push_back(&target);
  }
  return all;
}

double& coordinate(Vec3& v, std::int64_t which) {
  return which == 0 ? v.x : which == 1 ? v.y : v.z;
}

}  // namespace

double hostile_number(Random& random) {
  constexpr std::array kNumbers{std::numeric_limits<double>::quiet_NaN(),
                                kInfinity,
                                -kInfinity,
                                0.0,
                                -0.0,
                                -1.0,
                                -1e-9,
                                1e300,
                                -1e300,
                                1e12,
                                std::numeric_limits<double>::max(),
                                std::numeric_limits<double>::denorm_min(),
                                1e-300,
                                1e-30};
  return kNumbers[static_cast<std::size_t>(random.integer(0, std::ssize(kNumbers) - 1))];
}

RobotPlace MoveDealer::neighbour(Random& random, const RobotPlace& from, double scale) const {
  const ToolSpace& space = robot_.space;
  RobotPlace place;
  for (int tries = 0; tries < 20; ++tries) {
    if (robot_.is_hexapod()) {
      const auto some = [&](double size) {
        return Vec3{random.uniform(-size, size), random.uniform(-size, size),
                    random.uniform(-size, size)};
      };
      place.X_BT = {rotation_from_vector(some(0.2 * scale)) * from.X_BT.R,
                    from.X_BT.p + some(0.03 * scale)};
      const auto q = space.inverse_near(space.point(place.X_BT), from.q);
      if (!q) continue;
      place.q = *q;
      return place;
    }
    for (std::size_t j = 0; j < space.size(); ++j) {
      const Joint& joint = robot_.model.joints[j];
      place.q[j] = std::clamp(from.q[j] + scale * random.uniform(-1, 1), joint.lower, joint.upper);
    }
    place.X_BT = *space.forward(robot_.joints(place.q), {});
    if (robot_.can_be(place)) return place;
  }
  return robot_.random_place(random);
}

/// @param to  where it ends.
Move MoveDealer::deal_move(Random& random, const RobotPlace& from, double scale,
                           RobotPlace& to) const {
  const auto target = [&](const RobotPlace& place) {
    constexpr std::array kAsked{Asked::kPose, Asked::kPose, Asked::kApproach, Asked::kPoint};
    return ToolTarget{place.X_BT, kAsked[static_cast<std::size_t>(random.integer(0, 3))]};
  };
  to = neighbour(random, from, scale);
  Move move;
  const auto kind = random.integer(0, 9);
  if (kind < 3) {
    move.way = MoveJ{to.q};
  } else if (kind < 5) {
    move.way = MoveTo{target(to)};
  } else if (kind < 8) {
    move.way = MoveL{target(to)};
  } else if (kind < 9) {
    move.way = MoveC{neighbour(random, from, scale / 2).X_BT.p, target(to)};
  } else {
    MoveSpline spline;
    RobotPlace at = from;
    for (auto k = random.integer(1, 4); k >= 0; --k) {
      at = neighbour(random, at, scale / 2);
      spline.through.push_back(target(at));
    }
    to = at;
    move.way = std::move(spline);
  }
  // What is quick is the robot's own business: from far below it to beyond.
  const double quick = robot_.is_hexapod() ? 1e-4 : 0.3;
  if (random.chance(0.6)) move.tool_speed = quick * ten_to(random, -1.5, 0.5);
  if (random.chance(0.3)) move.tool_acceleration = quick * ten_to(random, -0.5, 1.5);
  if (random.chance(0.4)) move.joint_share = random.uniform(0.05, 1);
  if (random.chance(0.5)) move.blend_radius = 0.3 * scale * ten_to(random, -2, 0);
  if (random.chance(0.2)) move.blend_joints = scale * ten_to(random, -2, 0);
  return move;
}

std::vector<Move> MoveDealer::deal(Random& random, const RobotPlace& from) const {
  std::vector<Move> moves;
  RobotPlace at = from;
  const double scale =
      robot_.is_hexapod() ? ten_to(random, -4.5, -0.5) : ten_to(random, -2.5, -0.6);
  for (auto k = random.integer(1, 3); k > 0; --k) {
    const RobotPlace begin = at;
    moves.push_back(deal_move(random, begin, scale, at));
  }
  return moves;
}

/// To where the robot cannot go: out of its reach, through its base or its table.
void MoveDealer::take_away(Random& random, Move& move) const {
  if (auto* joints = std::get_if<MoveJ>(&move.way)) {
    const auto j = static_cast<std::size_t>(random.integer(0, std::ssize(robot_.model.joints) - 1));
    const Joint& joint = robot_.model.joints[j];
    const double off = (joint.upper - joint.lower) * ten_to(random, -3, 1);
    joints->q[j] = random.chance(0.5) ? joint.upper + off : joint.lower - off;
    return;
  }
  const auto targets = targets_of(move);
  ToolTarget& target =
      *targets[static_cast<std::size_t>(random.integer(0, std::ssize(targets) - 1))];
  Vec3& p = target.X_BT.p;
  if (random.chance(0.4)) {
    p = random.uniform(2, 20) * p;
  } else if (random.chance(0.5)) {
    p.x = -p.x;
    p.y = -p.y;
  } else {
    p.z = -random.uniform(0, 0.3);
  }
  if (random.chance(0.5)) target.asked = Asked::kPoint;
}

/// One of its numbers becomes a hostile one. @return  nobody could mean this
bool MoveDealer::spoil(Random& random, Move& move) const {
  const double number = hostile_number(random);
  const bool beyond = !(std::abs(number) <= 1e3);
  switch (random.integer(0, 6)) {
    case 0:
      move.tool_speed = number;
      return !(number > 0);
    case 1:
      move.tool_acceleration = number;
      return !(number > 0);
    case 2:
      move.joint_share = number;
      return !(number > 0 && number <= 1);
    case 3:
      (random.chance(0.5) ? move.blend_radius : move.blend_joints) = number;
      return !(number >= 0);
    default:
      break;
  }
  if (auto* joints = std::get_if<MoveJ>(&move.way)) {
    joints->q[static_cast<std::size_t>(random.integer(0, std::ssize(robot_.model.joints) - 1))] =
        number;
    return beyond;
  }
  if (auto* arc = std::get_if<MoveC>(&move.way); arc != nullptr && random.chance(0.5)) {
    coordinate(arc->p_via_BT, random.integer(0, 2)) = number;
    return beyond;
  }
  const auto targets = targets_of(move);
  ToolTarget& target =
      *targets[static_cast<std::size_t>(random.integer(0, std::ssize(targets) - 1))];
  if (random.chance(0.6)) {
    coordinate(target.X_BT.p, random.integer(0, 2)) = number;
    return beyond;
  }
  const Rotation before = target.X_BT.R;
  coordinate(target.X_BT.R.y, random.integer(0, 2)) = number;
  // Only just another number may still be a rotation.
  return target.asked != Asked::kPoint && !(norm(target.X_BT.R.y - before.y) < 1e-3);
}

DealtMoves MoveDealer::deal_any(Random& random, const RobotPlace& from) const {
  DealtMoves dealt{deal(random, from), 0};
  dealt.nonsense = dealt.moves.size();
  const auto which = static_cast<std::size_t>(random.integer(0, std::ssize(dealt.moves) - 1));
  if (random.chance(0.25)) {
    take_away(random, dealt.moves[which]);
  } else if (random.chance(0.3) && spoil(random, dealt.moves[which])) {
    dealt.nonsense = which;
  }
  return dealt;
}

}  // namespace sinew::planning
