#include "sinew/devices/ideal/ideal_device.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::ideal {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(1);
/// s. Longer is a mistake of units.
constexpr std::uint32_t kDurationMax = 3'600'000'000;
/// Of a joint's speed: pieces that are cut out of a smooth motion swing so much.
constexpr double kSpeedShare = 1.02;
/// rad or m: likewise beyond a limit.
constexpr double kSwing = 2e-4;
/// s: no stop is shorter than a tick.
constexpr double kBrakeMin = 1e-3;

}  // namespace

IdealDevice::IdealDevice(std::span<const Joint> joints, const std::optional<JawGripper>& gripper,
                         Instant boot)
    : joints_(joints), now_(boot), heard_(boot) {
  SINEW_ASSERT(!joints.empty() && joints.size() <= kJointsMax);
  for (const Joint& joint : joints) {
    q_.push_back(joint.home);
    qd_.push_back(0);
    free_.push_back({});
  }
  for (std::size_t i = 0; i < joints.size(); ++i) unblock(i);
  if (gripper) width_max_ = jaws_ = jaws_to_ = gripper->width_max;
}

void IdealDevice::unblock(std::size_t joint) {
  constexpr double kAnywhere = 1e9;
  free_[joint] = {-kAnywhere, kAnywhere};
}

void IdealDevice::block(std::size_t joint, double at) {
  (at >= q_[joint] ? free_[joint].upper : free_[joint].lower) = at;
}

void IdealDevice::place(std::span<const double> q) {
  SINEW_ASSERT(q.size() == q_.size());
  std::ranges::copy(q, q_.begin());
}

void IdealDevice::lose_power() {
  held_ = Held::kStarted;
  end_at(Phase::kHeld);
  taken_ = done_ = 0;
  blocked_joint_ = 0;
  jaws_to_ = jaws_;
}

bool IdealDevice::Piece::ends_at_rest() const {
  return std::ranges::all_of(joints, [](const Cubic& one) { return one.end().qd == 0; });
}

void IdealDevice::end_at(Phase phase) {
  phase_ = phase;
  pieces_.clear();
  time_ = 0;
  rate_ = 1;
  std::ranges::fill(qd_, 0.0);
}

void IdealDevice::stand() {
  end_at(held_ == Held::kNo ? Phase::kRest : Phase::kHeld);
}

void IdealDevice::begin_stop(Held held) {
  if (phase_ != Phase::kMoving) return;
  held_ = held;
  phase_ = Phase::kStopping;
  brake_time_ = kBrakeMin;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    brake_time_ = std::max(brake_time_, std::abs(qd_[i]) / joints_[i].acceleration_max);
  }
}

// Time

void IdealDevice::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  while (now_ < now) {
    if (!moving() && jaws_ == jaws_to_) {
      now_ = now;
      return;
    }
    if (phase_ == Phase::kMoving && now_ - heard_ >= kDeadline) begin_stop(Held::kSilent);
    const Instant next = std::min(now, now_ + kTick);
    step(to_seconds(next - now_));
    now_ = next;
  }
}

void IdealDevice::step(double dt) {
  if (width_max_) {
    const double way = *width_max_ * dt / to_seconds(sinew::IdealDevice::kJawsStroke);
    const double least = std::min(jaws_, std::max(jaws_to_, jaws_least_));
    jaws_ = std::clamp(jaws_to_, std::max(jaws_ - way, least), jaws_ + way);
  }
  if (!moving()) return;
  if (phase_ == Phase::kStopping) {
    const double before = rate_;
    rate_ = std::max(0.0, before - dt / brake_time_);
    time_ += (before + rate_) / 2 * std::min(dt, before * brake_time_);
  } else {
    time_ += dt;
  }
  while (pieces_.size() > 1 && time_ >= pieces_[0].duration) {
    time_ -= pieces_[0].duration;
    done_ = pieces_[0].number;
    pieces_.drop_front(1);
  }
  put_joints();
  if (runs_into_something()) return;
  const Piece& last = pieces_[0];
  if (time_ >= last.duration && last.ends_at_rest()) {
    // A stop that was asked for may come to the end of the way before it comes to its own.
    done_ = last.number;
    return stand();
  }
  if (time_ >= last.duration) begin_stop(Held::kStarved);
  if (rate_ == 0) stand();
}

/// Where the first piece is at `time_`; beyond its end straight on, as far as the joint can.
void IdealDevice::put_joints() {
  const Piece& piece = pieces_[0];
  for (std::size_t i = 0; i < q_.size(); ++i) {
    const Cubic::State there = piece.joints[i].at(time_);
    const double beyond = std::max(0.0, time_ - piece.duration) * there.qd;
    const double lower = std::min(joints_[i].lower, there.q);
    const double upper = std::max(joints_[i].upper, there.q);
    q_[i] = std::clamp(there.q + beyond, lower, upper);
    qd_[i] = q_[i] == there.q + beyond ? there.qd * rate_ : 0;
  }
}

bool IdealDevice::runs_into_something() {
  for (std::size_t i = 0; i < q_.size(); ++i) {
    const double inside = std::clamp(q_[i], free_[i].lower, free_[i].upper);
    if (q_[i] == inside) continue;
    q_[i] = inside;
    held_ = Held::kBlocked;
    blocked_joint_ = static_cast<int>(i);
  }
  if (held_ != Held::kBlocked) return false;
  end_at(Phase::kHeld);
  return true;
}

// Requests

State IdealDevice::state() const {
  State state{.phase = phase_,
              .held = phase_ == Phase::kHeld ? held_ : Held::kNo,
              .joint = static_cast<std::uint8_t>(blocked_joint_),
              .taken = taken_,
              .done = done_,
              .jaws_um = -1,
              .q = {},
              .qd = {}};
  if (width_max_) state.jaws_um = micro(jaws_);
  for (std::size_t i = 0; i < q_.size(); ++i) {
    state.q.push_back(micro(q_[i]));
    state.qd.push_back(micro(qd_[i]));
  }
  return state;
}

/// Neither leaves the joint's range nor is faster than its speed, on the whole way. From beyond a
/// limit it may come back.
bool IdealDevice::allows(std::size_t joint, double from, const Cubic& way) const {
  const Joint& one = joints_[joint];
  const double lower = std::min(one.lower, from) - kSwing;
  const double upper = std::max(one.upper, from) + kSwing;
  const auto inside = [&](double q) { return q >= lower && q <= upper; };
  bool fine = inside(way.end().q);
  way.for_turns([&](double q) { fine = fine && inside(q); });
  // What rounding to the wire's units may add, at both ends.
  const double rounding = 2 * kMicro / way.duration();
  return fine && way.peak_speed() <= kSpeedShare * one.velocity_max + rounding;
}

Reply IdealDevice::take(const Move& move) {
  if (move.number == taken_) return state();  // said again: the answer was lost
  if (move.number != static_cast<std::uint16_t>(taken_ + 1)) return Refusal{Why::kNumber};
  const bool runs = phase_ == Phase::kMoving;
  if ((phase_ != Phase::kRest && !runs) || pieces_.full()) return Refusal{Why::kBusy};
  const bool whole = move.q.size() == q_.size() && move.qd.size() == q_.size();
  if (!whole || move.duration_us == 0 || move.duration_us > kDurationMax) {
    return Refusal{Why::kForm};
  }
  Piece piece;
  piece.number = move.number;
  piece.duration = move.duration_us * kMicro;
  for (std::size_t i = 0; i < q_.size(); ++i) {
    const Cubic::State from = runs ? pieces_.back().joints[i].end() : Cubic::State{q_[i], 0};
    const Cubic::State to{move.q[i] * kMicro, move.qd[i] * kMicro};
    piece.joints.push_back(Cubic(from, to, piece.duration));
    if (!allows(i, from.q, piece.joints.back())) {
      return Refusal{Why::kLimit, static_cast<std::uint8_t>(i)};
    }
  }
  pieces_.push_back(piece);
  taken_ = move.number;
  phase_ = Phase::kMoving;
  return state();
}

Reply IdealDevice::take(const Jaws& jaws) {
  const double width = jaws.width_um * kMicro;
  if (!width_max_ || width < 0 || width > *width_max_ + kMicro) return Refusal{Why::kTool};
  jaws_to_ = width;
  return state();
}

Reply IdealDevice::answer(const Request& request, Instant now) {
  advance(now);
  heard_ = now;
  if (const auto* move = std::get_if<Move>(&request)) return take(*move);
  if (const auto* jaws = std::get_if<Jaws>(&request)) return take(*jaws);
  if (std::holds_alternative<Hello>(request)) {
    return Identity{kVersion, static_cast<std::uint8_t>(q_.size()), taken_};
  }
  if (std::holds_alternative<Stop>(request)) {
    begin_stop(Held::kNo);
    jaws_to_ = jaws_;
  }
  if (std::holds_alternative<Clear>(request) && phase_ == Phase::kHeld) {
    held_ = Held::kNo;
    phase_ = Phase::kRest;
    blocked_joint_ = 0;
  }
  return state();
}

}  // namespace sinew::ideal
