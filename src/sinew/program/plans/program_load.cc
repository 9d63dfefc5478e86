#include "sinew/program/plans/program_load.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/model/joint_lookup.h"

namespace sinew::program {
namespace {

constexpr double kPeriod = 5e-3;  // s
constexpr double kLooksMax = 500'000;
constexpr double kLeast = 1e-12;

class Meter {
 public:
  Meter(const planning::InverseDynamics& dynamics, std::span<const planning::DriveTrain> drives)
      : dynamics_(dynamics), drives_(drives), loads_(drives.size()), squares_(drives.size(), 0.0) {}

  /// One look that stands for `dt` seconds.
  std::optional<Error> look(std::span<const double> q, const kinematics::JointMotion& motion,
                            int line, double time, double dt) {
    const auto torque = dynamics_.torque(q, motion);
    if (!torque) return torque.error();
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      const double demand = drives_[i].demand({(*torque)[i], motion.qd[i], motion.qdd[i]});
      const double available = std::max(drives_[i].available(motion.qd[i]), kLeast);
      squares_[i] += demand * demand * dt;
      JointLoad& load = loads_[i];
      const bool first = load.line == 0;
      if (!first && demand * load.available <= load.peak * available) continue;
      load.peak = demand;
      load.available = available;
      load.line = line;
      load.time = time;
    }
    seconds_ += dt;
    return std::nullopt;
  }

  /// All of a motion that begins at `time`.
  std::optional<Error> look_along(const planning::PlannedMotion& motion, int line, double time,
                                  double period) {
    if (motion.empty()) return std::nullopt;
    const planning::Trajectory trajectory = motion.trajectory();
    const std::size_t n = drives_.size();
    const double looks = std::max(1.0, std::ceil(trajectory.duration() / period));
    planning::JointMotion at;
    for (double k = 0; k <= looks; ++k) {
      const double t = trajectory.duration() * k / looks;
      trajectory.sample(t, at);
      // Trapezoidal weights: both ends stand for half of what the others do.
      const double share = k == 0 || k == looks ? 0.5 : 1;
      if (const auto error = look({at.q.data(), n}, {{at.qd.data(), n}, {at.qdd.data(), n}}, line,
                                  time + t, share * trajectory.duration() / looks)) {
        return error;
      }
    }
    return std::nullopt;
  }

  std::vector<JointLoad> loads() const {
    std::vector<JointLoad> loads = loads_;
    for (std::size_t i = 0; i < loads.size(); ++i) {
      if (seconds_ > 0) loads[i].rms = std::sqrt(squares_[i] / seconds_);
    }
    return loads;
  }

 private:
  const planning::InverseDynamics& dynamics_;
  std::span<const planning::DriveTrain> drives_;
  std::vector<JointLoad> loads_;
  std::vector<double> squares_;
  double seconds_ = 0;
};

}  // namespace

std::expected<std::vector<JointLoad>, Refusal> load_of(
    const Plan& plan, const RobotModel& robot, const planning::InverseDynamics& dynamics,
    std::span<const planning::DriveTrain> drives) {
  const std::size_t n = robot.joints.size();
  SINEW_ASSERT(drives.size() == n);
  const double period = std::max(kPeriod, plan.duration / kLooksMax);
  Meter meter(dynamics, drives);
  RowPlanner planner(robot);
  JointVector q = home_joints(robot), still;
  still.resize(n);
  double start = 0;
  for (const Order& order : plan.orders) {
    std::optional<Error> error;
    if (const auto* move = std::get_if<MoveOrder>(&order.what)) {
      SINEW_ASSERT(move->q_start.has_value());
      if (move->first_move) {
        // Nobody knows how it goes.
        start += move->duration;
        q = move->q;
        continue;
      }
      JointVector at = *move->q_start;
      for (std::span<const Step> rows = move->rows; !rows.empty() && !error;) {
        const auto motion = planner.plan(at, move->tool, rows);
        if (!motion) return std::unexpected(motion.error());
        error = meter.look_along(planner.motion(), order.line, start, period);
        start += planner.motion().law.duration();
        rows = rows.subspan(motion->rows);
        at = motion->q_end;
      }
      q = move->q;
    } else if (const auto* wait = std::get_if<WaitOrder>(&order.what)) {
      const double seconds = to_seconds(wait->duration);
      error = meter.look(q, {still, still}, order.line, start, seconds);
      start += seconds;
    } else if (std::holds_alternative<HomeOrder>(order.what)) {
      q = home_joints(robot);
    }
    if (error) return std::unexpected(Refusal{order.line, *error, std::nullopt});
  }
  return meter.loads();
}

}  // namespace sinew::program
