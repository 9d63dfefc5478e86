#include "sinew/motion/step_timing.h"

#include <bit>

namespace sinew::motion {
namespace {

/// floor(a u / 2^32), from two products of 32 bits: what a small processor has.
std::int64_t scaled(std::int64_t a, std::uint32_t u) {
  const std::int64_t upper = (a >> 32) * static_cast<std::int64_t>(u);
  const std::uint64_t lower = static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) * u;
  return upper + static_cast<std::int64_t>(lower >> 32);
}

constexpr int kReciprocalBits = 30;

/// 2^62 / m for m with its top bit set, to 16 bits. Linear start, 1/17 off at most, then two
/// rounds of Newton's, each of which squares the error.
std::uint32_t reciprocal(std::uint32_t m) {
  constexpr std::uint64_t kStart = 3'031'741'621;  // 48/17 in 2^-30
  constexpr std::uint64_t kSlope = 2'021'161'081;  // 32/17 in 2^-30
  std::uint64_t x = kStart - ((kSlope * m) >> 32);
  for (int i = 0; i < 2; ++i) {
    const std::uint64_t product = (x * m) >> 32;
    x = (x * ((std::uint64_t{2} << kReciprocalBits) - product)) >> kReciprocalBits;
  }
  return static_cast<std::uint32_t>(x);
}

}  // namespace

int StepSegment::span_bits() const {
  return static_cast<int>(std::bit_width(duration));
}

std::int64_t StepSegment::way(std::uint32_t u) const {
  return scaled(c1 + scaled(c2 + scaled(c3, u), u), u);
}

void StepTimer::load(const StepSegment& segment) {
  segment_ = segment;
  loaded_ = true;
  made_ = 0;
  mantissa_ = 0;
  if (segment.direction == direction_) return;
  direction_ = segment.direction;
  interval_ = interval_before_ = 0;
}

/// Newton's slope at a tick: 1 / (c1 + 2 c2 u + 3 c3 u^2), a mantissa of 31 bits and an exponent.
void StepTimer::take_slope(std::uint32_t tick) {
  const std::uint32_t u = segment_.u_after(tick);
  const std::int64_t rise = scaled(3 * (segment_.c3 >> 2), u);
  const std::int64_t quarter = (segment_.c1 >> 2) + scaled((segment_.c2 >> 1) + rise, u);
  mantissa_ = 0;
  if (quarter <= 0) return;
  const auto speed = static_cast<std::uint64_t>(quarter);
  const int zeros = std::countl_zero(speed);
  mantissa_ = reciprocal(static_cast<std::uint32_t>((speed << zeros) >> 32));
  // 4 quarter per 2^span ticks; quarter = m 2^(32 - zeros); 1/m = mantissa 2^-62.
  slope_shift_ = 96 - segment_.span_bits() - zeros;
}

/// Ticks in which `missing` of the way is come; 0 where the slope says less than a half.
std::int64_t StepTimer::correction(std::int64_t missing) const {
  const auto size = static_cast<std::uint64_t>(missing < 0 ? -missing : missing);
  const auto bits = static_cast<int>(std::bit_width(size));
  const int cut = bits > 31 ? bits - 31 : 0;
  const std::uint64_t product = (size >> cut) * mantissa_;
  const int shift = slope_shift_ - cut;
  std::uint64_t ticks = 0;
  if (shift <= 0) {
    ticks = product == 0 ? 0 : StepSegment::kTicksMax;
  } else if (shift < 64) {
    ticks = (product + (std::uint64_t{1} << (shift - 1))) >> shift;
  }
  if (ticks > StepSegment::kTicksMax) ticks = StepSegment::kTicksMax;
  return missing < 0 ? -static_cast<std::int64_t>(ticks) : static_cast<std::int64_t>(ticks);
}

/// The first tick after `lower` at whose end, half a tick later, `target` of the way is come. The
/// host has counted the steps, so the last tick is an answer.
std::uint32_t StepTimer::search(std::int64_t target, std::int64_t lower) {
  std::int64_t upper = static_cast<std::int64_t>(segment_.duration) - 1;
  const auto inside = [&](std::int64_t tick) {
    return tick <= lower ? lower + 1 : (tick >= upper ? upper - 1 : tick);
  };
  std::int64_t guess = last_ + 2 * interval_ - interval_before_;
  if (interval_ == 0 && made_ == 0) guess = lower + (upper - lower) / 2;
  int evaluations = 0;
  while (upper - lower > 1) {
    guess = inside(guess);
    const auto tick = static_cast<std::uint32_t>(guess);
    const std::int64_t missing = target - segment_.way(segment_.u_after(tick));
    (missing > 0 ? lower : upper) = guess;
    ++evaluations;
    if (upper - lower <= 1) break;
    if (evaluations != 1 || mantissa_ == 0) take_slope(tick);
    if (evaluations >= kNewtonMax || mantissa_ == 0) {
      guess = lower + (upper - lower) / 2;
      continue;
    }
    const std::int64_t ticks = correction(missing);
    guess += ticks != 0 ? ticks : (missing > 0 ? 1 : -1);
  }
  evaluations_ += static_cast<std::uint64_t>(evaluations);
  if (evaluations > evaluations_most_) evaluations_most_ = evaluations;
  return static_cast<std::uint32_t>(upper);
}

bool StepTimer::next(TimedStep& step) {
  if (!loaded_) return false;
  const std::int64_t offset = segment_.direction > 0 ? offset_ : -offset_;
  if (made_ == segment_.steps) {
    const std::int64_t way = segment_.way(segment_.u_at(segment_.duration));
    const std::int64_t left = offset + way - static_cast<std::int64_t>(made_) * StepSegment::kStep;
    offset_ = segment_.direction > 0 ? left : -left;
    begin_ += segment_.duration;
    last_ -= static_cast<std::int64_t>(segment_.duration);
    loaded_ = false;
    return false;
  }
  const std::int64_t middle =
      static_cast<std::int64_t>(made_) * StepSegment::kStep + StepSegment::kStep / 2;
  const std::int64_t lower = last_ < 0 ? -1 : last_;
  const auto tick = static_cast<std::int64_t>(search(middle - offset, lower));
  interval_before_ = interval_ == 0 ? tick - last_ : interval_;
  interval_ = tick - last_;
  last_ = tick;
  ++made_;
  position_ += segment_.direction;
  step = {begin_ + static_cast<std::uint64_t>(tick), segment_.direction};
  return true;
}

}  // namespace sinew::motion
