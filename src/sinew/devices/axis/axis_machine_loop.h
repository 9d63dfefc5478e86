#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/devices/axis/axis_device_encoders.h"
#include "sinew/devices/axis/axis_device_settings.h"
#include "sinew/devices/axis/axis_machine_plant.h"
#include "sinew/model/robot_model.h"
#include "sinew/motion/cascade.h"
#include "sinew/motion/online_profile.h"
#include "sinew/sim/arm_load.h"

namespace sinew::sim {

/// The control loop of one axis and nothing around it: encoders, Cascade and steps as its
/// controller has them, on the axis with the arm's load. It takes any reference, jumps included,
/// which a controller refuses for good reasons; that is how a loop is tried out.
class AxisLoop {
 public:
  /// @param pose     rad, of all joints; the others stay there, this one begins there, or as near
  ///                 as its motor has a place of rest
  /// @param payload  kg at the tool
  AxisLoop(const RobotModel& model, std::size_t joint, const AxisSettings& settings,
           const JointVector& pose, double payload, std::uint64_t seed);

  static constexpr double kTick = 1e-3;  ///< s, as the controllers run

  /// One cycle towards the reference.
  void tick(const motion::AxisState& reference);

  double q() const { return plant_.q(); }              ///< the joint itself, rad
  double q_measured() const { return encoders_.q(); }  ///< as the motor's encoder has it
  std::int64_t steps() const { return outputs_.steps; }
  double load_torque() const { return load_.torque(joint_); }    ///< Nm, of weight
  double load_inertia() const { return load_.inertia(joint_); }  ///< kg m^2
  bool stalled() const { return plant_.stalled(); }

 private:
  void carry_load();

  AxisSettings settings_;
  std::size_t joint_;
  JointVector pose_;
  ArmLoad load_;
  AxisPlant plant_;
  AxisEncoders encoders_;
  motion::Cascade cascade_;
  AxisOutputs outputs_;
  double steps_ = 0;
};

/// What is tried on a loop.
struct LoopTrial {
  JointVector pose;    ///< rad, where it begins
  double payload = 0;  ///< kg
  std::uint64_t seed = 1;
  double step = from_deg(2);  ///< of the reference, either sign
  double seconds = 3;         ///< after the step, or after the end of the move
  bool feed_forward = true;
};

/// What came of it, one entry a tick.
struct LoopRecord {
  std::vector<double> t;          ///< s
  std::vector<double> reference;  ///< rad
  std::vector<double> q;          ///< rad, the joint itself
  std::vector<double> measured;   ///< rad, by the motor's encoder
  double load_torque = 0;         ///< Nm of weight at the start
  double load_inertia = 0;        ///< kg m^2
  bool stalled = false;
};

/// The reference jumps by `step`.
LoopRecord step_trial(const RobotModel& model, std::size_t joint, const AxisSettings& settings,
                      const LoopTrial& trial);
/// A jerk-limited move by `step` with the joint's limits, half a second of rest, and back.
LoopRecord tracking_trial(const RobotModel& model, std::size_t joint, const AxisSettings& settings,
                          const LoopTrial& trial);

/// The numbers of a step response, of the joint itself.
struct StepFigures {
  double rise = 0;       ///< s, from a tenth to nine tenths of the step
  double overshoot = 0;  ///< rad beyond the reference, 0 where it never is
  double settling = 0;   ///< s, until it stays within `band` of where it ends
  double steady = 0;     ///< rad between reference and where it ends
  double ripple = 0;     ///< rad, peak to peak in the last half second, of joint or motor
};
StepFigures step_figures(const LoopRecord& record, double band = from_deg(0.05));

/// Greatest distance between reference and joint, rad.
double tracking_error(const LoopRecord& record);

}  // namespace sinew::sim
