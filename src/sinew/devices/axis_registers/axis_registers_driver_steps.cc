#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis_registers/axis_registers_driver.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"

// What one axis is asked, and what its answers mean.

namespace sinew {

using namespace axis_registers;

namespace {

/// Homing may end a little beyond a limit.
constexpr double kBeyondLimits = from_deg(1);
/// Within it every board that was seen to move has been asked once more.
constexpr Duration kAskedAgain = std::chrono::seconds(1);

}  // namespace

void AxisRegistersDriver::ask(std::size_t i, Instant now) {
  Axis& axis = axes_[i];
  // What is claimed of the position must hold from the moment when an order may arrive.
  if (axis.phase == Phase::kWrite) stretch_to_target(i);
  if (axis.phase == Phase::kHome) {
    axis.homing = true;
    set_lost(i);
  }
  asked_ = Asked{i, axis.phase, request_for(i)};
  link_.start(asked_->request, now);
}

AxisRegisterRequest AxisRegistersDriver::request_for(std::size_t i) const {
  const Axis& axis = axes_[i];
  const AxisRegisterMap& map = device_.registers;
  AxisRegisterRequest request;
  request.select = static_cast<std::uint8_t>(1U << i);
  request.tries = axis.answers || activity_ == Activity::kOpening ? timing_.link.tries : 1;
  const auto write = [&](std::uint16_t address, const Data& data) {
    request.operation = Operation::kWrite;
    request.address = address;
    request.size = static_cast<std::uint16_t>(data.size());
    request.data = data;
    return request;
  };
  const auto read = [&](std::uint16_t address, std::uint16_t size) {
    request.address = address;
    request.size = size;
    return request;
  };
  switch (axis.phase) {
    case Phase::kClear:
      return write(map.diag_control, {kClearFaults});
    case Phase::kStop:
      return write(map.emergency_stop, {kOn});
    case Phase::kCancel:
      return write(map.homing, {kOff});
    case Phase::kRelease:
      return write(map.emergency_stop, {kOff});
    case Phase::kHome:
      return write(map.homing, {kOn});
    case Phase::kWrite:
      return write(map.move_angle, Data(axis.target.bytes));
    case Phase::kTest:
      return write(map.diag_control, {kRunSelfTest});
    case Phase::kPollHoming:
      return read(map.homing, 1);
    case Phase::kBefore:
    case Phase::kReadBack:
      return read(map.move_angle, 4);
    case Phase::kPoll:
    case Phase::kVerify:
    case Phase::kFind:
    case Phase::kDone:
      break;
  }
  // The first firmware reads a register of four bytes wrong, and has a status that says nothing.
  if (device_.reports_status) return read(map.diag_status, 4);
  return read(map.emergency_stop, 1);
}

void AxisRegistersDriver::take(const AxisRegisterOutcome& outcome, Instant now) {
  if (!asked_) return;  // a broadcast: its boards are asked one by one
  const Asked asked = *asked_;
  asked_.reset();
  if (activity_ == Activity::kIdle) watch_at_ = now + timing_.watch;
  if (outcome.error) return axis_fails(asked.axis, *outcome.error, now);
  note(asked, outcome.value, now);
  if (axes_[asked.axis].phase == asked.phase) {
    return take_value(asked.axis, asked.phase, outcome.value, now);
  }
  // A command was taken up while a board was asked how it is: the question is over, the answer
  // holds, and a board that has just lost its position goes nowhere.
  if (asked.phase != Phase::kFind || !device_.reports_status) return;
  take_status(asked.axis, outcome.value);
  if (activity_ != Activity::kMoving || axes_[asked.axis].phase == Phase::kDone) return;
  const bool lost = positions_[asked.axis].quality == PositionQuality::kLost;
  if (axes_[asked.axis].fault) {
    fail_motion(*axes_[asked.axis].fault, now);
  } else if (lost) {
    fail_motion({ErrorCode::kPositionUnknown, static_cast<std::int8_t>(asked.axis)}, now);
  }
}

void AxisRegistersDriver::note(const Asked& asked, const Data& value, Instant now) {
  const AxisRegisterMap& map = device_.registers;
  // As kDocumentRegisters has them.
  const std::array places{map.homing, map.move_angle, map.diag_control, map.diag_status,
                          map.emergency_stop};
  static_assert(places.size() == AxisRegistersFacts::kRegisters);
  const auto place = std::ranges::find(places, asked.request.address);
  if (place == places.end()) return;
  const bool written = asked.request.operation == Operation::kWrite;
  auto& heard = axes_[asked.axis].heard[static_cast<std::size_t>(place - places.begin())];
  heard = {{written ? asked.request.data : value, written}, now};
}

DeviceFacts AxisRegistersDriver::facts() const {
  AxisRegistersFacts facts;
  for (const Axis& axis : axes_) facts.axes.push_back({axis.answers, axis.fault, axis.heard});
  return DeviceFacts(facts);
}

void AxisRegistersDriver::take_value(std::size_t i, Phase phase, const Data& value, Instant now) {
  Axis& axis = axes_[i];
  switch (phase) {
    case Phase::kClear:
      axis.phase = Phase::kRelease;
      return;
    case Phase::kStop:
      axis.phase = Phase::kVerify;
      axis.not_before = now;
      return;
    case Phase::kCancel:
      axis.homing = false;
      axis.phase = Phase::kDone;
      return;
    case Phase::kRelease:
      return after_release(i);
    case Phase::kBefore:
      axis.before = read_angle(device_.encoding, device_.boards[i].zero, value);
      axis.phase = Phase::kHome;
      return;
    case Phase::kHome:
      axis.phase = Phase::kPollHoming;
      axis.deadline = now + timing_.homing_limit;
      return;
    case Phase::kWrite:
      axis.phase = Phase::kPoll;
      axis.deadline = now + from_seconds(axis.expected * timing_.move_factor) + timing_.move_margin;
      if (!device_.reports_status) axis.not_before = now + from_seconds(axis.expected);
      return;
    case Phase::kTest:
      axis.phase = Phase::kPoll;
      axis.deadline = now + timing_.test_limit;
      return;
    case Phase::kPollHoming:
      return take_homing(i, value, now);
    case Phase::kPoll:
      return take_poll(i, value, now);
    case Phase::kReadBack:
      return take_read_back(i, value, now);
    case Phase::kVerify:
      return take_stop_check(i, value, now);
    case Phase::kFind:
      return take_found(i, value, now);
    case Phase::kDone:
      return;
  }
}

void AxisRegistersDriver::after_release(std::size_t i) {
  Axis& axis = axes_[i];
  axis.latched = axis.latched_before = false;
  axis.stop_due = false;
  if (activity_ == Activity::kHoming) {
    axis.phase = Phase::kBefore;
  } else if (activity_ == Activity::kMoving) {
    axis.phase = Phase::kWrite;
  } else if (activity_ == Activity::kTesting) {
    axis.phase = Phase::kTest;
  } else {
    // Acknowledged: what the status says next counts.
    axis.fault.reset();
    axis.phase = Phase::kFind;
  }
}

std::optional<Status> AxisRegistersDriver::take_status(std::size_t i, const Data& value) {
  const auto status = decode_status(value);
  if (!status) return status;
  Axis& axis = axes_[i];
  axis.blank = *status == Status{};
  std::optional<Error> fault = fault_of(status->fault);
  if (status->emergency_stop && !axis.latched) {
    axis.latched_before = axis.latched_before || memory_.held_by_stop;
    const ErrorCode who = axis.latched_before ? ErrorCode::kStopLatched : ErrorCode::kEmergencyStop;
    if (!fault) fault = Error{who};
  }
  if (!fault && !status->sensor_ok) fault = Error{ErrorCode::kEncoderLost};
  if (!fault && !status->motor_ok) fault = Error{ErrorCode::kSelfTestFailed};
  if (fault && !axis.fault) {
    fault->index = static_cast<std::int8_t>(i);
    axis.fault = fault;
  }
  const bool weak = axis.fault && (axis.fault->code == ErrorCode::kSupplyFlag ||
                                   axis.fault->code == ErrorCode::kStalled);
  axis.unheld = axis.unheld || weak;
  axis.knows = status->homed && status->position_ok && !axis.unheld;
  const bool lost = positions_[i].quality == PositionQuality::kLost;
  if (!axis.knows) {
    // The board may know; this wire does not tell where, and the limits do not bound a fall.
    set_lost(i);
  } else if (status->moving ? activity_ == Activity::kIdle : lost && !axis.homing) {
    // The board knows where it is and this host does not: it moves unasked, or was homed by
    // somebody else.
    set_everywhere(i);
  }
  return status;
}

void AxisRegistersDriver::take_homing(std::size_t i, const Data& value, Instant now) {
  Axis& axis = axes_[i];
  const auto index = static_cast<std::int8_t>(i);
  if (value[0] == kOff) {
    axis.phase = Phase::kPoll;
  } else if (now > axis.deadline) {
    fail_motion({ErrorCode::kHomingFailed, index}, now);
  }
}

void AxisRegistersDriver::take_poll(std::size_t i, const Data& value, Instant now) {
  Axis& axis = axes_[i];
  const auto index = static_cast<std::int8_t>(i);
  const auto status = take_status(i, value);
  if (!status) return axis_fails(i, {ErrorCode::kUnexpectedReply, index, 1.0 * value[0]}, now);
  if (activity_ == Activity::kTesting) return take_test(i, *status, now);
  if (axis.fault) return fail_motion(*axis.fault, now);
  if (axis.moves && status->emergency_stop) {
    return fail_motion({ErrorCode::kEmergencyStop, index}, now);
  }
  if (status->moving) {
    if (now > axis.deadline) fail_motion({ErrorCode::kMotionIgnored, index}, now);
    return;
  }
  const bool known = status->homed && status->position_ok;
  if (!known) {
    return fail_motion(
        {axis.homing ? ErrorCode::kHomingFailed : ErrorCode::kPositionUnknown, index}, now);
  }
  axis.phase = axis.moves || axis.homing ? Phase::kReadBack : Phase::kDone;
}

/// The others go on with theirs, whatever this board found.
void AxisRegistersDriver::take_test(std::size_t i, const Status& status, Instant now) {
  Axis& axis = axes_[i];
  const bool late = status.moving && now > axis.deadline;
  if (late && !axis.fault) {
    axis.fault = Error{ErrorCode::kSelfTestFailed, static_cast<std::int8_t>(i)};
  }
  // Its power was away in between, and its test with it.
  if (axis.was_known && !axis.knows && !axis.fault) {
    axis.fault = Error{ErrorCode::kPositionUnknown, static_cast<std::int8_t>(i)};
  }
  if (!status.moving || axis.fault) axis.phase = Phase::kDone;
}

void AxisRegistersDriver::take_read_back(std::size_t i, const Data& value, Instant now) {
  Axis& axis = axes_[i];
  const auto index = static_cast<std::int8_t>(i);
  const double zero = device_.boards[i].zero;
  const auto read = read_angle(device_.encoding, zero, value);
  if (!read) return axis_fails(i, {ErrorCode::kUnexpectedReply, index, 1.0 * value[0]}, now);
  axis.phase = Phase::kDone;
  const double tolerance = same_target_tolerance(*read);
  const auto is_at = [&](double q) { return std::abs(read->q - q) <= tolerance; };
  if (activity_ == Activity::kOpening) {
    take_found_angle(i, *read);
  } else if (activity_ == Activity::kHoming) {
    axis.homing = axis.unheld = false;
    set_at(i, *read);
    // Where MOVE_ANGLE is what it was before homing, the board may not have touched it, and then
    // homing ends at the joint's zero.
    const bool untouched = !axis.before || is_at(axis.before->q);
    if (untouched && !is_at(zero)) {
      positions_[i] = {PositionQuality::kUncertain, zero, std::min(zero, read->q) - read->half_unit,
                       std::max(zero, read->q) + read->half_unit};
    }
  } else if (is_at(axis.target.q)) {
    set_at(i, axis.target);
  } else {
    fail_motion({ErrorCode::kMotionIgnored, index}, now);
  }
}

/// Of a board that stands, homed and in no stop, when the port is opened.
void AxisRegistersDriver::take_found_angle(std::size_t i, const ToldAngle& read) {
  const JointPosition& known = positions_[i];
  Axis& axis = axes_[i];
  axis.found = read;
  if (is_everywhere(i)) return;
  const bool uncertain = known.quality == PositionQuality::kUncertain;
  // Behind a stop the register reads where the joint was sent, which is not where it stands; also
  // where the host died before the next target had replaced that one.
  const bool sent_since =
      memory_.ended_in_motion && !memory_.held_by_stop && !known.count_zero.has_value();
  axis.adrift = known.count_zero.has_value() || (uncertain && !sent_since);
  if (axis.adrift && uncertain) return;
  const double here = read.q + known.count_zero.value_or(0);
  const double tolerance = same_target_tolerance(read);
  if (here < known.lower - tolerance || here > known.upper + tolerance) {
    // Somebody else sent it elsewhere since the position was known.
    set_everywhere(i);
  } else if (uncertain) {
    set_at(i, read);
  }
}

/// What a person says of a board that was found. @return  false: the board knows better
bool AxisRegistersDriver::take_statement(std::size_t i, JointPosition& declared) const {
  const Axis& axis = axes_[i];
  if (declared.quality == PositionQuality::kLost) return true;
  if (device_.reports_status && !axis.knows) return false;
  const double zero = device_.boards[i].zero;
  const SendRange range = SendRange(joints_[i]).from(declared);
  const auto told = tell_angle(device_.encoding, zero, range, declared.q);
  const double half_unit = told ? told->half_unit : 0;
  declared.lower = std::min(declared.lower, declared.q - half_unit);
  declared.upper = std::max(declared.upper, declared.q + half_unit);
  if (!axis.found) return true;
  if (axis.adrift) {
    declared.count_zero = declared.q - axis.found->q;
    return true;
  }
  const double tolerance = same_target_tolerance(*axis.found);
  return declared.lower - tolerance <= axis.found->q && axis.found->q <= declared.upper + tolerance;
}

void AxisRegistersDriver::take_stop_check(std::size_t i, const Data& value, Instant now) {
  Axis& axis = axes_[i];
  const Error ignored{ErrorCode::kMotionIgnored, static_cast<std::int8_t>(i)};
  bool latched = value[0] == kOn;
  bool moving = false;
  if (device_.reports_status) {
    const auto status = take_status(i, value);
    if (!status) return axis_fails(i, {ErrorCode::kUnexpectedReply, -1, 1.0 * value[0]}, now);
    latched = status->emergency_stop;
    moving = status->moving;
  }
  if (!latched) {
    if (axis.stops_left-- <= 0) return axis_fails(i, ignored, now);
    axis.phase = Phase::kStop;
    return;
  }
  if (moving) {
    if (now > axis.deadline) axis_fails(i, ignored, now);
    return;
  }
  axis.stop_due = false;
  if (!axis.answers) {
    axis.answers = true;
    axis.fault.reset();
    if (activity_ == Activity::kIdle && !fault_) tell(DriverEvent::Kind::kReady);
  }
  axis.phase = axis.homing ? Phase::kCancel : Phase::kDone;
}

void AxisRegistersDriver::take_found(std::size_t i, const Data& value, Instant now) {
  Axis& axis = axes_[i];
  axis.phase = Phase::kDone;
  const bool was_out = !axis.answers;
  if (was_out) axis.fault.reset();  // silence was its fault
  const bool had_fault = axis.fault.has_value();
  if (!device_.reports_status) {
    if (value[0] != kOff && !axis.latched && !had_fault) {
      axis.latched_before = memory_.held_by_stop;
      axis.fault = Error{axis.latched_before ? ErrorCode::kStopLatched : ErrorCode::kEmergencyStop,
                         static_cast<std::int8_t>(i)};
    }
  } else if (!take_status(i, value)) {
    return axis_fails(i, {ErrorCode::kUnexpectedReply, -1, 1.0 * value[0]}, now);
  }
  axis.answers = true;
  if (activity_ == Activity::kOpening && device_.reports_status) {
    if (finishes(i, value, now)) return;
    const bool stands = positions_[i].quality != PositionQuality::kLost && !axis.fault;
    if (stands) axis.phase = Phase::kReadBack;
  }
  if (activity_ != Activity::kIdle) return;
  if (!fault_) fault_ = latched_stop();
  if (axis.fault && !had_fault) tell(DriverEvent::Kind::kNotice, *axis.fault);
  if (was_out && !axis.fault && !fault_) tell(DriverEvent::Kind::kReady);
}

/// A board that goes on with what a host before told it is asked again until it stands: what it
/// reads as its target is where it is then, and not before.
bool AxisRegistersDriver::finishes(std::size_t i, const Data& value, Instant now) {
  const auto status = decode_status(value);
  const bool under_way = status && status->moving && status->homed && !axes_[i].fault;
  if (!under_way) return false;
  if (now - opened_at_ > timing_.finish_limit) {
    set_everywhere(i);
    return true;
  }
  axes_[i].phase = Phase::kFind;
  axes_[i].not_before = now + timing_.watch;
  goes_on_until_ = now + kAskedAgain;
  return true;
}

void AxisRegistersDriver::axis_fails(std::size_t i, Error error, Instant now) {
  Axis& axis = axes_[i];
  const bool answered = axis.answers;
  const bool takes_part = axis.phase != Phase::kDone;
  error.index = static_cast<std::int8_t>(i);
  axis.fault = error;
  axis.answers = false;
  axis.homing = false;
  axis.not_before = now + timing_.retry;
  axis.phase = Phase::kDone;
  // It may have lost its supply, and then its joint is held by nothing: not even by its limits.
  if (positions_[i].quality != PositionQuality::kLost) set_lost(i);
  switch (activity_) {
    case Activity::kMoving:
    case Activity::kHoming:
      if (takes_part) return fail_motion(error, now);
      break;
    case Activity::kStopping:
      axis.stop_due = true;
      if (answered && !stop_error_) stop_error_ = error;
      return;
    case Activity::kOpening:
      if (silence_told_) return;
      break;
    case Activity::kIdle:
      if (!answered) return;
      break;
    case Activity::kClearing:
    case Activity::kTesting:
    case Activity::kClosed:
      return;
  }
  tell(DriverEvent::Kind::kNotice, error);
}

void AxisRegistersDriver::set_everywhere(std::size_t i) {
  JointPosition& position = positions_[i];
  axes_[i].adrift = false;
  position.count_zero.reset();
  position.quality = PositionQuality::kUncertain;
  position.lower = joints_[i].lower - kBeyondLimits;
  position.upper = joints_[i].upper + kBeyondLimits;
}

bool AxisRegistersDriver::is_everywhere(std::size_t i) const {
  const JointPosition& position = positions_[i];
  return position.quality == PositionQuality::kUncertain &&
         position.lower <= joints_[i].lower - kBeyondLimits + kJointLimitTolerance &&
         position.upper >= joints_[i].upper + kBeyondLimits - kJointLimitTolerance;
}

void AxisRegistersDriver::set_lost(std::size_t i) {
  JointPosition& position = positions_[i];
  position = {PositionQuality::kLost, position.q, position.q, position.q};
}

void AxisRegistersDriver::set_at(std::size_t i, const ToldAngle& where) {
  positions_[i] = {PositionQuality::kCommanded, where.q, where.q - where.half_unit,
                   where.q + where.half_unit};
}

void AxisRegistersDriver::stretch_to_target(std::size_t i) {
  const ToldAngle& target = axes_[i].target;
  JointPosition& position = positions_[i];
  SINEW_ASSERT(position.quality != PositionQuality::kLost);
  position.quality = PositionQuality::kUncertain;
  position.count_zero.reset();
  position.q = target.q;
  position.lower = std::min(position.lower, target.q - target.half_unit);
  position.upper = std::max(position.upper, target.q + target.half_unit);
}

}  // namespace sinew
