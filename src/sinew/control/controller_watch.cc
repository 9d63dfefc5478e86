#include <algorithm>
#include <utility>

#include "sinew/control/controller.h"
#include "sinew/core/error_code.h"

namespace sinew::control {

void Controller::watch_time(Instant now) {
  const CycleWatch::Verdict verdict = watch_.look(now);
  if (!may_move(state_) || verdict == CycleWatch::Verdict::kFine) return;
  const double between = to_seconds(watch_.between());
  if (verdict == CycleWatch::Verdict::kGap) {
    return stop(StopCause::kClockGap,
                Error{ErrorCode::kClockGap, -1, between, to_seconds(watch_.gap())}, now);
  }
  if (state_ == MachineState::kStopping) return;
  stop(StopCause::kCycleOverrun,
       Error{ErrorCode::kCycleOverrun, -1, between, to_seconds(watch_.cycle())}, now);
}

void Controller::watch_lease(Instant now) {
  const auto holder = lease_.holder(now);
  if (holder || !had_holder_) {
    had_holder_ = holder.has_value();
    return;
  }
  had_holder_ = false;
  tell(ControlEvent::Kind::kLease);
  if (granted()) stop(StopCause::kLeaseEnded, Error{ErrorCode::kLeaseLost}, now);
}

void Controller::watch_journal(const Inputs& inputs, Instant now) {
  if (!journal_) return;
  const Error error{ErrorCode::kNotRecorded};
  const bool failed = inputs.journal_failed && state_ != MachineState::kFault;
  if (failed && !(latched_ && latched_->cause == StopCause::kNotRecorded)) {
    return stop(StopCause::kNotRecorded, error, now);
  }
  // A look waits for its record by itself, and moves nothing meanwhile.
  if (granted() && task_ && task_->begun && !driver_.looks() && journal_->overdue(now)) {
    stop(StopCause::kRecordLate, error, now);
  }
}

/// The runtime tells when it has lost the port; the driver is told here.
void Controller::watch_port(const Inputs& inputs, Instant now) {
  if (!inputs.port_open && driver_.state() != DriverState::kClosed) driver_.close(now);
}

void Controller::watch_driver(Instant now) {
  const DriverState driver = driver_.state();
  if (acknowledging_) return watch_acknowledging(now);
  if (state_ == MachineState::kOff || state_ == MachineState::kFault) return;
  if (driver == DriverState::kFault || driver == DriverState::kClosed) {
    if (stopping_ && latched_) return;
    const Error error = driver == DriverState::kClosed
                            ? Error{ErrorCode::kPortClosed}
                            : driver_.fault().value_or(Error{ErrorCode::kDeviceRefused});
    outstanding_ = 0;
    end_task(ControlEvent::Kind::kFailed, error);
    end_enabling(ControlEvent::Kind::kFailed, error);
    return stop(StopCause::kDevice, error, now);
  }
  if (driver == DriverState::kOpening && !may_move(state_) && state_ != MachineState::kEnabling) {
    end_task(ControlEvent::Kind::kStopped, {}, StopCause::kDevice);
    enabling_since_ = now;
    // What made it doubt was told just before.
    enabling_trouble_ = notice_.value_or(silence());
    change(Signal::kDoubt);
  }
  if (state_ != MachineState::kEnabling) return;
  if (driver == DriverState::kReady) return enabled();
  // A device that ends a motion of the run before is waited for.
  const Instant since =
      std::max(enabling_since_, driver_.goes_on_until().value_or(enabling_since_));
  if (now - since <= settings_.opening_limit) return;
  end_enabling(ControlEvent::Kind::kFailed, enabling_trouble_);
  stop(StopCause::kDevice, enabling_trouble_, now);
}

/// Closed before it is through, the device would keep its latch.
void Controller::watch_acknowledging(Instant now) {
  const Instant begun =
      std::max(acknowledging_->since, driver_.goes_on_until().value_or(Instant{}));
  const bool late = now - begun > 2 * settings_.opening_limit;
  const auto refused = late ? std::nullopt : clear_device(now);
  if (!late && !refused && device_being_told()) return;
  const std::uint32_t command = std::exchange(acknowledging_, std::nullopt)->command;
  const DriverState driver = driver_.state();
  const bool taken = driver != DriverState::kFault && driver != DriverState::kClosed;
  if (taken && !refused && !late) {
    acknowledged(now);
    return tell(ControlEvent::Kind::kDone, command);
  }
  tell(ControlEvent::Kind::kFailed, command, refused.value_or(driver_.fault().value_or(silence())));
}

void Controller::enabled() {
  driver_spoke_ = true;
  outstanding_ = 0;
  stand_where_driver_says(Setpoint::kKept);
  // Who has lost its joints has lost its jaws.
  if (!reference_known_) fit({});
  change(Signal::kEnabled);
  end_enabling(ControlEvent::Kind::kDone);
}

/// Of the command that asked for it; a doubt enables again without one.
void Controller::end_enabling(ControlEvent::Kind kind, const Error& error) {
  if (enabling_ != 0) tell(kind, enabling_, error);
  enabling_ = 0;
}

void Controller::take_events(Instant now) {
  // What does not fit is taken in the next cycle.
  constexpr std::size_t kRoom = 3 * Outputs::kEventsMax / 4;
  while (out_.events.size() + kRoom <= Outputs::kEventsMax) {
    const auto event = driver_.take_event();
    if (!event) return;
    take(*event, now);
  }
}

void Controller::take(const DriverEvent& event, Instant now) {
  using Kind = DriverEvent::Kind;
  switch (event.kind) {
    case Kind::kDone: {
      outstanding_ = std::max(0, outstanding_ - 1);
      sent_.ended();
      const bool whole = task_ && task_->begun && outstanding_ == 0;
      if (!whole || task_->kind != TaskKind::kTool) break;
      if (const auto& jaws = task_->jaws) {
        fit({driver_.health().jaws_width.value_or(jaws->width), jaws->held});
      } else if (task_->holds) {
        free_drive_ = false;
        // Motors that were switched on hold the arm where it came to rest.
        stand_where_driver_says(Setpoint::kForgotten);
      }
      end_task(ControlEvent::Kind::kDone);
      break;
    }
    case Kind::kStopped:
      outstanding_ = 0;
      if (stopping_) stopping_->told = true;
      if (task_ && task_->kind == TaskKind::kTool) {
        end_task(ControlEvent::Kind::kStopped, {}, last_stop_.value_or(StopCause::kClient));
      }
      break;
    case Kind::kFailed:
      return failed(event.error, now);
    case Kind::kNotice:
      tell(ControlEvent::Kind::kNotice, 0, event.error);
      notice_ = event.error;
      if (state_ == MachineState::kEnabling) enabling_trouble_ = event.error;
      break;
    case Kind::kReady:
      break;
  }
}

/// A command of ours was not carried out, or nobody knows.
void Controller::failed(const Error& error, Instant now) {
  if (state_ == MachineState::kEnabling) {
    if (error.code != ErrorCode::kDeviceSilent) enabling_trouble_ = error;
    return;
  }
  outstanding_ = 0;
  const bool moving = may_move(state_);
  end_task(ControlEvent::Kind::kFailed, error);
  const ErrorInfo& what = info(error.code);
  const bool serious = driver_.state() == DriverState::kFault || what.stop != StopCategory::kNone ||
                       !what.position_survives;
  if (moving || serious) stop(serious ? StopCause::kDevice : StopCause::kRefused, error, now);
}

}  // namespace sinew::control
