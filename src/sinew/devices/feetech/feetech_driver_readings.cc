#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/devices/feetech/feetech_driver.h"

namespace sinew {

using namespace feetech;
using Kind = DriverEvent::Kind;

namespace {

/// Units between two replies that are no motion.
constexpr double kStill = 2;
/// A limp arm sinks, and a hand moves it: it is ready all the same.
constexpr Duration kStandLimit = std::chrono::seconds(2);
constexpr Duration kStands = std::chrono::milliseconds(40);
/// rad that a joint may be behind its setpoint, so many replies in a row.
constexpr double kBehind = 0.35;
constexpr int kBehindReplies = 3;
/// A complaint counts if it stays: a supply dips as motors start.
constexpr int kTroubledReplies = 3;

}  // namespace

/// Goals first; a question in between.
void FeetechDriver::ask_what_is_due(Instant now) {
  if (!bus_.may_send(now)) return;
  if (activity_ == Activity::kOpening && opening_ < 2 * servos_.size()) {
    if (bus_.may_ask(now) && now >= poll_due_) ask_opening(now);
    return;
  }
  if (switch_ && !switch_->said) {
    if (!bus_.may_ask(now)) return;
    if (round_open_) return ask_next(now);
    say_switch(now);
    begin_round(now);
    return;
  }
  if (ticks() && now >= tick_due_) {
    tick_due_ = now + tick();
    if (!switch_) say_goals(now);
    poll_due_ = now;
  }
  if (!bus_.may_ask(now)) return;
  if (round_open_) return ask_next(now);
  if (now >= poll_due_) begin_round(now);
}

void FeetechDriver::begin_round(Instant now) {
  round_.clear();
  round_open_ = true;
  const bool together = servos_.device().sts() && !one_by_one_;
  if (!together) {
    for (std::size_t i = 0; i < servos_.size(); ++i) round_.push_back(i);
    return ask_next(now);
  }
  SyncRead read{FeetechServos::kStateFrom, FeetechServos::kStateCount, {}};
  for (std::size_t i = 0; i < servos_.size(); ++i) read.ids.push_back(servos_.id(i));
  ++health_.requests;
  bus_.ask(read, now);
}

void FeetechDriver::ask_next(Instant now) {
  if (round_.empty()) return round_over(now);
  if (!bus_.may_ask(now)) return;
  const std::size_t i = round_[0];
  round_.drop_front(1);
  ++health_.requests;
  bus_.ask(Read{servos_.id(i), FeetechServos::kStateFrom, FeetechServos::kStateCount}, now);
}

/// Settings and state of each servo, one after the other.
void FeetechDriver::ask_opening(Instant now) {
  const std::size_t i = opening_ / 2;
  const bool settings = opening_ % 2 == 0;
  ++health_.requests;
  bus_.ask(settings ? Read{servos_.id(i), 0, FeetechServos::kSettingsCount}
                    : Read{servos_.id(i), FeetechServos::kStateFrom, FeetechServos::kStateCount},
           now);
}

void FeetechDriver::take(const Reply& reply, Instant now) {
  const auto i = servos_.index_of(reply.id);
  if (!i) return;
  const Instant asked = bus_.asked_at();
  const bool opening = activity_ == Activity::kOpening && opening_ < 2 * servos_.size();
  if (opening && opening_ % 2 == 0) {
    servos_.take_settings(*i, reply.data);
    ++opening_;
    return;
  }
  if (!servos_.take_state(*i, reply, asked)) ++health_.unexpected;
  const FeetechServoState& servo = servos_[*i];
  if (opening) {
    ++opening_;
    rested_[*i] = servo.units;
    moved_at_[*i] = asked;
    poll_due_ = now;
    return;
  }
  if (std::abs(servo.units - rested_[*i]) > kStill) {
    rested_[*i] = servo.units;
    moved_at_[*i] = asked;
  }
  if (*i < servos_.joints()) behind_[*i] = follows(*i) ? 0 : behind_[*i] + 1;
  if (!bus_.asking()) ask_next(now);
}

/// Whether a joint that moves is near where it shall be.
bool FeetechDriver::follows(std::size_t joint) const {
  const bool moves = activity_ == Activity::kMoving && !switch_;
  if (!moves || servos_[joint].at < began_) return true;
  const double goal = servos_.device().q_of(joint, goal_[joint]);
  return std::abs(servos_.q(joint) - goal) <= kBehind;
}

void FeetechDriver::take_miss(const Ids& missing, Instant now) {
  for (const std::uint8_t id : missing) {
    const auto i = servos_.index_of(id);
    if (!i) continue;
    servos_.miss(*i);
    ++health_.timeouts;
    const bool again = servos_[*i].missed < timing_.tries;
    if (again) ++health_.retries;
    // An opening leaves out whoever is silent, to see whether all are.
    if (activity_ == Activity::kOpening && opening_ < 2 * servos_.size() && !again) {
      opening_ = 2 * (*i + 1);
    }
  }
  if (activity_ == Activity::kOpening && opening_ < 2 * servos_.size()) return;
  if (round_open_ && round_.empty()) {
    if (servos_.device().sts() && !one_by_one_ && ++broken_rounds_ >= 2) {
      one_by_one_ = true;
    }
    round_over(now);
  }
  if (activity_ == Activity::kOpening && opening_ >= 2 * servos_.size() && !round_open_) {
    step_opening(now);
  }
}

/// Every servo has replied, or did not.
void FeetechDriver::round_over(Instant now) {
  round_open_ = false;
  std::size_t silent = 0;
  bool whole = true;
  bool moves = false;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    moves = moves || servos_[i].speed != 0 || servos_[i].suspect;
    silent += servos_[i].missed >= timing_.tries ? 1 : 0;
    whole = whole && servos_[i].missed == 0;
  }
  if (whole) broken_rounds_ = 0;
  if (silent == servos_.size()) return fall_silent(now);
  const bool close = activity_ == Activity::kOpening || free() || moves;
  poll_due_ = now + (ticks() ? tick() : close ? timing_.free_poll : timing_.resting_poll);
  health_.supply_volts.reset();
  health_.temperature_c.reset();
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    const FeetechServoState& servo = servos_[i];
    if (!servo.known || servo.missed > 0) continue;
    const double volts = servo.volts / 10.0;
    health_.supply_volts = std::min(health_.supply_volts.value_or(volts), volts);
    health_.temperature_c = std::max(health_.temperature_c.value_or(servo.heat), 1.0 * servo.heat);
  }
  if (servos_.has_jaws() && !jaws_ && servos_[servos_.jaws()].known) {
    health_.jaws_width = servos_.width_of(servos_[servos_.jaws()].units);
  }
  if (switch_ && switch_->said && whole) step_switch(now);
  if (activity_ == Activity::kOpening) return step_opening(now);
  watch(now);
}

/// What no motion may go on with.
void FeetechDriver::watch(Instant now) {
  if (fault_) return;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    const FeetechServoState& servo = servos_[i];
    const auto index = static_cast<std::int8_t>(i);
    const bool joint = i < servos_.joints();
    if (servo.missed >= timing_.tries) return fail({ErrorCode::kServoSilent, index}, now);
    const bool off = servo.off >= 2;
    const bool stays = servo.troubled >= kTroubledReplies || (off && servo.troubled > 0);
    const auto trouble = stays ? servos_.trouble(i) : std::nullopt;
    // Jaws that hold something push against it.
    if (trouble && (joint || trouble->code != ErrorCode::kOverloaded)) return fail(*trouble, now);
    // Behind a short loss of power a goal has switched it on again, with its torque of old.
    const bool other = servo.torque_limit != limits_[i] && (set_up_ & servo_bit(i)) != 0;
    restarts_[i] = other ? restarts_[i] + 1 : 0;
    if (servo.torque && !switch_) on_ |= servo_bit(i);
    if ((on_ & servo_bit(i)) != 0 && (off || restarts_[i] >= 2) && !switch_) {
      on_ = static_cast<std::uint8_t>(on_ & ~servo_bit(i));
      set_up_ = static_cast<std::uint8_t>(set_up_ & ~servo_bit(i));
      if (joint) return fail({ErrorCode::kSupplyFlag, index}, now);
      commands_.tell(Kind::kNotice, {ErrorCode::kSupplyFlag, index});
    }
    if (!joint || behind_[i] < kBehindReplies) continue;
    const bool moving = activity_ == Activity::kMoving;
    fail({ErrorCode::kFollowingError, index}, now);
    // None pushes on against what is in its way.
    for (std::size_t k = 0; moving && k < servos_.joints(); ++k) {
      if (behind_[k] > 0) target_[k] = {servos_.q(k), 0};
    }
    return;
  }
}

/// What keeps an opened bus from being used.
std::optional<Error> FeetechDriver::unfit() const {
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    const bool silent = !servos_[i].known || servos_[i].missed >= timing_.tries;
    if (silent) return Error{ErrorCode::kServoSilent, static_cast<std::int8_t>(i)};
  }
  if (const auto misfit = servos_.misfit()) return misfit;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    const auto trouble = servos_.trouble(i);
    const bool holds = i >= servos_.joints() && trouble && trouble->code == ErrorCode::kOverloaded;
    if (trouble && !holds) return trouble;
  }
  return servos_.beyond_turn(0xFF);
}

void FeetechDriver::step_opening(Instant now) {
  bool any = false;
  bool silent = false;
  std::uint8_t overloaded = 0;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    any = any || servos_[i].known;
    const auto trouble = servos_.trouble(i);
    const bool protects = trouble && trouble->code == ErrorCode::kOverloaded;
    if (protects && i < servos_.joints()) overloaded |= servo_bit(i);
    silent = silent || servos_[i].missed >= timing_.tries;
  }
  if (!any) return fall_silent(now);
  if (silent) switch_.reset();
  if (switch_) return;
  if (clearing_ && !cycled_ && overloaded != 0) {
    cycled_ = true;
    switch_ = Switch{.servos = overloaded, .anew = true};
    return;
  }
  if (const auto error = unfit()) return fail(*error, now);
  // Motors that are on are told their torque, and that they stay where they are.
  std::uint8_t on = 0;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    if (servos_[i].torque && (set_up_ & servo_bit(i)) == 0) on |= servo_bit(i);
  }
  if (on != 0) {
    switch_ = Switch{.servos = on};
    return;
  }
  bool stands = true;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    stands = stands && servos_[i].at - moved_at_[i] >= kStands;
  }
  if (stands || now - opened_at_ > kStandLimit) become_ready(now);
}

void FeetechDriver::become_ready(Instant now) {
  activity_ = Activity::kIdle;
  told_silent_ = false;
  goes_on_until_.reset();
  poll_due_ = now;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    if (servos_[i].torque) on_ |= servo_bit(i);
  }
  update_positions(now);
  if (clearing_) {
    clearing_ = false;
    commands_.end_all(Kind::kDone);
  } else if (!fault_) {
    commands_.tell(Kind::kReady);
  }
  commands_.end_stop();
}

}  // namespace sinew
