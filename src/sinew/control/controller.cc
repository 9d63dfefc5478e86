#include "sinew/control/controller.h"

#include <algorithm>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/model/left_out.h"
#include "sinew/planning/paths/motion_limits.h"

namespace sinew::control {

Controller::Controller(const RobotModel& robot, Driver& driver, const ControllerSettings& settings,
                       const ControllerStart& start)
    : robot_(robot),
      driver_(driver),
      settings_(settings),
      governor_(robot, planning::farthest_limits(robot)),
      lease_(settings.lease_life),
      watch_(settings.cycle, settings.gap),
      sent_(planning::motion_limits(robot), robot.device.settings->stop_facts().together),
      jog_(robot),
      streams_(robot.device.capability.motion == MotionKind::kStream),
      memory_(start.memory),
      positions_(start.positions) {
  positions_.resize(robot.joints.size());
  recorded_ = positions_;
  if (!settings.journal) return;
  journal_.emplace(*settings.journal, start.journal_end);
  journal_->device_says(memory_.held_by_stop, memory_.counted);
}

const Outputs& Controller::step(const Inputs& inputs, Instant now) {
  SINEW_ASSERT(inputs.commands.size() <= kCommandsMax);
  out_.events.clear();
  out_.records.clear();
  notice_.reset();
  wall_ns_ = inputs.wall_ns;
  if (journal_) {
    if (!opened_) offer(journal_->open({positions_.data(), positions_.size()}, time(now)));
    opened_ = true;
    journal_->durable(inputs.durable_sequence);
    if (driver_spoke_) journal_->device_says(driver_.held_by_stop(), driver_.counters_moved());
  }
  watch_time(now);
  take_events(now);
  watch_port(inputs, now);
  watch_driver(now);
  // Free joints are where a hand, or their weight, takes them.
  if (state_ == MachineState::kReady && !task_ && driver_.free()) {
    stand_where_driver_says(Setpoint::kForgotten);
  }
  for (const Command& command : inputs.commands) handle(command, inputs, now);
  watch_lease(now);
  watch_journal(inputs, now);
  advance(now);
  settle(now);
  record_rest(now);
  if (inputs.closing) record_end(now);
  if (journal_) driver_.allow_looks(journal_->may_look());
  return out_;
}

std::span<const JointPosition> Controller::positions() const {
  if (driver_spoke_) return driver_.positions();
  return {positions_.data(), positions_.size()};
}

std::optional<JointVector> Controller::reference() const {
  if (!reference_known_ || !driver_knows()) return std::nullopt;
  return reference_;
}

std::optional<JointVector> Controller::commanded() const {
  if (!governor_.known()) return std::nullopt;
  return JointVector(governor_.q());
}

Error Controller::silence() const {
  return {ErrorCode::kDeviceSilent, -1, 0, to_seconds(settings_.opening_limit)};
}

double Controller::progress() const {
  return task_ && task_->motion != nullptr ? task_->motion->progress() : 0;
}

void Controller::tell(ControlEvent::Kind kind, std::uint32_t command, const Error& error,
                      StopCause cause, const LeaseToken& lease) {
  if (!out_.events.full()) out_.events.push_back({kind, command, state_, cause, error, lease});
}

void Controller::change(Signal signal) {
  const auto next = next_state(state_, signal);
  if (!next || *next == state_) return;
  state_ = *next;
  tell(ControlEvent::Kind::kState);
}

void Controller::latch(StopCause cause, const Error& error) {
  if (latched_ && latched_->cause == cause && latched_->error.code == error.code) return;
  const auto same = [&](const Latched& one) {
    return one.cause == cause && one.error.code == error.code;
  };
  if (std::ranges::any_of(later_, same)) return;
  if (!latched_) {
    latched_ = Latched{cause, error};
  } else if (!later_.full()) {
    later_.push_back({cause, error});
  }
  tell(ControlEvent::Kind::kLatched, 0, error, cause);
}

void Controller::end_task(ControlEvent::Kind kind, const std::optional<Error>& error,
                          StopCause cause) {
  if (!task_) return;
  const std::uint32_t command = task_->command;
  task_.reset();
  waiting_since_.reset();
  position_given_up_ = false;
  tell(kind, command, error.value_or(Error{}), cause);
}

/// Whatever it does, it comes to rest, and what follows is in the rule of the cause.
void Controller::stop(StopCause cause, const std::optional<Error>& error, Instant now) {
  const StopRule& rule = stop_rule(cause);
  last_stop_ = cause;
  if (rule.after == StopAfter::kFault) latch(cause, error.value_or(Error{}));
  tell(ControlEvent::Kind::kStop, 0, error.value_or(Error{}), cause);
  if (!may_move(state_)) {
    // A tool at work, or a machine that goes on although nobody moves it.
    if (rule.manner == StopManner::kDevice) driver_.stop(now);
    if (state_ == MachineState::kHeld && rule.after != StopAfter::kHeld) {
      end_task(ControlEvent::Kind::kStopped, {}, cause);
      change(rule.after == StopAfter::kFault ? Signal::kFault : Signal::kStop);
    } else if (rule.after == StopAfter::kFault) {
      change(Signal::kFault);
    }
    return;
  }
  if (!stopping_) stopping_ = Stopping{.cause = cause, .after = rule.after, .since = now};
  // A fault is not taken back, and who only wanted a pause is overruled.
  if (rule.after == StopAfter::kFault || stopping_->after == StopAfter::kHeld) {
    stopping_->after = rule.after;
    stopping_->cause = cause;
  }
  const bool can_brake =
      task_ && (task_->kind == TaskKind::kMotion || task_->kind == TaskKind::kJog);
  if (rule.manner == StopManner::kOnPath && can_brake && !stopping_->by_device) {
    task_->motion->hold();
  } else {
    stop_device(now);
  }
  // A search or a small step cannot be gone on with: there is nothing to hold.
  const bool holds = rule.after == StopAfter::kHeld && state_ != MachineState::kRecovering;
  change(holds ? Signal::kHold : Signal::kStop);
}

void Controller::stop_device(Instant now) {
  if (stopping_->by_device) return;
  stopping_->by_device = true;
  stopping_->since = now;
  driver_.stop(now);
}

/// Nothing is under way, and nothing goes on by itself.
bool Controller::standing(Instant now) const {
  const DriverState state = driver_.state();
  if (outstanding_ > 0 || state == DriverState::kMoving || state == DriverState::kStopping) {
    return false;
  }
  const auto until = driver_.goes_on_until();
  return !until || *until <= now;
}

/// Of a joint that is left out nobody asks.
bool Controller::driver_knows() const {
  if (!driver_spoke_) return false;
  const auto positions = driver_.positions();
  for (std::size_t j = 0; j < positions.size(); ++j) {
    if (positions[j].quality < PositionQuality::kCommanded && !is_left_out(robot_, j)) return false;
  }
  return true;
}

void Controller::stand_where_driver_says(Setpoint setpoint) {
  const bool had_setpoint = reference_known_ && setpoint == Setpoint::kKept;
  reference_known_ = driver_knows();
  if (!reference_known_) return governor_.lose();
  bool at_setpoint = had_setpoint;
  for (std::size_t j = 0; at_setpoint && j < reference_.size(); ++j) {
    const JointPosition& joint = driver_.positions()[j];
    if (is_left_out(robot_, j)) continue;
    const double sag = joint.quality == PositionQuality::kMeasured ? kSag : 0;
    at_setpoint = joint.lower - sag <= reference_[j] && reference_[j] <= joint.upper + sag;
  }
  if (!at_setpoint) {
    reference_.clear();
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      reference_.push_back(is_left_out(robot_, j) ? assumed_place(robot_.joints[j])
                                                  : driver_.positions()[j].q);
    }
  }
  stand_at_reference();
}

void Controller::stand_at_setpoint() {
  if (!driver_knows() || !governor_.known()) return stand_where_driver_says(Setpoint::kForgotten);
  reference_ = JointVector(governor_.q());
  reference_known_ = true;
  stand_at_reference();
}

void Controller::stand_at_reference() {
  const std::span<const double> q(reference_.data(), reference_.size());
  governor_.rest(q);
  sent_.rest(q);
}

void Controller::fit(const ToolState& tool) {
  if (tool == tool_) return;
  tool_ = tool;
  governor_.fit(tool);
  jog_.fit(tool);
}

void Controller::settle(Instant now) {
  if (state_ != MachineState::kStopping || !stopping_) return;
  if (stopping_->by_device) {
    const DriverState driver = driver_.state();
    const bool gone = driver == DriverState::kClosed || driver == DriverState::kFault;
    if (gone) outstanding_ = 0;
    // Whoever asked for the motion need not wait for a machine that goes on by itself.
    if (stopping_->told && driver_.goes_on_until()) {
      end_task(ControlEvent::Kind::kStopped, {}, stopping_->cause);
    }
    if (standing(now) && (stopping_->told || gone)) return rested();
    const auto until = driver_.goes_on_until();
    const Instant from = until ? std::max(*until, stopping_->since) : stopping_->since;
    if (now - from <= settings_.stop_limit) return;
    const double waited = to_seconds(now - from);
    latch(StopCause::kDevice,
          {ErrorCode::kDeviceSilent, -1, waited, to_seconds(settings_.stop_limit)});
    outstanding_ = 0;
    return rested();
  }
  const bool braked = !task_ || task_->motion == nullptr || task_->motion->next(now) == nullptr;
  if (braked && standing(now)) rested();
}

void Controller::rested() {
  const Stopping how = *stopping_;
  stopping_.reset();
  const bool finished = task_ && task_->motion != nullptr && task_->motion->finished();
  const bool resumable =
      task_ && task_->kind == TaskKind::kMotion && !finished && !how.by_device && !latched_;
  if (how.by_device) {
    stand_where_driver_says(Setpoint::kForgotten);
  } else {
    stand_at_setpoint();
  }
  if (how.after == StopAfter::kHeld && resumable) return change(Signal::kRestedHeld);
  if (finished && !how.by_device) {
    end_task(ControlEvent::Kind::kDone);
  } else {
    end_task(ControlEvent::Kind::kStopped, {}, how.cause);
  }
  change(latched_ ? Signal::kRestedFault : Signal::kRested);
}

}  // namespace sinew::control
