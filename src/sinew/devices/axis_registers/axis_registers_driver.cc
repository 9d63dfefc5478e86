#include "sinew/devices/axis_registers/axis_registers_driver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/model/left_out.h"

namespace sinew {

using namespace axis_registers;

namespace {

/// Events that are told whatever happens; notices give way to them.
constexpr std::size_t kRoomForEnds = 16;

/// Of the first board that is out.
template <class Axes>
std::optional<Error> first_fault(const Axes& axes) {
  const auto out =
      std::ranges::find_if(axes, [](const auto& axis) { return axis.fault.has_value(); });
  return out != axes.end() ? out->fault : std::nullopt;
}

}  // namespace

AxisRegistersDriver::AxisRegistersDriver(const AxisRegistersDevice& device,
                                         std::span<const Joint> joints,
                                         const AxisRegistersTiming& timing)
    : device_(device), timing_(timing), joints_(joints), link_(device, timing.link) {
  SINEW_ASSERT(!joints.empty() && joints.size() == device.boards.size());
  axes_.resize(joints.size());
  positions_.resize(joints.size());
  homing_order_ = homing_order(device.boards);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    std::uint8_t same_bus = 0;
    for (std::size_t k = 0; k < joints.size(); ++k) {
      if (device.boards[k].spi_bus == device.boards[i].spi_bus && !is_out_by_choice(k)) {
        same_bus = static_cast<std::uint8_t>(same_bus | 1U << k);
      }
    }
    if (same_bus == 0) continue;
    if (std::ranges::find(buses_, same_bus) == buses_.end()) buses_.push_back(same_bus);
  }
}

bool AxisRegistersDriver::is_out_by_choice(std::size_t i) const {
  return is_left_out(std::span<const AxisBoard>(device_.boards.data(), device_.boards.size()), i);
}

void AxisRegistersDriver::open(Instant now) {
  if (activity_ != Activity::kClosed) return;
  link_.reset();
  silence_told_ = false;
  begin_opening(now);
  pump(now);
}

void AxisRegistersDriver::close(Instant) {
  if (activity_ == Activity::kClosed) return;
  if (command_ || stop_asked_) tell(DriverEvent::Kind::kFailed, {ErrorCode::kPortClosed});
  command_ = stop_asked_ = open_again_ = false;
  link_.reset();
  asked_.reset();
  wake_at_.reset();
  activity_ = Activity::kClosed;
}

DriverState AxisRegistersDriver::state() const {
  switch (activity_) {
    case Activity::kClosed:
      return DriverState::kClosed;
    case Activity::kOpening:
    case Activity::kClearing:
      return DriverState::kOpening;
    case Activity::kMoving:
    case Activity::kHoming:
    case Activity::kTesting:
      return DriverState::kMoving;
    case Activity::kStopping:
      return DriverState::kStopping;
    case Activity::kIdle:
      break;
  }
  return fault_ ? DriverState::kFault : DriverState::kReady;
}

std::span<const JointPosition> AxisRegistersDriver::positions() const {
  return {positions_.data(), positions_.size()};
}

std::optional<std::size_t> AxisRegistersDriver::homing_joint() const {
  const bool searching = activity_ == Activity::kHoming && homing_place_ < homing_order_.size();
  return searching ? std::optional<std::size_t>(homing_order_[homing_place_]) : std::nullopt;
}

bool AxisRegistersDriver::held_by_stop() const {
  return memory_.held_by_stop || std::ranges::any_of(axes_, [](const Axis& axis) {
           return axis.latched || axis.latched_before;
         });
}

std::optional<JointInterval> AxisRegistersDriver::counted(std::size_t joint) const {
  const auto& found = axes_[joint].found;
  if (!found || axes_[joint].adrift) return std::nullopt;
  return JointInterval{found->q - found->half_unit, found->q + found->half_unit};
}

/// Of the first board that an emergency stop holds which this run did not set.
std::optional<Error> AxisRegistersDriver::latched_stop() const {
  for (const Axis& axis : axes_) {
    if (!axis.fault) continue;
    const ErrorCode code = axis.fault->code;
    if (code == ErrorCode::kEmergencyStop || code == ErrorCode::kStopLatched) return axis.fault;
  }
  return std::nullopt;
}

bool AxisRegistersDriver::statuses_are_blank() const {
  return device_.reports_status && std::ranges::any_of(axes_, &Axis::answers) &&
         std::ranges::all_of(axes_, [](const Axis& axis) { return axis.blank || !axis.answers; });
}

bool AxisRegistersDriver::wants_move(Instant) const {
  return activity_ == Activity::kIdle && !fault_;
}

std::optional<Error> AxisRegistersDriver::check_ready() const {
  if (activity_ == Activity::kClosed) return Error{ErrorCode::kPortClosed};
  if (activity_ != Activity::kIdle) return Error{ErrorCode::kBusy};
  return fault_;
}

Expected<ToldAngle> AxisRegistersDriver::target_for(std::size_t i, double q) const {
  if (is_out_by_choice(i)) return ToldAngle{};
  const auto index = static_cast<std::int8_t>(i);
  const JointPosition& position = positions_[i];
  const SendRange range = SendRange(joints_[i]).from(position);
  auto told = tell_angle(device_.encoding, device_.boards[i].zero, range, q);
  if (axes_[i].fault) {
    // It takes part by standing still.
    const bool holds =
        q >= position.lower - kJointLimitTolerance && q <= position.upper + kJointLimitTolerance;
    if (!holds) return std::unexpected(*axes_[i].fault);
    return ToldAngle{};
  }
  if (!told) {
    Error error = told.error();
    error.index = index;
    return std::unexpected(error);
  }
  if (position.quality == PositionQuality::kLost) {
    return std::unexpected(Error{ErrorCode::kPositionUnknown, index});
  }
  return told;
}

Expected<void> AxisRegistersDriver::move(const JointMove& move, Instant now) {
  SINEW_ASSERT(move.q.size() == joints_.size());
  if (const auto error = check_ready()) return std::unexpected(*error);
  std::array<ToldAngle, kMaxJoints> targets{};
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto target = target_for(i, move.q[i]);
    if (!target) return std::unexpected(target.error());
    targets[i] = *target;
  }
  begin(Activity::kMoving);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    axis.phase = Phase::kDone;
    axis.moves = false;
    if (axis.fault || is_out_by_choice(i)) continue;
    const JointPosition& from = positions_[i];
    axis.target = targets[i];
    axis.moves = from.quality != PositionQuality::kCommanded || from.q != axis.target.q;
    const double distance =
        std::max(std::abs(axis.target.q - from.lower), std::abs(axis.target.q - from.upper));
    axis.expected = std::max(to_seconds(move.duration), quickest_time(joints_[i], distance));
    axis.not_before = now;
    axis.deadline = now + timing_.move_margin;
    if (axis.moves) {
      axis.phase = axis.latched ? Phase::kRelease : Phase::kWrite;
    } else if (device_.reports_status) {
      axis.phase = Phase::kPoll;
    }
  }
  pump(now);
  return {};
}

void AxisRegistersDriver::stop(Instant now) {
  // Nothing leaves any more, which is as good as a stop gets.
  if (activity_ == Activity::kClosed) return tell(DriverEvent::Kind::kStopped);
  stop_asked_ = true;
  if (activity_ == Activity::kStopping) return;
  open_again_ = activity_ == Activity::kOpening;
  command_ = false;
  begin_stopping(now);
  pump(now);
}

Expected<void> AxisRegistersDriver::home(Instant now, std::uint8_t joints) {
  if (!device_.reports_status) return std::unexpected(Error{ErrorCode::kTaskNotSupported});
  if (const auto error = check_ready()) return std::unexpected(*error);
  // All of them or none: who asks for home has a program that counts on every joint.
  if (const auto out = first_fault(axes_)) return std::unexpected(*out);
  begin(Activity::kHoming);
  to_home_ = joints;
  begin_homing_of(0);
  pump(now);
  return {};
}

Expected<void> AxisRegistersDriver::clear_fault(Instant now) {
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  begin(Activity::kClearing);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (is_out_by_choice(i)) continue;
    axes_[i].phase = Phase::kClear;
    axes_[i].not_before = now;
  }
  pump(now);
  return {};
}

Expected<void> AxisRegistersDriver::service(DeviceService what, Instant now) {
  const bool tests = what == DeviceService::kSelfTest && device_.reports_status;
  if (!tests) return std::unexpected(Error{ErrorCode::kNoSuchService});
  if (const auto error = check_ready()) return std::unexpected(*error);
  // The result covers all of them.
  if (const auto out = first_fault(axes_)) return std::unexpected(*out);
  begin(Activity::kTesting);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (is_out_by_choice(i)) continue;
    Axis& axis = axes_[i];
    axis.was_known = axis.knows;
    axis.phase = axis.latched ? Phase::kRelease : Phase::kTest;
    axis.not_before = now;
  }
  pump(now);
  return {};
}

void AxisRegistersDriver::declare_positions(std::span<const JointPosition> positions) {
  SINEW_ASSERT(positions.size() == positions_.size());
  const bool at_rest = activity_ == Activity::kClosed || activity_ == Activity::kOpening ||
                       activity_ == Activity::kIdle;
  if (!at_rest) return;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    JointPosition declared = positions[i];
    if (!std::isfinite(declared.q)) declared = {};
    const bool inside = declared.lower <= declared.q && declared.q <= declared.upper;
    if (!inside) declared.lower = declared.upper = declared.q;
    if (is_out_by_choice(i)) declared = {};
    if (declared.quality == PositionQuality::kMeasured) {
      declared.quality = PositionQuality::kCommanded;
    }
    if (activity_ == Activity::kIdle && !take_statement(i, declared)) continue;
    positions_[i] = declared;
  }
}

std::optional<Instant> AxisRegistersDriver::goes_on_until() const {
  if (activity_ != Activity::kStopping) return goes_on_until_;
  std::optional<Instant> until;
  for (const Axis& axis : axes_) {
    if (axis.phase != Phase::kDone) until = std::max(until.value_or(axis.deadline), axis.deadline);
  }
  return until;
}

void AxisRegistersDriver::begin(Activity activity) {
  activity_ = activity;
  command_ = true;
  cursor_ = 0;
  for (Axis& axis : axes_) {
    axis.phase = Phase::kDone;
    // What follows changes what was found, or where the joint stands.
    const bool stays = activity == Activity::kClearing || activity == Activity::kTesting;
    if (!stays) axis.found.reset();
  }
}

void AxisRegistersDriver::begin_opening(Instant now) {
  activity_ = Activity::kOpening;
  open_again_ = false;
  cursor_ = 0;
  opened_at_ = now;
  goes_on_until_.reset();
  fault_.reset();
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    axis.phase = is_out_by_choice(i) ? Phase::kDone : Phase::kFind;
    axis.answers = axis.knows = axis.adrift = false;
    axis.fault.reset();
    axis.found.reset();
    axis.not_before = now;
  }
}

void AxisRegistersDriver::begin_stopping(Instant now) {
  link_.abandon();
  asked_.reset();
  activity_ = Activity::kStopping;
  goes_on_until_.reset();
  memory_.ended_in_motion = false;
  cursor_ = 0;
  buses_stopped_ = 0;
  stop_error_.reset();
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (is_out_by_choice(i)) continue;
    Axis& axis = axes_[i];
    const Joint& joint = joints_[i];
    axis.latched = true;
    axis.found.reset();
    axis.stops_left = timing_.link.tries;
    axis.phase = axis.answers ? Phase::kVerify : Phase::kStop;
    axis.not_before = now;
    axis.deadline = now + timing_.stop_margin +
                    from_seconds(joint.velocity_max / joint.acceleration_max +
                                 joint.acceleration_max / joint.jerk_max);
  }
}

void AxisRegistersDriver::begin_homing_of(std::size_t place) {
  for (; place < homing_order_.size(); ++place) {
    Axis& axis = axes_[homing_order_[place]];
    if (!axis.answers || (to_home_ >> homing_order_[place] & 1U) == 0) continue;
    axis.phase = axis.latched ? Phase::kRelease : Phase::kBefore;
    break;
  }
  homing_place_ = place;
}

bool AxisRegistersDriver::all_done() const {
  return std::ranges::all_of(axes_, [](const Axis& axis) { return axis.phase == Phase::kDone; });
}

void AxisRegistersDriver::pump(Instant now) {
  // Each round asks somebody or ends an activity or an axis.
  for (std::size_t round = 0; round < 4 * kMaxJoints; ++round) {
    wake_at_.reset();
    if (activity_ == Activity::kClosed || link_.busy()) return;
    if (activity_ == Activity::kStopping && broadcast_stop(now)) return;
    const auto next = activity_ == Activity::kIdle ? next_idle_axis(now) : next_axis(now);
    if (!next && (activity_ == Activity::kIdle || !all_done())) return;
    if (!next) {
      finish(now);
    } else if (axes_[*next].phase == Phase::kPoll && !device_.reports_status) {
      // Its time is over; nothing that it could be asked says more.
      set_at(*next, axes_[*next].target);
      axes_[*next].phase = Phase::kDone;
    } else {
      return ask(*next, now);
    }
  }
}

bool AxisRegistersDriver::broadcast_stop(Instant now) {
  if (buses_stopped_ == buses_.size()) return false;
  link_.start({.select = buses_[buses_stopped_++],
               .operation = Operation::kWrite,
               .address = device_.registers.emergency_stop,
               .data = {kOn},
               .blind = true},
              now);
  return true;
}

std::optional<std::size_t> AxisRegistersDriver::next_axis(Instant now) {
  // Orders before questions, and nobody waits for a board that is known to be silent.
  const auto rank = [](const Axis& axis) {
    return (axis.phase < Phase::kPollHoming ? 0 : 1) + (axis.answers ? 0 : 2);
  };
  std::optional<std::size_t> best;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const std::size_t i = (cursor_ + k) % axes_.size();
    const Axis& axis = axes_[i];
    if (axis.phase == Phase::kDone) continue;
    if (axis.not_before > now) {
      wake_at_ = std::min(wake_at_.value_or(axis.not_before), axis.not_before);
    } else if (!best || rank(axis) < rank(axes_[*best])) {
      best = i;
    }
  }
  if (best) cursor_ = (*best + 1) % axes_.size();
  return best;
}

std::optional<std::size_t> AxisRegistersDriver::next_idle_axis(Instant now) {
  std::optional<std::size_t> watched;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const std::size_t i = (cursor_ + k) % axes_.size();
    Axis& axis = axes_[i];
    if (axis.answers && !watched) watched = i;
    if (axis.answers || is_out_by_choice(i)) continue;
    if (axis.not_before <= now) {
      if (!axis.stop_due) axis.phase = Phase::kFind;
      if (axis.stop_due && axis.phase != Phase::kVerify) axis.phase = Phase::kStop;
      return i;
    }
    wake_at_ = std::min(wake_at_.value_or(axis.not_before), axis.not_before);
  }
  if (!watched) return std::nullopt;
  if (now < watch_at_) {
    wake_at_ = std::min(wake_at_.value_or(watch_at_), watch_at_);
    return std::nullopt;
  }
  axes_[*watched].phase = Phase::kFind;
  cursor_ = (*watched + 1) % axes_.size();
  return watched;
}

void AxisRegistersDriver::finish(Instant now) {
  switch (activity_) {
    case Activity::kOpening:
      return finish_opening(now);
    case Activity::kStopping:
      return finish_stopping(now);
    case Activity::kClearing:
      return finish_clearing();
    case Activity::kTesting:
      return finish_testing(now);
    case Activity::kHoming:
      begin_homing_of(homing_place_ + 1);
      if (homing_place_ < homing_order_.size()) return;
      break;
    case Activity::kMoving:
      break;
    case Activity::kClosed:
    case Activity::kIdle:
      return;
  }
  activity_ = Activity::kIdle;
  watch_at_ = now + timing_.watch;
  command_ = false;
  tell(DriverEvent::Kind::kDone);
}

void AxisRegistersDriver::finish_opening(Instant now) {
  if (std::ranges::any_of(axes_, &Axis::answers)) {
    activity_ = Activity::kIdle;
    goes_on_until_.reset();
    memory_ = {};
    fault_ = latched_stop();
    if (fault_) return tell(DriverEvent::Kind::kFailed, *fault_);
    return tell(DriverEvent::Kind::kReady);
  }
  const bool all_silent = std::ranges::all_of(axes_, [](const Axis& axis) {
    return !axis.fault || axis.fault->code == ErrorCode::kDeviceSilent;
  });
  Error error = why_none_is_fit();
  if (all_silent) error.index = -1;  // it is no board's own trouble
  if (!silence_told_) tell(DriverEvent::Kind::kFailed, error);
  silence_told_ = true;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (is_out_by_choice(i)) continue;
    axes_[i].phase = Phase::kFind;
    axes_[i].not_before = now + timing_.retry;
  }
}

/// Of the first board that is asked at all.
Error AxisRegistersDriver::why_none_is_fit() const {
  return first_fault(axes_).value_or(Error{ErrorCode::kDeviceSilent});
}

void AxisRegistersDriver::finish_stopping(Instant now) {
  activity_ = Activity::kIdle;
  if (stop_error_ && !fault_) fault_ = stop_error_;
  if (stop_asked_ && !stop_error_) tell(DriverEvent::Kind::kStopped);
  if (stop_asked_ && stop_error_) tell(DriverEvent::Kind::kFailed, *stop_error_);
  if (!stop_asked_ && stop_error_) tell(DriverEvent::Kind::kNotice, *stop_error_);
  stop_asked_ = false;
  if (open_again_) begin_opening(now);
}

void AxisRegistersDriver::finish_clearing() {
  activity_ = Activity::kIdle;
  command_ = false;
  const bool fit =
      std::ranges::any_of(axes_, [](const Axis& axis) { return axis.answers && !axis.fault; });
  if (fit) {
    fault_.reset();
    return tell(DriverEvent::Kind::kDone);
  }
  fault_ = why_none_is_fit();
  tell(DriverEvent::Kind::kFailed, *fault_);
}

void AxisRegistersDriver::finish_testing(Instant now) {
  activity_ = Activity::kIdle;
  watch_at_ = now + timing_.watch;
  command_ = false;
  fault_ = first_fault(axes_);
  if (!fault_) return tell(DriverEvent::Kind::kDone);
  tell(DriverEvent::Kind::kFailed, *fault_);
}

void AxisRegistersDriver::fail_motion(Error error, Instant now) {
  fault_ = error;
  if (command_) tell(DriverEvent::Kind::kFailed, error);
  command_ = false;
  begin_stopping(now);
}

void AxisRegistersDriver::poll(Instant now) {
  pump(now);
}

std::optional<Instant> AxisRegistersDriver::next_deadline() const {
  return link_.busy() ? link_.next_deadline() : wake_at_;
}

std::optional<spi::Transfer> AxisRegistersDriver::take_transfer(Instant now) {
  pump(now);
  return link_.take_transfer(now);
}

void AxisRegistersDriver::exchanged(std::span<const std::uint8_t> miso, Instant now) {
  link_.exchanged(miso, now);
  if (const auto outcome = link_.take_outcome()) take(*outcome, now);
  pump(now);
}

std::optional<DriverEvent> AxisRegistersDriver::take_event() {
  return events_.take_front();
}

void AxisRegistersDriver::tell(DriverEvent::Kind kind, const Error& error) {
  const bool notice = kind == DriverEvent::Kind::kNotice;
  if (notice && events_.size() >= events_.capacity() - kRoomForEnds) return;
  SINEW_ASSERT(!events_.full());
  events_.push_back({kind, error});
}

}  // namespace sinew
