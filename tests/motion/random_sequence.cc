#include "motion/random_sequence.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace sinew::planning {
namespace {

constexpr std::uint64_t kToolLooks = 8;      // samples between two looks at the tool's speed
constexpr std::uint64_t kContactLooks = 16;  // and at the collision model

}  // namespace

RandomSequence::RandomSequence(MotionBench& bench, std::uint64_t seed, MotionSums& sums)
    : bench_(bench), random_(seed), sums_(sums), judge_(bench.robot.model, sums) {}

std::string RandomSequence::run() {
  ++sums_.sequences;
  bool fine = begin();
  for (auto k = random_.integer(3, 12); fine && k > 0; --k) {
    ++sums_.commands;
    fine = command();
  }
  if (fine) settle();
  return complaint_.empty() ? complaint_ : complaint_ + "\nafter:" + history_;
}

bool RandomSequence::fail(const std::string& what) {
  if (complaint_.empty()) complaint_ = what;
  return false;
}

/// At the begin of a plan that was made before, or anywhere.
bool RandomSequence::begin() {
  look_ = random_.bits() % kContactLooks;
  const auto plans = bench_.plans();
  const bool planned = !plans.empty() && random_.chance(0.75);
  const std::size_t which = planned ? random_.bits() % plans.size() : 0;
  place_ = planned ? plans[which].from : bench_.free_place(random_);
  JointMotion at;
  at.q = place_.q;
  judge_.begin(at);
  return !planned || start(plans[which].motion);
}

bool RandomSequence::command() {
  const bool rests = judge_.rests();
  const double draw = random_.uniform(0, 1);
  if (rests && draw < 0.35) {
    if (draw < 0.06) return step_outside();
    if (draw < 0.09) return plan_from_nowhere();
    return draw < 0.18 ? plan() : jog();
  }
  if (mode_ == Mode::kJog) {
    if (draw < 0.5) return jog_command() && hold_jog();
    if (draw < 0.75) return hold_jog();
    return draw < 0.9 ? stop_jog() : hostile_jog_command() && hold_jog();
  }
  if (mode_ == Mode::kLaw || mode_ == Mode::kStands) {
    if (draw < 0.85) return follow();
    return rests ? plan() : jog();
  }
  if (draw < 0.35) return override_feed() && follow();
  if (draw < 0.5) return pause_or_resume() && follow();
  if (draw < 0.8) return follow();
  if (draw < 0.9) return stop_path();
  return draw < 0.94 ? plan_ahead() && follow() : jog();
}

/// 0.2 ms to 20 ms; now and then a long one, since a law may be looked at anywhere.
double RandomSequence::random_step() {
  if (mode_ != Mode::kJog && random_.chance(0.02)) return random_.uniform(0, 2);
  return 0.2e-3 * std::pow(100, random_.uniform(0, 1));
}

bool RandomSequence::Snapshot::operator==(const Snapshot& other) const {
  return motion.q == other.motion.q && motion.qd == other.motion.qd &&
         motion.qdd == other.motion.qdd && state.s == other.state.s && state.v == other.state.v &&
         state.a == other.state.a && feed == other.feed && time_left == other.time_left &&
         paused == other.paused && stopped == other.stopped && jog.reason == other.jog.reason &&
         jog.joint == other.jog.joint && jog.share == other.jog.share &&
         jog.moving == other.jog.moving;
}

RandomSequence::Snapshot RandomSequence::snapshot() const {
  Snapshot now;
  if (mode_ == Mode::kJog) {
    const auto& setpoint = bench_.jog.jog.setpoint();
    now.motion = {setpoint.q, setpoint.qd, setpoint.qdd, {}};
    now.jog = bench_.jog.jog.status();
  } else {
    const PathFollower& follower = bench_.follower;
    now = {follower.now(),
           follower.state(),
           follower.feed(),
           follower.time_left(),
           follower.paused(),
           follower.stopped(),
           {}};
  }
  return now;
}

bool RandomSequence::unchanged(const Snapshot& before) {
  return snapshot() == before || fail("a refusal has changed what is under way");
}

bool RandomSequence::refused(const Error& error, bool asked_nonsense) {
  sums_.count(error);
  const std::string fault = fault_of(error, asked_nonsense);
  return fault.empty() || fail(fault);
}

bool RandomSequence::judge(const JointMotion& now, double dt) {
  for (std::size_t j = 0; j < judge_.joints(); ++j) {
    digest_ =
        std::rotl(digest_, 7) * 0x9E3779B97F4A7C15ULL ^ std::bit_cast<std::uint64_t>(now.q[j]);
  }
  if (outside_ && mode_ != Mode::kJog && !judge_way_in(now)) return false;
  const std::string wrong = judge_.judge(now, dt);
  if (!wrong.empty()) return fail(wrong + " (step of " + std::to_string(dt) + " s)");
  ++look_;
  if (look_ % kToolLooks == 0 && mode_ != Mode::kJog && !judge_tool()) return false;
  return look_ % kContactLooks != 0 || judge_contact();
}

/// A planned motion that began outside the limits never turns back on its way in.
bool RandomSequence::judge_way_in(const JointMotion& now) {
  for (std::size_t j = 0; j < judge_.joints(); ++j) {
    const Joint& joint = bench_.robot.model.joints[j];
    const double before = judge_.last().q[j];
    const double upper = std::max(before, joint.upper);
    const double lower = std::min(before, joint.lower);
    constexpr double kRounding = 1e-8;  // rad or m
    if (now.q[j] > upper + kRounding || now.q[j] < lower - kRounding) {
      return fail("joint " + std::to_string(j + 1) + " goes farther out, from " +
                  std::to_string(before) + " to " + std::to_string(now.q[j]));
    }
  }
  return true;
}

/// The slowest that was asked for on the rest of the way, of s. What is quicker when a lower feed
/// is asked for may have to brake from one section into the next.
double RandomSequence::asked_ahead(double s) const {
  const PlannedPath& path = under_way_->path;
  double least = std::numeric_limits<double>::infinity();
  std::size_t section = 0;
  for (std::size_t piece = 0; piece < path.joints.size(); ++piece) {
    if (path.joints.begin(piece + 1) < s) continue;
    const auto& sections = path.sections;
    while (section + 1 < sections.size() &&
           sections[section + 1].begin <= path.joints.begin(piece)) {
      ++section;
    }
    for (std::size_t i = section;
         i < sections.size() && (i == section || sections[i].begin < path.joints.begin(piece + 1));
         ++i) {
      if (path.tool[piece].speed > 0) {
        least = std::min(least, sections[i].tool_speed / path.tool[piece].speed);
      }
    }
  }
  return least;
}

/// The tool's speed and acceleration by the robot's own kinematics, against what its move asked
/// for.
bool RandomSequence::judge_tool() {
  const JointMotion& now = judge_.last();
  const ToolSpace& space = bench_.robot.space;
  // A hexapod's pose is found by steps, to 1e-12 m: it is slow, so that the longer step costs
  // nothing.
  const double h = bench_.robot.is_hexapod() ? 1e-2 : 1e-3;  // s
  JointArray before{};
  JointArray behind{};
  for (std::size_t j = 0; j < space.size(); ++j) {
    before[j] = now.q[j] - h * (now.qd[j] - h / 2 * now.qdd[j]);
    behind[j] = now.q[j] + h * (now.qd[j] + h / 2 * now.qdd[j]);
  }
  const auto X_before = space.forward(bench_.joints(before), place_.X_BT);
  const auto X_now = space.forward(bench_.joints(now.q), place_.X_BT);
  const auto X_behind = space.forward(bench_.joints(behind), place_.X_BT);
  if (!X_before || !X_now || !X_behind) {
    return fail("forward kinematics has no tool on a planned path");
  }
  place_.X_BT = *X_behind;
  const PathFollower& follower = bench_.follower;
  const PathState state =
      mode_ == Mode::kPath ? follower.state() : under_way_->law.sample(law_time_);
  const auto& sections = under_way_->path.sections;
  std::size_t i = 0;
  while (i + 1 < sections.size() && sections[i + 1].begin <= state.s) ++i;
  const Vec3 change = (X_behind->p - X_now->p) - (X_now->p - X_before->p);
  if (!judge_tool_acceleration(norm(change) / (h * h), sections[i], state)) return false;
  const double asked = sections[i].tool_speed;
  if (!std::isfinite(asked)) return true;
  const double speed = norm(X_behind->p - X_before->p) / (2 * h);
  const double share = speed / (asked * feed_bound_);
  sums_.tool_speed = std::max(sums_.tool_speed, share);
  // The joints' spline is 5 um true to the tool's way, which its slope may tell.
  constexpr double kSlope = 2e-3;
  if (share > 1 + kSlope && speed > 1e-9) {
    return fail("the tool's speed is " + std::to_string(speed) + " m/s, asked for were " +
                std::to_string(asked) + " times " + std::to_string(feed_bound_) + ", at s " +
                std::to_string(state.s) + ", v " + std::to_string(state.v));
  }
  if (mode_ == Mode::kPath && follower.feed() > 0 && !follower.paused() && state.a <= 0 &&
      state.v <= follower.feed() * asked_ahead(state.s)) {
    feed_bound_ = follower.feed();
  }
  return true;
}

bool RandomSequence::judge_tool_acceleration(double acceleration, const PathSection& section,
                                             const PathState& state) {
  const double asked = section.tool_acceleration;
  if (!std::isfinite(asked)) return true;
  constexpr double kSlope = 2e-3;
  constexpr double kNoise = 1e-7;  // m/s^2, of positions over the square of the step
  sums_.tool_acceleration = std::max(sums_.tool_acceleration, (acceleration - kNoise) / asked);
  return acceleration <= asked * (1 + kSlope) + kNoise ||
         fail("the tool's acceleration is " + std::to_string(acceleration) +
              " m/s2, asked for were " + std::to_string(asked) + ", at s " +
              std::to_string(state.s) + ", v " + std::to_string(state.v) + ", a " +
              std::to_string(state.a));
}

bool RandomSequence::judge_contact() {
  const JointMotion& now = judge_.last();
  ++sums_.contact_looks;
  const PoseBT& X_near = mode_ == Mode::kJog ? bench_.jog.jog.pose() : place_.X_BT;
  const double distance = bench_.distance(now.q, X_near);
  if (mode_ != Mode::kJog) {
    return distance >= clearance_ - 1e-9 ||
           fail("a planned motion is " + std::to_string(1e3 * distance) +
                " mm from a contact, less than " + std::to_string(1e3 * clearance_));
  }
  // docs/jog.md: out of an overlap a person may drive the joints anywhere, slowly.
  if (bench_.jog.jog.overlap()) {
    overlaps_ = true;
    return true;
  }
  if (std::exchange(overlaps_, false)) {
    clearance_ = bench_.collision.margin() - Jog::kOverlapDepth;
  }
  // docs/jog.md: joints may be off by a millimetre of the tool's way from what was looked at.
  constexpr double kOff = 1e-3;
  if (!taken_over_) sums_.jog_inside = std::max(sums_.jog_inside, clearance_ - distance);
  const double least = taken_over_ ? std::min(clearance_, 0.0) : clearance_ - kOff;
  return distance >= least ||
         fail("a jog is " + std::to_string(1e3 * distance) + " mm from a contact, " +
              std::to_string(1e3 * clearance_) + " were to be kept");
}

bool RandomSequence::take_place() {
  if (!judge_.rests()) return fail("it was to be at rest and is not");
  place_.q = judge_.last().q;
  bool inside = true;
  for (std::size_t j = 0; j < judge_.joints(); ++j) {
    inside = inside && within_limits(bench_.robot.model.joints[j], place_.q[j]);
  }
  if (!outside_ && !inside) return fail("it has left its limits");
  outside_ = !inside;
  const auto X_BT = bench_.robot.space.forward(bench_.joints(place_.q), place_.X_BT);
  if (!X_BT) return fail("it stands where it has no pose: " + describe(X_BT.error()));
  place_.X_BT = *X_BT;
  return true;
}

bool RandomSequence::settle() {
  if (mode_ == Mode::kJog) return stop_jog();
  if (mode_ == Mode::kPath) return stop_path();
  if (mode_ == Mode::kStands) return true;
  while (mode_ == Mode::kLaw) {
    if (!follow_law(std::max(random_step(), under_way_->law.duration() / 50))) return false;
  }
  return true;
}

}  // namespace sinew::planning
