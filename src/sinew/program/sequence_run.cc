#include "sinew/program/sequence_run.h"

#include <algorithm>

namespace sinew::sequence {

Run::Run(const Program& program, const RobotModel& robot, BigRobotArmDriver& driver,
         Duration opening_limit)
    : program_(program),
      robot_(robot),
      driver_(driver),
      opening_limit_(opening_limit),
      opening_trouble_{.code = ErrorCode::kDeviceSilent, .limit = to_seconds(opening_limit)} {}

void Run::start(Instant now) {
  opened_at_ = now;
  driver_.open(now);
}

void Run::stop() {
  if (phase_ == Phase::kRunning) phase_ = current_ ? Phase::kStopping : Phase::kStopped;
  if (phase_ == Phase::kOpening) phase_ = Phase::kStopped;
}

std::optional<Record> Run::under_way() const {
  return current_;
}

void Run::poll(Instant now) {
  while (const auto event = driver_.take_event()) {
    if (finished()) continue;
    if (const auto* status = std::get_if<BigRobotArmDriver::StatusRead>(&*event)) {
      if (phase_ == Phase::kOpening) take(*status);
    } else if (const auto* failed = std::get_if<BigRobotArmDriver::Failed>(&*event)) {
      take(*failed);
    } else if (std::holds_alternative<BigRobotArmDriver::Started>(*event)) {
      if (current_) current_->started = now;
    } else if (const auto* done = std::get_if<BigRobotArmDriver::Done>(&*event); done && current_) {
      current_->done = now;
      current_->q_reported = done->q;
      records_.push_back(*current_);
      current_.reset();
      if (phase_ == Phase::kStopping && closing_.empty()) prepare_closing();
    }
  }
  if (phase_ == Phase::kOpening && now - opened_at_ > opening_limit_) fail(opening_trouble_);
  const bool on = phase_ == Phase::kRunning || phase_ == Phase::kStopping;
  if (on && !current_) issue_next(now);
}

/// The next program must not find speeds that were meant for one move of this one.
void Run::prepare_closing() {
  const Order& last = *records_.back().order;
  Order order = last;
  if (last.set.speeds != last.wanted.speeds) {
    order.what = SpeedsOrder{last.wanted.speeds};
    closing_.push_back(order);
  }
  if (last.set.accelerations != last.wanted.accelerations) {
    order.what = AccelerationsOrder{last.wanted.accelerations};
    closing_.push_back(order);
  }
}

const Order* Run::next_order() {
  if (phase_ == Phase::kStopping) {
    return closing_next_ < closing_.size() ? &closing_[closing_next_++] : nullptr;
  }
  return next_ < plan_.orders.size() ? &plan_.orders[next_++] : nullptr;
}

/// While the port opens, a device may be deaf or talk nonsense for a while; the driver asks again.
void Run::take(const BigRobotArmDriver::Failed& failed) {
  const bool for_good = failed.error.code == ErrorCode::kPortClosed;
  if (phase_ != Phase::kOpening || for_good) return fail(failed.error);
  if (failed.error.code != ErrorCode::kDeviceSilent) opening_trouble_ = failed.error;
}

/// The device's own word on where it is and how it is set: the plan is made for that.
void Run::take(const BigRobotArmDriver::StatusRead& read) {
  looked_like_boot_ = read.looks_like_boot;
  const auto& status = read.status;
  // Switching it off for the user would leave the arm where its reports do not say it is.
  if (status.sync) return fail({.code = ErrorCode::kDeviceSync});
  auto plan = make_plan(program_, robot_, {status.positions, status.speeds, status.accelerations});
  if (!plan) {
    failure_ = plan.error();
    phase_ = Phase::kFailed;
    return;
  }
  plan_ = std::move(*plan);
  records_.reserve(plan_.orders.size() + closing_.capacity());
  phase_ = Phase::kRunning;
}

void Run::issue_next(Instant now) {
  const Order* order = next_order();
  if (order == nullptr) {
    phase_ = phase_ == Phase::kStopping ? Phase::kStopped : Phase::kDone;
    return;
  }
  current_ = Record{.order = order, .asked = now, .started = now, .done = now, .q_reported = {}};
  if (const auto accepted = issue(*order, now); !accepted) fail(accepted.error());
}

Expected<void> Run::issue(const Order& order, Instant now) {
  if (const auto* move = std::get_if<MoveOrder>(&order.what)) {
    const Duration expected = from_seconds(move->duration);
    return move->home ? driver_.home(expected, now) : driver_.move_to(move->q, expected, now);
  }
  if (const auto* speeds = std::get_if<SpeedsOrder>(&order.what)) {
    return driver_.set_speeds(speeds->multipliers, now);
  }
  if (const auto* accelerations = std::get_if<AccelerationsOrder>(&order.what)) {
    return driver_.set_accelerations(accelerations->multipliers, now);
  }
  if (const auto* gripper = std::get_if<GripperOrder>(&order.what)) {
    return driver_.set_gripper(gripper->enabled, gripper->position, now);
  }
  return driver_.reset_positions(now);
}

void Run::fail(const Error& error) {
  failure_ = PlanRefusal{current_ ? current_->order->line : 0, error};
  current_.reset();
  phase_ = Phase::kFailed;
}

double Run::progress(Instant now) const {
  double done = 0;
  for (const Record& record : records_) {
    if (const auto* move = std::get_if<MoveOrder>(&record.order->what)) done += move->duration;
  }
  if (current_) {
    if (const auto* move = std::get_if<MoveOrder>(&current_->order->what)) {
      done += std::clamp(to_seconds(now - current_->started), 0.0, move->duration);
    }
  }
  return done;
}

}  // namespace sinew::sequence
