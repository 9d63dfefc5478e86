#include "sinew/planning/studies/torque_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"

namespace sinew::planning {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();
constexpr double kTiny = 1e-12;
constexpr std::array kRampParts{1.0, 0.5, 0.0};
constexpr double kPayloadMax = 1000;      // kg
constexpr double kAccelerationMax = 1e4;  // rad/s^2
constexpr int kRounds = 12;
constexpr double kCloseEnough = 1e-5;  // of x
constexpr double kNotFailing = 1e6;    // m; farther than any reach

double from_base_axis(const Vec3& p) {
  return std::hypot(p.x, p.y);
}

std::vector<DriveTrain> drive_trains(const RobotModel& model) {
  std::vector<DriveTrain> drives;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const auto drive = drive_train(model, i);
    SINEW_ASSERT(drive.has_value());
    drives.push_back(*drive);
  }
  return drives;
}

/// Speed and acceleration of a joint on its ramp from rest to top speed.
struct RampPoint {
  double velocity = 0;
  double acceleration = 0;
};

/// Where the acceleration, which jerk brings up and down again, has come down to this part of its
/// peak: 1 is where it begins to fall, 0 where top speed is reached.
RampPoint ramp_point(const Joint& joint, double part) {
  const double peak =
      std::min(joint.acceleration_max, std::sqrt(joint.velocity_max * joint.jerk_max));
  const double acceleration = part * peak;
  return {joint.velocity_max - acceleration * acceleration / (2 * joint.jerk_max), acceleration};
}

/// The x in [0, x_max] where a growing f passes 1.
template <class F>
double crossing(F&& f, double x_max) {
  if (f(x_max) <= 1) return x_max;
  double below = 0, above = x_max;
  for (int i = 0; i < 100 && above - below > kCloseEnough * 1e-3 * above; ++i) {
    const double middle = 0.5 * (below + above);
    (f(middle) > 1 ? above : below) = middle;
  }
  return above;
}

}  // namespace

TorqueStudy::TorqueStudy(const RobotModel& model, double step_rate_max)
    : model_(model),
      step_rate_max_(step_rate_max),
      drives_(drive_trains(model_)),
      search_(model_) {}

double TorqueStudy::share(std::size_t i, const JointDuty& duty) const {
  return drives_[i].demand(duty) / std::max(drives_[i].available(duty.velocity), kTiny);
}

TorqueStudy::Duties TorqueStudy::duties(const InverseDynamics& dynamics, std::size_t i,
                                        const JointVector& q, std::size_t number) const {
  Duties duties;
  const auto parts = dynamics.parts(q);
  if (!parts) return duties;
  std::optional<std::size_t> way;
  if (number != PoseSearch::kClimbing) way = number;
  for (const double part : kRampParts) {
    JointVector qd, qdd;
    double inertial = 0;
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const RampPoint point = ramp_point(model_.joints[j], part);
      qd.push_back(point.velocity);
      qdd.push_back(point.acceleration);
      inertial += std::abs(parts->inertia[i][j]) * point.acceleration;
    }
    // In the direction of its motion the joint has everything against it.
    const auto by_speed = dynamics.torque_by_speed(q, qd, i, way);
    const double upwards = parts->weight[i] + by_speed.down;
    const double downwards = -parts->weight[i] + by_speed.up;
    duties.push_back({std::max(upwards, downwards) + inertial, qd[i], qdd[i]});
  }
  return duties;
}

std::optional<TorqueStudy::Hardest> TorqueStudy::hardest(const InverseDynamics& dynamics,
                                                         std::size_t i, const JointVector& q,
                                                         std::size_t number) const {
  std::optional<Hardest> hardest;
  for (const JointDuty& duty : duties(dynamics, i, q, number)) {
    const double needed = share(i, duty);
    if (!hardest || needed > hardest->share) hardest = {duty, needed};
  }
  return hardest;
}

/// The ratio that does all of them.
std::optional<RatioAnswer> TorqueStudy::ratio_for(std::size_t i, const Duties& duties,
                                                  double reserve) const {
  std::optional<RatioAnswer> all;
  for (const JointDuty& duty : duties) {
    const auto one = drives_[i].ratio_for(duty, step_rate_max_, reserve);
    if (!one) return std::nullopt;
    if (!all) {
      all = one;
      continue;
    }
    all->lowest = all->lowest && one->lowest ? std::optional(std::max(*all->lowest, *one->lowest))
                                             : std::nullopt;
    all->highest_useful = std::min(all->highest_useful, one->highest_useful);
    if (all->highest_for_speed) {
      all->highest_for_speed = std::min(*all->highest_for_speed, *one->highest_for_speed);
    }
  }
  return all;
}

JointNeed TorqueStudy::need(std::size_t i, double payload) const {
  SINEW_ASSERT(i < size());
  const InverseDynamics dynamics(model_, payload);
  JointNeed need;
  const auto heaviest = search_.best([&](const JointVector& q, std::size_t) {
    const auto parts = dynamics.parts(q);
    return parts ? std::abs(parts->weight[i]) : kNever;
  });
  need.weight = heaviest.score;
  need.q_weight = heaviest.q;
  const auto worst = search_.best([&](const JointVector& q, std::size_t number) {
    const auto found = hardest(dynamics, i, q, number);
    return found ? found->share : kNever;
  });
  const auto found = hardest(dynamics, i, worst.q, PoseSearch::kClimbing);
  SINEW_ASSERT(found.has_value());
  need.q_demand = worst.q;
  need.duty = found->duty;
  need.demand = drives_[i].demand(need.duty);
  need.available = drives_[i].available(need.duty.velocity);
  need.holding = drives_[i].available(0);
  const Duties all = duties(dynamics, i, worst.q, PoseSearch::kClimbing);
  need.ratio = ratio_for(i, all, 1);
  need.ratio_with_reserve = ratio_for(i, all, kTorqueReserve);
  return need;
}

std::optional<double> TorqueStudy::first_failing(const Need& need, double x_max) const {
  const auto worst_at = [&](double x) {
    return search_.best(
        [&](const JointVector& q, std::size_t number) { return need(q, number, x); });
  };
  // The largest of growing convex functions: where the one that is largest here crosses 1, the
  // largest of all has crossed it already, so each round comes closer from above.
  double x = x_max;
  auto worst = worst_at(0);
  if (worst.score > 1) return 0;
  for (int round = 0; round < kRounds; ++round) {
    const double next =
        crossing([&](double at) { return need(worst.q, PoseSearch::kClimbing, at); }, x);
    const bool close = round > 0 && x - next <= kCloseEnough * x;
    x = next;
    if (close) break;
    worst = worst_at(x);
    if (worst.score <= 1) break;
  }
  if (x >= x_max) return std::nullopt;
  return x;
}

std::optional<double> TorqueStudy::failing_payload(std::size_t i) const {
  InverseDynamics dynamics(model_);
  const auto need = [&](const JointVector& q, std::size_t number, double payload) {
    dynamics.set_payload(payload);
    const auto found = hardest(dynamics, i, q, number);
    return found ? found->share : kNever;
  };
  return first_failing(need, kPayloadMax);
}

std::optional<double> TorqueStudy::failing_payload_at_rest(std::size_t i) const {
  InverseDynamics dynamics(model_);
  const double holding = drives_[i].available(0);
  const auto need = [&](const JointVector& q, std::size_t, double payload) {
    dynamics.set_payload(payload);
    const auto parts = dynamics.parts(q);
    return parts ? std::abs(parts->weight[i]) / holding : kNever;
  };
  return first_failing(need, kPayloadMax);
}

std::optional<double> TorqueStudy::failing_acceleration(std::size_t i, double payload) const {
  const InverseDynamics dynamics(model_, payload);
  const auto need = [&](const JointVector& q, std::size_t, double acceleration) {
    const auto parts = dynamics.parts(q);
    if (!parts) return kNever;
    const double links = std::abs(parts->weight[i]) + parts->inertia[i][i] * acceleration;
    return share(i, {links, 0, acceleration});
  };
  return first_failing(need, kAccelerationMax);
}

std::optional<double> TorqueStudy::failing_reach(std::size_t i, double payload) const {
  const InverseDynamics dynamics(model_, payload);
  const auto nearest = search_.best([&](const JointVector& q, std::size_t number) {
    const auto found = hardest(dynamics, i, q, number);
    const auto p = dynamics.payload_point(q);
    if (!found || !p) return kNever;
    // Poses that do not fail lead the climb to those that do.
    return found->share > 1 ? -from_base_axis(*p) : found->share - 1 - kNotFailing;
  });
  if (nearest.score < -0.5 * kNotFailing) return std::nullopt;
  return -nearest.score;
}

double TorqueStudy::reach_max() const {
  const InverseDynamics dynamics(model_);
  return search_
      .best([&](const JointVector& q, std::size_t) {
        const auto p = dynamics.payload_point(q);
        return p ? from_base_axis(*p) : kNever;
      })
      .score;
}

}  // namespace sinew::planning
