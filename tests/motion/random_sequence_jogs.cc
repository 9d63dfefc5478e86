#include <algorithm>
#include <cmath>

#include "motion/random_sequence.h"

namespace sinew::planning {

bool RandomSequence::jog() {
  return start_jog() && (random_.chance(0.1) || jog_command()) && hold_jog();
}

/// From rest, or out of the middle of a planned motion.
bool RandomSequence::start_jog() {
  note("jog");
  ++sums_.jogs;
  Jog& jog = bench_.jog.jog;
  if (mode_ == Mode::kJog) return true;
  const JointMotion& now = judge_.last();
  std::vector<motion::AxisState> states;
  for (std::size_t j = 0; j < judge_.joints(); ++j) {
    states.push_back({now.q[j], now.qd[j], now.qdd[j]});
  }
  if (const auto error = jog.start(states, bench_.jog.now, &place_.X_BT)) {
    if (!outside_) return fail("a jog was refused where it stands: " + describe(*error));
    return refused(*error, false);
  }
  overlaps_ = false;
  taken_over_ = !judge_.rests();
  sums_.takeovers += taken_over_ ? 1 : 0;
  mode_ = Mode::kJog;
  clearance_ = std::min(bench_.collision.margin(), bench_.distance(now.q, place_.X_BT));
  return true;
}

bool RandomSequence::jog_command() {
  if (mode_ != Mode::kJog) return true;
  JogCommand command = bench_.jog.random_command(random_);
  if (random_.chance(0.3)) command.expiry = from_seconds(random_.uniform(1e-3, 1));
  note("command");
  if (const auto error = bench_.jog.jog.command(command, bench_.jog.now)) {
    // Quick numbers may be beyond what a command may be.
    bool beyond = false;
    for (const double number : command.velocity) {
      beyond = beyond || std::abs(number) > Jog::kSpeedMax;
    }
    return beyond ? refused(*error, false) : fail("a jog was refused: " + describe(*error));
  }
  return true;
}

bool RandomSequence::hostile_jog_command() {
  if (mode_ != Mode::kJog) return true;
  note("hostile command");
  Jog& jog = bench_.jog.jog;
  JogCommand command = bench_.jog.random_command(random_);
  for (double& number : command.velocity) {
    number = std::clamp(number, -Jog::kSpeedMax, Jog::kSpeedMax);
  }
  bool nonsense = true;
  Instant now = bench_.jog.now;
  switch (random_.integer(0, 4)) {
    case 0: {
      const double number = hostile_number(random_);
      const auto which = random_.integer(0, std::ssize(command.velocity) - 1);
      command.velocity[static_cast<std::size_t>(which)] = number;
      nonsense = !(std::abs(number) <= Jog::kSpeedMax);
      break;
    }
    case 1:
      command.velocity.resize(random_.chance(0.5) ? 1 : 8);
      break;
    case 2:
      command.expiry = random_.chance(0.5)
                           ? Duration{-random_.integer(0, 1'000'000'000)}
                           : kJogExpiryMax + Duration{random_.integer(1, 1LL << 60)};
      break;
    case 3:
      now -= Duration{random_.integer(1, 1'000'000'000)};
      break;
    default:
      nonsense = !bench_.robot.is_hexapod();
      command.frame = JogFrame::kPlatform;
      if (!nonsense) command.velocity.resize(6);
      break;
  }
  const Snapshot before = snapshot();
  const auto error = jog.command(command, now);
  if (error.has_value() != nonsense) return fail("a hostile jog was taken, or a good one refused");
  if (error) return refused(*error, true) && unchanged(before);
  return true;
}

bool RandomSequence::hold_jog() {
  if (mode_ != Mode::kJog) return true;
  const auto steps = random_.integer(3, 25);
  const double base = random_step();
  const bool jitter = random_.chance(0.5);
  for (auto k = steps; k > 0; --k) {
    if (!jog_one(jitter ? random_step() : base)) return false;
  }
  // A gap, in which it comes to rest; or a clock that runs back, which nothing comes of.
  if (random_.chance(0.05)) return jog_one(random_.uniform(0.05, 0.4));
  if (!random_.chance(0.05)) return true;
  const Snapshot before = snapshot();
  const auto error = bench_.jog.jog.step(bench_.jog.now - Duration{random_.integer(1, 1 << 30)});
  if (!error) return fail("a clock that runs back was followed");
  return refused(*error, true) && unchanged(before);
}

bool RandomSequence::jog_one(double dt) {
  const Duration step = from_seconds(dt);
  bench_.jog.now += step;
  Jog& jog = bench_.jog.jog;
  if (const auto error = jog.step(bench_.jog.now)) {
    return fail("a step was refused: " + describe(*error));
  }
  const auto& setpoint = jog.setpoint();
  JointMotion now;
  for (std::size_t j = 0; j < judge_.joints(); ++j) {
    now.q[j] = setpoint.q[j];
    now.qd[j] = setpoint.qd[j];
    now.qdd[j] = setpoint.qdd[j];
  }
  place_.X_BT = jog.pose();
  if (!judge(now, to_seconds(step))) return false;
  if (taken_over_ && judge_.rests()) {
    taken_over_ = false;
    clearance_ = std::min(bench_.collision.margin(), bench_.distance(now.q, place_.X_BT));
  }
  return true;
}

/// All joints to rest in the time that the slowest of them needs.
bool RandomSequence::stop_jog() {
  note("stop jog");
  ++sums_.stops;
  Jog& jog = bench_.jog.jog;
  jog.stop();
  double needed = 0;
  for (std::size_t j = 0; j < judge_.joints(); ++j) {
    const JointMotion& now = judge_.last();
    const motion::ProfileBounds bounds(bench_.limits[j]);
    const auto stop = motion::OnlineProfile::stop({now.q[j], now.qd[j], now.qdd[j]}, bounds);
    needed = std::max(needed, stop.duration());
  }
  double gone = 0;
  while (!jog.at_rest()) {
    const double dt = std::max(random_step(), needed / 20);
    if (gone > needed + 1e-6) {
      return fail("a jog takes more than " + std::to_string(needed) + " s to stop");
    }
    gone += dt;
    if (!jog_one(dt)) return false;
  }
  if (!judge_.rests()) return fail("a jog that has stopped still moves");
  return take_place();
}

/// Some joints stand a little outside of their limits, as nobody asked them to; from there a plan
/// or a jog may come back and go no farther out.
bool RandomSequence::step_outside() {
  note("outside");
  ++sums_.outside;
  if (!take_place()) return false;
  mode_ = Mode::kStands;
  JointMotion at;
  at.q = place_.q;
  const auto count = static_cast<std::int64_t>(judge_.joints());
  for (auto k = random_.integer(1, 2); k > 0; --k) {
    const auto j = static_cast<std::size_t>(random_.integer(0, count - 1));
    const Joint& joint = bench_.robot.model.joints[j];
    const double off = (joint.upper - joint.lower) * std::pow(10, random_.uniform(-6, -1.5));
    at.q[j] = random_.chance(0.5) ? joint.upper + off : joint.lower - off;
  }
  const auto X_BT = bench_.robot.space.forward(bench_.joints(at.q), place_.X_BT);
  if (!X_BT) return refused(X_BT.error(), false);
  place_ = {at.q, *X_BT};
  judge_.begin(at);
  outside_ = true;
  return plan() && jog();
}

}  // namespace sinew::planning
