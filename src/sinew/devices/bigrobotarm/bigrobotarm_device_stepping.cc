#include "sinew/devices/bigrobotarm/bigrobotarm_device_stepping.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// s; fitted, see the class comment.
constexpr double kRound = 92e-6;
constexpr double kRoundPerStep = 170e-6;
constexpr double kRoundPerMix = 10e-6;
/// Of a round, lost at each step of a motor that is slower than the loop.
constexpr double kLostOfRound = 0.87;
constexpr double kLevelRound = 134e-6;
constexpr double kLevelRoundPerStep = 44.7e-6;

constexpr double kTick = 1e-3;  // s
/// A ramp may change its rate by this part within one stretch of time, but not for longer than
constexpr double kRampChange = 0.01;
constexpr double kRampTickMax = 20e-3;  // s
/// Steps that are none: rounding.
constexpr double kNoStep = 1e-9;

double round_time(double steps) {
  return kRound + kRoundPerStep * steps + kRoundPerMix * steps * (kBigRobotArmJoints - steps);
}

}  // namespace

double BigRobotArmStepping::Leg::length() const {
  return std::abs(run_on) + std::abs(way);
}

double BigRobotArmStepping::Leg::own_rate() const {
  if (left() <= kNoStep) return 0;
  // The first interval is about as long as if half a step had been made already.
  const auto ramp = [&](double steps) { return std::sqrt(acceleration * (1 + 2 * steps)); };
  const double away = std::abs(run_on) - done;
  if (away > kNoStep) return ramp(away);
  return std::min({speed, ramp(-away), ramp(left())});
}

BigRobotArmStepping BigRobotArmStepping::ramped(const Joints& joints) {
  BigRobotArmStepping stepping;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Joint& joint = joints[i];
    Leg& leg = stepping.legs_[i];
    leg.speed = joint.speed;
    leg.acceleration = joint.acceleration;
    leg.stuck = joint.distance != 0 && joint.speed <= 0;
    if (leg.stuck) {
      leg.way = std::copysign(1.0, joint.distance);
      leg.speed = 1 / kTick;
      leg.acceleration = leg.speed / kTick;
      continue;
    }
    const double stop = joint.old_speed * std::abs(joint.old_speed) / (2 * joint.acceleration);
    const bool in_time = stop * joint.distance > 0 && std::abs(stop) <= std::abs(joint.distance);
    leg.run_on = in_time || std::abs(stop) < 1 ? 0 : stop;
    leg.way = joint.distance - leg.run_on;
  }
  stepping.set_rates();
  return stepping;
}

BigRobotArmStepping BigRobotArmStepping::level(const Joints& joints) {
  BigRobotArmStepping stepping;
  double longest = 0;
  double furthest = 0;
  double total = 0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double way = std::abs(joints[i].distance);
    stepping.legs_[i].way = joints[i].distance;
    stepping.legs_[i].stuck = way > 0 && joints[i].speed <= 0;
    if (joints[i].speed > 0) longest = std::max(longest, way / joints[i].speed);
    furthest = std::max(furthest, way);
    total += way;
  }
  // Every round the furthest motor makes a step, and the others their share of one.
  stepping.level_time_ = std::max(longest, kLevelRound * furthest + kLevelRoundPerStep * total);
  return stepping;
}

void BigRobotArmStepping::set_rates() {
  double rate_max = 1 / round_time(0);
  double rate_min = 0;
  std::array<double, kBigRobotArmJoints> own{};
  double fastest = 0;
  for (std::size_t i = 0; i < legs_.size(); ++i) {
    own[i] = legs_[i].own_rate();
    fastest = std::max(fastest, own[i]);
  }
  if (fastest == 0) {
    for (Leg& leg : legs_) leg.rate = 0;
    return;
  }
  for (int i = 0; i < 24; ++i) {
    const double rate = (rate_min + rate_max) / 2;
    double steps = 0;
    for (const double one : own) steps += std::min(one, rate) / rate;
    (rate * round_time(steps) < 1 ? rate_min : rate_max) = rate;
  }
  for (std::size_t i = 0; i < legs_.size(); ++i) {
    const bool slower = own[i] < rate_min && own[i] > 0;
    legs_[i].held_back = own[i] >= rate_min;
    legs_[i].rate =
        slower ? 1 / (1 / own[i] + kLostOfRound / rate_min) : std::min(own[i], rate_min);
  }
}

double BigRobotArmStepping::steady_time() const {
  double time = 1e9;
  for (const Leg& leg : legs_) {
    if (leg.rate == 0) continue;
    const double from_stop = leg.done - std::abs(leg.run_on);
    const double level_rate = leg.held_back ? leg.rate : leg.own_rate();
    const double ramp_steps = level_rate * level_rate / (2 * leg.acceleration);
    // The first interval counts for half a step, as in own_rate().
    const bool level = leg.held_back || level_rate >= leg.speed;
    if (!level || from_stop + 1 < ramp_steps || leg.left() < ramp_steps) {
      time = std::min({time, kRampChange * leg.rate / leg.acceleration, kRampTickMax});
    } else {
      time = std::min(time, (leg.left() - ramp_steps) / leg.rate);
    }
  }
  return std::max(kTick, std::floor(time / kTick) * kTick);
}

bool BigRobotArmStepping::arrived() const {
  return std::all_of(legs_.begin(), legs_.end(), [](const Leg& leg) { return leg.rate == 0; });
}

void BigRobotArmStepping::advance_to(double t) {
  seen_ = std::max(seen_, t);
  if (level_time_ > 0) return;
  while (!arrived()) {
    const double dt = steady_time();
    if (time_ + dt > seen_) return;
    for (Leg& leg : legs_) {
      if (leg.rate == 0) continue;
      const double need = leg.left() / leg.rate;
      if (need <= dt) last_step_ = std::max(last_step_, time_ + need);
      leg.done = need <= dt ? leg.length() : leg.done + leg.rate * dt;
    }
    time_ += dt;
    set_rates();
  }
}

double BigRobotArmStepping::position(std::size_t joint) const {
  const Leg& leg = legs_[joint];
  if (level_time_ > 0) {
    if (leg.stuck) return 0;
    return leg.way * std::min(1.0, seen_ / level_time_);
  }
  const double done = std::min(leg.length(), leg.done + leg.rate * (seen_ - time_));
  const double away = std::min(done, std::abs(leg.run_on));
  return std::copysign(away, leg.run_on) + std::copysign(done - away, leg.way);
}

double BigRobotArmStepping::level_speed(std::size_t joint) const {
  return level_time_ > 0 ? legs_[joint].way / level_time_ : 0;
}

std::optional<double> BigRobotArmStepping::duration() const {
  if (std::any_of(legs_.begin(), legs_.end(), [](const Leg& leg) { return leg.stuck; })) {
    return std::nullopt;
  }
  if (level_time_ > 0) return level_time_;
  BigRobotArmStepping rest = *this;
  rest.advance_to(1e12);
  return rest.last_step_;
}

}  // namespace sinew
