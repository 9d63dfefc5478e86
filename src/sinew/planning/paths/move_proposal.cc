#include "sinew/planning/paths/move_proposal.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "sinew/core/error_code.h"

namespace sinew::planning {
namespace {

/// The same move with another orientation at its end.
Move turned(Move move, const PoseBT& X_BT) {
  const ToolTarget target{X_BT, Asked::kPose};
  if (auto* to = std::get_if<MoveTo>(&move.way)) to->to = target;
  if (auto* line = std::get_if<MoveL>(&move.way)) line->to = target;
  if (auto* arc = std::get_if<MoveC>(&move.way)) arc->to = target;
  return move;
}

/// X with its tool tilted by `tilt` in the vertical plane through the base axis and the tool.
PoseBT tilted(const PoseBT& X_BT, double tilt) {
  const double yaw = std::atan2(X_BT.p.y, X_BT.p.x);
  const Vec3 across{-std::sin(yaw), std::cos(yaw), 0};
  return {rotation_from_vector(tilt * across) * X_BT.R, X_BT.p};
}

/// Away from what was asked for.
struct Turn {
  double tilt = 0;  ///< rad, as MoveProposal::Tilted
  double other = 0;
};

/// The least first: a tilt, and a roll or a swing.
std::vector<Turn> turns() {
  constexpr double kTilt = from_deg(5);
  constexpr double kOther = from_deg(15);
  std::vector<Turn> all;
  for (int i = -18; i <= 18; ++i) {
    for (int k = -12; k <= 12; ++k) {
      if (i != 0 || k != 0) all.push_back({i * kTilt, k * kOther});
    }
  }
  std::ranges::sort(all, [](const Turn& a, const Turn& b) {
    const double left = std::abs(a.tilt) + std::abs(a.other);
    const double right = std::abs(b.tilt) + std::abs(b.other);
    // The same as far: in an order of its own, so that each time the same one is found.
    return std::tuple(left, a.tilt, a.other) < std::tuple(right, b.tilt, b.other);
  });
  return all;
}

/// The k-th of n directions that are spread evenly: a spiral from pole to pole.
Vec3 sphere_point(int k, int n) {
  const double z = 1 - (2 * k + 1) / static_cast<double>(n);
  const double around = std::sqrt(1 - z * z);
  const double angle = k * (std::sqrt(5.0) - 1) * kPi;
  return {around * std::cos(angle), around * std::sin(angle), z};
}

/// The same place, the tool tilted as tilted() says.
TaskPoint pitched(TaskPoint at, double tilt, const ToolSpace& space) {
  if (space.task() == TaskSpace::kPitchRoll) {
    at.attitude[0] += tilt;
  } else if (tilt != 0) {
    const TaskPoint turned = space.point(tilted(space.pose(at), tilt));
    at.attitude = turned.attitude;
  }
  return at;
}

class Search {
 public:
  /// Joint moves that are planned at most to find a place near the target, and a nearer one then.
  static constexpr int kLooksMax = 600;
  Search(MovePathBuilder& builder, const ToolSpace& space, const PathRefusal& refusal, Move move,
         PlannedPath& scratch, const HitsNothing& hits_nothing)
      : builder_(builder),
        space_(space),
        refusal_(refusal),
        from_(refusal.from),
        move_(std::move(move)),
        scratch_(scratch),
        hits_nothing_(hits_nothing),
        way_(space) {
    move_.blend_radius = 0;
    move_.blend_joints = 0;
  }

  MoveProposal run();

 private:
  std::optional<RobotPlace> end_of(const RobotPlace& from, const Move& move);
  bool works(const RobotPlace& from, const Move& move) { return end_of(from, move).has_value(); }
  /// A joint move as quick as the refused one.
  Move joint_move(const JointArray& q) const {
    return {.way = MoveJ{q}, .joint_share = move_.joint_share};
  }
  bool outside() const;
  std::optional<JointArray> clamped(JointArray q) const;

  void come_back_inside();
  void turn_to_nearest();
  void for_joint_row(const JointArray& q);
  void join_target(const TaskPoint& end);
  void find_part();
  bool any_pitch_will_do() const;
  void find_near(const TaskPoint& end);
  bool look(const Vec3& p, double nearer_than);
  void find_somewhere_near();
  void come_nearer();
  std::optional<JointArray> reach(TaskPoint& at);
  void find_other_start();
  void find_tilt(const TaskPoint& end);
  PoseBT turned_by(const TaskPoint& end, const Turn& turn) const;

  MovePathBuilder& builder_;
  const ToolSpace& space_;
  const PathRefusal& refusal_;
  const RobotPlace& from_;
  Move move_;
  PlannedPath& scratch_;
  const HitsNothing& hits_nothing_;
  MoveWay way_;
  MoveProposal found_;
  // Of find_near().
  int looks_left_ = 0;
  TaskPoint end_, best_;   ///< the target, and what found_.near reaches
  int pitches_ = 0;        ///< so many are tried to either side of the best one's
  double pitch_step_ = 0;  ///< rad
};

/// Where a move ends that can be made; nothing where it cannot.
std::optional<RobotPlace> Search::end_of(const RobotPlace& from, const Move& move) {
  const auto stretch = builder_.build(from, std::span(&move, 1), 0, scratch_);
  if (!stretch) return std::nullopt;
  const bool clear = !hits_nothing_ || scratch_.joints.empty() || hits_nothing_(from, scratch_);
  return clear ? std::optional(stretch->end) : std::nullopt;
}

bool Search::outside() const {
  for (std::size_t j = 0; j < space_.size(); ++j) {
    if (!within_limits(space_.joints()[j], from_.q[j])) return true;
  }
  return false;
}

/// Into the limits, and as far inside as a typed number is rounded; nothing where it is inside.
std::optional<JointArray> Search::clamped(JointArray q) const {
  constexpr double kInside = 1e-5;  // rad or m
  bool was_outside = false;
  for (std::size_t j = 0; j < space_.size(); ++j) {
    const Joint& joint = space_.joints()[j];
    if (within_limits(joint, q[j])) continue;
    was_outside = true;
    const double room = std::min(kInside, (joint.upper - joint.lower) / 2);
    q[j] = std::clamp(q[j], joint.lower + room, joint.upper - room);
  }
  return was_outside ? std::optional(q) : std::nullopt;
}

void Search::come_back_inside() {
  const auto q = clamped(from_.q);
  if (q && works(from_, joint_move(*q))) found_.back_inside = q;
}

/// The orientation alone may not be all that is wrong.
void Search::turn_to_nearest() {
  const auto& nearest = refusal_.nearest;
  if (!nearest) return;
  const bool by_joints = std::holds_alternative<MoveTo>(move_.way);
  if (!by_joints && works(from_, turned(move_, nearest->X_BT))) {
    found_.nearest = nearest;
    return;
  }
  const auto end = end_of(from_, {.way = MoveTo{{nearest->X_BT, Asked::kPose}}});
  if (!end) return;
  found_.nearest = nearest;
  found_.nearest_q = end->q;
}

/// As far as the joints themselves go; the same place of the tool by other joints.
void Search::for_joint_row(const JointArray& q) {
  if (const auto inside = clamped(q)) {
    if (works(from_, joint_move(*inside))) found_.near = {.q = *inside, .left = 0};
    return;
  }
  const auto X_BT = space_.forward({q.data(), space_.size()}, from_.X_BT);
  if (X_BT && space_.hexapod() == nullptr) join_target(space_.point(*X_BT));
  double share = refusal_.place.share;
  constexpr double kFirst = 0.01;
  for (double before = kFirst; before < share && !found_.near; before *= 2) {
    JointArray part = from_.q;
    for (std::size_t j = 0; j < space_.size(); ++j) {
      part[j] += (share - before) * (q[j] - from_.q[j]);
    }
    if (works(from_, joint_move(part))) found_.near = {.q = part, .left = 0};
  }
}

/// The first branch that a joint move reaches.
void Search::join_target(const TaskPoint& end) {
  for (const JointArray& q : space_.branches(end, from_.q)) {
    // To where it stands already is no offer.
    if (!works(from_, joint_move(q)) || scratch_.joints.empty()) continue;
    found_.move_j = q;
    return;
  }
}

/// A line that cannot be gone to its end, up to where it can.
void Search::find_part() {
  constexpr double kFirst = 1e-3;  // m before the refused place, then twice as far again and again
  for (double before = kFirst; before < refusal_.place.at; before *= 2) {
    const double length = refusal_.place.at - before;
    const PoseBT X_BT = space_.pose(way_.point_at(length), from_.X_BT.R);
    const Asked asked = space_.task() == TaskSpace::kPoint ? Asked::kPoint : Asked::kPose;
    Move shorter = move_;
    shorter.way = MoveL{{X_BT, asked}};
    if (const auto end = end_of(from_, shorter)) {
      found_.part = {length, end->X_BT};
      return;
    }
  }
}

/// The pitch is the planner's choice, and none reaches the target itself.
bool Search::any_pitch_will_do() const {
  const auto open = [&](const ToolTarget& to) {
    const bool five =
        space_.task() == TaskSpace::kPitchRoll || space_.task() == TaskSpace::kApproach;
    return five && to.asked == Asked::kPoint &&
           !space_.serial()->inverse_nearest_pitch(to.X_BT.p, kPi, {from_.q.data(), space_.size()});
  };
  if (const auto* to = std::get_if<MoveTo>(&move_.way)) return open(to->to);
  if (const auto* line = std::get_if<MoveL>(&move_.way)) return open(line->to);
  return false;
}

/// The joints of a free joint move that brings the tool to `at`, where there are any; with another
/// pitch where that may be chosen.
std::optional<JointArray> Search::reach(TaskPoint& at) {
  constexpr int kLooksOfPlace = 4;
  const int least_left = looks_left_ - kLooksOfPlace;
  for (int k = 0; k <= 2 * pitches_; ++k) {
    const TaskPoint turned = pitched(at, (k % 2 == 0 ? k / 2 : -(k + 1) / 2) * pitch_step_, space_);
    for (const JointArray& q : space_.branches(turned, from_.q)) {
      if (looks_left_ <= 0 || (pitches_ > 0 && looks_left_ <= least_left)) return std::nullopt;
      --looks_left_;
      if (!works(from_, joint_move(q))) continue;
      at = turned;
      return q;
    }
  }
  return std::nullopt;
}

/// Whether the tool can be at p, which is nearer to the target than so (m).
bool Search::look(const Vec3& p, double nearer_than) {
  const double left = norm(p - end_.p_BT);
  if (!(left < nearer_than)) return false;
  TaskPoint at = best_;
  at.p_BT = p;
  const auto q = reach(at);
  if (!q) return false;
  best_ = at;
  found_.near = {.q = *q, .left = left};
  return true;
}

constexpr double kNearStep = 0.01e-3;  // m, to which the nearest place is found

/// In shells about the target, each larger than the one before. Where all of a shell is in reach
/// and something is hit there, a few of its places are enough.
void Search::find_somewhere_near() {
  constexpr int kLooksOfShell = 12;
  constexpr int kStride = 37;  // so that they lie all around
  const int directions = pitches_ > 0 ? 26 : 96;
  const double growth = pitches_ > 0 ? 2 : 1.25;
  const double farthest = norm(from_.X_BT.p - end_.p_BT);
  const Vec3 back = farthest > 0 ? (1 / farthest) * (from_.X_BT.p - end_.p_BT) : Vec3{};
  for (double r = kNearStep; r < farthest && !found_.near; r *= growth) {
    look(end_.p_BT + r * back, 2 * r);
    const int least_left = looks_left_ - kLooksOfShell;
    for (int k = 0; k < directions && !found_.near && looks_left_ > least_left; ++k) {
      look(end_.p_BT + r * sphere_point(k * kStride % directions, directions), 2 * r);
    }
  }
  // So turned it may reach only what is near to where it is.
  for (double left = farthest / 2; left > kNearStep && !found_.near; left /= 2) {
    look(from_.X_BT.p - left * back, farthest);
  }
}

/// Towards the target and sideways, in steps that get smaller.
void Search::come_nearer() {
  // Others each time: along an edge of what is in reach few lead on.
  int directions = 48;
  for (double step = norm(best_.p_BT - end_.p_BT) / 2; step > kNearStep;) {
    const double left = norm(best_.p_BT - end_.p_BT);
    const Vec3 towards = (1 / left) * (end_.p_BT - best_.p_BT);
    const double nearer_than = left - kNearStep / 2;
    bool nearer = look(best_.p_BT + std::min(step, left) * towards, nearer_than);
    for (int k = 0; k < directions && !nearer; ++k) {
      nearer = look(best_.p_BT + step * sphere_point(k, directions), nearer_than);
    }
    ++directions;
    if (nearer) continue;
    step /= 2;
    // What a turn costs grows with its square.
    pitch_step_ = std::sqrt(2 * step / kTurnRadius);
  }
}

/// The nearest place to the target that a joint move reaches with the tool turned as it was asked,
/// or, where no pitch was named and none reaches the target, with any.
void Search::find_near(const TaskPoint& end) {
  const bool any_pitch = any_pitch_will_do();
  end_ = best_ = end;
  if (any_pitch) {
    pitches_ = 36;
    pitch_step_ = kPi / pitches_;
  }
  looks_left_ = kLooksMax;
  find_somewhere_near();
  if (!found_.near) return;
  if (any_pitch) pitches_ = 1;
  looks_left_ = kLooksMax;
  come_nearer();
  if (!any_pitch || !found_.at_target) return;
  best_.p_BT = end.p_BT;
  if (const auto q = space_.inverse_near(best_, from_.q); !q) found_.at_target = q.error();
}

void Search::find_other_start() {
  constexpr double kSameBranch = 1e-4;
  for (const JointArray& q : space_.branches(space_.point(from_.X_BT), from_.q)) {
    double apart = 0;
    for (std::size_t j = 0; j < kMaxJoints; ++j)
      apart = std::max(apart, std::abs(q[j] - from_.q[j]));
    const auto place = builder_.place_at(std::span(q.data(), space_.size()), from_.X_BT);
    if (apart < kSameBranch || !place || !works(*place, move_)) continue;
    found_.other_start = q;
    return;
  }
}

/// As little turned as works: where the move asked for a line along one, else by a joint move.
void Search::find_tilt(const TaskPoint& end) {
  const Asked asked = space_.task() == TaskSpace::kApproach ? Asked::kApproach : Asked::kPose;
  for (const bool by_line : {true, false}) {
    if (by_line && !std::holds_alternative<MoveL>(move_.way)) continue;
    for (const Turn& turn : turns()) {
      const ToolTarget target{turned_by(end, turn), asked};
      // What no branch reaches need not be planned.
      if (space_.branches(space_.point(target.X_BT), from_.q).empty()) continue;
      const Move move = by_line ? Move{.way = MoveL{target}} : Move{.way = MoveTo{target}};
      const auto there = end_of(from_, move);
      if (!there) continue;
      const bool rolls = space_.task() == TaskSpace::kPitchRoll;
      found_.tilted = {turn.tilt, rolls ? turn.other : 0, rolls ? 0 : turn.other, there->X_BT,
                       std::nullopt};
      if (!by_line) found_.tilted->q = there->q;
      return;
    }
  }
}

PoseBT Search::turned_by(const TaskPoint& end, const Turn& turn) const {
  const PoseBT X_BT = tilted(space_.pose(end, from_.X_BT.R), turn.tilt);
  if (space_.task() == TaskSpace::kPitchRoll) return {X_BT.R * rotation_z(turn.other), X_BT.p};
  const double yaw = std::atan2(X_BT.p.y, X_BT.p.x);
  const Vec3 upright = cross(X_BT.R.z, Vec3{-std::sin(yaw), std::cos(yaw), 0});
  if (!(norm(upright) > 0)) return X_BT;
  return {rotation_from_vector(turn.other * normalized(upright)) * X_BT.R, X_BT.p};
}

MoveProposal Search::run() {
  if (refusal_.error.code == ErrorCode::kMoveInput) return found_;
  const bool was_outside = outside();
  if (was_outside) come_back_inside();
  if (const auto* joints = std::get_if<MoveJ>(&move_.way)) {
    for_joint_row(joints->q);
    return found_;
  }
  if (!was_outside) turn_to_nearest();
  const bool line = std::holds_alternative<MoveL>(move_.way);
  const bool made = !way_.make(move_, from_) && way_.length() > 0;
  const bool by_joints = std::holds_alternative<MoveTo>(move_.way);
  const auto end =
      made && !by_joints ? std::optional(way_.point_at(way_.length())) : way_.end_of(move_, from_);
  if (end) {
    if (!by_joints) {
      if (const auto q = space_.inverse_near(*end, from_.q); !q) found_.at_target = q.error();
    }
    join_target(*end);
  }
  if (was_outside) return found_;
  if (made && line) find_part();
  const std::optional<TaskPoint> point = end                ? end
                                         : refusal_.nearest ? std::optional(refusal_.nearest->point)
                                                            : std::nullopt;
  if (!point || std::holds_alternative<MoveSpline>(move_.way)) return found_;
  if ((!line || found_.at_target) && !found_.move_j && !found_.nearest) find_near(*point);
  if (space_.hexapod() != nullptr) return found_;
  if (made && !by_joints) find_other_start();
  const bool five = space_.task() == TaskSpace::kPitchRoll || space_.task() == TaskSpace::kApproach;
  if (five && !std::holds_alternative<MoveC>(move_.way) && !found_.nearest) find_tilt(*point);
  return found_;
}

}  // namespace

MoveProposal propose(MovePathBuilder& builder, const ToolSpace& space, const PathRefusal& refusal,
                     std::span<const Move> moves, PlannedPath& scratch,
                     const HitsNothing& hits_nothing) {
  return Search(builder, space, refusal, moves[refusal.place.move], scratch, hits_nothing).run();
}

}  // namespace sinew::planning
