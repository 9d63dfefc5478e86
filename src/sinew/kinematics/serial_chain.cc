#include "sinew/kinematics/serial_chain.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/dispatch.h"
#include "sinew/core/trig.h"

namespace sinew::kinematics {
namespace {

/// sin or cos of an angle that is nearly always a multiple of 90 degrees: 6.1e-17 becomes 0.
double clean(double value) {
  return std::abs(value) < 1e-15 ? 0.0 : value;
}

}  // namespace

SerialChain::SerialChain(const SerialGeometry& geometry) : size_(geometry.rows.size()) {
  for (std::size_t i = 0; i < size_; ++i) {
    const DhRow& row = geometry.rows[i];
    rows_[i] = row;
    links_[i] = {row.d, row.a, clean(std::cos(row.alpha)), clean(std::sin(row.alpha))};
    theta_offset_[i] = row.theta_offset;
    has_slide_ |= slides(i);
  }
}

/// Walks the links from base to flange; before link i is passed, `visit` gets i and the frame whose
/// z axis joint i turns about, or slides along.
/// @param theta  rad, one per row, without theta_offset
template <class V, class Visit>
PoseBF SerialChain::pass(const double* theta, const Links& links, Visit&& visit) const {
  std::array<double, kMaxJoints> s, c;
  sines(theta, theta_offset_, size_, s, c);
  WalkFrame<V> frame;
  for (std::size_t i = 0; i < size_; ++i) {
    visit(i, frame);
    frame.pass(links[i], s[i], c[i]);
  }
  return {{vec3(frame.x), vec3(frame.y), vec3(frame.z)}, vec3(frame.p)};
}

template <class V, class Visit>
PoseBF SerialChain::walk(std::span<const double> q, Visit&& visit) const {
  SINEW_ASSERT(q.size() == size_);
  if (!has_slide_) return pass<V>(q.data(), links_, visit);
  std::array<double, kMaxJoints> theta{};
  Links links = links_;
  for (std::size_t i = 0; i < size_; ++i) (slides(i) ? links[i].d : theta[i]) += q[i];
  return pass<V>(theta.data(), links, visit);
}

template <class V>
PoseBF SerialChain::walk(std::span<const double> q, Jacobian& J) const {
  std::array<Vec3, kMaxJoints> origin;
  J.size = size_;
  const PoseBF X = walk<V>(q, [&](std::size_t i, const WalkFrame<V>& frame) {
    J.w[i] = vec3(frame.z);
    origin[i] = vec3(frame.p);
  });
  for (std::size_t i = 0; i < size_; ++i) {
    J.v[i] = slides(i) ? J.w[i] : cross(J.w[i], X.p - origin[i]);
    if (slides(i)) J.w[i] = {};
  }
  return X;
}

PoseBF SerialChain::forward_portable(std::span<const double> q) const {
  return walk<Vec3>(q, [](std::size_t, const WalkFrame<Vec3>&) {});
}

PoseBF SerialChain::forward_portable(std::span<const double> q, Jacobian& J) const {
  return walk<Vec3>(q, J);
}

PoseBF SerialChain::forward(std::span<const double> q) const {
  return dispatched([&] { return forward_portable(q); },
                    [&] { return walk<Column>(q, [](std::size_t, const WalkFrame<Column>&) {}); });
}

PoseBF SerialChain::forward(std::span<const double> q, Jacobian& J) const {
  return dispatched([&] { return forward_portable(q, J); }, [&] { return walk<Column>(q, J); });
}

template <class V>
void SerialChain::walk(std::span<const double> q, std::span<PoseBL> X) const {
  SINEW_ASSERT(X.size() == size_);
  const PoseBF X_BF = walk<V>(q, [&](std::size_t i, const WalkFrame<V>& frame) {
    if (i > 0) X[i - 1] = {{vec3(frame.x), vec3(frame.y), vec3(frame.z)}, vec3(frame.p)};
  });
  X[size_ - 1] = relabel<frame::Base, frame::Link>(X_BF);
}

void SerialChain::frames(std::span<const double> q, std::span<PoseBL> X) const {
  dispatched([&] { walk<Vec3>(q, X); }, [&] { walk<Column>(q, X); });
}

PoseBF SerialChain::link(std::size_t row, double q) const {
  SINEW_ASSERT(row < size_);
  const SerialLink& link = links_[row];
  const SinCos sc = sin_cos(slides(row) ? theta_offset_[row] : q + theta_offset_[row]);
  const double d = slides(row) ? link.d + q : link.d;
  const Vec3 x{sc.cos, sc.sin, 0};
  const Vec3 y{-sc.sin, sc.cos, 0};
  const Vec3 z{0, 0, 1};
  return {{x, link.cos_alpha * y + link.sin_alpha * z, link.cos_alpha * z - link.sin_alpha * y},
          d * z + link.a * x};
}

double SerialChain::reach(std::span<const Joint> joints) const {
  double sum = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    double d = std::abs(rows_[i].d);
    if (slides(i)) {
      d = std::max(std::abs(rows_[i].d + joints[i].lower), std::abs(rows_[i].d + joints[i].upper));
    }
    sum += std::hypot(d, rows_[i].a);
  }
  return sum;
}

Dexterity dexterity(const Jacobian& J, double length) {
  // One-sided Jacobi (Hestenes, 1958): rotate pairs of columns of A until all are orthogonal; their
  // norms are then the singular values. For fewer than six joints A has fewer columns.
  std::array<std::array<double, 6>, kMaxJoints> column{};
  const double scale = 1 / length;
  for (std::size_t i = 0; i < J.size; ++i) {
    column[i] = {scale * J.v[i].x, scale * J.v[i].y, scale * J.v[i].z,
                 J.w[i].x,         J.w[i].y,         J.w[i].z};
  }
  const auto product = [&](std::size_t i, std::size_t j) {
    double sum = 0;
    for (std::size_t k = 0; k < 6; ++k) sum += column[i][k] * column[j][k];
    return sum;
  };
  constexpr int kSweepsMax = 30;
  bool rotated = true;
  for (int sweep = 0; sweep < kSweepsMax && rotated; ++sweep) {
    rotated = false;
    for (std::size_t i = 0; i + 1 < J.size; ++i) {
      for (std::size_t j = i + 1; j < J.size; ++j) {
        const double alpha = product(i, i);
        const double beta = product(j, j);
        const double gamma = product(i, j);
        if (std::abs(gamma) <= 1e-15 * std::sqrt(alpha * beta) || gamma == 0) continue;
        rotated = true;
        const double zeta = (beta - alpha) / (2 * gamma);
        const double t = std::copysign(1, zeta) / (std::abs(zeta) + std::hypot(1, zeta));
        const double c = 1 / std::hypot(1, t);
        const double s = c * t;
        for (std::size_t k = 0; k < 6; ++k) {
          const double first = column[i][k];
          column[i][k] = c * first - s * column[j][k];
          column[j][k] = s * first + c * column[j][k];
        }
      }
    }
  }
  std::array<double, kMaxJoints> values{};
  for (std::size_t i = 0; i < J.size; ++i) values[i] = std::sqrt(product(i, i));
  std::sort(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(J.size), std::greater<>());
  Dexterity result{values[0], 1};
  const std::size_t rank_max = std::min<std::size_t>(J.size, 6);
  for (std::size_t i = 0; i < rank_max; ++i) {
    result.singular_value_min = values[i];
    result.manipulability *= values[i];
  }
  return result;
}

}  // namespace sinew::kinematics
