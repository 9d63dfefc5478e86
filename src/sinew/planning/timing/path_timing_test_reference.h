#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sinew/planning/timing/path_timing_test_paths.h"

namespace sinew::planning::test_paths {

/// How long a path takes at best, from rest to rest, under the joints' velocities, accelerations
/// and jerks and the tool's: a long local optimisation that shares nothing with the planner. With
/// b = v^2 as a function of s every limit but the jerk's is linear, and
///   jerk = sqrt(b) (q''' b + 3/2 q'' b' + 1/2 q' b'').
/// b is a spline of parabolas; a barrier keeps it inside of all limits while Newton's steps make
/// the motion quicker, until the barrier weighs nothing. The limits are looked at in the middle and
/// at the ends of each parabola, so what it gives may be too short by a little of the grid's.
class QuickestMotion {
 public:
  QuickestMotion(const PlannedPath& path, std::span<const motion::AxisLimits> limits,
                 std::size_t cells)
      : path_(path), limits_(limits.begin(), limits.end()), n_(cells) {
    // Places lie close where it starts and ends: from rest s grows with t^3.
    const double length = path.joints.length();
    for (std::size_t k = 0; k <= n_; ++k) {
      const double x = static_cast<double>(k) / static_cast<double>(n_);
      s_.push_back(length * x * x * x * (10 - x * (15 - 6 * x)));
    }
    for (std::size_t k = 1; k < n_; ++k) add_limits(k);
    add_rest(1, 0);
    add_rest(n_ - 1, n_);
  }

  /// The time it takes, s.
  double duration() {
    start();
    double weight = 1;
    double last = time();
    for (int round = 0; round < 60; ++round) {
      for (int i = 0; i < 30; ++i) {
        if (newton(weight) < 1e-7) break;
      }
      const double now = time();
      if (weight * static_cast<double>(rows_.size()) > 1e5 && last - now < 1e-6 * now) break;
      last = now;
      weight *= 3;
    }
    return time();
  }
  /// v at each place.
  const std::vector<double>& squares() const { return b_; }
  const std::vector<double>& places() const { return s_; }

 private:
  /// least <= (x b[k-1] + y b[k] + z b[k+1]) <= bound, where the bound is `limit`, or that over the
  /// speed for a jerk.
  struct Row {
    std::size_t k;
    double x, y, z;
    double limit;
    bool jerk;
  };

  void add_limits(std::size_t k) {
    const double h0 = s_[k] - s_[k - 1];
    const double h1 = s_[k + 1] - s_[k];
    const double m = 2 / (h0 + h1);
    // b' at the middle, b'' / 2.
    const double d1[3] = {-1 / (h0 + h1), 0, 1 / (h0 + h1)};
    const double d2[3] = {m / h0 / 2, -m * (1 / h0 + 1 / h1) / 2, m / h1 / 2};
    const std::size_t piece = path_.joints.piece_at(s_[k]);
    PathPoint at;
    path_.joints.sample_piece(piece, s_[k] - path_.joints.begin(piece), at);
    std::size_t section = 0;
    while (section + 1 < path_.sections.size() && path_.sections[section + 1].begin <= s_[k]) {
      ++section;
    }
    const PathSection& asked = path_.sections[section];
    const ToolRate& tool = path_.tool[piece];
    double v = asked.tool_speed / std::max(tool.speed, 1e-12);
    for (std::size_t j = 0; j < limits_.size(); ++j) {
      const auto& [velocity, acceleration, jerk] = limits_[j];
      v = std::min(v, asked.joint_share * velocity / std::max(std::abs(at.dq[j]), 1e-12));
      // a = b' / 2
      rows_.push_back({k, at.dq[j] * d1[0] / 2 / acceleration,
                       (at.ddq[j] + at.dq[j] * d1[1] / 2) / acceleration,
                       at.dq[j] * d1[2] / 2 / acceleration, 1, false});
      rows_.push_back({k, (1.5 * at.ddq[j] * d1[0] + at.dq[j] * d2[0]) / jerk,
                       (at.dddq[j] + 1.5 * at.ddq[j] * d1[1] + at.dq[j] * d2[1]) / jerk,
                       (1.5 * at.ddq[j] * d1[2] + at.dq[j] * d2[2]) / jerk, 1, true});
    }
    if (std::isfinite(asked.tool_acceleration)) {
      for (const double sign : {-1.0, 1.0}) {
        rows_.push_back({k, sign * tool.speed * d1[0] / 2 / asked.tool_acceleration,
                         tool.curvature / asked.tool_acceleration,
                         sign * tool.speed * d1[2] / 2 / asked.tool_acceleration, 1, false});
      }
    }
    rows_.push_back({k, 0, 1, 0, std::min(v, 1e4) * std::min(v, 1e4), false});
  }

  /// One jerk between rest and the place next to it: v^3 = 9/2 jerk h^2, where mean(b) is 9/2 b.
  void add_rest(std::size_t k, std::size_t rest) {
    const double h = s_[k] - s_[rest];
    PathPoint at;
    path_.joints.sample(s_[rest], at);
    for (std::size_t j = 0; j < limits_.size(); ++j) {
      const double rate = at.dq[j] / limits_[j].jerk;
      rows_.push_back({k, 0, rate / (4.5 * h * h * std::sqrt(4.5)), 0, 1, true});
    }
  }

  /// Around a place: next to rest the place alone would let a motion gain acceleration there by
  /// standing still.
  static double mean(const std::vector<double>& b, std::size_t k) {
    return b[k - 1] / 4 + b[k] / 2 + b[k + 1] / 4;
  }
  /// What is left of a row's limit on both sides.
  bool slack(const Row& row, const std::vector<double>& b, double& value, double& bound) const {
    value = row.x * b[row.k - 1] + row.y * b[row.k] + row.z * b[row.k + 1];
    bound = row.jerk ? row.limit / std::sqrt(mean(b, row.k)) : row.limit;
    return bound > std::abs(value);
  }
  bool inside(const std::vector<double>& b) const {
    for (std::size_t k = 1; k < n_; ++k) {
      if (!(b[k] > 0)) return false;
    }
    double value = 0, bound = 0;
    for (const Row& row : rows_) {
      if (!slack(row, b, value, bound)) return false;
    }
    return true;
  }

  double time() const { return time(b_); }
  double time(const std::vector<double>& b) const {
    double sum = 0;
    for (std::size_t k = 0; k < n_; ++k) {
      sum += 2 * (s_[k + 1] - s_[k]) / (std::sqrt(b[k]) + std::sqrt(b[k + 1]));
    }
    return sum;
  }
  double merit(const std::vector<double>& b, double weight) const {
    double sum = weight * time(b) / scale_;
    double value = 0, bound = 0;
    for (const Row& row : rows_) {
      if (!slack(row, b, value, bound)) return std::numeric_limits<double>::infinity();
      sum -= std::log((bound - value) / bound) + std::log((bound + value) / bound);
    }
    return sum;
  }

  /// A motion as slow as needed to be inside.
  void start() {
    b_.assign(n_ + 1, 0);
    const double length = path_.joints.length();
    double square = 1;
    do {
      for (std::size_t k = 0; k <= n_; ++k) {
        const double x = std::min(s_[k], length - s_[k]) / length;
        b_[k] = square * std::pow(x, 4.0 / 3) / (1 + 4 * x);
      }
      b_[n_] = 0;
      square /= 2;
    } while (!inside(b_));
    scale_ = time();
  }

  /// One step; @return how much it promised, of the merit.
  double newton(double weight) {
    const std::size_t n = n_ - 1;
    g_.assign(n, 0);
    d0_.assign(n, 1e-300), d1_.assign(n, 0), d2_.assign(n, 0);
    const double w = weight / scale_;
    for (std::size_t k = 0; k < n_; ++k) add_time(k, w);
    for (const Row& row : rows_) add_row(row);
    // LDL' of the five diagonals, d0 the middle.
    step_ = g_;
    for (double& x : step_) x = -x;
    for (std::size_t i = 0; i < n; ++i) {
      const double p = d0_[i];
      if (i + 1 < n) {
        const double l = d1_[i] / p;
        d0_[i + 1] -= l * d1_[i];
        if (i + 2 < n) d1_[i + 1] -= l * d2_[i];
        step_[i + 1] -= l * step_[i];
      }
      if (i + 2 < n) {
        const double l = d2_[i] / p;
        d0_[i + 2] -= l * d2_[i];
        step_[i + 2] -= l * step_[i];
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      double x = step_[i];
      if (i + 1 < n) x -= d1_[i] * step_[i + 1];
      if (i + 2 < n) x -= d2_[i] * step_[i + 2];
      step_[i] = x / d0_[i];
    }
    double promise = 0;
    for (std::size_t i = 0; i < n; ++i) promise -= g_[i] * step_[i];
    const double before = merit(b_, weight);
    std::vector<double> next = b_;
    for (double t = 1; t > 1e-9; t /= 2) {
      bool positive = true;
      for (std::size_t i = 0; i < n; ++i) {
        next[i + 1] = b_[i + 1] + t * step_[i];
        positive = positive && next[i + 1] > 0;
      }
      if (positive && merit(next, weight) < before - 0.1 * t * promise) {
        b_ = next;
        return promise;
      }
    }
    return 0;
  }

  void add(std::size_t k, std::size_t l, double value) {
    // Nodes 0 and n stand still.
    if (k == 0 || l == 0 || k == n_ || l == n_) return;
    const std::size_t i = std::min(k, l) - 1;
    const std::size_t apart = k > l ? k - l : l - k;
    (apart == 0 ? d0_ : apart == 1 ? d1_ : d2_)[i] += value;
  }
  void add_time(std::size_t k, double w) {
    // 2 h / (x + y), x = sqrt(b): convex in b.
    const double h = s_[k + 1] - s_[k];
    const double x = std::sqrt(b_[k]);
    const double y = std::sqrt(b_[k + 1]);
    const double sum = x + y;
    const auto first = [&](double z) { return -w * h / (sum * sum * z); };
    const auto second = [&](double z) {
      return w * h * (1 / (sum * sum * sum * z * z) + 1 / (2 * sum * sum * z * z * z));
    };
    if (k > 0) g_[k - 1] += first(x), add(k, k, second(x));
    if (k + 1 < n_) g_[k] += first(y), add(k + 1, k + 1, second(y));
    if (k > 0 && k + 1 < n_) add(k, k + 1, w * h / (sum * sum * sum * x * y));
  }
  void add_row(const Row& row) {
    double value = 0, bound = 0;
    slack(row, b_, value, bound);
    const double root = row.jerk ? -bound / (2 * mean(b_, row.k)) : 0;
    const double share[3] = {0.25, 0.5, 0.25};
    const double c[3] = {row.x, row.y, row.z};
    for (const double sign : {-1.0, 1.0}) {
      const double left = bound - sign * value;
      double e[3];
      for (std::size_t i = 0; i < 3; ++i) e[i] = root * share[i] - sign * c[i];
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t at = row.k + i - 1;
        if (at > 0 && at < n_) g_[at - 1] -= e[i] / left - root * share[i] / bound;
        for (std::size_t l = i; l < 3; ++l) {
          add(at, row.k + l - 1, e[i] * e[l] / (left * left));
        }
      }
    }
  }

  const PlannedPath& path_;
  std::vector<motion::AxisLimits> limits_;
  std::size_t n_;
  double scale_ = 1;
  std::vector<double> s_, b_;
  std::vector<Row> rows_;
  std::vector<double> g_, d0_, d1_, d2_, step_;
};

}  // namespace sinew::planning::test_paths
