#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "sinew/planning/studies/drive_train.h"
#include "sinew/planning/studies/inverse_dynamics.h"
#include "sinew/planning/studies/pose_search.h"

namespace sinew::planning {

/// What one joint needs at its worst, and what it has. Nm at the joint (N at a leg), motors counted
/// as DriveTrain does.
struct JointNeed {
  double weight = 0;     ///< of links and payload at rest, at its largest
  JointVector q_weight;  ///< there
  double demand = 0;     ///< moving, where it is the largest share of what the motors give
  double available = 0;  ///< what they give at the speed that the joint has then
  JointVector q_demand;  ///< there
  JointDuty duty;        ///< there: links and payload, without friction and rotors
  double holding = 0;    ///< what the motors give at rest
  std::optional<RatioAnswer> ratio;               ///< that just does; nothing for a servo
  std::optional<RatioAnswer> ratio_with_reserve;  ///< with kTorqueReserve

  double margin() const { return available / demand; }
};

/// A stepper that runs without feedback is planned with half of its holding torque: what is left
/// is for ripple, resonance and hot windings. Usual in motor makers' guides.
inline constexpr double kTorqueReserve = 2;

/// Torque over a robot's whole workspace: largest needs, and where they first become too much.
/// Poses come from PoseSearch, so the same question has the same answer. "Moving" is the ramp from
/// rest to top speed under the file's limits, with all joints in the same phase of theirs, each in
/// the way that is worst for the one that is asked about.
class TorqueStudy {
 public:
  /// @param model          with a drive or a servo for every joint
  /// @param step_rate_max  microsteps a second that the boards can make; 0 where nobody knows
  TorqueStudy(const RobotModel& model, double step_rate_max);

  std::size_t size() const { return drives_.size(); }
  const DriveTrain& drive(std::size_t i) const { return drives_[i]; }

  /// What joint i needs with this payload (kg).
  JointNeed need(std::size_t i, double payload) const;

  /// Smallest payload (kg) with which joint i needs more than its motors give, moving as the file
  /// allows; nothing where a thousand kg do not make it so.
  std::optional<double> failing_payload(std::size_t i) const;

  /// The same at rest: the largest weight is more than the motors hold, gear losses not counted as
  /// help.
  std::optional<double> failing_payload_at_rest(std::size_t i) const;

  /// Smallest acceleration (rad/s^2) of joint i alone, from rest, with which it fails; 0 where it
  /// cannot even start, nothing where no acceleration fails.
  std::optional<double> failing_acceleration(std::size_t i, double payload) const;

  /// Smallest distance (m) of the payload from the base's axis at which joint i fails, moving as
  /// the file allows; nothing where it never does.
  std::optional<double> failing_reach(std::size_t i, double payload) const;

  /// Largest distance of the payload from the base's axis, m.
  double reach_max() const;

 private:
  /// The hardest motion at one pose that the file's limits allow.
  struct Hardest {
    JointDuty duty;
    double share = 0;  ///< of what the motors give at that speed
  };
  using Duties = FixedVector<JointDuty, 3>;  ///< along the ramp
  Duties duties(const InverseDynamics& dynamics, std::size_t i, const JointVector& q,
                std::size_t number) const;
  std::optional<Hardest> hardest(const InverseDynamics& dynamics, std::size_t i,
                                 const JointVector& q, std::size_t number) const;
  std::optional<RatioAnswer> ratio_for(std::size_t i, const Duties& duties, double reserve) const;
  double share(std::size_t i, const JointDuty& duty) const;

  /// The share of its torque that a joint needs at one pose, which grows with x; minus infinity
  /// where the pose does not count.
  using Need = std::function<double(const JointVector& q, std::size_t number, double x)>;
  /// The smallest x at which it is above 1 somewhere.
  std::optional<double> first_failing(const Need& need, double x_max) const;

  RobotModel model_;
  double step_rate_max_;
  std::vector<DriveTrain> drives_;
  PoseSearch search_;
};

}  // namespace sinew::planning
