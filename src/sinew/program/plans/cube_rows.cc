#include "sinew/program/plans/cube_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/grasping/grasps.h"
#include "sinew/model/hand.h"
#include "sinew/model/tool_body.h"
#include "sinew/planning/collision/collision.h"
#include "sinew/program/plans/table_things.h"

namespace sinew::program {
namespace {

/// m, from where the tool goes straight down; lower ones where the higher one is out of reach.
constexpr std::array kAbove{40e-3, 30e-3, 20e-3};
/// m, of a cube's bottom over a basket's rim where it is released.
constexpr std::array kOverRim{15e-3, 30e-3, 50e-3};
constexpr double kLetGo = 15e-3;        // m, that jaws open more than what they hold
constexpr double kPress = 1.5e-3;       // m, of a cup's lip into a top
constexpr double kPressMore = 0.75e-3;  // m
constexpr double kStillThere = 0.6;     // of an edge, from where a cube was taken
constexpr double kPitchStep = from_deg(3);
constexpr int kPitchTries = 12;

/// A place of the tool; of arms with five joints with its pitch and roll, with six with all of its
/// orientation, else it turns with the base.
struct Spot {
  Vec3 p_BT;                      ///< m
  std::optional<double> pitch{};  ///< rad
  std::optional<double> roll{};   ///< rad
  std::optional<Rotation> R_BT{};
};

bool meets_thing(const Refusal& refusal) {
  return refusal.error.code == ErrorCode::kCollision && refusal.error.other == kObstacleLink;
}

/// Rows one behind the other, each planned from where the one before it ends, clear of what stands
/// on the table.
class Sequence {
 public:
  /// @param things  outlive this
  Sequence(RowPlanner& planner, const Standing& standing, const Step& row,
           const TableThings& things)
      : planner_(planner),
        row_(row),
        things_(things),
        begin_(*standing.q),
        q_(begin_),
        carries_(standing.tool.held || standing.at_cup) {
    rows_.tool = standing.tool;
  }

  const Step& row() const { return row_; }
  const ToolState& tool() const { return rows_.tool; }
  const TableThings& things() const { return things_; }

  /// @param upright  straight up or down, where the tool comes no nearer to what is beside it
  template <class What>
  std::optional<Refusal> go(What what, bool upright = false) {
    const Step step{row_.line, std::move(what), row_.file};
    const auto& aside = carries_ ? things_.carrying : things_.aside;
    const auto& around = upright ? things_.bare : aside;
    const auto motion = planner_.plan(q_, rows_.tool, std::span(&step, 1), around);
    if (!motion) return refused(motion.error());
    q_ = motion->q_end;
    for (std::size_t j = 0; j < q_.size(); ++j) {
      const Joint& joint = planner_.robot().joints[j];
      rows_.room = std::min({rows_.room, q_[j] - joint.lower, joint.upper - q_[j]});
    }
    rows_.duration += motion->duration;
    rows_.steps.push_back(step);
    return std::nullopt;
  }

  /// The joints go straight to where the tool is there, `above` (m) it.
  std::optional<Refusal> go_over(const Spot& spot, double above, const MotionOptions& how) {
    return go(move_to(spot, ToolMoveStep::Way::kJoints, above, how));
  }
  /// The tool goes straight.
  std::optional<Refusal> go_straight(const Spot& spot, const MotionOptions& how) {
    return go(move_to(spot, ToolMoveStep::Way::kLine, 0, how));
  }
  /// Straight down onto it.
  std::optional<Refusal> descend(const Spot& spot, const MotionOptions& how) {
    return go(move_to(spot, ToolMoveStep::Way::kLine, 0, how), true);
  }
  /// Straight up, as the tool is turned.
  std::optional<Refusal> rise(double height, const MotionOptions& how) {
    return go(move_to(spot(), ToolMoveStep::Way::kLine, height, how), true);
  }
  /// Where the tool is.
  Spot spot() const {
    const planning::ToolSpace space(planner_.robot(), rows_.tool.jaws);
    const auto X_BT = space.forward({q_.data(), q_.size()}, space.home());
    SINEW_ASSERT(X_BT);  // a motion ends there
    Spot spot{.p_BT = X_BT->p};
    if (space.task() == planning::TaskSpace::kPitchRoll) {
      const auto attitude = space.point(*X_BT).attitude;
      spot.pitch = attitude[0];
      spot.roll = attitude[1];
    }
    if (space.task() == planning::TaskSpace::kPose) spot.R_BT = X_BT->R;
    return spot;
  }

  std::optional<Refusal> use(const ToolAction& action) {
    if (const auto* jaws = std::get_if<JawsTo>(&action)) {
      const auto fine = planner_.check_jaws(q_, rows_.tool, jaws->width, things_.bare);
      if (!fine) return refused({row_.line, fine.error(), std::nullopt});
      rows_.duration += to_seconds(
          planner_.robot().device.settings->tool_time(planner_.robot(), action, rows_.tool.jaws));
      rows_.tool = {jaws->width, jaws->held};
      carries_ = jaws->held.has_value();
    } else {
      carries_ = std::get<Suction>(action).state == Suction::State::kOn;
      rows_.duration += to_seconds(
          planner_.robot().device.settings->tool_time(planner_.robot(), action, std::nullopt));
    }
    rows_.steps.push_back({row_.line, ToolStep{action}, row_.file});
    return std::nullopt;
  }

  /// To where the row began.
  std::optional<Refusal> back(const MotionOptions& how) {
    JointStep joints{.q = begin_, .given = 0, .how = how};
    joints.given = static_cast<std::uint8_t>((1U << begin_.size()) - 1);
    const double room = rows_.room;
    auto refusal = go(joints);
    rows_.room = room;
    return refusal;
  }
  CubeRows take() { return std::move(rows_); }

 private:
  static ToolMoveStep move_to(const Spot& spot, ToolMoveStep::Way way, double above,
                              const MotionOptions& how) {
    ToolMoveStep move{.way = way, .to = {}, .p_via_BT = {}, .how = how};
    move.to.p_BT = {spot.p_BT.x, spot.p_BT.y, spot.p_BT.z + above};
    move.to.pitch = spot.pitch;
    move.to.roll = spot.roll;
    move.to.R_BT = spot.R_BT;
    return move;
  }

  Refusal refused(Refusal refusal) const {
    refusal.file = row_.file;
    if (!meets_thing(refusal)) return refusal;
    const double less = things_shrunk_by(planner_.robot());
    refusal.error.measured -= less;
    refusal.error.limit -= less;
    return refusal;
  }

  RowPlanner& planner_;
  const Step& row_;
  const TableThings& things_;
  JointVector begin_, q_;
  bool carries_;
  CubeRows rows_;
};

/// What is out of reach by less is reported before what is so by more, and anything else before
/// both.
bool is_nearer(const Refusal& one, const Refusal& other) {
  const bool far = one.error.code == ErrorCode::kOutOfReach;
  const bool other_far = other.error.code == ErrorCode::kOutOfReach;
  return other_far && (!far || excess(one.error) < excess(other.error));
}

ToolAction letting_go(const RobotModel& robot, const ToolState& tool) {
  const JawGripper* gripper = jaws_of(robot);
  if (gripper == nullptr) return Suction{Suction::State::kRelease};
  const double held = tool.held.value_or(tool.jaws.value_or(kUsualCube));
  return JawsTo{std::min(gripper->width_max, held + kLetGo)};
}

/// The first of several ways that can be planned and keeps its joints off their limits: the arm
/// stands beside where it was sent, so at a limit the next row cannot be planned from there. Else
/// the first that can be planned.
class Choice {
 public:
  /// Whether that is the one.
  bool take(std::expected<CubeRows, Refusal> rows) {
    if (!rows) {
      if (!refusal_ || is_nearer(rows.error(), *refusal_)) refusal_ = rows.error();
      return false;
    }
    const bool roomy = rows->room >= kRoom;
    if (!best_ || rows->room > best_->room) best_ = std::move(*rows);
    return roomy;
  }
  bool any() const { return best_.has_value(); }
  /// @pre at least one was offered
  std::expected<CubeRows, Refusal> get() {
    if (!best_) return std::unexpected(*refusal_);
    best_->is_last_resort = best_->is_last_resort || best_->room < kRoom;
    return std::move(*best_);
  }

 private:
  static constexpr double kRoom = from_deg(1.5);
  std::optional<CubeRows> best_;
  std::optional<Refusal> refusal_;
};

/// Higher places over one, nearer to the base or farther out: from there and to there an arm goes
/// over what stands around it. As the tool is turned first, then tilted more and more: an arm whose
/// wrist ends there goes higher so.
std::vector<Spot> beside(const Spot& spot) {
  struct Aside {
    double in, up;  // m
  };
  constexpr std::array<Aside, 5> kAside{
      {{25e-3, 25e-3}, {45e-3, 45e-3}, {0, 40e-3}, {-30e-3, 28e-3}, {-55e-3, 30e-3}}};
  constexpr std::array kTilts{0.0, from_deg(15), from_deg(-15)};
  std::vector<Spot> places;
  const double far = std::hypot(spot.p_BT.x, spot.p_BT.y);
  for (const double tilt : kTilts) {
    if (tilt != 0 && !spot.pitch) continue;
    for (const Aside& aside : kAside) {
      const double in = std::min(aside.in, far) / std::max(far, 1e-9);
      Spot& place = places.emplace_back(spot);
      place.p_BT = spot.p_BT + Vec3{-in * spot.p_BT.x, -in * spot.p_BT.y, aside.up};
      if (tilt != 0) *place.pitch += tilt;
    }
  }
  return places;
}

/// A tilted tool may do.
bool ends_a_joint(const Refusal& refusal) {
  return refusal.error.code == ErrorCode::kJointLimit ||
         refusal.error.code == ErrorCode::kOutOfReach;
}

/// Whether a way goes by a place beside a spot; the first one by which it does. Tilted ones are
/// tried only where a joint ended before.
/// @param way  from such a place: why not, or nothing
template <class Way>
bool by_a_place_beside(const Spot& spot, const Way& way) {
  bool is_limited = false;
  for (const Spot& place : beside(spot)) {
    if (place.pitch != spot.pitch && !is_limited) return false;
    const std::optional<Refusal> why = way(place);
    if (!why) return true;
    is_limited = is_limited || ends_a_joint(*why);
  }
  return false;
}

/// To a place over the spot; by a place beside it where an obstacle is in the way.
std::expected<Sequence, Refusal> gone_over(const Sequence& rows, Spot spot, double above,
                                           const MotionOptions& how) {
  Sequence direct = rows;
  const auto refusal = direct.go_over(spot, above, how);
  if (!refusal) return direct;
  if (!meets_thing(*refusal)) return std::unexpected(*refusal);
  spot.p_BT.z += above;
  std::optional<Sequence> around;
  const bool goes = by_a_place_beside(spot, [&](const Spot& first) {
    around.emplace(rows);
    const auto why = around->go_over(first, 0, how);
    return why ? why : around->go_straight(spot, how);
  });
  if (!goes) return std::unexpected(*refusal);
  return *std::move(around);
}

/// To where the row began; by a place beside where it is, where an obstacle is in the way.
std::expected<CubeRows, Refusal> gone_back(const Sequence& rows, const MotionOptions& how) {
  Sequence direct = rows;
  const auto refusal = direct.back(how);
  if (!refusal) return direct.take();
  if (!meets_thing(*refusal)) return std::unexpected(*refusal);
  std::optional<Sequence> around;
  const bool goes = by_a_place_beside(rows.spot(), [&](const Spot& first) {
    around.emplace(rows);
    const auto why = around->go_straight(first, how);
    return why ? why : around->back(how);
  });
  if (!goes) return std::unexpected(*refusal);
  return around->take();
}

/// Over the spot, straight down, `action`, straight up, and back.
std::expected<CubeRows, Refusal> from_above(const Sequence& sequence, const Spot& spot,
                                            const ToolAction& action, const MotionOptions& how) {
  std::optional<Refusal> why;
  for (const double above : kAbove) {
    auto rows = gone_over(sequence, spot, above, how);
    if (!rows) {
      why = rows.error();
      continue;
    }
    why = rows->descend(spot, how);
    if (!why) why = rows->use(action);
    if (!why) why = rows->rise(above, how);
    if (why) continue;
    auto all = gone_back(*rows, how);
    if (all) return all;
    why = all.error();
  }
  return std::unexpected(*why);
}

/// A tool of one width, and what the arm must not meet meanwhile: itself, its table and the things
/// on it.
struct Hand {
  Hand(const RobotModel& robot, std::optional<double> jaws, const TableThings& things)
      : space(robot, jaws), bodies(robot) {
    bodies.fit({.jaws = jaws, .held = {}});
    bodies.surround(things.bare);
  }
  planning::ToolSpace space;
  planning::CollisionModel bodies;
};

/// An arm that is sent to whole poses.
bool takes_poses(const planning::ToolSpace& space) {
  return space.task() == planning::TaskSpace::kPose;
}

/// R_BT of a grasp.
Rotation turned(const Vec3& p_BT, double pitch, double roll) {
  return rotation_z(std::atan2(p_BT.y, p_BT.x)) * rotation_y(pitch) * rotation_z(roll);
}

/// Whether there are joints for it, and for the lower place above it, in which the arm is clear.
bool has_joints(const Hand& hand, const Vec3& p_BT, double pitch, double roll) {
  const auto is_clear = [&](const planning::JointArray& q) {
    const std::span<const double> joints{q.data(), hand.space.size()};
    return hand.bodies.clear(joints, hand.bodies.margin());
  };
  for (const double above : {0.0, kAbove.back()}) {
    planning::TaskPoint at{p_BT + Vec3{0, 0, above}, {pitch, roll}};
    if (takes_poses(hand.space)) at = hand.space.point({turned(p_BT, pitch, roll), at.p_BT});
    const auto branches = hand.space.branches(at, {});
    if (std::ranges::none_of(branches, is_clear)) return false;
  }
  return true;
}

/// Hands by how wide they are open: many grasps share one.
class Hands {
 public:
  Hands(const RobotModel& robot, const TableThings& things) : robot_(robot), things_(things) {}
  /// Whether the arm has clear joints for a grasp.
  bool reach(const grasping::JawGrasp& grasp) {
    const Hand& hand = hands_.try_emplace(grasp.open, robot_, grasp.open, things_).first->second;
    return has_joints(hand, grasp.p_BT, grasp.pitch, grasp.roll);
  }

 private:
  const RobotModel& robot_;
  const TableThings& things_;
  std::map<double, Hand> hands_;
};

/// Those that have clear joints: what the planner would refuse after a longer look is left out.
std::vector<grasping::JawGrasp> with_joints(const RobotModel& robot, const TableThings& things,
                                            const std::vector<grasping::JawGrasp>& grasps) {
  Hands hands(robot, things);
  std::vector<grasping::JawGrasp> found;
  std::ranges::copy_if(grasps, std::back_inserter(found),
                       [&](const auto& grasp) { return hands.reach(grasp); });
  return found;
}

/// A few of many, from the first to the last.
std::vector<grasping::JawGrasp> few_of(const std::vector<grasping::JawGrasp>& grasps) {
  constexpr std::size_t kFew = 12;
  std::vector<grasping::JawGrasp> few;
  const std::size_t step = grasps.size() / kFew + 1;
  for (std::size_t i = 0; i < grasps.size(); i += step) few.push_back(grasps[i]);
  return few;
}

std::expected<CubeRows, Refusal> taken_so(Sequence sequence, const RobotModel& robot,
                                          const grasping::JawGrasp& grasp, double edge) {
  const MotionOptions& how = std::get<PickCubeStep>(sequence.row().what).how;
  if (auto refusal = sequence.use(JawsTo{grasp.open})) return std::unexpected(*refusal);
  Spot spot{grasp.p_BT, grasp.pitch, grasp.roll};
  if (takes_poses(planning::ToolSpace(robot))) {
    spot = {.p_BT = grasp.p_BT, .R_BT = turned(grasp.p_BT, grasp.pitch, grasp.roll)};
  }
  auto rows = from_above(sequence, spot, JawsTo{grasp.close, edge}, how);
  if (rows) rows->tilt = std::abs(kPi - grasp.pitch);
  return rows;
}

std::vector<grasping::Body> bodies_of(const std::vector<OtherThing>& others) {
  std::vector<grasping::Body> bodies;
  for (const OtherThing& other : others) bodies.push_back(other.body);
  return bodies;
}

/// Without uncertain obstacles.
Sighting likely_of(Sighting seen) {
  std::erase_if(seen.others, [](const OtherThing& other) { return !other.is_likely; });
  return seen;
}

/// m, extra clearance of lateral motions where it is available.
constexpr double kRoomAside = 6e-3;

/// Plans with all obstacles and extra clearance, then with the required clearance, then without
/// uncertain obstacles. The first success counts, but a last resort with extra clearance only where
/// the required clearance gives nothing better; else the last refusal.
/// @param rows  called with a Sighting and the extra clearance
template <class Rows>
std::expected<CubeRows, Refusal> clear_of(const Sighting& seen, std::span<const Basket> baskets,
                                          const Rows& rows) {
  const bool is_alone = seen.cubes.size() <= 1 && seen.others.empty() && baskets.empty();
  auto roomy = rows(seen, is_alone ? 0.0 : kRoomAside);
  if (is_alone || (roomy && !roomy->is_last_resort)) return roomy;
  auto found = rows(seen, 0.0);
  if (found && (!found->is_last_resort || !roomy)) return found;
  if (roomy) return roomy;
  const Sighting likely = likely_of(seen);
  return likely.others.size() < seen.others.size() ? rows(likely, 0.0) : found;
}

std::expected<CubeRows, Refusal> picked_by_jaws(RowPlanner& planner, const Sequence& sequence,
                                                const Sighting& seen, std::size_t which, int skip) {
  const Step& row = sequence.row();
  const RobotModel& robot = planner.robot();
  const auto grasps = grasping::jaw_grasps(robot, seen.cubes, which, bodies_of(seen.others));
  if (!grasps) {
    return std::unexpected(Refusal{row.line, grasps.error(), std::nullopt, row.file});
  }
  const double edge = seen.cubes[which].edge;
  const auto having = with_joints(robot, sequence.things(), *grasps);
  Choice choice, left_out;  // those are better than nothing where no other can be had
  const grasping::JawGrasp* nearest = nullptr;
  std::optional<Refusal> why;
  const auto tried = having.empty() ? few_of(*grasps) : having;
  planner.propose(false);
  // What stands where the arm itself is meets all grasps alike.
  constexpr int kMeetingsMax = 80;
  int meetings = 0;
  for (const grasping::JawGrasp& grasp : tried) {
    auto rows = taken_so(sequence, robot, grasp, edge);
    if (!rows && (!why || is_nearer(rows.error(), *why))) {
      why = rows.error();
      nearest = &grasp;
    }
    if (!rows && meets_thing(rows.error()) && ++meetings == kMeetingsMax) break;
    const bool skipped = rows && skip-- > 0;
    if (skipped) rows->is_last_resort = true;
    if ((skipped ? left_out : choice).take(std::move(rows)) && !skipped) break;
  }
  planner.propose(true);
  if (choice.any()) return choice.get();
  if (left_out.any()) return left_out.get();
  return taken_so(sequence, robot, *nearest, edge);  // with what would go instead
}

/// The lip is sent below the top, as bellows give and an arm may stop short; further after each
/// grasp that held nothing.
std::expected<CubeRows, Refusal> picked_by_cup(Sequence sequence, const RobotModel& robot,
                                               const Sighting& seen, std::size_t which, int skip) {
  const Step& row = sequence.row();
  const auto lip = grasping::cup_grasp(seen.cubes, which, bodies_of(seen.others));
  if (!lip) return std::unexpected(Refusal{row.line, lip.error(), std::nullopt, row.file});
  const MotionOptions& how = std::get<PickCubeStep>(row.what).how;
  const double press = kPress + kPressMore * std::min(skip, 2);
  return from_above(sequence, {.p_BT = *lip + Vec3{0, 0, cup_reach(robot) - press}},
                    Suction{Suction::State::kOn}, how);
}

/// The cube whose top is nearest to a place (m, in B), and nearer than an edge.
std::optional<std::size_t> cube_at(const Sighting& seen, const Vec3& p_BT) {
  std::optional<std::size_t> nearest;
  double least = 0;
  for (std::size_t i = 0; i < seen.cubes.size(); ++i) {
    const grasping::Cube& cube = seen.cubes[i];
    const double far = norm(cube.p_BO + Vec3{0, 0, cube.edge / 2} - p_BT);
    if (far > cube.edge || (nearest && far >= least)) continue;
    nearest = i;
    least = far;
  }
  return nearest;
}

/// The place as the tool is turned there, as it would be turned above it, and at pitches around: an
/// arm that chooses its own pitch may find one for each that does not work for the other.
std::vector<Spot> spots_of(const Sequence& there, const Sequence& begin,
                           const PlaceCubeStep& place) {
  std::vector<Spot> spots{there.spot()};
  const auto* move = std::get_if<ToolMoveStep>(&place.there);
  if (move == nullptr) return spots;
  for (const double above : kAbove) {
    Sequence up = begin;
    ToolMoveStep higher = *move;
    if (!higher.to.p_BT[2]) break;
    *higher.to.p_BT[2] += above;
    if (up.go(higher)) continue;
    spots.push_back(up.spot());
    spots.back().p_BT = spots.front().p_BT;
  }
  // Between the two, and beside them: at the end of a joint's range the way down would leave it.
  if (move->to.pitch || !spots.front().pitch) return spots;
  for (int k = 1; k <= kPitchTries; ++k) {
    for (const double way : {1.0, -1.0}) {
      spots.push_back(spots.front());
      *spots.back().pitch += way * k * kPitchStep;
    }
  }
  return spots;
}

}  // namespace

bool can_pick(const RobotModel& robot) {
  if (robot.device.capability.hand == HandDrive::kSuction) return true;
  if (jaws_of(robot) == nullptr) return false;
  // A forearm that rolls, four joints, or a chain without a closed form have no grasps here.
  const planning::ToolSpace space(robot);
  const bool closed = space.serial()->solver() == kinematics::SerialArm::Solver::kSixR;
  return space.task() == planning::TaskSpace::kPitchRoll || closed;
}

namespace {

/// What a `place` keeps clear of.
struct Around {
  double room;  ///< m, extra clearance of lateral motions
  const Sighting& seen;
  std::span<const Basket> baskets{};
};

/// But for what is beside the place, which it may be put on or against, and the basket that it is
/// in.
TableThings away_from(const RobotModel& robot, const Around& around, const Vec3& p_BT,
                      double edge) {
  Sighting left = around.seen;
  const auto is_beside = [&](const grasping::Body& body) {
    const double far = std::hypot(body.p_BO.x - p_BT.x, body.p_BO.y - p_BT.y);
    return far < edge + 2 * std::max(body.half.x, body.half.y);
  };
  std::erase_if(left.cubes, [&](const auto& cube) { return is_beside(grasping::body_of(cube)); });
  std::erase_if(left.others, [&](const OtherThing& other) { return is_beside(other.body); });
  std::vector<Basket> baskets;
  for (const Basket& basket : around.baskets) {
    const Vec3 p_K = basket.X_BK.inverse() * p_BT;
    // From above the rim its walls are clear as well.
    if (!is_over(basket, p_K) || p_K.z > basket.size.z) baskets.push_back(basket);
  }
  return things_on_table(robot, left, {}, baskets, edge, around.room);
}

/// At one place.
std::expected<CubeRows, Refusal> rows_to_one_place(RowPlanner& planner, const Standing& standing,
                                                   const Step& row, const PlaceCubeStep& place,
                                                   const Around& around) {
  const ToolAction opening = letting_go(planner.robot(), standing.tool);
  const auto* joints = std::get_if<JointStep>(&place.there);
  const auto go_there = [&](Sequence& rows) {
    return joints != nullptr ? rows.go(*joints) : rows.go(std::get<ToolMoveStep>(place.there));
  };
  // Where it is and how the tool is turned there, whatever stands on the straight way.
  const TableThings nothing;
  const Sequence free(planner, standing, row, nothing);
  Sequence there = free;
  if (const auto refusal = go_there(there)) return std::unexpected(*refusal);
  const double edge = standing.tool.held.value_or(standing.at_cup.value_or(0));
  const auto things = away_from(planner.robot(), around, there.spot().p_BT, edge);
  const Sequence begin(planner, standing, row, things);
  const auto how = std::visit([](const auto& to) { return to.how; }, place.there);
  Choice choice;
  for (const Spot& spot : spots_of(there, free, place)) {
    if (choice.take(from_above(begin, spot, opening, how))) break;
  }
  if (choice.any()) return choice.get();
  // Where there is no room above it: as `move` goes there.
  Sequence direct = begin;
  auto refusal = go_there(direct);
  if (!refusal) refusal = direct.use(opening);
  if (!refusal) refusal = direct.back(how);
  if (refusal) return std::unexpected(*refusal);
  CubeRows rows = direct.take();
  rows.is_last_resort = true;
  return rows;
}

/// m, of the tool point above the bottom of a cube that it holds, at least.
double tool_above(const RobotModel& robot, double edge) {
  return jaws_of(robot) != nullptr ? edge / 2 : edge + cup_reach(robot);
}

/// The first spot over the basket's floor, and the lowest height over its rim, that can be had with
/// room to the limits of joints; else the roomiest.
std::expected<CubeRows, Refusal> rows_to_basket(RowPlanner& planner, const Standing& standing,
                                                const Step& row, const BasketGoal& goal,
                                                const Basket& basket, std::span<const Vec3> lying,
                                                const Around& around) {
  const double edge = standing.tool.held.value_or(standing.at_cup.value_or(kUsualCube));
  constexpr double kEnough = from_deg(0.3);  // what an arm stands beside where it was sent
  Choice choice;
  for (const Vec3& p_K : spots_in(basket, edge, lying)) {
    for (const double above : kOverRim) {
      // Over the rim, and over what lies there.
      const double height =
          std::max(basket.size.z, p_K.z) + above + tool_above(planner.robot(), edge);
      const Vec3 p_B = basket.X_BK * Vec3{p_K.x, p_K.y, height};
      ToolMoveStep move{
          .way = ToolMoveStep::Way::kJoints, .to = {}, .p_via_BT = {}, .how = goal.how};
      move.to.p_BT = {p_B.x, p_B.y, p_B.z};
      auto rows = rows_to_one_place(planner, standing, row, {move}, around);
      if (rows) rows->p_BO = p_B;
      if (rows && rows->room >= kEnough) {
        rows->is_last_resort = false;
        return rows;
      }
      choice.take(std::move(rows));
    }
  }
  auto chosen = choice.get();
  if (!chosen && chosen.error().error.code == ErrorCode::kOutOfReach) {
    chosen.error().error.code = ErrorCode::kBasketOutOfReach;
    chosen.error().way.reset();
  }
  return chosen;
}

}  // namespace

std::expected<CubeRows, Refusal> rows_to_place(RowPlanner& planner, const Standing& standing,
                                               const Step& row, const TableTop* table,
                                               std::span<const Vec3> lying, const Sighting* seen) {
  const auto& place = std::get<PlaceCubeStep>(row.what);
  const auto* goal = std::get_if<BasketGoal>(&place.there);
  const Basket* basket =
      goal != nullptr && table != nullptr ? basket_named(*table, goal->name) : nullptr;
  if (goal != nullptr && basket == nullptr) {
    return std::unexpected(Refusal{row.line, {ErrorCode::kNoBasket}, std::nullopt, row.file});
  }
  const auto rows = [&](const Sighting& known, double room) {
    const Around around{room, known, baskets_on(table)};
    return goal == nullptr ? rows_to_one_place(planner, standing, row, place, around)
                           : rows_to_basket(planner, standing, row, *goal, *basket, lying, around);
  };
  return clear_of(seen != nullptr ? *seen : Sighting{}, baskets_on(table), rows);
}

namespace {

/// With all obstacles of `seen`, uncertain ones too.
std::expected<CubeRows, Refusal> rows_to_cube_among(RowPlanner& planner, const Standing& standing,
                                                    const Step& row, const Sighting& seen,
                                                    double room, std::size_t which, int skip,
                                                    std::span<const Basket> baskets) {
  const RobotModel& robot = planner.robot();
  const auto things = things_on_table(robot, seen, which, baskets, seen.cubes[which].edge, room);
  Standing empty = standing;
  empty.tool.held.reset();
  empty.at_cup.reset();
  const Sequence begin(planner, empty, row, things);
  auto rows = jaws_of(robot) != nullptr ? picked_by_jaws(planner, begin, seen, which, skip)
                                        : picked_by_cup(begin, robot, seen, which, skip);
  if (rows) rows->cube = seen.cubes[which];
  return rows;
}

}  // namespace

std::expected<CubeRows, Refusal> rows_to_cube(RowPlanner& planner, const Standing& standing,
                                              const Step& row, const Sighting& seen,
                                              std::size_t which, std::span<const Basket> baskets) {
  return clear_of(seen, baskets, [&](const Sighting& known, double room) {
    return rows_to_cube_among(planner, standing, row, known, room, which, 0, baskets);
  });
}

std::expected<CubeRows, Refusal> rows_to_pick(RowPlanner& planner, const Standing& standing,
                                              const Step& row, const Sighting& seen,
                                              std::span<const Basket> baskets,
                                              const std::optional<Tried>& tried) {
  const auto& pick = std::get<PickCubeStep>(row.what);
  const auto nearest = pick.p_BT ? cube_at(seen, *pick.p_BT) : std::nullopt;
  const auto rows = [&](const Sighting& known, double room) -> std::expected<CubeRows, Refusal> {
    std::optional<Refusal> first;
    for (const std::size_t which : grasping::order_of(known.cubes)) {
      const grasping::Cube& cube = known.cubes[which];
      if (pick.color && cube.color != static_cast<int>(*pick.color)) continue;
      if (pick.p_BT && which != nearest) continue;
      const int skip = tried && lies_at(cube, tried->cube) ? tried->grasps : 0;
      auto found = rows_to_cube_among(planner, standing, row, known, room, which, skip, baskets);
      if (found) return found;
      if (!first) first = found.error();
    }
    return std::unexpected(
        first.value_or(Refusal{row.line, {ErrorCode::kNothingSeen}, std::nullopt, row.file}));
  };
  return clear_of(seen, baskets, rows);
}

bool in_reach(const RobotModel& robot, const Sighting& seen, std::size_t which) {
  const Sighting likely = likely_of(seen);
  const auto others = bodies_of(likely.others);
  const auto things = things_on_table(robot, likely, which, {}, seen.cubes[which].edge);
  if (jaws_of(robot) != nullptr) {
    const auto grasps = grasping::jaw_grasps(robot, seen.cubes, which, others);
    Hands hands(robot, things);
    return grasps &&
           std::ranges::any_of(*grasps, [&](const auto& one) { return hands.reach(one); });
  }
  const auto lip = grasping::cup_grasp(seen.cubes, which, others);
  return lip &&
         has_joints({robot, std::nullopt, things}, *lip + Vec3{0, 0, cup_reach(robot)}, 0, 0);
}

bool lies_at(const grasping::Cube& cube, const grasping::Cube& taken) {
  return norm(cube.p_BO - taken.p_BO) < kStillThere * taken.edge;
}

bool still_there(const Sighting& seen, const grasping::Cube& taken) {
  return std::ranges::any_of(seen.cubes, [&](const auto& cube) { return lies_at(cube, taken); });
}

bool may_hold(const grasping::Cube& cube, double jaws) {
  return jaws > cube.edge - grasping::kSqueeze / 2 - 1e-3;
}

}  // namespace sinew::program
