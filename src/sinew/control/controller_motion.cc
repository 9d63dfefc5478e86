#include <algorithm>
#include <cmath>

#include "sinew/control/controller.h"

namespace sinew::control {

/// As much of the motion under way as its driver takes now.
void Controller::advance(Instant now) {
  if (!task_ || task_->kind == TaskKind::kTool) return;
  const bool braking = state_ == MachineState::kStopping && stopping_ && !stopping_->by_device;
  if (!granted() && !braking) return;
  if (task_->kind == TaskKind::kHome || task_->kind == TaskKind::kNudge) {
    if (!task_->begun && task_->kind == TaskKind::kNudge) return begin_nudge(now);
    if (!task_->begun) return begin_homing(now);
    if (task_->kind == TaskKind::kHome) follow_homing();
    if (standing(now) && driver_.state() == DriverState::kReady) arrive();
    return;
  }
  // Its record says that nothing is sent: a piece that comes too late for the last one waits.
  if (journal_ && driver_.looks()) return;
  while (const JointMove* piece = task_->motion->next(now)) {
    const bool ready = driver_.state() == DriverState::kReady;
    const bool asks = driver_.wants_move(now);
    // Who should take a piece and does not is asked why.
    if (!asks && !(ready && !task_->begun && now - task_->since > settings_.start_limit)) break;
    if (!hand_over(*piece, now)) return;
  }
  if (!braking && task_ && task_->motion->finished() && standing(now)) arrive();
}

void Controller::begin_homing(Instant now) {
  const std::uint8_t kept = task_->home.resumes ? still_found() : std::uint8_t{0};
  if (journal_ && !position_given_up_) {
    JournalPositions left(driver_.positions());
    // The search moves joints nobody knows how far.
    for (std::size_t j = 0; j < left.size(); ++j) {
      if ((kept >> j & 1U) == 0) left[j] = {};
    }
    const auto record = journal_->lost({left.data(), left.size()}, JournalCause::kUser, time(now));
    position_given_up_ = record.has_value();
    offer(record);
  }
  if (journal_ && (!position_given_up_ || !journal_->settled())) return;
  const auto joints = static_cast<std::uint8_t>(kAllJoints & ~unsigned{kept});
  if (const auto accepted = driver_.home(now, joints); !accepted) {
    return piece_refused(accepted.error(), now);
  }
  found_ = kept;
  searched_.reset();
  task_->begun = true;
  ++outstanding_;
  reference_known_ = false;
  governor_.lose();
}

/// Joints are searched for one after the other: the last one is found when the next one's turn
/// comes.
void Controller::follow_homing() {
  const auto joint = driver_.homing_joint();
  if (joint && searched_ && *joint != *searched_) {
    found_ = static_cast<std::uint8_t>(found_ | 1U << *searched_);
  }
  searched_ = joint;
}

/// What the last search has found and is known still; nothing where that is all of them.
std::uint8_t Controller::still_found() const {
  std::uint8_t found = 0;
  const auto known = driver_.positions();
  for (std::size_t j = 0; j < known.size(); ++j) {
    const bool kept = (found_ >> j & 1U) != 0 && known[j].quality != PositionQuality::kLost;
    if (kept) found = static_cast<std::uint8_t>(found | 1U << j);
  }
  return found + 1U == 1U << known.size() ? std::uint8_t{0} : found;
}

void Controller::begin_nudge(Instant now) {
  const Nudge& nudge = task_->nudge;
  if (journal_) {
    FixedVector<JointInterval, kMaxJoints> next;
    for (const JointPosition& joint : driver_.positions()) {
      next.push_back({joint.lower, joint.upper});
    }
    JointInterval& own = next[nudge.joint];
    own.lower += std::min(0.0, nudge.way);
    own.upper += std::max(0.0, nudge.way);
    const std::span<const JointInterval> reach(next.data(), next.size());
    offer(journal_->reserve({driver_.positions(), reach, reach}, time(now)));
    if (!journal_->may_send(reach)) return;
  }
  const double share = nudge.probes ? kProbeShare : kNudgeShare;
  const double speed = share * robot_.joints[nudge.joint].velocity_max;
  const Duration duration = from_seconds(std::abs(nudge.way) / speed);
  const auto accepted = nudge.probes ? driver_.probe(nudge.joint, nudge.way, duration, now)
                                     : driver_.nudge(nudge.joint, nudge.way, duration, now);
  if (!accepted) {
    return piece_refused(accepted.error(), now);
  }
  task_->begun = true;
  ++outstanding_;
  reference_known_ = false;
  governor_.lose();
}

/// The motion is at its end, and the driver has said so.
void Controller::arrive() {
  const bool found = state_ == MachineState::kRecovering;
  if (found) {
    // It is where a first move was sent, unless the driver contradicts.
    if (task_->kind == TaskKind::kBlindMotion && driver_knows()) {
      reference_ = blind_target_;
      reference_known_ = true;
    }
    stand_where_driver_says(Setpoint::kKept);
  } else {
    stand_at_setpoint();
  }
  end_task(ControlEvent::Kind::kDone);
  change(Signal::kArrived);
}

bool Controller::hand_over(const JointMove& piece, Instant now) {
  if (!recorded(piece, now)) return false;
  const bool blind = task_->kind == TaskKind::kBlindMotion;
  const auto passed = blind ? governor_.pass_blind(piece) : governor_.pass(piece);
  if (!passed) {
    piece_refused(passed.error(), now);
    return false;
  }
  if (blind) blind_target_ = piece.q;
  if (const auto accepted = driver_.move(piece, now); !accepted) {
    piece_refused(accepted.error(), now);
    return false;
  }
  ++outstanding_;
  sent_.sent(piece, state_ == MachineState::kStopping);
  task_->begun = true;
  task_->motion->taken();
  return true;
}

/// What it would do is safe on disk.
bool Controller::recorded(const JointMove& piece, Instant now) {
  if (!journal_) return true;
  const bool braking = state_ == MachineState::kStopping;
  const auto next = sent_.with(driver_.positions(), piece, braking);
  offer(journal_->reserve({driver_.positions(), next, task_->motion->whole()}, time(now)));
  if (journal_->may_send(next)) {
    waiting_since_.reset();
    return true;
  }
  if (!waiting_since_) waiting_since_ = now;
  // A stop on a way that leads where nothing is reserved, and the disk does not come back.
  if (braking && now - *waiting_since_ > PositionJournal::kOverdue) stop_device(now);
  return false;
}

/// Where nothing has moved yet it is the command that is refused, else the machine is stopped.
void Controller::piece_refused(const Error& error, Instant now) {
  if (task_ && task_->kind == TaskKind::kJog) jog_refused_ = error;
  end_task(ControlEvent::Kind::kFailed, error);
  const bool at_rest = standing(now);
  // Some devices latch a stop: at rest there is nothing to stop.
  if (at_rest && state_ != MachineState::kStopping) {
    change(Signal::kArrived);
  } else {
    stop(StopCause::kRefused, error, now);
  }
  // It is elsewhere than was planned: the next plan begins there.
  if (at_rest) stand_where_driver_says(Setpoint::kForgotten);
}

void Controller::offer(const std::optional<JournalRecord>& record) {
  if (!record) return;
  out_.records.push_back(*record);
  if (record->kind != JournalKind::kIntent) recorded_ = record->positions;
}

void Controller::record_rest(Instant now) {
  if (!journal_ || closed_) return;
  if (driver_.looks()) {
    const auto known = positions();
    return offer(journal_->look(known, time(now)));
  }
  if (!driver_spoke_ || may_move(state_)) return;
  const DriverState driver = driver_.state();
  const bool looked = driver == DriverState::kReady || driver == DriverState::kFault;
  // Where nothing measures, what an opening has found out so far counts: it may be all that ever
  // tells of it.
  if ((!looked && measures()) || !standing(now)) return;
  offer(journal_->at_rest(driver_.positions(), time(now)));
}

void Controller::record_end(Instant now) {
  // What it finds out belongs into the last record.
  if (!journal_ || closed_ || may_move(state_) || !standing(now) || driver_.looks()) return;
  if (driver_spoke_ && !measures()) recorded_ = JournalPositions(driver_.positions());
  const auto record = journal_->close({recorded_.data(), recorded_.size()}, time(now));
  closed_ = record.has_value();
  offer(record);
}

}  // namespace sinew::control
