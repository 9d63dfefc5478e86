#include "sinew/devices/bigrobotarm/bigrobotarm_driver_multipliers.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"

namespace sinew {
namespace {

using bigrobotarm::kJoints;
using bigrobotarm::Words;
using bigrobotarm::byte::sendable;

/// The nearest value at or below that the wire carries; 1 at worst.
std::int32_t sendable_at_or_below(std::int32_t value) {
  while (value > 1 && !sendable(value)) --value;
  return std::max(value, 1);
}

/// From here on a motion is slowed on purpose, and not only predicted to take that long.
constexpr double kSlowed = 1.05;

struct Pair {
  std::int32_t speed = 1;
  std::int32_t acceleration = 1;
};

/// The pair of whole numbers, neither above `base`, whose trapezoid takes nearest to `time`
/// seconds; among equals the one with the shape of the base profile slowed evenly.
/// @param evenly  no acceleration above what that shape has: slowness was asked for, and a crawl
///                that starts with a jerk is none
Pair pair_for_time(const BigRobotArmJoint& joint, double steps, Pair base, double time,
                   bool evenly) {
  const double unit = joint.steps_per_motor_rev / 100;
  const double way = std::abs(steps) / unit;  // in multipliers, so that v and a are the numbers
  const double k = motion_time(joint, steps, base.speed, base.acceleration) / time;
  const double speed_even = std::max(1.0, base.speed * k);
  const double even = std::ceil(base.acceleration * k * k);
  const auto most = evenly ? std::clamp(static_cast<std::int32_t>(even), 1, base.acceleration)
                           : base.acceleration;
  Pair best{1, 1};
  double best_cost = 1e300;
  for (std::int32_t speed = 1; speed <= base.speed; ++speed) {
    if (!sendable(speed)) continue;
    // time = way / v + v / a where the top speed is reached, 2 sqrt(way / a) where it is not.
    const double ramp = time - way / speed;
    double acceleration = ramp > 0 ? speed / ramp : base.acceleration;
    if (acceleration * way < static_cast<double>(speed) * speed) {
      acceleration = 4 * way / (time * time);
    }
    const double floor = std::clamp(std::floor(acceleration), 1.0, 1.0 * most);
    for (const double candidate : {floor, floor + 1}) {
      const auto whole = static_cast<std::int32_t>(candidate);
      if (whole > most || !sendable(whole)) continue;
      const double own = motion_time(joint, steps, speed, whole);
      const double cost =
          std::abs(own - time) / time + 0.01 * std::abs(speed - speed_even) / speed_even;
      if (cost < best_cost) {
        best_cost = cost;
        best = {speed, whole};
      }
    }
  }
  return best;
}

}  // namespace

double motion_time(const BigRobotArmJoint& joint, double steps, std::int32_t speed,
                   std::int32_t acceleration) {
  SINEW_ASSERT(speed >= 1 && acceleration >= 1 && joint.steps_per_motor_rev > 0);
  const double unit = joint.steps_per_motor_rev / 100;
  const double way = std::abs(steps);
  if (way == 0) return 0;
  const double v = speed * unit;
  const double a = acceleration * unit;
  return way * a >= v * v ? way / v + v / a : 2 * std::sqrt(way / a);
}

double motion_share(const BigRobotArmJoint& joint, double steps, std::int32_t speed,
                    std::int32_t acceleration, double t) {
  const double whole = motion_time(joint, steps, speed, acceleration);
  if (t >= whole) return 1;
  if (t <= 0) return 0;
  const double a = acceleration * joint.steps_per_motor_rev / 100 / std::abs(steps);  // 1/s^2
  const double ramp = std::min(whole / 2, 1.0 * speed / acceleration);
  if (t < ramp) return a * t * t / 2;
  if (t > whole - ramp) return 1 - a * (whole - t) * (whole - t) / 2;
  return a * ramp * (t - ramp / 2);
}

Expected<BigRobotArmMultipliers> synchronised_multipliers(const BigRobotArmDevice& device,
                                                          const Words& deltas,
                                                          const BigRobotArmMultipliers& base,
                                                          double at_least) {
  BigRobotArmMultipliers result;
  std::array<double, kJoints> times{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const std::int32_t value : {base.speeds[i], base.accelerations[i]}) {
      if (value < 1 || value > device.multiplier_max) {
        return std::unexpected(Error{ErrorCode::kMultiplierRange, static_cast<std::int8_t>(i),
                                     1.0 * value, 1.0 * device.multiplier_max});
      }
    }
    result.speeds[i] = sendable_at_or_below(base.speeds[i]);
    result.accelerations[i] = sendable_at_or_below(base.accelerations[i]);
    times[i] = motion_time(device.joints[i], deltas[i], result.speeds[i], result.accelerations[i]);
  }
  const double own = *std::max_element(times.begin(), times.end());
  const double slowest = std::max(at_least, own);
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (times[i] == 0 || times[i] == slowest) continue;
    const Pair pair =
        pair_for_time(device.joints[i], deltas[i], {result.speeds[i], result.accelerations[i]},
                      slowest, at_least > own * kSlowed);
    result.speeds[i] = pair.speed;
    result.accelerations[i] = pair.acceleration;
  }
  return result;
}

BigRobotArmMultipliers raised(const BigRobotArmDevice& device, const Words& deltas,
                              BigRobotArmMultipliers base, double time) {
  const std::int32_t most = device.multiplier_max;
  for (std::size_t i = 0; time > 0 && i < kJoints; ++i) {
    std::int32_t& speed = base.speeds[i];
    std::int32_t& acceleration = base.accelerations[i];
    const auto late = [&] {
      return motion_time(device.joints[i], deltas[i], speed, acceleration) > kSlowed * time;
    };
    for (; late() && (speed < most || acceleration < most);) {
      speed = std::min(most, speed + 1);
      acceleration = std::min(most, acceleration + 1);
    }
  }
  return base;
}

Expected<void> check_multipliers(const BigRobotArmDevice& device, const Words& multipliers) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto joint = static_cast<std::int8_t>(i);
    const std::int32_t value = multipliers[i];
    if (value < 1 || value > device.multiplier_max) {
      return std::unexpected(
          Error{ErrorCode::kMultiplierRange, joint, 1.0 * value, 1.0 * device.multiplier_max});
    }
    if (device.wire == BigRobotArmWire::kByte && !sendable(value)) {
      return std::unexpected(Error{ErrorCode::kUnsendable, joint, 1.0 * value});
    }
  }
  return {};
}

}  // namespace sinew
