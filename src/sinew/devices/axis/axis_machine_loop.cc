#include "sinew/devices/axis/axis_machine_loop.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/devices/axis/axis_machine.h"
#include "sinew/motion/rest_to_rest.h"

namespace sinew::sim {
namespace {

constexpr double kLoadResolution = from_deg(0.1);
constexpr double kPowerUp = 0.3;     // s: the rotor snaps to its place and comes to rest
constexpr double kQuiet = 0.7;       // s in the loop before anything is tried
constexpr double kDwell = 0.5;       // s between there and back
constexpr double kRippleTime = 0.5;  // s

int ticks(double seconds) {
  return static_cast<int>(std::lround(seconds / AxisLoop::kTick));
}

/// Ticks a loop and writes down what happens.
class Recorder {
 public:
  Recorder(const RobotModel& model, std::size_t joint, const AxisSettings& settings,
           const LoopTrial& trial)
      : start_(trial.pose[joint]),
        loop_(model, joint, settings, trial.pose, trial.payload, trial.seed) {
    for (int i = ticks(kQuiet); i > 0; --i) loop_.tick({start_, 0, 0});
    record_.load_torque = loop_.load_torque();
    record_.load_inertia = loop_.load_inertia();
  }
  void tick(const motion::AxisState& reference) {
    loop_.tick(reference);
    record_.t.push_back(AxisLoop::kTick * static_cast<double>(record_.t.size() + 1));
    record_.reference.push_back(reference.q);
    record_.q.push_back(loop_.q());
    record_.measured.push_back(loop_.q_measured());
  }
  double start() const { return start_; }
  LoopRecord finish() {
    record_.stalled = loop_.stalled();
    return std::move(record_);
  }

 private:
  double start_;
  AxisLoop loop_;
  LoopRecord record_;
};

/// The nearest place where a power stage that comes on leaves the rotor: within 0.2 deg of the
/// joint.
double powered_place(const AxisSettings& settings, double q) {
  const double place = 4 * 2 * kPi / settings.full_steps_per_turn / settings.gear_ratio;
  return std::round(q / place) * place;
}

AxisSettings with_feed_forward(AxisSettings settings, bool feed_forward) {
  if (!feed_forward) settings.cascade.feed_forward = 0;
  return settings;
}

}  // namespace

AxisLoop::AxisLoop(const RobotModel& model, std::size_t joint, const AxisSettings& settings,
                   const JointVector& pose, double payload, std::uint64_t seed)
    : settings_(settings),
      joint_(joint),
      pose_(pose),
      load_(std::get<SerialGeometry>(model.geometry), model.dynamics),
      plant_(axis_plant_settings(model, joint, settings), powered_place(settings, pose[joint]),
             seed),
      encoders_(settings.encoders),
      cascade_(settings.cascade) {
  SINEW_ASSERT(joint < pose.size() && pose.size() == model.joints.size());
  load_.set_payload(payload);
  load_.update({pose_.data(), pose_.size()});
  plant_.set_load(load_.torque(joint_), load_.inertia(joint_));
  outputs_.enabled = true;
  for (int i = ticks(kPowerUp); i > 0; --i) {
    plant_.advance(outputs_, kTick);
    encoders_.read(plant_.inputs(), kTick);
  }
  // As after homing, but for the half of the play that homing may be off by.
  encoders_.mark();
  encoders_.name_mark(plant_.q(), plant_.motor_angle() / settings_.gear_ratio);
}

void AxisLoop::carry_load() {
  if (std::abs(plant_.q() - pose_[joint_]) < kLoadResolution) return;
  pose_[joint_] = plant_.q();
  load_.update({pose_.data(), pose_.size()});
  plant_.set_load(load_.torque(joint_), load_.inertia(joint_));
}

void AxisLoop::tick(const motion::AxisState& reference) {
  carry_load();
  plant_.advance(outputs_, kTick);
  encoders_.read(plant_.inputs(), kTick);
  const double rate =
      cascade_.rate(reference.q, reference.qd, encoders_.q(), encoders_.qd(), kTick);
  steps_ += rate * kTick * settings_.steps_per_rad();
  outputs_.steps = std::llround(steps_);
}

LoopRecord step_trial(const RobotModel& model, std::size_t joint, const AxisSettings& settings,
                      const LoopTrial& trial) {
  Recorder recorder(model, joint, with_feed_forward(settings, trial.feed_forward), trial);
  for (int i = ticks(trial.seconds); i > 0; --i) {
    recorder.tick({recorder.start() + trial.step, 0, 0});
  }
  return recorder.finish();
}

LoopRecord tracking_trial(const RobotModel& model, std::size_t joint, const AxisSettings& settings,
                          const LoopTrial& trial) {
  Recorder recorder(model, joint, with_feed_forward(settings, trial.feed_forward), trial);
  double from = recorder.start();
  for (const double to : {from + trial.step, from}) {
    const motion::RestToRest move({&from, 1}, {&to, 1}, {&settings.limits, 1});
    motion::AxisStates state;
    for (int i = 1; i <= ticks(move.duration() + kDwell); ++i) {
      move.sample(i * AxisLoop::kTick, state);
      recorder.tick({state.q[0], state.qd[0], state.qdd[0]});
    }
    from = to;
  }
  for (int i = ticks(trial.seconds); i > 0; --i) recorder.tick({from, 0, 0});
  return recorder.finish();
}

StepFigures step_figures(const LoopRecord& record, double band) {
  SINEW_ASSERT(!record.q.empty() && record.measured.size() == record.q.size());
  StepFigures figures;
  const double target = record.reference.back();
  const double from = record.q.front();
  const double way = target - from;
  const auto share = [&](double q) { return (q - from) / way; };
  const std::size_t size = record.q.size();
  const auto first_above = [&](double level) {
    std::size_t i = 0;
    while (i + 1 < size && share(record.q[i]) < level) ++i;
    return record.t[i];
  };
  figures.rise = first_above(0.9) - first_above(0.1);
  const auto tail = std::min(size, static_cast<std::size_t>(ticks(kRippleTime)));
  const auto last =
      std::minmax_element(record.q.end() - static_cast<std::ptrdiff_t>(tail), record.q.end());
  const double end = (*last.first + *last.second) / 2;
  // The motor may hunt inside the play, where the joint does not show it.
  const auto motor = std::minmax_element(record.measured.end() - static_cast<std::ptrdiff_t>(tail),
                                         record.measured.end());
  figures.ripple = std::max(*last.second - *last.first, *motor.second - *motor.first);
  figures.steady = std::abs(end - target);
  for (std::size_t i = 0; i < size; ++i) {
    figures.overshoot =
        std::max(figures.overshoot, std::copysign(1.0, way) * (record.q[i] - target));
    if (std::abs(record.q[i] - end) > band) figures.settling = record.t[i];
  }
  return figures;
}

double tracking_error(const LoopRecord& record) {
  double worst = 0;
  for (std::size_t i = 0; i < record.q.size(); ++i) {
    worst = std::max(worst, std::abs(record.q[i] - record.reference[i]));
  }
  return worst;
}

}  // namespace sinew::sim
