#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/random_sequence.h"
#include "sinew/motion/online_profile.h"

namespace sinew::planning {

/// From where it stands. What is refused changes nothing; what is planned is started.
bool RandomSequence::plan() {
  note("plan");
  if (mode_ == Mode::kJog || mode_ == Mode::kPath) {
    if (!take_place()) return false;
  }
  const DealtMoves dealt = bench_.dealer.deal_any(random_, place_);
  PlannedMotion& motion = bench_.fresh[fresh_];
  const Snapshot before = snapshot();
  const auto planned = bench_.planner.plan(place_, dealt.moves, 0, motion);
  if (!unchanged(before)) return false;
  const bool nonsense = dealt.nonsense < dealt.moves.size();
  if (!planned) {
    sums_.count(planned.error().error);
    const std::string fault = fault_of(planned.error(), dealt.moves.size(), nonsense);
    if (!fault.empty()) return fail(fault);
    return motion.law.size() == 0 || fail("a refused plan has left a law to be followed");
  }
  if (outside_ && !motion.empty() && dealt.moves[0].way.index() > 1) {
    return fail("a tool's way that begins outside the limits was planned");
  }
  if (motion.stretch.moves > dealt.nonsense) return fail("a move that is none was planned");
  if (motion.empty()) return true;
  ++sums_.plans;
  sums_.ways_in += outside_ ? 1 : 0;
  sums_.blends += motion.stretch.moves - 1;
  fresh_ = 1 - fresh_;
  return start(motion);
}

/// A start that is no number, or far outside.
bool RandomSequence::plan_from_nowhere() {
  note("plan from nowhere");
  if (mode_ != Mode::kStands && !take_place()) return false;
  RobotPlace nowhere = place_;
  const auto j =
      static_cast<std::size_t>(random_.integer(0, static_cast<std::int64_t>(judge_.joints()) - 1));
  do {
    nowhere.q[j] = hostile_number(random_);
  } while (std::abs(nowhere.q[j]) <= 1e3);
  const auto moves = bench_.dealer.deal(random_, place_);
  PlannedMotion& motion = bench_.fresh[fresh_];
  const Snapshot before = snapshot();
  const auto planned = bench_.planner.plan(nowhere, moves, 0, motion);
  if (planned) return fail("a plan that begins nowhere was made");
  if (!unchanged(before)) return false;
  sums_.count(planned.error().error);
  const std::string fault = fault_of(planned.error(), moves.size(), true);
  if (!fault.empty()) return fail(fault);
  return motion.law.size() == 0 || fail("a refused plan has left a law to be followed");
}

/// While another motion is under way, from where that one ends.
bool RandomSequence::plan_ahead() {
  note("plan ahead");
  const RobotPlace end = under_way_->stretch.end;
  const DealtMoves dealt = bench_.dealer.deal_any(random_, end);
  const Snapshot before = snapshot();
  const auto planned = bench_.planner.plan(end, dealt.moves, 0, bench_.fresh[fresh_]);
  if (!planned) {
    sums_.count(planned.error().error);
    const bool nonsense = dealt.nonsense < dealt.moves.size();
    const std::string fault = fault_of(planned.error(), dealt.moves.size(), nonsense);
    if (!fault.empty()) return fail(fault);
  } else if (bench_.fresh[fresh_].stretch.moves > dealt.nonsense) {
    return fail("a move that is none was planned");
  }
  return unchanged(before);
}

bool RandomSequence::start(const PlannedMotion& motion) {
  under_way_ = &motion;
  clearance_ = motion.clearance_min;
  if (random_.chance(0.25)) {
    note("law");
    mode_ = Mode::kLaw;
    law_time_ = 0;
    feed_bound_ = 1;
    return follow();
  }
  double feed = 1;
  if (random_.chance(0.5)) feed = random_.chance(0.1) ? 0 : random_.uniform(0.02, 2);
  note(("start at " + std::to_string(feed)).c_str());
  PathFollower& follower = bench_.follower;
  if (const auto error = follower.start(motion.path, bench_.limits, feed)) {
    mode_ = Mode::kStands;
    return refused(*error, false);
  }
  mode_ = Mode::kPath;
  feed_bound_ = feed > 0 ? feed : 1e-9;
  return follow_one(0) && follow();
}

bool RandomSequence::follow() {
  const auto steps = random_.integer(3, 40);
  const double base = random_step();
  const bool jitter = random_.chance(0.5);
  for (auto k = steps; k > 0; --k) {
    if (mode_ == Mode::kStands) return true;
    const double dt = jitter ? random_step() : base;
    if (!(mode_ == Mode::kLaw ? follow_law(dt) : follow_one(dt))) return false;
  }
  return true;
}

bool RandomSequence::follow_one(double dt) {
  PathFollower& follower = bench_.follower;
  if (!judge(follower.step(dt), dt)) return false;
  const PathProgress progress = follower.progress();
  return (progress.move_share >= 0 && progress.move_share <= 1 && progress.path_share >= 0 &&
          progress.path_share <= 1) ||
         fail("progress is " + std::to_string(progress.path_share));
}

/// A law that is followed as it is ends where its plan says.
bool RandomSequence::follow_law(double dt) {
  law_time_ += dt;
  JointMotion now;
  under_way_->trajectory().sample(law_time_, now);
  if (!judge(now, dt)) return false;
  return law_time_ < under_way_->law.duration() || arrive();
}

bool RandomSequence::arrive() {
  mode_ = Mode::kStands;
  if (!take_place()) return false;
  const RobotPlace& end = under_way_->stretch.end;
  for (std::size_t j = 0; j < judge_.joints(); ++j) {
    if (!(std::abs(place_.q[j] - end.q[j]) <= 1e-9)) return fail("it has arrived somewhere else");
  }
  return true;
}

bool RandomSequence::override_feed() {
  PathFollower& follower = bench_.follower;
  double feed = random_.uniform(0, 2);
  if (random_.chance(0.1)) feed = 0;
  if (random_.chance(0.15)) feed = hostile_number(random_);
  note(("feed " + std::to_string(feed)).c_str());
  const Snapshot before = snapshot();
  const bool fine = feed >= 0 && feed <= PathFollower::kFeedMax;
  if (const auto error = follower.set_feed(feed)) {
    if (fine) return fail("a feed was refused: " + describe(*error));
    return refused(*error, true) && unchanged(before);
  }
  if (!fine) return fail("a feed that is none was taken");
  feed_bound_ = std::max(feed_bound_, follower.feed());
  return follow_one(0);
}

bool RandomSequence::pause_or_resume() {
  PathFollower& follower = bench_.follower;
  const bool pause = random_.chance(0.6);
  note(pause ? "pause" : "resume");
  pause ? follower.pause() : follower.resume();
  return follow_one(0);
}

/// As long as a stop takes along a path that is one straight line in joint space, where s has
/// limits of its own; infinite where it is none.
double RandomSequence::straight_stop() const {
  const PlannedPath& path = under_way_->path;
  if (path.joints.size() != 1 || path.sections.size() != 1 ||
      std::isfinite(path.sections[0].tool_acceleration)) {
    return std::numeric_limits<double>::infinity();
  }
  PathPoint at;
  path.joints.sample(0, at);
  motion::AxisLimits s{1e9, 1e9, 1e9};
  for (std::size_t j = 0; j < judge_.joints(); ++j) {
    if (at.dq[j] == 0) continue;
    s.acceleration = std::min(s.acceleration, bench_.limits[j].acceleration / std::abs(at.dq[j]));
    s.jerk = std::min(s.jerk, bench_.limits[j].jerk / std::abs(at.dq[j]));
  }
  const PathState& state = bench_.follower.state();
  return motion::OnlineProfile::stop({state.s, state.v, state.a}, motion::ProfileBounds(s))
      .duration();
}

bool RandomSequence::stop_path() {
  note("stop");
  ++sums_.stops;
  PathFollower& follower = bench_.follower;
  const bool rests = judge_.rests();
  const bool pauses = follower.paused() || follower.feed() == 0;
  const double left = follower.time_left();
  const double straight = straight_stop();
  follower.stop();
  const double predicted = follower.time_left();
  // What was under way comes to rest as well, and no earlier than it can.
  if (!rests && !(predicted <= left * (1 + 1e-6) + 1e-9)) {
    return fail("a stop takes " + std::to_string(predicted) + " s, its motion would have taken " +
                std::to_string(left));
  }
  if (!rests && !pauses && left > 0) sums_.stop_time = std::max(sums_.stop_time, predicted / left);
  if (!rests && !(predicted <= straight * (1 + 1e-6) + 1e-9)) {
    return fail("a stop takes " + std::to_string(predicted) + " s, the limits let it take " +
                std::to_string(straight));
  }
  return follow_one(0) && rest_on_path(predicted);
}

bool RandomSequence::rest_on_path(double predicted) {
  PathFollower& follower = bench_.follower;
  double gone = 0;
  double dt = 0;
  for (int k = 0; !follower.at_rest(); ++k) {
    dt = std::max(random_step(), predicted / 30);
    gone += dt;
    if (!follow_one(dt)) return false;
    if (k > 100 || gone > predicted + dt + 1e-9) return fail("a stop does not end");
  }
  if (!judge_.rests()) return fail("what has stopped still moves");
  // For good, whatever is said to it.
  const JointArray q = judge_.last().q;
  if (random_.chance(0.3)) {
    static_cast<void>(follower.set_feed(random_.uniform(0, 2)));
    follower.resume();
  }
  if (!follow_one(random_.uniform(0, 1))) return false;
  if (judge_.last().q != q) return fail("what has stopped has moved on");
  mode_ = Mode::kStands;
  return take_place();
}

}  // namespace sinew::planning
