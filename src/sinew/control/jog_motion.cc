#include "sinew/control/jog_motion.h"

#include <algorithm>
#include <array>

#include "sinew/core/error_code.h"

namespace sinew::control {

JogMotion::JogMotion(const RobotModel& robot)
    : jog_(robot), segment_(robot.device.capability.segment) {}

std::optional<Error> JogMotion::start(const JointVector& q, Instant now) {
  std::array<motion::AxisState, kMaxJoints> states{};
  for (std::size_t j = 0; j < q.size(); ++j) states[j].q = q[j];
  if (const auto error = jog_.start({states.data(), q.size()}, now)) return error;
  q_start_ = q;
  at_ = now_ = alive_until_ = now;
  begun_ = made_ = false;
  return {};
}

std::optional<Error> JogMotion::command(const planning::JogCommand& command, Instant now) {
  // Nothing was made while it stood: its time goes on with the clock's.
  if (jog_.at_rest() && !made_ && now > at_) {
    if (const auto error = jog_.step(now)) return error;
    at_ = now;
  }
  const Instant from = std::max(now, at_);
  if (const auto error = jog_.command(command, from)) return error;
  const bool stands = std::ranges::all_of(command.velocity, [](double v) { return v == 0; });
  alive_until_ = stands ? now : from + command.expiry;
  return {};
}

const JointMove* JogMotion::next(Instant now) {
  now_ = now;
  if (made_) return &piece_;
  const bool stood = jog_.at_rest();
  if (stood && (now >= alive_until_ || at_ > now)) return nullptr;
  // The jog's time is that of its segments: a cycle that is late makes no gap.
  const Instant end = at_ + segment_;
  while (at_ < end) {
    at_ = std::min(end, at_ + planning::Jog::kStep);
    if (jog_.step(at_)) return nullptr;
  }
  const bool rests = jog_.at_rest();
  if (stood && rests) return nullptr;  // something is in the way
  const motion::AxisStates& states = jog_.setpoint();
  piece_ = {.q = {}, .qd = {}, .duration = segment_};
  for (std::size_t j = 0; j < q_start_.size(); ++j) {
    piece_.q.push_back(states.q[j]);
    piece_.qd.push_back(rests ? 0 : states.qd[j]);
  }
  if (!begun_) piece_.q_start = q_start_;
  begun_ = made_ = true;
  return &piece_;
}

Expected<void> JogMotion::set_feed(double /*share*/) {
  return std::unexpected(Error{ErrorCode::kTaskNotSupported});
}

void JogMotion::hold() {
  jog_.stop();
  alive_until_ = now_;
}

}  // namespace sinew::control
