#include "sinew/planning/timing/path_timing_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/dispatch.h"

namespace sinew::planning {
namespace {

constexpr double kFastest = 1e4;    // where nothing moves, 1/s
constexpr double kNearRest = 1e-3;  // of a cell from rest: where its limits are looked at
constexpr double kRamp = 0.1;       // of the path, of the weight
constexpr int kSmooth = 4;          // times the first guess is smoothed
constexpr double kStartLoad = 0.6;  // of the limits, of the first guess
constexpr double kAboveZero = 0.1;  // weight of the barrier before 0
constexpr double kReach = 0.9;      // of what is left to a limit, in one step
constexpr double kCentred = 200;    // of the promise of a step: below it the weight may grow
constexpr double kWeightGrowth = 30;
constexpr double kFinalWeight = 600;   // a cell: under 1 % of the time is left to the barrier
constexpr double kMeasureWeight = 60;  // less than at last, when the phases are measured
constexpr double kSame = 1e-9;
constexpr double kCounts = 0.5;  // a load below that is none
constexpr double kSqueezeSettled = 1.15;
constexpr double kAfterSqueeze = 0.97;
constexpr double kStretchMost = 1.003;  // of time at last, or the phases are measured again
constexpr int kRoundsMax = 3;

}  // namespace

/// First and second derivatives of the barrier by b, b' and b''.
struct SpeedCurve::Sums {
  double g0, g1, g2, h00, h01, h02, h11, h12, h22;
};

SpeedCurve::SpeedCurve(std::size_t cells_max) {
  cells_.reserve(cells_max);
  borders_.reserve(cells_max + 1);
  borders_next_.reserve(cells_max + 1);
  forms_.reserve(cells_max);
  squeeze_.reserve(cells_max);
  phase_loads_.reserve(cells_max);
  binding_.reserve(cells_max);
  for (auto* numbers : {&c_, &before_, &step_, &g_, &d0_, &d1_, &d2_})
    numbers->reserve(cells_max + 2);
}

/// As b is from rest and to rest: s^(4/3) near the ends, level far away.
SpeedCurve::Weight SpeedCurve::weight(double s) const {
  const auto ramp = [&](double x) {
    const double y = x / (x + ramp_);
    const double w = std::cbrt(y) * y;
    const double rate = 4.0 / 3 * (1 / x - 1 / (x + ramp_));
    const double bend = 4.0 / 3 * (1 / ((x + ramp_) * (x + ramp_)) - 1 / (x * x));
    return Weight{w, w * rate, w * (rate * rate + bend)};
  };
  const Weight up = ramp(s - start_);
  const Weight down = ramp(length_ - s);
  return {up.w * down.w, up.d * down.w - up.w * down.d,
          up.dd * down.w - 2 * up.d * down.d + up.w * down.dd};
}

void SpeedCurve::make_forms(std::size_t k) {
  Forms& forms = forms_[k];
  const bool first = k == first_;
  const bool last = k + 1 == size();
  const double h = width(k);
  // From rest and to rest one jerk: in the first and last cell there is the weight alone.
  const double before = k > first_ + 1 ? width(k - 1) : 0;
  const double behind = k + 2 < size() ? width(k + 1) : 0;
  const double left = 1 / (before + h);
  const double right = 1 / (h + behind);
  double value[2][3] = {{h * left, before * left, 0}, {0, behind * right, h * right}};
  double slope[2][3] = {{-2 * left, 2 * left, 0}, {0, -2 * right, 2 * right}};
  for (auto& row : {&value, &slope}) {
    for (double(&x)[3] : *row) {
      if (first || last || k == first_ + 1) x[1] += x[0], x[0] = 0;
      if (first || last || k + 2 == size()) x[1] += x[2], x[2] = 0;
    }
  }
  for (std::size_t x = 0; x < 3; ++x) {
    forms.middle[x] = (value[0][x] + value[1][x]) / 4 + (x == 1 ? 0.5 : 0);
  }
  const double from = begin_of(k);
  const double to = border(k + 1);
  const double near = kNearRest * h;
  const Weight weights[2] = {weight(k == first_ ? from + near : from),
                             weight(k + 1 == size() ? to - near : to)};
  Form* const ends[2] = {&forms.left, &forms.right};
  for (std::size_t e = 0; e < 2; ++e) {
    const auto& [w, d, dd] = weights[e];
    for (std::size_t i = 0; i < 3; ++i) {
      const double bend = (slope[1][i] - slope[0][i]) / h;
      ends[e]->b[i] = w * value[e][i];
      ends[e]->d[i] = d * value[e][i] + w * slope[e][i];
      ends[e]->dd[i] = dd * value[e][i] + 2 * d * slope[e][i] + w * bend;
    }
  }
  // The integral of 1 / sqrt(weight): exact for s^(4/3) at the ends, two places of Gauss elsewhere.
  if (k == first_ || k + 1 == size()) {
    const double s = k == first_ ? to : from;
    forms.time = 3 * h / std::sqrt(weight(size() == first_ + 1 ? from + h / 2 : s).w);
    return;
  }
  const double middle = from + h / 2;
  const double off = h / (2 * std::sqrt(3.0));
  forms.time =
      h / 2 * (1 / std::sqrt(weight(middle - off).w) + 1 / std::sqrt(weight(middle + off).w));
}

/// The largest share of a limit at one end of a cell, of b: jerks as their power of 2/3.
double SpeedCurve::load(const Cell& cell, const Place& place, const Values& at) const {
  const double root = std::sqrt(at.b);
  double jerk = 0, acceleration = 0;
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    const double u = place.d3[j] * at.b + 1.5 * place.d2[j] * at.d + 0.5 * place.d1[j] * at.dd;
    const double a = (place.d2[j] * at.b + 0.5 * place.d1[j] * at.d) * jerk_per_acceleration_[j];
    jerk = std::max(jerk, std::abs(u));
    acceleration = std::max(acceleration, std::abs(a));
  }
  const double tool = cell.tool_curvature * at.b + cell.tool_speed * std::abs(at.d) / 2;
  return std::max({std::pow(jerk * root, 2.0 / 3), acceleration, tool, at.b / cell.cap});
}

void SpeedCurve::add_place(const Cell& cell, const Place& place, const Values& at,
                           Sums& sums) const {
  const auto [b, d, dd] = at;
  const double root = std::sqrt(b);
  const double half_per_root = 0.5 / root;
  using Lanes = double[kMaxJoints];
  // Local, so that the lanes of the loop are known to be apart.
  Lanes g0, g1, g2, h00, h01, h02, h11, h12, h22;
  // Barrier -log(1 - r^2) of each jerk and each acceleration.
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    const double x = place.d3[j], y = 1.5 * place.d2[j], z = 0.5 * place.d1[j];
    const double u = x * b + y * d + z * dd;
    const double r = u * root;
    const double per = jerk_per_acceleration_[j];
    const double ab = place.d2[j] * per, ad = z * per;
    const double a = ab * b + ad * d;
    // One division for both.
    const double left = 1 - r * r, a_left = 1 - a * a;
    const double both = 1 / (left * a_left);
    const double per_left = a_left * both, per_a_left = left * both;
    const double first = 2 * r * per_left;
    const double second = 2 * (1 + r * r) * per_left * per_left;
    const double a_first = 2 * a * per_a_left;
    const double a_second = 2 * (1 + a * a) * per_a_left * per_a_left;
    const double gb = x * root + u * half_per_root, gd = y * root, gdd = z * root;
    const double sb = second * gb, sd = second * gd;
    const double asb = a_second * ab;
    g0[j] = first * gb + a_first * ab;
    g1[j] = first * gd + a_first * ad;
    g2[j] = first * gdd;
    h00[j] = sb * gb + asb * ab;
    h01[j] = sb * gd + asb * ad;
    h02[j] = sb * gdd;
    h11[j] = sd * gd + a_second * ad * ad;
    h12[j] = sd * gdd;
    h22[j] = second * gdd * gdd;
  }
  static_assert(kMaxJoints == 8);
  const auto sum = [](const Lanes& x) {
    return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
  };
  sums = {sum(g0), sum(g1), sum(g2), sum(h00), sum(h01), sum(h02), sum(h11), sum(h12), sum(h22)};
  // -log(1 - r) of the speed and of the tool's acceleration both ways.
  const auto one = [&](double by_b, double by_d) {
    const double left = 1 / (1 - by_b * b - by_d * d);
    sums.g0 += left * by_b, sums.g1 += left * by_d;
    sums.h00 += left * left * by_b * by_b;
    sums.h01 += left * left * by_b * by_d;
    sums.h11 += left * left * by_d * by_d;
  };
  one(1 / cell.cap, 0);
  if (cell.tool_speed > 0 || cell.tool_curvature > 0) {
    one(cell.tool_curvature, cell.tool_speed / 2);
    one(cell.tool_curvature, -cell.tool_speed / 2);
  }
}

void SpeedCurve::collect(std::size_t k) {
  const std::size_t i = index(k);
  const Cell& cell = cells_[k];
  const Forms& forms = forms_[k];
  const double* c = &c_[i];
  double g[3] = {};
  double h[3][3] = {};
  const double q = squeeze_[k];
  for (std::size_t e = 0; e < 2; ++e) {
    const Form& form = e == 0 ? forms.left : forms.right;
    Values at = values(form, c);
    at.b *= q, at.d *= q, at.dd *= q;
    Sums sums;
    add_place(cell, e == 0 ? cell.left : cell.right, at, sums);
    const auto& [g0, g1, g2, h00, h01, h02, h11, h12, h22] = sums;
    for (std::size_t x = 0; x < 3; ++x) {
      const double fb = form.b[x] * q, fd = form.d[x] * q, fdd = form.dd[x] * q;
      g[x] += g0 * fb + g1 * fd + g2 * fdd;
      const double hb = h00 * fb + h01 * fd + h02 * fdd;
      const double hd = h01 * fb + h11 * fd + h12 * fdd;
      const double hdd = h02 * fb + h12 * fd + h22 * fdd;
      for (std::size_t y = x; y < 3; ++y) {
        h[x][y] += q * (hb * form.b[y] + hd * form.d[y] + hdd * form.dd[y]);
      }
    }
  }
  // The time, of the middle of the parabola.
  const double* m = forms.middle;
  const double middle = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
  const double time = forms.time / std::sqrt(middle);
  if (weight_ == 0) {
    // How strongly both pull at the size of b.
    time_pull_ += 0.5 * time;
    limit_pull_ += g[0] * c[0] + g[1] * c[1] + g[2] * c[2];
    return;
  }
  const double w = weight_ * time / middle;
  // Nothing else keeps a coefficient above 0 while all loads are small.
  if (k > first_ && k + 1 < size()) {
    g[1] -= kAboveZero / c[1];
    h[1][1] += kAboveZero / (c[1] * c[1]);
  }
  for (std::size_t x = 0; x < 3; ++x) {
    g_[i + x] += g[x] - 0.5 * w * m[x];
    for (std::size_t y = x; y < 3; ++y) h[x][y] += 0.75 * w / middle * m[x] * m[y];
  }
  d0_[i] += h[0][0], d0_[i + 1] += h[1][1], d0_[i + 2] += h[2][2];
  d1_[i] += h[0][1], d1_[i + 1] += h[1][2];
  d2_[i] += h[0][2];
}

void SpeedCurve::eliminate(std::size_t i) {
  const double per = 1 / d0_[i];
  step_[i] = -g_[i];
  promise_ += g_[i] * g_[i] * per;
  const double l1 = d1_[i] * per;
  const double l2 = d2_[i] * per;
  if (i + 1 < unknowns()) {
    d0_[i + 1] -= l1 * d1_[i];
    d1_[i + 1] -= l1 * d2_[i];
    g_[i + 1] -= l1 * g_[i];
  }
  if (i + 2 < unknowns()) {
    d0_[i + 2] -= l2 * d2_[i];
    g_[i + 2] -= l2 * g_[i];
  }
}

void SpeedCurve::substitute(std::size_t i) {
  double x = step_[i];
  if (i + 1 < unknowns()) x -= d1_[i] * step_[i + 1];
  if (i + 2 < unknowns()) x -= d2_[i] * step_[i + 2];
  step_[i] = x / d0_[i];
}

/// How much of the step this cell allows.
double SpeedCurve::reach(std::size_t k) const {
  const std::size_t i = index(k);
  const Cell& cell = cells_[k];
  double share = 1;
  for (std::size_t x = 0; x < 3; ++x) {
    if (step_[i + x] < -0.7 * c_[i + x]) share = std::min(share, -0.7 * c_[i + x] / step_[i + x]);
  }
  const double full = share;
  double next[3];
  for (std::size_t x = 0; x < 3; ++x) next[x] = c_[i + x] + full * step_[i + x];
  const Form* const ends[2] = {&forms_[k].left, &forms_[k].right};
  const double q = squeeze_[k];
  for (std::size_t e = 0; e < 2; ++e) {
    const Place& place = e == 0 ? cell.left : cell.right;
    Values from = values(*ends[e], &c_[i]);
    Values to = values(*ends[e], next);
    from.b *= q, from.d *= q, from.dd *= q, to.b *= q, to.d *= q, to.dd *= q;
    const double root_from = std::sqrt(from.b);
    const double root_to = std::sqrt(to.b);
    const auto limit = [&](double r0, double r1) {
      if (r1 > kReach && r1 - r0 > kReach * (1 - r0)) {
        share = std::min(share, full * kReach * (1 - r0) / (r1 - r0));
      }
    };
    using Lanes = double[kMaxJoints];
    Lanes u0, u1, a0, a1;
    for (std::size_t j = 0; j < kMaxJoints; ++j) {
      const double x = place.d3[j], y = 1.5 * place.d2[j], z = 0.5 * place.d1[j];
      const double per = jerk_per_acceleration_[j];
      u0[j] = std::abs(x * from.b + y * from.d + z * from.dd) * root_from;
      u1[j] = std::abs(x * to.b + y * to.d + z * to.dd) * root_to;
      a0[j] = std::abs(place.d2[j] * from.b + z * from.d) * per;
      a1[j] = std::abs(place.d2[j] * to.b + z * to.d) * per;
    }
    for (std::size_t j = 0; j < joints_; ++j) limit(u0[j], u1[j]), limit(a0[j], a1[j]);
    limit(from.b / cell.cap, to.b / cell.cap);
    const auto tool = [&](const Values& at) {
      return cell.tool_curvature * at.b + cell.tool_speed * std::abs(at.d) / 2;
    };
    limit(tool(from), tool(to));
  }
  return share;
}

PathState SpeedCurve::state_at_border(std::size_t k) const {
  if (k == first_) return {start_, 0, 0};
  if (k == size()) return {length_, 0, 0};
  const Values at = values(forms_[k - 1].right, &c_[index(k - 1)]);
  return {border(k), std::sqrt(at.b), at.d / 2};
}

/// Two phases of equal duration from border to border: h = (v0 + v1) T/2 - (a1 - a0) (T/2)^2 / 3.
bool SpeedCurve::join(std::size_t k, Joint& out) const {
  const PathState from = state_at_border(k);
  const PathState to = state_at_border(k + 1);
  const double h = width(k);
  const double speed = from.v + to.v;
  const double change = to.a - from.a;
  const double square = speed * speed - 4 * h * change / 3;
  if (!(square >= 0)) return false;
  const double t = 2 * h / (speed + std::sqrt(square));
  const double u = (to.v - from.v - 2 * from.a * t) / (t * t) - change / (2 * t);
  out.phases[0] = {from, u, t};
  out.phases[1] = {advanced(from, u, t), change / t - u, t};
  out.to = to;
  return std::isfinite(u) && t > 0 && out.phases[1].from.v > 0;
}

/// Fourth and fifth derivatives of the joints in a cell: of polynomials of degree 5, exact.
void SpeedCurve::bend_of(std::size_t k, Bend& out) const {
  const Cell& cell = cells_[k];
  out = {};
  if (!cell.bends) return;
  const double h = border(k + 1) - cell.begin;
  PathPoint at;
  path_->joints.sample_piece(cell.piece, cell.begin + h / 2 - path_->joints.begin(cell.piece), at);
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    const double middle = at.dddq[j] * per_jerk_[j];
    out.d4[j] = (-3 * cell.left.d3[j] + 4 * middle - cell.right.d3[j]) / h;
    out.d5[j] = 4 * (cell.left.d3[j] - 2 * middle + cell.right.d3[j]) / (h * h);
  }
}

/// Of one joint within one phase: bounds of its speed, acceleration and jerk, over its jerk limit.
/// A function leaves its chord by T^2/8 of its second derivative at most.
SpeedCurve::Values SpeedCurve::phase_bounds(std::size_t k, std::size_t j, const Bend& bend,
                                            const Phase& phase, const PathState& end) const {
  const Cell& cell = cells_[k];
  const double h = border(k + 1) - cell.begin;
  const double f4 = bend.d4[j], f5 = bend.d5[j];
  Values most{};
  for (const PathState* at : {&phase.from, &end}) {
    const double x = at->s - cell.begin;
    const double d3 = cell.left.d3[j] + x * (f4 + x * f5 / 2);
    const double d2 = cell.left.d2[j] + x * (cell.left.d3[j] + x * (f4 / 2 + x * f5 / 6));
    const double d1 =
        cell.left.d1[j] +
        x * (cell.left.d2[j] + x * (cell.left.d3[j] / 2 + x * (f4 / 6 + x * f5 / 24)));
    const double v = at->v, a = at->a;
    most.b = std::max(most.b, std::abs(d1 * v));
    most.d = std::max(most.d, std::abs(d2 * v * v + d1 * a));
    most.dd = std::max(most.dd, std::abs(d3 * v * v * v + 3 * d2 * v * a + d1 * phase.jerk));
  }
  const double v = top_speed(phase, end);
  const double a = std::max(std::abs(phase.from.a), std::abs(end.a));
  const double u = std::abs(phase.jerk);
  const auto larger = [](double one, double other) {
    return std::max(std::abs(one), std::abs(other));
  };
  const double s5 = std::abs(f5);
  const double s4 = std::abs(f4) + h * s5;
  const double s3 = larger(cell.left.d3[j], cell.right.d3[j]) + h * h / 8 * s5;
  const double s2 = larger(cell.left.d2[j], cell.right.d2[j]) + h * h / 8 * s4;
  const double fifth =
      ((s5 * v + 10 * s4 * a) * v * v + 15 * s3 * a * a + 10 * s3 * v * u) * v + 10 * s2 * a * u;
  const double fourth = (s4 * v * v + 6 * s3 * a) * v * v + 3 * s2 * a * a + 4 * s2 * v * u;
  const double eighth = phase.duration * phase.duration / 8;
  most.dd += eighth * fifth;
  most.d += eighth * fourth;
  most.b += eighth * most.dd;
  return most;
}

double SpeedCurve::top_speed(const Phase& phase, const PathState& end) {
  const double turn = phase.from.a > 0 && end.a < 0
                          ? phase.from.v - phase.from.a * phase.from.a / (2 * phase.jerk)
                          : 0;
  return std::max({phase.from.v, end.v, turn});
}

/// The largest share of a limit anywhere within the phases of a cell. Of speeds as it is, of
/// accelerations the root and of jerks the third root: what time would have to be stretched by.
double SpeedCurve::verify(std::size_t k) {
  Joint two;
  if (!join(k, two)) return std::numeric_limits<double>::infinity();
  const Cell& cell = cells_[k];
  Bend bend;
  bend_of(k, bend);
  double worst = 0;
  PathLimit binding;
  const auto raise = [&](double load, LimitKind kind, int joint) {
    if (load > worst) worst = load, binding = {kind, static_cast<std::int8_t>(joint)};
  };
  const double share = std::min(1.0, cell.share * feed_);
  for (std::size_t p = 0; p < 2; ++p) {
    const Phase& phase = two.phases[p];
    const PathState& end = p == 0 ? two.phases[1].from : two.to;
    double shared = 0;
    for (std::size_t j = 0; j < joints_; ++j) {
      const Values most = phase_bounds(k, j, bend, phase, end);
      const int joint = static_cast<int>(j);
      raise(std::cbrt(most.dd), LimitKind::kJointJerk, joint);
      raise(std::sqrt(most.d * jerk_per_acceleration_[j]), LimitKind::kJointAcceleration, joint);
      raise(most.b * jerk_per_velocity_[j] / share, LimitKind::kJointVelocity, joint);
      shared += most.b * jerk_per_shared_[j];
    }
    // One joint alone may have the wire's whole speed as its own limit.
    if (shared / share > worst || (shared > 0 && shared / share > worst * (1 - kSame) &&
                                   binding.kind == LimitKind::kJointVelocity)) {
      worst = std::max(worst, shared / share);
      binding = {LimitKind::kWire, -1};
    }
    const double v = top_speed(phase, end);
    const double a = std::max(std::abs(phase.from.a), std::abs(end.a));
    raise(std::sqrt(cell.tool_curvature * v * v + cell.tool_speed * a),
          LimitKind::kToolAcceleration, -1);
    raise(v / (cell.v_tool * feed_), LimitKind::kToolSpeed, -1);
  }
  const bool speed = binding.kind == LimitKind::kJointVelocity ||
                     binding.kind == LimitKind::kWire || binding.kind == LimitKind::kToolSpeed;
  binding_[k] = speed && feed_ < 1 ? PathLimit{LimitKind::kFeed, -1} : binding;
  return worst;
}

void SpeedCurve::begin(double s, double feed) {
  start_ = s;
  feed_ = feed;
  first_ = 0;
  const auto after = std::upper_bound(cells_.begin(), cells_.end(), s,
                                      [](double at, const Cell& cell) { return at < cell.begin; });
  if (after != cells_.begin()) first_ = static_cast<std::size_t>(after - cells_.begin()) - 1;
  ramp_ = kRamp * (length_ - start_);
  forms_.resize(size());
  squeeze_.assign(size(), 1);
  binding_.resize(size());
  phase_loads_.resize(size());
  const std::size_t n = unknowns();
  for (auto* numbers : {&c_, &before_, &step_, &g_, &d0_, &d1_, &d2_}) numbers->assign(n, 0);
  stage_ = size() - first_ >= 8 && length_ - start_ > 0 ? Stage::kGuess : Stage::kFailed;
  at_ = first_;
  iteration_ = rounds_ = 0;
  stretch_ = 1;
  measured_ = squeezed_ = false;
}

/// What one cell lets b have at most and how steeply b^(3/4), which is linear in s from rest, may
/// rise.
void SpeedCurve::guess(std::size_t k) {
  Cell& cell = cells_[k];
  const double v =
      std::min({kFastest, cell.v_joints * std::min(1.0, cell.share * feed_), cell.v_tool * feed_});
  cell.cap = v * v;
  make_forms(k);
  double rate = 0, bend = 0, twist = 0;
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    const auto most = [](double one, double other) {
      return std::max(std::abs(one), std::abs(other));
    };
    rate = std::max(rate, most(cell.left.d1[j], cell.right.d1[j]));
    bend = std::max(bend, most(cell.left.d2[j], cell.right.d2[j]) * jerk_per_acceleration_[j]);
    twist = std::max(twist, most(cell.left.d3[j], cell.right.d3[j]));
  }
  const double most = std::min({0.5 * cell.cap, 0.3 / bend, std::cbrt(0.1 / (twist * twist)),
                                0.5 / std::max(cell.tool_curvature, 1e-300)});
  const double before = k == first_ ? 0 : g_[k - 1 - first_];
  const double slope = 0.5 * std::sqrt(4.5 / std::max(rate, 1e-300));
  step_[k - first_] = slope;
  g_[k - first_] = std::min(std::pow(most, 0.75), before + slope * width(k));
}

void SpeedCurve::guess_back(std::size_t k) {
  const std::size_t i = k - first_;
  const double behind = k + 1 == size() ? 0 : g_[i + 1];
  g_[i] = std::min(g_[i], behind + step_[i] * width(k));
  const double half_way = forms_[k].time / width(k);
  c_[index(k) + 1] = std::cbrt(g_[i]) * g_[i] * half_way * half_way;
}

double SpeedCurve::load_of(std::size_t k) const {
  const double* c = &c_[index(k)];
  const Forms& forms = forms_[k];
  return squeeze_[k] * std::max(load(cells_[k], cells_[k].left, values(forms.left, c)),
                                load(cells_[k], cells_[k].right, values(forms.right, c)));
}

void SpeedCurve::go_to(Stage stage) {
  stage_ = stage;
  at_ = stage == Stage::kBack || stage == Stage::kGuessBack ? size() - 1 : first_;
  worst_ = 0;
  if (stage == Stage::kCollect) {
    for (auto* numbers : {&g_, &d0_, &d1_, &d2_}) std::fill(numbers->begin(), numbers->end(), 0);
  }
  if (stage == Stage::kReach) worst_ = 1;
  if (stage == Stage::kCollect) promise_ = 0;
}

/// After the last cell of a stage.
void SpeedCurve::turn_over() {
  switch (stage_) {
    case Stage::kGuess:
      return go_to(Stage::kGuessBack);
    case Stage::kGuessBack:
      for (int pass = 0; pass < kSmooth; ++pass) {
        for (std::size_t i = 1; i + 1 < unknowns(); ++i) {
          step_[i] = (c_[i - 1] + 2 * c_[i] + c_[i + 1]) / 4;
        }
        for (std::size_t i = 1; i + 1 < unknowns(); ++i) c_[i] = step_[i];
      }
      tie_ends();
      return go_to(Stage::kScale);
    case Stage::kScale:
      return scale();
    case Stage::kCollect:
      if (weight_ == 0) {
        weight_ = limit_pull_ / time_pull_;
        return go_to(Stage::kCollect);
      }
      // Of no cell of their own.
      d0_.back() += 1;
      for (std::size_t i = 3; i > 0; --i) eliminate(unknowns() - i);
      for (std::size_t i = 1; i <= 3; ++i) substitute(unknowns() - i);
      return go_to(Stage::kBack);
    case Stage::kBack:
      return go_to(Stage::kReach);
    case Stage::kReach:
      return take_step();
    case Stage::kVerify:
      return judge();
    case Stage::kDone:
    case Stage::kFailed:
      return;
  }
}

void SpeedCurve::tie_ends() {
  const std::size_t n = unknowns();
  c_[0] = c_[1];
  c_[n - 1] = c_[n - 2];
}

void SpeedCurve::scale() {
  if (!(std::isfinite(worst_) && worst_ > 0)) return go_to(Stage::kFailed);
  for (double& c : c_) c *= kStartLoad / worst_;
  weight_ = time_pull_ = limit_pull_ = 0;
  go_to(Stage::kCollect);
}

void SpeedCurve::take_step() {
  // worst_: the share of the step that stays inside.
  if (!std::isfinite(step_[0])) return go_to(Stage::kFailed);
  if (++iteration_ > kIterationsMax) {
    // What was found so far is inside of all limits too, if not the quickest.
    measured_ = true;
    rounds_ = kRoundsMax;
    if (!(worst_ > 0)) c_ = before_;
    return go_to(Stage::kVerify);
  }
  if (!(worst_ > 0)) {
    // The last step went too far after all.
    for (std::size_t i = 0; i < unknowns(); ++i) c_[i] = (c_[i] + before_[i]) / 2;
    return go_to(Stage::kCollect);
  }
  before_ = c_;
  for (std::size_t i = 0; i < unknowns(); ++i) c_[i] += worst_ * step_[i];
  tie_ends();
  if (worst_ > 0.5 && promise_ < kCentred) {
    if (weight_ >= last_weight_ && measured_) return go_to(Stage::kVerify);
    double time = 0;
    for (std::size_t k = first_; k < size(); ++k) {
      time += forms_[k].time / std::sqrt(c_[index(k) + 1]);
    }
    last_weight_ = kFinalWeight * static_cast<double>(unknowns()) / time;
    if (weight_ >= last_weight_ / kMeasureWeight && !measured_) return go_to(Stage::kVerify);
    weight_ = std::min(last_weight_, weight_ * kWeightGrowth);
  }
  go_to(Stage::kCollect);
}

/// worst_: what time would have to be stretched by for all limits to hold.
void SpeedCurve::judge() {
  if (!std::isfinite(worst_)) return go_to(Stage::kFailed);
  const bool last = measured_ && (worst_ <= kStretchMost || rounds_ >= kRoundsMax);
  if (!last) {
    // Now that it is known how much more the phases need than the places that were looked at:
    ++rounds_;
    double most = 0;
    for (std::size_t k = first_; k < size(); ++k) {
      const double load = load_of(k);
      squeezed_ = squeezed_ || squeeze_[k] > kSqueezeSettled;
      const double more = phase_loads_[k] * phase_loads_[k] / std::max(load, kCounts);
      squeeze_[k] = std::max(1.0, squeeze_[k] * more);
      most = std::max(most, load * std::max(1.0, more));
    }
    if (most > kAfterSqueeze) {
      for (double& c : c_) c *= kAfterSqueeze / most;
    }
    if (measured_) weight_ = last_weight_ / kMeasureWeight;
    measured_ = true;
    return go_to(Stage::kCollect);
  }
  stretch_ = std::max(1.0, worst_);
  stage_ = Stage::kDone;
}

bool SpeedCurve::advance(std::size_t cells) {
  return dispatched([&] { return work(cells); });
}

bool SpeedCurve::work(std::size_t cells) {
  while (stage_ != Stage::kDone && stage_ != Stage::kFailed) {
    if (cells-- == 0) return false;
    const std::size_t k = at_;
    switch (stage_) {
      case Stage::kGuess:
        guess(k);
        break;
      case Stage::kGuessBack:
        guess_back(k);
        break;
      case Stage::kScale:
        worst_ = std::max(worst_, load_of(k));
        break;
      case Stage::kCollect:
        collect(k);
        if (k == first_) d0_[0] += 1;
        if (k > first_ && k + 2 < size() && weight_ != 0) eliminate(index(k));
        break;
      case Stage::kBack:
        if (k > first_ && k + 2 < size()) substitute(index(k));
        break;
      case Stage::kReach:
        worst_ = std::min(worst_, reach(k));
        break;
      case Stage::kVerify:
        phase_loads_[k] = verify(k);
        worst_ = std::max(worst_, phase_loads_[k]);
        break;
      case Stage::kDone:
      case Stage::kFailed:
        return true;
    }
    const bool back = stage_ == Stage::kBack || stage_ == Stage::kGuessBack;
    if (back ? k == first_ : k + 1 == size()) {
      turn_over();
    } else {
      at_ = back ? k - 1 : k + 1;
    }
  }
  return true;
}

}  // namespace sinew::planning
