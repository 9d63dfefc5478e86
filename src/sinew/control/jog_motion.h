#pragma once

#include <optional>

#include "sinew/control/motion_source.h"
#include "sinew/model/robot_model.h"
#include "sinew/planning/jog/jog.h"

namespace sinew::control {

/// A jog, segment by segment, until nobody commands it any more and it rests. Where something is in
/// its way it stands there and waits for another command. Only for devices that stream.
class JogMotion final : public MotionSource {
 public:
  /// @param robot  outlives this. Allocates.
  explicit JogMotion(const RobotModel& robot);
  /// At rest.
  void fit(const ToolState& tool) { jog_.fit(tool); }

  /// At rest there. @error as Jog::start
  std::optional<Error> start(const JointVector& q, Instant now);
  /// Counts from the next segment on that is not handed over yet, and so long as it says.
  /// @error as Jog::command; what was commanded before then goes on.
  std::optional<Error> command(const planning::JogCommand& command, Instant now);
  void surround(std::span<const planning::Surrounding> bodies) { jog_.surround(bodies); }
  /// Where it was sent last, and how fast.
  const motion::AxisStates& setpoint() const { return jog_.setpoint(); }
  planning::JogStatus status() const { return jog_.status(); }

  const JointVector& q_start() const override { return q_start_; }
  const JointMove* next(Instant now) override;
  void taken() override { made_ = false; }
  bool finished() const override { return !made_ && jog_.at_rest() && now_ >= alive_until_; }
  void hold() override;
  void resume() override {}
  Expected<void> set_feed(double share) override;
  double progress() const override { return 0; }
  double time_left() const override { return 0; }

 private:
  planning::Jog jog_;
  Duration segment_;
  JointVector q_start_;
  Instant at_{};           ///< of the setpoint that was made last
  Instant now_{};          ///< of the last cycle
  Instant alive_until_{};  ///< a command counts until then
  bool begun_ = false;     ///< something was handed over since start()
  bool made_ = false;
  JointMove piece_;
};

}  // namespace sinew::control
