#include "sinew/planning/paths/joint_path.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::planning {

JointPath::JointPath(std::size_t joints, std::size_t capacity) : joints_(joints) {
  SINEW_ASSERT(joints > 0 && joints <= kMaxJoints);
  pieces_.reserve(capacity);
  curvature_.reserve(capacity + 1);
  diagonal_.reserve(capacity + 1);
}

void JointPath::clear() {
  pieces_.clear();
  length_ = 0;
}

void JointPath::truncate(std::size_t count) {
  SINEW_ASSERT(count <= size());
  length_ = begin(count);
  pieces_.resize(count);
}

bool JointPath::append_line(std::span<const double> from, std::span<const double> to,
                            double length) {
  SINEW_ASSERT(from.size() == joints_ && to.size() == joints_ && length > 0);
  if (!has_room(1)) return false;
  Piece piece{length_, {}};
  for (std::size_t j = 0; j < joints_; ++j) {
    piece.coefficients[0][j] = from[j];
    piece.coefficients[1][j] = (to[j] - from[j]) / length;
  }
  pieces_.push_back(piece);
  length_ += length;
  return true;
}

bool JointPath::append_quintic(const PathPoint& from, const PathPoint& to, double length) {
  SINEW_ASSERT(length > 0);
  if (!has_room(1)) return false;
  Piece piece{length_, {}};
  auto& c = piece.coefficients;
  const double h = length;
  for (std::size_t j = 0; j < joints_; ++j) {
    // What is left at the far end of the parabola that leaves `from` as it should.
    const double rest_q = to.q[j] - from.q[j] - h * (from.dq[j] + h / 2 * from.ddq[j]);
    const double rest_dq = h * (to.dq[j] - from.dq[j] - h * from.ddq[j]);
    const double rest_ddq = h * h * (to.ddq[j] - from.ddq[j]);
    c[0][j] = from.q[j];
    c[1][j] = from.dq[j];
    c[2][j] = from.ddq[j] / 2;
    c[3][j] = (10 * rest_q - 4 * rest_dq + rest_ddq / 2) / (h * h * h);
    c[4][j] = (-15 * rest_q + 7 * rest_dq - rest_ddq) / (h * h * h * h);
    c[5][j] = (6 * rest_q - 3 * rest_dq + rest_ddq / 2) / (h * h * h * h * h);
  }
  pieces_.push_back(piece);
  length_ += length;
  return true;
}

bool JointPath::append_spline(std::span<const double> knots, std::span<const JointArray> points,
                              const JointArray& dq_first, const JointArray& dq_last) {
  const std::size_t n = knots.size();
  SINEW_ASSERT(n >= 2 && points.size() == n && knots[0] == 0);
  if (!has_room(n - 1)) return false;
  // Second derivatives m at the knots: h[i-1] m[i-1] + 2 (h[i-1]+h[i]) m[i] + h[i] m[i+1]
  // = 6 (slope[i] - slope[i-1]), clamped at both ends; Thomas' elimination, one matrix for all
  // joints.
  curvature_.resize(n);
  diagonal_.resize(n);
  const auto width = [&](std::size_t i) { return knots[i + 1] - knots[i]; };
  const auto slope = [&](std::size_t i, std::size_t j) {
    return (points[i + 1][j] - points[i][j]) / width(i);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const double before = i > 0 ? width(i - 1) : 0;
    const double behind = i + 1 < n ? width(i) : 0;
    SINEW_ASSERT(i + 1 == n || behind > 0);
    const double factor = i > 0 ? before / diagonal_[i - 1] : 0;
    diagonal_[i] = 2 * (before + behind) - factor * before;
    for (std::size_t j = 0; j < joints_; ++j) {
      const double in = i > 0 ? slope(i - 1, j) : dq_first[j];
      const double out = i + 1 < n ? slope(i, j) : dq_last[j];
      curvature_[i][j] = 6 * (out - in) - (i > 0 ? factor * curvature_[i - 1][j] : 0);
    }
  }
  for (std::size_t i = n; i-- > 0;) {
    const double behind = i + 1 < n ? width(i) : 0;
    for (std::size_t j = 0; j < joints_; ++j) {
      const double next = i + 1 < n ? behind * curvature_[i + 1][j] : 0;
      curvature_[i][j] = (curvature_[i][j] - next) / diagonal_[i];
    }
  }
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = width(i);
    Piece piece{length_ + knots[i], {}};
    auto& c = piece.coefficients;
    for (std::size_t j = 0; j < joints_; ++j) {
      const double m0 = curvature_[i][j];
      const double m1 = curvature_[i + 1][j];
      c[0][j] = points[i][j];
      c[1][j] = slope(i, j) - h / 6 * (2 * m0 + m1);
      c[2][j] = m0 / 2;
      c[3][j] = (m1 - m0) / (6 * h);
    }
    pieces_.push_back(piece);
  }
  length_ += knots[n - 1];
  return true;
}

std::size_t JointPath::piece_at(double s, std::size_t hint) const {
  SINEW_ASSERT(!empty());
  const auto holds = [&](std::size_t i) {
    return pieces_[i].s <= s && (i + 1 == size() || s < pieces_[i + 1].s);
  };
  if (hint < size() && holds(hint)) return hint;
  if (hint + 1 < size() && holds(hint + 1)) return hint + 1;
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), s,
                                      [](double at, const Piece& piece) { return at < piece.s; });
  return after == pieces_.begin() ? 0 : static_cast<std::size_t>(after - pieces_.begin()) - 1;
}

void JointPath::sample_piece(std::size_t i, double u, PathPoint& out) const {
  const auto& c = pieces_[i].coefficients;
  // Over all lanes, so that the loop has a fixed length for the vectoriser.
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    out.q[j] =
        c[0][j] + u * (c[1][j] + u * (c[2][j] + u * (c[3][j] + u * (c[4][j] + u * c[5][j]))));
    out.dq[j] =
        c[1][j] + u * (2 * c[2][j] + u * (3 * c[3][j] + u * (4 * c[4][j] + u * 5 * c[5][j])));
    out.ddq[j] = 2 * c[2][j] + u * (6 * c[3][j] + u * (12 * c[4][j] + u * 20 * c[5][j]));
    out.dddq[j] = 6 * c[3][j] + u * (24 * c[4][j] + u * 60 * c[5][j]);
  }
}

void JointPath::bound_piece(std::size_t i, double u0, double u1, PathPoint& out) const {
  // Between two places a function leaves its chord by h^2/8 of its second derivative at most.
  const auto& c = pieces_[i].coefficients;
  const double eighth = (u1 - u0) * (u1 - u0) / 8;
  const auto d1 = [&](std::size_t j, double u) {
    return c[1][j] + u * (2 * c[2][j] + u * (3 * c[3][j] + u * (4 * c[4][j] + u * 5 * c[5][j])));
  };
  const auto d2 = [&](std::size_t j, double u) {
    return 2 * c[2][j] + u * (6 * c[3][j] + u * (12 * c[4][j] + u * 20 * c[5][j]));
  };
  const auto d3 = [&](std::size_t j, double u) {
    return 6 * c[3][j] + u * (24 * c[4][j] + u * 60 * c[5][j]);
  };
  const auto d4 = [&](std::size_t j, double u) { return 24 * c[4][j] + u * 120 * c[5][j]; };
  const auto larger = [](double a, double b) {
    a = std::abs(a), b = std::abs(b);
    return a > b ? a : b;
  };
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    out.dddq[j] = larger(d3(j, u0), d3(j, u1)) + eighth * 120 * std::abs(c[5][j]);
    out.ddq[j] = larger(d2(j, u0), d2(j, u1)) + eighth * larger(d4(j, u0), d4(j, u1));
    out.dq[j] = larger(d1(j, u0), d1(j, u1)) + eighth * out.dddq[j];
  }
}

void JointPath::sample(double s, PathPoint& out, std::size_t hint) const {
  s = std::clamp(s, 0.0, length_);
  const std::size_t i = piece_at(s, hint);
  sample_piece(i, s - pieces_[i].s, out);
}

}  // namespace sinew::planning
