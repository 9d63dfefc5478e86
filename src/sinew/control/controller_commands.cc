#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/control/controller.h"
#include "sinew/control/position_evidence.h"
#include "sinew/core/error_code.h"
#include "sinew/model/left_out.h"
#include "sinew/planning/timing/path_follower.h"

namespace sinew::control {
namespace {

/// rad or m: rounding between a plan and the place that it was made for.
constexpr double kSamePlace = 1e-9;

std::unexpected<Error> refused(ErrorCode code) {
  return std::unexpected(Error{code});
}

/// What is known of a joint that is not lost.
Evidence evidence_of(const RobotModel& robot, std::size_t joint, const JointPosition& known) {
  const bool measured = known.quality == PositionQuality::kMeasured;
  double slack = measured ? Controller::kSag : kSamePlace;
  if (known.quality == PositionQuality::kCommanded) {
    slack += robot.device.settings->resolution(joint);
  }
  return {measured ? Evidence::Source::kSensor : Evidence::Source::kRecord,
          {known.lower, known.upper},
          slack};
}

/// Whatever it reports of that is dropped: the command it ends has its end already, and a port that
/// was closed on purpose is no failure.
void close_on_purpose(Driver& driver, Instant now) {
  driver.close(now);
  while (driver.take_event()) continue;
}

/// What is done at once when it is done at all.
Expected<bool> at_once(const Expected<void>& what) {
  if (!what) return std::unexpected(what.error());
  return true;
}
/// The tool cannot be led while nobody knows where a joint is, and that joint not at all.
std::optional<Error> left_out_jog(const planning::JogCommand& jog, const RobotModel& robot) {
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    if (!is_left_out(robot, j)) continue;
    const bool others = jog.frame == planning::JogFrame::kJoint && j < jog.velocity.size();
    if (others && jog.velocity[j] == 0) continue;
    return Error{ErrorCode::kPositionUnknown, static_cast<std::int8_t>(j)};
  }
  return std::nullopt;
}

/// What goes on for a while.
Expected<bool> begun(const Expected<void>& what) {
  if (!what) return std::unexpected(what.error());
  return false;
}

}  // namespace

void Controller::handle(const Command& command, const Inputs& inputs, Instant now) {
  Expected<bool> done = true;
  if (needs_lease(command.what)) done = at_once(lease_.check(command.lease, now));
  if (done) {
    const Asked asked{command, inputs, now};
    done = std::visit([&](const auto& what) { return on(what, asked); }, command.what);
  }
  if (!done) return tell(ControlEvent::Kind::kRefused, command.id, done.error());
  tell(*done ? ControlEvent::Kind::kDone : ControlEvent::Kind::kStarted, command.id);
}

Expected<bool> Controller::on(const TakeLease& take, const Asked& asked) {
  const ClientId client = asked.command.lease.client;
  const auto token = take.take_over ? Expected<LeaseToken>(lease_.take_over(client, asked.now))
                                    : lease_.take(client, asked.now);
  if (!token) return std::unexpected(token.error());
  take_lease(*token, take.take_over, asked.now);
  return true;
}

Expected<bool> Controller::on(const RenewLease& /*renew*/, const Asked& asked) {
  return at_once(lease_.renew(asked.command.lease, asked.now));
}

Expected<bool> Controller::on(const ReturnLease& /*give*/, const Asked& asked) {
  lease_.give_back(asked.command.lease);
  return true;
}

Expected<bool> Controller::on(const Enable& /*enable*/, const Asked& asked) {
  if (state_ != MachineState::kOff) return refused(ErrorCode::kWrongState);
  if (!asked.inputs.port_open) return refused(ErrorCode::kPortClosed);
  enable(asked.command.id, asked.now);
  return false;
}

Expected<bool> Controller::on(const Disable& /*disable*/, const Asked& asked) {
  if (!next_state(state_, Signal::kDisable)) return refused(ErrorCode::kWrongState);
  end_task(ControlEvent::Kind::kStopped, {}, StopCause::kShutdown);
  end_enabling(ControlEvent::Kind::kStopped);
  close_on_purpose(driver_, asked.now);
  outstanding_ = 0;
  change(Signal::kDisable);
  return true;
}

Expected<bool> Controller::on(const Acknowledge& /*acknowledge*/, const Asked& asked) {
  return acknowledge(asked.command, asked.inputs, asked.now);
}

Expected<bool> Controller::on(const Begin& motion, const Asked& asked) {
  return begun(begin(asked.command, motion, asked.now));
}

Expected<bool> Controller::on(const Home& home, const Asked& asked) {
  return begun(this->home(asked.command, home, asked.now));
}

Expected<bool> Controller::on(const Nudge& nudge, const Asked& asked) {
  return begun(this->nudge(asked.command, nudge, asked.now));
}

Expected<bool> Controller::on(const JogAt& velocity, const Asked& asked) {
  return jog(asked.command, velocity, asked.now);
}

Expected<bool> Controller::on(const Hold& /*hold*/, const Asked& asked) {
  if (state_ != MachineState::kMoving) return refused(ErrorCode::kWrongState);
  stop(StopCause::kPause, {}, asked.now);
  return true;
}

Expected<bool> Controller::on(const Resume& /*resume*/, const Asked& asked) {
  if (state_ != MachineState::kHeld || !task_) return refused(ErrorCode::kWrongState);
  task_->motion->resume();
  governor_.leave(task_->motion->overlaps());
  task_->since = asked.now;
  change(Signal::kResume);
  return true;
}

Expected<bool> Controller::on(const Stop& /*stop*/, const Asked& asked) {
  stop(StopCause::kClient, {}, asked.now);
  return true;
}

Expected<bool> Controller::on(const SetFeed& feed, const Asked& /*asked*/) {
  return at_once(set_feed(feed.share));
}

Expected<bool> Controller::on(const UseTool& tool, const Asked& asked) {
  return begun(use_tool(asked.command, tool, asked.now));
}

Expected<bool> Controller::on(const Declare& where, const Asked& asked) {
  if (const auto declared = declare(where, asked); !declared) {
    return std::unexpected(declared.error());
  }
  return !where.zeroes_counters;
}

Expected<bool> Controller::on(const Service& service, const Asked& asked) {
  if (const auto rest = at_rest(asked.now); !rest) return std::unexpected(rest.error());
  if (const auto accepted = driver_.service(service.what, asked.now); !accepted) {
    return std::unexpected(accepted.error());
  }
  free_drive_ = free_drive_ || service.what == DeviceService::kFree;
  ++outstanding_;
  task_ = Task{asked.command.id, TaskKind::kTool, nullptr, asked.now, true};
  task_->holds = service.what == DeviceService::kHold;
  return false;
}

/// Whoever takes over stops the machine first: nobody shall steer what another one has begun.
void Controller::take_lease(const LeaseToken& token, bool take_over, Instant now) {
  had_holder_ = true;
  tell(ControlEvent::Kind::kLease, 0, {}, StopCause::kClient, token);
  const bool under_way = may_move(state_) || state_ == MachineState::kHeld;
  if (take_over && under_way) stop(StopCause::kTakeOver, {}, now);
}

void Controller::enable(std::uint32_t command, Instant now) {
  enabling_ = command;
  enabling_since_ = now;
  enabling_trouble_ = silence();
  if (!driver_spoke_) driver_.remember(memory_);
  // What the run before knew; a driver that can ask its device does not need it.
  const bool anything = std::ranges::any_of(positions_, [](const JointPosition& joint) {
    return joint.quality != PositionQuality::kLost || joint.count_zero;
  });
  if (!driver_spoke_ && anything) {
    driver_.declare_positions({positions_.data(), positions_.size()});
    // Where nothing measures it keeps them from now on: an opening that fails may have found out
    // that they are no longer true, and the next one would not.
    driver_spoke_ = !measures();
  }
  driver_.open(now);
  change(Signal::kEnable);
}

Expected<void> Controller::at_rest(Instant now) const {
  if (state_ != MachineState::kReady) return refused(ErrorCode::kWrongState);
  if (task_ || !standing(now)) return refused(ErrorCode::kBusy);
  return {};
}

/// Hands may be on an arm that was freed.
Expected<void> Controller::may_begin(Instant now) const {
  if (const auto rest = at_rest(now); !rest) return rest;
  return free_drive_ ? Expected<void>(refused(ErrorCode::kFreeDrive)) : Expected<void>();
}

Expected<void> Controller::begin(const Command& command, const Begin& begin, Instant now) {
  if (const auto may = may_begin(now); !may) return may;
  if (begin.motion == nullptr) return refused(ErrorCode::kMoveInput);
  if (!begin.recovers) {
    const auto from = reference();
    if (!from) return std::unexpected(unknown_position());
    const JointVector& q_start = begin.motion->q_start();
    for (std::size_t j = 0; j < from->size(); ++j) {
      if (j < q_start.size() && std::abs((*from)[j] - q_start[j]) <= kSamePlace) continue;
      return std::unexpected(Error{ErrorCode::kMovedUnasked, static_cast<std::int8_t>(j),
                                   (*from)[j], j < q_start.size() ? q_start[j] : 0});
    }
    if (feed_ != 1) {
      if (const auto fed = begin.motion->set_feed(feed_); !fed) return fed;
    }
  }
  task_ = Task{command.id, begin.recovers ? TaskKind::kBlindMotion : TaskKind::kMotion,
               begin.motion, now, false};
  governor_.leave(begin.motion->overlaps());
  change(begin.recovers ? Signal::kRecover : Signal::kBegin);
  return {};
}

Expected<bool> Controller::jog(const Command& command, const JogAt& velocity, Instant now) {
  if (!streams_) return refused(ErrorCode::kTaskNotSupported);
  const Instant asked_before = std::exchange(jog_asked_, now);
  const bool same_hold = now - asked_before <= velocity.velocity.expiry;
  if (jog_refused_ && same_hold) return std::unexpected(*jog_refused_);
  jog_refused_.reset();
  if (state_ == MachineState::kMoving && task_ && task_->kind == TaskKind::kJog) {
    if (const auto error = left_out_jog(velocity.velocity, robot_)) return std::unexpected(*error);
    if (const auto error = jog_.command(velocity.velocity, now)) return std::unexpected(*error);
    return true;
  }
  if (const auto may = may_begin(now); !may) return std::unexpected(may.error());
  const auto from = reference();
  if (!from) return std::unexpected(unknown_position());
  if (const auto error = left_out_jog(velocity.velocity, robot_)) return std::unexpected(*error);
  if (const auto error = jog_.start(*from, now)) return std::unexpected(*error);
  if (const auto error = jog_.command(velocity.velocity, now)) return std::unexpected(*error);
  task_ = Task{command.id, TaskKind::kJog, &jog_, now, false};
  change(Signal::kBegin);
  return false;
}

Expected<void> Controller::home(const Command& command, const Home& home, Instant now) {
  if (const auto may = may_begin(now); !may) return may;
  if (!home.resumes) found_ = 0;
  task_ = Task{command.id, TaskKind::kHome, nullptr, now, false, {}, home};
  change(Signal::kRecover);
  return {};
}

Expected<void> Controller::nudge(const Command& command, const Nudge& nudge, Instant now) {
  if (const auto may = may_begin(now); !may) return may;
  if (const auto passed = governor_.pass_nudge(nudge.joint, nudge.way, positions()); !passed) {
    return passed;
  }
  if (nudge.probes) {
    if (const auto may = driver_.may_probe(); !may) return may;
  }
  task_ = Task{command.id, TaskKind::kNudge, nullptr, now, false, nudge};
  change(Signal::kRecover);
  return {};
}

Expected<void> Controller::use_tool(const Command& command, const UseTool& tool, Instant now) {
  if (const auto rest = at_rest(now); !rest) return rest;
  const auto* jaws = std::get_if<JawsTo>(&tool.action);
  if (jaws != nullptr) {
    if (const auto passed = governor_.pass_jaws(jaws->width); !passed) return passed;
  }
  if (const auto accepted = driver_.tool(tool.action, now); !accepted) return accepted;
  ++outstanding_;
  task_ = Task{command.id, TaskKind::kTool, nullptr, now, true};
  if (jaws != nullptr) {
    task_->jaws = *jaws;
    fit({});
  }
  return {};
}

Expected<void> Controller::set_feed(double share) {
  const bool fits = std::isfinite(share) && share >= 0 &&
                    share <= (streams_ ? planning::PathFollower::kFeedMax : 1);
  if (!fits) {
    return std::unexpected(
        Error{ErrorCode::kMoveInput, -1, share, streams_ ? planning::PathFollower::kFeedMax : 1});
  }
  if (!streams_ && share != 1 && share != 0 && !robot_.device.capability.takes_speed) {
    return refused(ErrorCode::kTaskNotSupported);
  }
  if (task_ && task_->motion != nullptr && task_->kind == TaskKind::kMotion) {
    if (auto fed = task_->motion->set_feed(share); !fed) return fed;
  }
  feed_ = share;
  return {};
}

Expected<void> Controller::declare(const Declare& where, const Asked& asked) {
  const Instant now = asked.now;
  if (const auto rest = at_rest(now); !rest) return rest;
  if (where.positions.size() != robot_.joints.size()) {
    return std::unexpected(
        Error{ErrorCode::kMoveInput, -1, static_cast<double>(where.positions.size())});
  }
  for (std::size_t j = 0; j < where.positions.size(); ++j) {
    const JointPosition& one = where.positions[j];
    if (one.quality == PositionQuality::kLost) continue;
    const bool ordered = one.lower <= one.q && one.q <= one.upper;
    if (!std::isfinite(one.q) || !ordered) {
      return std::unexpected(
          Error{ErrorCode::kMoveInput, static_cast<std::int8_t>(j), one.q, one.upper});
    }
    const Joint& joint = robot_.joints[j];
    const double beyond = reach_beyond_limits(joint);
    if (one.q < joint.lower - beyond || one.q > joint.upper + beyond) {
      return std::unexpected(Error{ErrorCode::kJointLimit, static_cast<std::int8_t>(j), one.q,
                                   one.q < joint.lower ? joint.lower : joint.upper});
    }
  }
  if (const auto error = contradiction(where)) return std::unexpected(*error);
  const JournalPositions before(driver_.positions());
  driver_.declare_positions({where.positions.data(), where.positions.size()});
  if (const auto error = dropped(where)) {
    driver_.declare_positions({before.data(), before.size()});
    return std::unexpected(*error);
  }
  if (where.zeroes_counters) {
    if (const auto accepted = driver_.zero_counters(now); !accepted) return accepted;
    ++outstanding_;
    task_ = Task{asked.command.id, TaskKind::kTool, nullptr, now, true};
  }
  stand_where_driver_says(Setpoint::kForgotten);
  if (journal_) offer(journal_->told(JournalKind::kDeclared, driver_.positions(), time(now)));
  return {};
}

/// Held against all that is known of the joint otherwise, whoever has looked.
std::optional<Error> Controller::contradiction(const Declare& where) const {
  const auto known = positions();
  for (std::size_t j = 0; !where.moved && j < where.positions.size(); ++j) {
    const JointPosition& said = where.positions[j];
    if (said.quality == PositionQuality::kLost) continue;
    FixedVector<Evidence, 2> evidence;
    if (const auto counted = driver_.counted(j)) {
      evidence.push_back({Evidence::Source::kCounters, *counted, kSamePlace});
    }
    if (known[j].quality != PositionQuality::kLost) {
      evidence.push_back(evidence_of(robot_, j, known[j]));
    }
    const auto agreed = agree(j, {evidence.data(), evidence.size()}, said);
    if (!agreed) return agreed.error();
  }
  return std::nullopt;
}

/// The first joint whose statement the driver did not keep: its device knows better.
std::optional<Error> Controller::dropped(const Declare& where) const {
  const auto kept = driver_.positions();
  for (std::size_t j = 0; j < where.positions.size(); ++j) {
    const bool stated = where.positions[j].quality != PositionQuality::kLost;
    if (!stated || is_left_out(robot_, j)) continue;
    const std::array known{evidence_of(robot_, j, kept[j])};
    const bool lost = kept[j].quality == PositionQuality::kLost;
    if (!lost && agree(j, known, where.positions[j])) continue;
    return Error{ErrorCode::kNotHomed, static_cast<std::int8_t>(j)};
  }
  return std::nullopt;
}

/// False: the device is being told, and the end of that is the command's.
Expected<bool> Controller::acknowledge(const Command& command, const Inputs& inputs, Instant now) {
  const bool latched = state_ == MachineState::kFault && latched_;
  if (!latched || acknowledging_) return refused(ErrorCode::kWrongState);
  const auto of_disk = [](const Latched& one) { return one.cause == StopCause::kNotRecorded; };
  // A disk that failed once is not trusted again by this run.
  if (journal_ && inputs.journal_failed &&
      (of_disk(*latched_) || std::ranges::any_of(later_, of_disk))) {
    return refused(ErrorCode::kNotRecorded);
  }
  acknowledging_ = Acknowledging{.command = command.id, .since = now};
  if (const auto error = clear_device(now)) {
    acknowledging_.reset();
    return std::unexpected(*error);
  }
  if (device_being_told()) return false;
  acknowledging_.reset();
  acknowledged(now);
  return true;
}

/// What a stop still under way latches in the device can be cleared only behind it.
std::optional<Error> Controller::clear_device(Instant now) {
  if (acknowledging_->cleared || driver_.state() != DriverState::kFault) return std::nullopt;
  acknowledging_->cleared = true;
  const auto cleared = driver_.clear_fault(now);
  return cleared ? std::nullopt : std::optional(cleared.error());
}

bool Controller::device_being_told() const {
  return driver_.clearing() || driver_.state() == DriverState::kStopping;
}

void Controller::acknowledged(Instant now) {
  close_on_purpose(driver_, now);
  latched_.reset();
  later_.clear();
  change(Signal::kAcknowledge);
}

Error Controller::unknown_position() const {
  const auto all = positions();
  for (std::size_t j = 0; j < all.size(); ++j) {
    if (all[j].quality >= PositionQuality::kCommanded || is_left_out(robot_, j)) continue;
    return {ErrorCode::kPositionUnknown, static_cast<std::int8_t>(j)};
  }
  return {ErrorCode::kPositionUnknown};
}

}  // namespace sinew::control
