#include "sinew/motion/step_runs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/dispatch.h"

namespace sinew::motion {
namespace {

constexpr double kUnit = 1.0 / static_cast<double>(StepSegment::kStep);
constexpr double kTimeTolerance = 0.01;  // ticks, of exact times
constexpr int kSearchSteps = 60;
constexpr int kTries = 12;
constexpr std::int64_t kCountMax = 0xFFFF;
/// Of the tolerance, what the sampled error may take before every step is looked at.
constexpr double kSampledShare = 0.92;
constexpr double kGoodShare = 0.6;  // shorter than need be below this
constexpr double kRoundingTicks = 0.51;
/// Where the exact times lie that the cubic goes through, of its length. With both ends held, the
/// error (x^2 - 1)(x^2 - a^2) on [-1, 1] is least for a = sqrt(2) - 1.
constexpr double kNode = 0.29289;
constexpr std::array kSampled{0.13, 0.5, 0.87};

}  // namespace

double StepRuns::Piece::at(double time) const {
  const double u = (std::clamp(time, begin, end) - begin) * per_tick;
  return way + u * (c1 + u * (c2 + u * c3));
}

/// A run, and its times as a polynomial k (a + k (b + k c)) behind `base`.
struct StepRuns::Fit {
  StepRun run;
  double base = 0;
  double a = 0, b = 0, c = 0;
  double tolerance = 0;
  double time(double k) const { return base + k * (a + k * (b + k * c)); }
};

StepRuns::StepRuns(const StepRunSettings& settings, std::size_t segments_max)
    : settings_(settings) {
  SINEW_ASSERT(settings.tolerance >= StepRunSettings::kToleranceMin);
  pieces_.reserve(segments_max);
}

void StepRuns::take(std::span<const StepSegment> segments, std::int64_t offset,
                    std::uint64_t tick) {
  SINEW_ASSERT(segments.size() <= pieces_.capacity());
  pieces_.clear();
  auto clock = static_cast<double>(tick);
  std::int64_t level = 0;  // steps of this direction so far
  double way = 0;
  int direction = 0;
  for (const StepSegment& segment : segments) {
    if (segment.direction != direction) {
      direction = segment.direction;
      level = 0;
      way = static_cast<double>(direction * offset) * kUnit;
    }
    const double ticks = segment.duration;
    const std::int64_t come = segment.way(segment.u_at(segment.duration));
    pieces_.push_back(
        {.begin = clock,
         .end = clock + ticks,
         .per_tick = 1.0 / static_cast<double>(std::uint64_t{1} << segment.span_bits()),
         .c1 = static_cast<double>(segment.c1) * kUnit,
         .c2 = static_cast<double>(segment.c2) * kUnit,
         .c3 = static_cast<double>(segment.c3) * kUnit,
         .way = way,
         .first = static_cast<double>(level) + 0.5,
         .steps = segment.steps,
         .direction = segment.direction});
    level += segment.steps;
    offset += direction * (come - static_cast<std::int64_t>(segment.steps) * StepSegment::kStep);
    way = static_cast<double>(direction * offset) * kUnit + static_cast<double>(level);
    clock += ticks;
  }
}

const StepRuns::Piece& StepRuns::piece_at(double time) {
  while (cursor_ > begin_ && time < pieces_[cursor_].begin) --cursor_;
  while (cursor_ + 1 < end_ && time > pieces_[cursor_].end) ++cursor_;
  return pieces_[cursor_];
}

const StepRuns::Piece& StepRuns::piece_of(double level) {
  const auto last = [](const Piece& piece) {
    return piece.first + static_cast<double>(piece.steps) - 1;
  };
  while (cursor_ > begin_ && level < pieces_[cursor_].first) --cursor_;
  while (cursor_ + 1 < end_ && level > last(pieces_[cursor_])) ++cursor_;
  return pieces_[cursor_];
}

double StepRuns::way_at(double time) {
  return piece_at(time).at(time);
}

/// When the way comes to `level`: Newton's, inside a bracket.
double StepRuns::time_of(double level, double near) {
  const Piece& piece = piece_of(level);
  const double wanted = level - piece.way;
  double lower = 0;
  double upper = (piece.end - piece.begin) * piece.per_tick;
  double u = (near - piece.begin) * piece.per_tick;
  if (!(u > lower && u < upper)) u = (lower + upper) / 2;
  const double enough = kTimeTolerance * piece.per_tick;
  for (int i = 0; i < kSearchSteps && upper - lower > enough; ++i) {
    const double missing = wanted - u * (piece.c1 + u * (piece.c2 + u * piece.c3));
    (missing > 0 ? lower : upper) = u;
    const double slope = piece.c1 + u * (2 * piece.c2 + u * 3 * piece.c3);
    const double change = missing / slope;
    const double next = u + change;
    if (std::abs(change) < enough) {
      u = std::clamp(next, lower, upper);
      break;
    }
    u = next > lower && next < upper ? next : (lower + upper) / 2;
  }
  return piece.begin + u / piece.per_tick;
}

/// The cubic through base and three exact times of the `count` steps from `level` on.
StepRuns::Fit StepRuns::fit(double level, std::int64_t count, double base) {
  const auto n = static_cast<double>(count);
  const double k1 = count > 2 ? std::max(1.0, std::round(kNode * n)) : 1;
  const double k2 = count > 2 ? std::min(n - 1, std::round((1 - kNode) * n)) : n;
  const auto time = [&](double k, double near) { return time_of(level + k - 1, near) - base; };
  const double t1 = time(k1, base);
  const double t2 = k2 > k1 ? time(k2, base + t1 * k2 / k1) : t1;
  const double t3 = n > k2 ? time(n, base + t2 * n / k2) : t2;
  // Divided differences; the lowest ones where there are not so many steps.
  const double f01 = t1 / k1;
  const double f12 = k2 > k1 ? (t2 - t1) / (k2 - k1) : f01;
  const double f23 = n > k2 ? (t3 - t2) / (n - k2) : f12;
  const double f012 = k2 > k1 ? (f12 - f01) / k2 : 0;
  const double f0123 = n > k2 ? ((f23 - f12) / (n - k1) - f012) / n : 0;
  const double interval = f01 + f012 * (1 - k1) + f0123 * (1 - k1) * (1 - k2);
  const double add = 2 * (f012 + f0123 * (3 - k1 - k2));
  const double add2 = 6 * f0123;

  const StepRunPrecision precision(static_cast<std::uint32_t>(count));
  const auto said = [](double value, int bits) {
    return std::ldexp(std::round(std::ldexp(value, bits)), -bits);
  };
  const double interval_said = said(interval, precision.interval);
  const double add_said = said(add, precision.add);
  const double add2_said = said(add2, precision.add2);
  const int shift = std::max(
      {precision.interval, add_said != 0 ? precision.add : 0, add2_said != 0 ? precision.add2 : 0});
  Fit fit;
  fit.run = {.count = static_cast<std::uint32_t>(count),
             .direction = pieces_[begin_].direction,
             .shift = static_cast<std::int8_t>(shift),
             .interval = std::llround(std::ldexp(interval_said, shift)),
             .add = std::llround(std::ldexp(add_said, shift)),
             .add2 = std::llround(std::ldexp(add2_said, shift))};
  fit.base = base;
  fit.a = interval_said - add_said / 2 + add2_said / 3;
  fit.b = add_said / 2 - add2_said / 2;
  fit.c = add2_said / 6;
  const auto interval_of = [&](double k) {
    return interval_said + (k - 1) * (add_said + (k - 2) / 2 * add2_said);
  };
  const double least =
      std::min({interval_of(std::min(2.0, n)), interval_of((n + 2) / 2), interval_of(n)});
  fit.tolerance = std::min(settings_.tolerance, StepRunSettings::kIntervalShare * least);
  return fit;
}

/// About how far the fit is off where it should be worst, ticks.
double StepRuns::deviation(const Fit& fit, double level) {
  double worst = 0;
  for (const double share : kSampled) {
    const double k = std::max(1.0, std::round(share * fit.run.count));
    const Piece& piece = piece_of(level + k - 1);
    const double u = (fit.time(k) - piece.begin) * piece.per_tick;
    const double missing =
        level + k - 1 - piece.way - u * (piece.c1 + u * (piece.c2 + u * piece.c3));
    const double slope = piece.c1 + u * (2 * piece.c2 + u * 3 * piece.c3);
    worst = std::max(worst, std::abs(missing / (slope * piece.per_tick)));
  }
  return std::isfinite(worst) ? worst : 1e300;
}

bool StepRuns::keeps_at(const Fit& fit, double level, std::int64_t k) {
  const double time = fit.time(static_cast<double>(k));
  const double room = fit.tolerance - kRoundingTicks;
  const double wanted = level + static_cast<double>(k) - 1;
  return way_at(time - room) <= wanted && way_at(time + room) >= wanted;
}

/// A fit in one piece, as functions of u behind the piece's begin.
struct StepRuns::Window {
  double base, a, b, c;  ///< u of step k
  double width;          ///< u
  double c1, c2, c3;     ///< the way
  double first, wanted;  ///< k and way of the first step

  /// `N` steps, without branches.
  template <std::size_t N>
  bool keeps() const {
    std::int64_t bad = 0;
    for (std::size_t i = 0; i < N; ++i) {
      const double k = first + static_cast<double>(i);
      const double u = base + k * (a + k * (b + k * c));
      const double before = u - width;
      const double after = u + width;
      const double middle = wanted + static_cast<double>(i);
      bad |= before * (c1 + before * (c2 + before * c3)) <= middle ? 0 : 1;
      bad |= after * (c1 + after * (c2 + after * c3)) >= middle ? 0 : 1;
    }
    return bad == 0;
  }
};

/// Every step. As many as lie in one piece are looked at together.
inline bool StepRuns::keeps_all(const Fit& fit, double level) {
  const double room = fit.tolerance - kRoundingTicks;
  if (room <= 0) return false;
  const std::int64_t count = fit.run.count;
  for (std::int64_t k = 1; k <= count;) {
    const auto first = static_cast<double>(k);
    const Piece& piece = piece_at(fit.time(first));
    const bool begins = fit.time(first) - room >= piece.begin;
    const auto fits = [&](std::int64_t size) {
      return begins && k + size - 1 <= count &&
             fit.time(static_cast<double>(k + size - 1)) + room <= piece.end;
    };
    const double scale = piece.per_tick;
    const Window window{(fit.base - piece.begin) * scale,
                        fit.a * scale,
                        fit.b * scale,
                        fit.c * scale,
                        room * scale,
                        piece.c1,
                        piece.c2,
                        piece.c3,
                        first,
                        level + first - 1 - piece.way};
    bool good = false;
    if (fits(32)) {
      good = window.keeps<32>();
      k += 32;
    } else if (fits(8)) {
      good = window.keeps<8>();
      k += 8;
    } else if (fits(1)) {
      good = window.keeps<1>();
      k += 1;
    } else {
      good = keeps_at(fit, level, k);
      k += 1;
    }
    if (!good) return false;
  }
  return true;
}

bool StepRuns::keeps(const Fit& fit, double level) {
  return dispatched([&] { return keeps_all(fit, level); });
}

/// The longest run that a few tries find.
StepRuns::Fit StepRuns::longest(double level, std::int64_t left, double base) {
  const auto most = std::min(left, kCountMax);
  std::int64_t count =
      std::clamp<std::int64_t>(std::llround(static_cast<double>(length_) * growth_), 1, most);
  std::int64_t too_long = most + 1;
  Fit best;
  for (int i = 0; i < kTries && count > best.run.count; ++i) {
    const Fit tried = fit(level, count, base);
    const double limit = tried.tolerance - kRoundingTicks;
    const double off = deviation(tried, level);
    const double factor = std::sqrt(std::sqrt(0.85 * limit / std::max(off, 1e-9)));
    const auto scaled = [&](double by) {
      return static_cast<std::int64_t>(static_cast<double>(count) * by);
    };
    // 62 bits hold the time within a run.
    const bool fits = std::ldexp(tried.time(static_cast<double>(count)) - base, tried.run.shift) <
                      std::ldexp(1.0, 61);
    const bool good = fits && off <= kSampledShare * limit && keeps(tried, level);
    if (good) {
      best = tried;
      if (off > kGoodShare * limit || i >= 3) break;
      count = std::min({scaled(std::clamp(factor, 1.1, 3.0)), too_long - 1});
    } else {
      too_long = count;
      count = std::max<std::int64_t>(
          best.run.count, scaled(std::clamp(std::isfinite(factor) ? factor : 0.0, 0.25, 0.85)));
      count = std::max<std::int64_t>(count, 1);
    }
  }
  if (best.run.count == 0) best = fit(level, 1, base);
  return best;
}

std::expected<std::size_t, StepRefusal> StepRuns::compress(std::span<const StepSegment> segments,
                                                           std::int64_t offset, std::uint64_t tick,
                                                           std::span<StepRun> out) {
  take(segments, offset, tick);
  std::size_t size = 0;
  auto base = static_cast<double>(tick);
  for (begin_ = 0; begin_ < pieces_.size(); begin_ = end_) {
    std::int64_t left = 0;
    for (end_ = begin_; end_ < pieces_.size(); ++end_) {
      if (pieces_[end_].direction != pieces_[begin_].direction) break;
      left += pieces_[end_].steps;
    }
    cursor_ = begin_;
    double level = 0.5;
    while (left > 0) {
      if (size == out.size()) {
        const auto limit = static_cast<double>(out.size());
        return std::unexpected(StepRefusal{StepRefusal::Reason::kTooMany, base, limit, limit});
      }
      const Fit fit = longest(level, left, base);
      if (fit.tolerance < StepRunSettings::kToleranceMin) {
        return std::unexpected(StepRefusal{
            StepRefusal::Reason::kTooFast, base, fit.tolerance / StepRunSettings::kIntervalShare,
            StepRunSettings::kToleranceMin / StepRunSettings::kIntervalShare});
      }
      out[size++] = fit.run;
      growth_ =
          std::clamp(static_cast<double>(fit.run.count) / static_cast<double>(length_), 0.7, 2.0);
      length_ = fit.run.count;
      left -= fit.run.count;
      level += fit.run.count;
      // Where the axis will be, in closed form.
      const auto n = static_cast<std::int64_t>(fit.run.count);
      const std::int64_t half = fit.run.shift > 0 ? std::int64_t{1} << (fit.run.shift - 1) : 0;
      const std::int64_t time = n * fit.run.interval + n * (n - 1) / 2 * fit.run.add +
                                n * (n - 1) / 2 * (n - 2) / 3 * fit.run.add2;
      base += static_cast<double>((time + half) >> fit.run.shift);
    }
  }
  return size;
}

}  // namespace sinew::motion
