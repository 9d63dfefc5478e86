#include "sinew/devices/grbl/grbl_device_planner.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"

namespace sinew::grbl {
namespace {

constexpr double kNoWay = 1e-9;  // units

double dot(const Values& a, const Values& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

Planner::Planner(std::span<const AxisRates> axes, double deviation)
    : axes_(axes), deviation_(deviation) {
  SINEW_ASSERT(!axes.empty() && deviation > 0);
  at_.resize(axes.size());
}

void Planner::clear() {
  blocks_.clear();
  along_ = speed_ = 0;
  held_ = false;
}

double Planner::velocity(std::size_t axis) const {
  return empty() ? 0 : speed_ * blocks_[0].direction[axis];
}

/// Of the path in this direction, so that no axis exceeds its own limit.
double Planner::most(const Values& direction, double AxisRates::* limit) const {
  double least = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const double share = std::abs(direction[i]);
    if (share > 0) least = std::min(least, axes_[i].*limit / share);
  }
  return least;
}

/// Square of the speed at which the corner between two motions is passed.
double Planner::corner(const Block& before, const Block& after) const {
  const double cosine = -dot(before.direction, after.direction);
  if (cosine > 0.999999) return 0;  // it turns back
  Values change;
  double length = 0;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    change.push_back(after.direction[i] - before.direction[i]);
    length += change[i] * change[i];
  }
  const double sine_half = std::sqrt((1 - cosine) / 2);
  if (length == 0 || sine_half >= 1) return std::numeric_limits<double>::max();
  for (double& one : change) one /= std::sqrt(length);
  return most(change, &AxisRates::acceleration) * deviation_ * sine_half / (1 - sine_half);
}

void Planner::push(const Values& to, double duration) {
  SINEW_ASSERT(!full() && to.size() == axes_.size() && duration > 0);
  Block block;
  block.from = at_;
  if (!empty()) {
    const Block& last = blocks_.back();
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      block.from[i] = last.from[i] + last.direction[i] * last.length;
    }
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) block.direction.push_back(to[i] - block.from[i]);
  block.length = std::sqrt(dot(block.direction, block.direction));
  if (block.length < kNoWay) return;
  for (double& one : block.direction) one /= block.length;
  block.acceleration = most(block.direction, &AxisRates::acceleration);
  block.nominal = std::min(block.length / duration, most(block.direction, &AxisRates::rate));
  if (!empty()) {
    const Block& last = blocks_.back();
    const double slower = std::min(block.nominal, last.nominal);
    block.entry_max = std::min(corner(last, block), slower * slower);
  }
  blocks_.push_back(block);
  look_ahead();
}

/// Each motion begins no faster than so that all behind it can be braked for. How fast it can
/// become before shows when it runs.
void Planner::look_ahead() {
  double exit = 0;
  for (std::size_t i = blocks_.size(); i-- > 1;) {
    Block& block = blocks_[i];
    block.entry = std::min(block.entry_max, exit + 2 * block.acceleration * block.length);
    exit = block.entry;
  }
}

void Planner::advance(double dt) {
  while (dt > 0 && !empty() && !(held_ && speed_ == 0)) dt = held_ ? brake(dt) : run(dt);
  if (empty()) return;
  const Block& block = blocks_[0];
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    at_[i] = block.from[i] + block.direction[i] * along_;
  }
}

/// The first motion is over. @return  what is left of the time
double Planner::end_block(double left) {
  const Block& block = blocks_[0];
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    at_[i] = block.from[i] + block.direction[i] * block.length;
  }
  blocks_.drop_front(1);
  along_ = 0;
  if (empty()) speed_ = 0;
  return left;
}

/// Faster, even, slower, as far as the time goes in the first motion. @return  what is left of it
double Planner::run(double dt) {
  const Block& block = blocks_[0];
  const double a = block.acceleration;
  const double d = block.length - along_;
  const double v2 = speed_ * speed_;
  // No faster than it can become on the rest of the way, as behind a hold.
  const double exit2 = blocks_.size() > 1 ? std::min(blocks_[1].entry, v2 + 2 * a * d) : 0;
  const double peak2 =
      std::max(v2, std::min(block.nominal * block.nominal, (2 * a * d + v2 + exit2) / 2));
  const double peak = std::sqrt(peak2);
  const double exit = std::sqrt(std::min(exit2, peak2));
  const double slower = std::min(d, (peak2 - exit * exit) / (2 * a));
  const double even = std::max(0.0, d - slower - (peak2 - v2) / (2 * a));
  const double t1 = (peak - speed_) / a;
  const double t2 = peak > 0 ? even / peak : 0;
  const double t3 = (peak - exit) / a;
  if (dt < t1) {
    along_ += dt * (speed_ + a * dt / 2);
    speed_ += a * dt;
    return 0;
  }
  if (dt < t1 + t2) {
    along_ = block.length - slower - (t1 + t2 - dt) * peak;
    speed_ = peak;
    return 0;
  }
  if (dt < t1 + t2 + t3) {
    const double left = t1 + t2 + t3 - dt;
    along_ = block.length - left * (exit + a * left / 2);
    speed_ = exit + a * left;
    return 0;
  }
  speed_ = exit;
  return end_block(dt - t1 - t2 - t3);
}

double Planner::brake(double dt) {
  const Block& block = blocks_[0];
  const double a = block.acceleration;
  const double d = block.length - along_;
  const double stop = speed_ / a;
  const bool ends = speed_ * speed_ > 2 * a * d;
  const double until = ends ? (speed_ - std::sqrt(speed_ * speed_ - 2 * a * d)) / a : stop;
  const double t = std::min(dt, until);
  along_ += t * (speed_ - a * t / 2);
  speed_ = std::max(0.0, speed_ - a * t);
  if (t < until) return 0;
  if (ends) return end_block(dt - t);
  speed_ = 0;
  return 0;
}

}  // namespace sinew::grbl
