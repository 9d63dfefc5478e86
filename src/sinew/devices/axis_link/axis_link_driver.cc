#include "sinew/devices/axis_link/axis_link_driver.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/model/left_out.h"

namespace sinew {

using namespace axis_link;
using Kind = DriverEvent::Kind;

namespace {

/// A setpoint never looks farther ahead than this, however late a round was.
constexpr Duration kRoundMax = std::chrono::milliseconds(50);
/// Rounds over which the look ahead is evened out.
constexpr int kRoundsOfAhead = 8;
/// rad. A target nearer than this to where an axis stands leaves that axis alone.
constexpr double kLeftAlone = 1.6e-3;  // an AS5600's count

/// Why the first axis that is out is out.
std::optional<Error> first_out(std::span<const Channel> channels) {
  for (const Channel& channel : channels) {
    if (const auto out = channel.error()) return out;
  }
  return std::nullopt;
}

Error with_index(Error error, std::size_t joint) {
  error.index = static_cast<std::int8_t>(joint);
  return error;
}

}  // namespace

AxisLinkDriver::AxisLinkDriver(const AxisLinkDevice& device, std::span<const Joint> joints,
                               const AxisLinkTiming& timing)
    : joints_(joints), clock_hz_(device.clock_hz), deadline_(device.deadline), timing_(timing) {
  SINEW_ASSERT(joints.size() == device.boards.size() && !joints.empty());
  SINEW_ASSERT(deadline_ >= kDeadlineMin && deadline_ <= kDeadlineMax && clock_hz_ > 0);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    channels_.push_back(
        Channel({static_cast<std::uint8_t>(i), joints[i], deadline_, timing.failures_max}));
    run_out_ = std::max(run_out_, channels_[i].run_out());
    if (device.boards[i].homing_place == kLeftOut) {
      left_out_ = static_cast<std::uint8_t>(left_out_ | 1U << i);
    }
  }
  positions_.resize(joints.size());
  homing_order_ = homing_order(device.boards);
}

void AxisLinkDriver::open(Instant now) {
  if (activity_ != Activity::kClosed) close(now);
  activity_ = Activity::kOpening;
  now_ = since_ = round_due_ = outs_due_ = health_due_ = now;
  clearing_ = false;
  fault_.reset();
  flight_ = Flight::kNone;
  to_all_due_.reset();
  axis_ = 0;
  known_out_ = {};
  healths_asked_ = 0;
  told_ = {};
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!is_out_by_choice(i)) channels_[i].begin(false, now);
  }
}

void AxisLinkDriver::close(Instant now) {
  if (activity_ == Activity::kClosed) return;
  now_ = now;
  end_commands(Kind::kFailed, {ErrorCode::kPortClosed});
  if (stop_asked_ || stop_in_opening_) tell(Kind::kStopped);
  stop_asked_ = stop_in_opening_ = false;
  activity_ = Activity::kClosed;
  queue_.clear();
  for (Channel& channel : channels_) channel.shut();
  update_positions(now);
}

DriverState AxisLinkDriver::state() const {
  switch (activity_) {
    case Activity::kClosed:
      return DriverState::kClosed;
    case Activity::kOpening:
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

std::optional<Instant> AxisLinkDriver::goes_on_until() const {
  if (activity_ != Activity::kStopping) return std::nullopt;
  return since_ + deadline_ + run_out_ + timing_.stop_margin;
}

DriverHealth AxisLinkDriver::health() const {
  DriverHealth health;
  health.requests = requests_;
  for (const Channel& channel : channels_) {
    health.unexpected += channel.failed_frames();
    // Of several axes the worst: the lowest supply, the hottest power stage.
    const axis_link::Health told = channel.health().value_or(axis_link::Health{});
    if (const auto millivolts = told.supply_mv) {
      health.supply_volts = std::min(health.supply_volts.value_or(1e9), *millivolts * 1e-3);
    }
    if (const auto hundredths = told.temperature_c01) {
      health.temperature_c = std::max(health.temperature_c.value_or(-1e9), *hundredths * 1e-2);
    }
  }
  return health;
}

DeviceFacts AxisLinkDriver::facts() const {
  AxisLinkFacts facts;
  for (const Channel& channel : channels_) facts.axes.push_back(channel.facts());
  facts.round = round_;
  return DeviceFacts(facts);
}

Expected<void> AxisLinkDriver::may_begin() const {
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  if (fault_) return std::unexpected(*fault_);
  return {};
}

bool AxisLinkDriver::wants_move(Instant) const {
  if (fault_ || to_all_due_) return false;
  if (activity_ == Activity::kMoving) return !settling_ && !queue_.full();
  return activity_ == Activity::kIdle && any_up();
}

Expected<void> AxisLinkDriver::check_axes(const JointMove& move) const {
  if (move.q.size() != channels_.size()) {
    return std::unexpected(Error{ErrorCode::kUnsendable, -1, static_cast<double>(move.q.size())});
  }
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (is_out_by_choice(i)) continue;
    if (const auto out = channels_[i].error()) {
      if (std::abs(move.q[i] - channels_[i].q()) <= kLeftAlone) continue;
      return std::unexpected(*out);
    }
    if (!channels_[i].is_referenced()) {
      return std::unexpected(with_index({ErrorCode::kPositionUnknown}, i));
    }
  }
  return {};
}

Expected<void> AxisLinkDriver::move(const JointMove& move, Instant now) {
  const bool goes_on = activity_ == Activity::kMoving && !settling_ && !queue_.full();
  if (!goes_on) {
    if (const auto may = may_begin(); !may) return may;
  }
  if (!any_up()) return std::unexpected(why_all_are_out());
  if (const auto checked = check_axes(move); !checked) return checked;
  // Where an axis was sent is smoother to start from than where its encoder's last count is.
  std::array<segments::Setpoint, kMaxJoints> start{};
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    start[i].q = is_out_by_choice(i) ? move.q[i] : told_[i].value_or(channels_[i].q());
  }
  const auto pushed = queue_.push(move, joints_, std::span(start).first(channels_.size()), now);
  if (!pushed) return pushed;
  ++pending_;
  if (goes_on) return {};
  activity_ = Activity::kMoving;
  settling_ = false;
  told_ = {};
  now_ = now;
  return {};
}

void AxisLinkDriver::stop(Instant now) {
  if (activity_ == Activity::kClosed) return tell(Kind::kStopped);
  begin_stop(Mode::kStop, now);
  stop_asked_ = stop_asked_ || activity_ == Activity::kStopping;
}

void AxisLinkDriver::emergency_stop(Instant now) {
  if (activity_ == Activity::kClosed) return tell(Kind::kStopped);
  begin_stop(Mode::kEmergencyStop, now);
  stop_asked_ = stop_asked_ || activity_ == Activity::kStopping;
}

void AxisLinkDriver::begin_stop(Mode mode, Instant now) {
  now_ = now;
  // An emergency stop that is due is not made milder.
  if (to_all_due_ != Mode::kEmergencyStop) to_all_due_ = mode;
  queue_.clear();
  settling_ = false;
  told_ = {};
  if (activity_ == Activity::kOpening) {
    // No session yet, and a stop needs none; the opening goes on.
    stop_in_opening_ = true;
    return;
  }
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (is_out_by_choice(i)) continue;
    channels_[i].follow(std::nullopt);
    channels_[i].command(*to_all_due_);
  }
  activity_ = Activity::kStopping;
  since_ = now;
}

Expected<void> AxisLinkDriver::home(Instant now, std::uint8_t joints) {
  if (const auto may = may_begin(); !may) return may;
  // All of them or none: who asks for home has a program that counts on every joint.
  if (const auto out = first_out(channels_)) return std::unexpected(*out);
  begin_turns(Activity::kHoming, joints, now);
  return {};
}

Expected<void> AxisLinkDriver::service(DeviceService what, Instant now) {
  if (what != DeviceService::kSelfTest) return std::unexpected(Error{ErrorCode::kNoSuchService});
  if (const auto may = may_begin(); !may) return may;
  // The result covers all of them.
  if (const auto out = first_out(channels_)) return std::unexpected(*out);
  begin_turns(Activity::kTesting, kAllJoints, now);
  return {};
}

void AxisLinkDriver::begin_turns(Activity activity, std::uint8_t joints, Instant now) {
  ++pending_;
  activity_ = activity;
  told_ = {};
  now_ = since_ = now;
  takes_turn_ = joints;
  take_turn(0);
}

/// The first that is up, of those whose turn is to come; none is left where all had it.
void AxisLinkDriver::take_turn(std::size_t place) {
  homing_place_ = place;
  for (; homing_place_ < homing_order_.size(); ++homing_place_) {
    const std::uint8_t joint = homing_order_[homing_place_];
    const bool wanted = (takes_turn_ >> joint & 1U) != 0 && channels_[joint].is_up();
    if (!wanted) continue;
    return channels_[joint].command(activity_ == Activity::kHoming ? Mode::kHome : Mode::kSelfTest);
  }
}

Expected<void> AxisLinkDriver::clear_fault(Instant now) {
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  ++pending_;
  clearing_ = true;
  activity_ = Activity::kOpening;
  now_ = since_ = now;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!channels_[i].is_out()) continue;
    channels_[i].begin(true, now);
    known_out_[i] = false;
    told_[i].reset();
  }
  return {};
}

std::optional<spi::Transfer> AxisLinkDriver::take_transfer(Instant now) {
  if (activity_ == Activity::kClosed || flight_ != Flight::kNone) return std::nullopt;
  now_ = now;
  if (to_all_due_) {
    const auto all = static_cast<std::uint8_t>(((1U << channels_.size()) - 1) & ~left_out_);
    flight_ = Flight::kToAll;
    return transfer_to(all, encode(Request{.to_all = true, .mode = *to_all_due_}));
  }
  if (!next_axis(now)) return std::nullopt;
  Channel& channel = channels_[axis_];
  if (activity_ == Activity::kMoving && channel.is_up()) {
    channel.follow(queue_.at(axis_, now + ahead_));
  }
  flight_ = Flight::kToOne;
  return transfer_to(static_cast<std::uint8_t>(1U << axis_), encode(channel.next_request(now)));
}

/// Puts axis_ on the axis whose frame is due; false where none is.
bool AxisLinkDriver::next_axis(Instant now) {
  if (axis_ == 0) {
    if (now < round_due_) return false;
    round_ = std::clamp(now - round_began_, Duration::zero(), kRoundMax);
    // Evened out: after a pause the next round is a short one again, and a setpoint that looks as
    // far ahead as the pause was long would be a jump there and back.
    const Duration most = timing_.cycle;
    ahead_ += std::clamp(round_ - ahead_, -most, most) / kRoundsOfAhead;
    round_began_ = now;
    round_due_ = now + timing_.cycle;
    // An axis that is out costs its share of the wire; seldom is enough, but for a stop.
    serve_outs_ = now >= outs_due_ || activity_ == Activity::kStopping;
    if (serve_outs_) outs_due_ = now + timing_.retry;
  }
  const auto passed_by = [&](std::size_t i) {
    return is_out_by_choice(i) || (channels_[i].is_out() && !serve_outs_);
  };
  while (axis_ < channels_.size() && passed_by(axis_)) ++axis_;
  if (axis_ < channels_.size()) return true;
  axis_ = 0;
  const bool all_out = std::ranges::all_of(channels_, [](const Channel& channel) {
    return channel.is_out() || channel.step() == Channel::Step::kShut;
  });
  if (all_out) round_due_ = std::max(round_due_, outs_due_);
  return false;
}

spi::Transfer AxisLinkDriver::transfer_to(std::uint8_t select, const Frame& frame) const {
  return {.select = select,
          .mosi = spi::Bytes(std::span<const std::uint8_t>(frame)),
          .setup = timing_.select_setup,
          .clock_hz = clock_hz_};
}

void AxisLinkDriver::exchanged(std::span<const std::uint8_t> miso, Instant now) {
  const Flight flight = flight_;
  flight_ = Flight::kNone;
  if (activity_ == Activity::kClosed || flight == Flight::kNone) return;
  now_ = now;
  ++requests_;
  if (flight == Flight::kToAll) {
    // Several axes drove the line at once: what came back means nothing.
    to_all_due_.reset();
    if (stop_in_opening_) tell(Kind::kStopped);
    stop_in_opening_ = false;
  } else {
    channels_[axis_].replied(miso, now);
    axis_ = (axis_ + 1) % channels_.size();
  }
  step(now);
}

void AxisLinkDriver::poll(Instant now) {
  if (activity_ == Activity::kClosed) return;
  now_ = now;
  step(now);
}

std::optional<Instant> AxisLinkDriver::next_deadline() const {
  if (activity_ == Activity::kClosed || flight_ != Flight::kNone) return std::nullopt;
  return to_all_due_ || axis_ != 0 ? now_ : std::max(now_, round_due_);
}

std::optional<DriverEvent> AxisLinkDriver::take_event() {
  return events_.take_front();
}

void AxisLinkDriver::tell(DriverEvent::Kind kind, const Error& error) {
  SINEW_ASSERT(!events_.full());
  events_.push_back({kind, error});
}

void AxisLinkDriver::end_commands(DriverEvent::Kind kind, const Error& error) {
  for (; pending_ > 0; --pending_) tell(kind, error);
}

bool AxisLinkDriver::any_up() const {
  return std::ranges::any_of(channels_, [](const Channel& channel) { return channel.is_up(); });
}

/// The first one's reason, and no board's where all are silent alike.
Error AxisLinkDriver::why_all_are_out() const {
  const auto first =
      std::ranges::find_if(channels_, [](const Channel& channel) { return channel.is_out(); });
  Error error = first != channels_.end() ? *first->error() : Error{ErrorCode::kDeviceSilent};
  const bool all_silent = std::ranges::all_of(channels_, [](const Channel& channel) {
    return !channel.error() || channel.error()->code == ErrorCode::kDeviceSilent;
  });
  if (all_silent) error.index = -1;
  return error;
}

void AxisLinkDriver::update_positions(Instant now) {
  for (std::size_t i = 0; i < channels_.size(); ++i) positions_[i] = channels_[i].position(now);
}

}  // namespace sinew
