#include "sinew/devices/ideal/ideal_device.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::ideal {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(1);
constexpr double kMicro = 1e-6;
/// s. Longer is a mistake of units.
constexpr std::uint32_t kDurationMax = 3'600'000'000;
/// Of a joint's speed: what rounding and the middle of a cubic may add.
constexpr double kSpeedShare = 1.05;
/// s: no stop is shorter than a tick.
constexpr double kBrakeMin = 1e-3;

std::int32_t micro(double value) {
  return static_cast<std::int32_t>(std::lround(value / kMicro));
}

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
  held_ = Held::kNo;
  end_at(Phase::kRest);
  taken_ = done_ = 0;
  jaws_to_ = jaws_;
}

void IdealDevice::end_at(Phase phase) {
  phase_ = phase;
  pieces_.clear();
  time_ = 0;
  rate_ = 1;
  std::ranges::fill(qd_, 0.0);
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
    const double way = *width_max_ * dt / to_seconds(kJawsStroke);
    jaws_ += std::clamp(jaws_to_ - jaws_, -way, way);
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
  const bool ends_at_rest = std::ranges::all_of(last.tod, [](double speed) { return speed == 0; });
  if (time_ >= last.duration && ends_at_rest) {
    // A stop that was asked for may come to the end of the way before it comes to its own.
    done_ = last.number;
    return end_at(held_ == Held::kNo ? Phase::kRest : Phase::kHeld);
  }
  if (time_ >= last.duration) begin_stop(Held::kStarved);
  if (rate_ == 0) end_at(held_ == Held::kNo ? Phase::kRest : Phase::kHeld);
}

/// Where the first piece is at `time_`; beyond its end straight on.
/// Source: cubic Hermite interpolation, C. de Boor, A Practical Guide to Splines, 1978, ch. IV.
void IdealDevice::put_joints() {
  const Piece& piece = pieces_[0];
  const double T = piece.duration;
  const double t = std::min(time_, T);
  for (std::size_t i = 0; i < q_.size(); ++i) {
    const double mean = (piece.to[i] - piece.q[i]) / T;
    const double c2 = (3 * mean - 2 * piece.qd[i] - piece.tod[i]) / T;
    const double c3 = (piece.qd[i] + piece.tod[i] - 2 * mean) / (T * T);
    if (time_ >= T) {
      q_[i] = piece.to[i] + piece.tod[i] * (time_ - T);
      qd_[i] = piece.tod[i] * rate_;
    } else {
      q_[i] = piece.q[i] + t * (piece.qd[i] + t * (c2 + t * c3));
      qd_[i] = (piece.qd[i] + t * (2 * c2 + t * 3 * c3)) * rate_;
    }
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
    const Joint& joint = joints_[i];
    const double from = runs ? pieces_.back().to[i] : q_[i];
    const double to = move.q[i] * kMicro;
    const double speed = move.qd[i] * kMicro;
    const double lower = std::min(joint.lower, from) - kMicro;
    const double upper = std::max(joint.upper, from) + kMicro;
    const double most = joint.velocity_max * kSpeedShare;
    const bool slow = std::abs(speed) <= most && std::abs(to - from) <= most * piece.duration;
    if (!(to >= lower && to <= upper && slow)) {
      return Refusal{Why::kLimit, static_cast<std::uint8_t>(i)};
    }
    piece.q.push_back(from);
    piece.qd.push_back(runs ? pieces_.back().tod[i] : 0);
    piece.to.push_back(to);
    piece.tod.push_back(speed);
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
  if (std::holds_alternative<Stop>(request)) begin_stop(Held::kNo);
  if (std::holds_alternative<Clear>(request) && phase_ == Phase::kHeld) {
    held_ = Held::kNo;
    phase_ = Phase::kRest;
  }
  return state();
}

}  // namespace sinew::ideal
