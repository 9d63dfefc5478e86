#include "sinew/kinematics/numeric_ik.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/trig.h"

namespace sinew::kinematics {
namespace {

using Matrix = std::array<std::array<double, kMaxJoints>, kMaxJoints>;
using Column = std::array<double, 6>;
using Vector = std::array<double, kMaxJoints>;

/// Rotation vector of small or large error rotations, without the library's branches.
Vec3 rotation_error(const Rotation& from, const Rotation& to) {
  // sum of cross products of the axes = 2 sin(angle) axis; trace = 1 + 2 cos(angle).
  const Vec3 s = 0.5 * (cross(from.x, to.x) + cross(from.y, to.y) + cross(from.z, to.z));
  const double cos_angle = 0.5 * (dot(from.x, to.x) + dot(from.y, to.y) + dot(from.z, to.z) - 1);
  const double sin_angle = norm(s);
  if (sin_angle < 1e-6 && cos_angle > 0) return s;
  if (sin_angle < 1e-6) return rotation_vector(to * from.transposed());
  return (arc_tangent(sin_angle, cos_angle) / sin_angle) * s;
}

/// Solves H x = g for a symmetric positive definite H of size n by L D L^T; x overwrites g.
void solve_symmetric(Matrix& H, Vector& g, std::size_t n) {
  Vector inverse_diagonal;
  for (std::size_t j = 0; j < n; ++j) {
    inverse_diagonal[j] = 1 / H[j][j];
    for (std::size_t i = j + 1; i < n; ++i) {
      const double factor = H[i][j] * inverse_diagonal[j];
      for (std::size_t k = j + 1; k <= i; ++k) H[i][k] -= factor * H[k][j];
      g[i] -= factor * g[j];
    }
  }
  for (std::size_t j = n; j-- > 0;) {
    double sum = g[j];
    for (std::size_t i = j + 1; i < n; ++i) sum -= H[i][j] * g[i];
    g[j] = sum * inverse_diagonal[j];
  }
}

/// SplitMix64: the restarts must be the same on every platform.
double next_uniform(std::uint64_t& state) {
  state += 0x9E3779B97F4A7C15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

class Solver {
 public:
  Solver(const SerialChain& chain, std::span<const Joint> joints, const PoseBF& target,
         const NumericOptions& options)
      : chain_(chain), joints_(joints), target_(target), options_(options) {
    length_ = chain.length();
    rotation_weight_ = options.task == NumericTask::kPose ? 1 : 0;
  }

  /// One attempt from q; true when it converged. `residual` is the last error.
  bool attempt(JointVector& q, int& iterations, double& residual) const {
    double best = std::numeric_limits<double>::infinity();
    int stalled = 0;
    for (int i = 0; i < options_.iterations_max; ++i) {
      Jacobian J;
      const PoseBF X = chain_.forward(q, J);
      const Vec3 p_error = target_.p - X.p;
      const Vec3 w_error = rotation_weight_ * rotation_error(X.R, target_.R);
      const double p_size = norm(p_error);
      const double w_size = norm(w_error);
      residual = p_size + w_size * length_;
      if (p_size <= options_.position_tolerance && w_size <= options_.rotation_tolerance) {
        return true;
      }
      // An attempt that stopped falling is in a valley of the limits; a restart costs less.
      stalled = residual < 0.9 * best ? 0 : stalled + 1;
      best = std::min(best, residual);
      if (stalled > kStalledMax) return false;
      step(J, p_error, w_error, q);
      ++iterations;
    }
    return false;
  }

  void randomise(JointVector& q, std::uint64_t& state) const {
    for (std::size_t i = 0; i < q.size(); ++i) {
      q[i] = joints_[i].lower + (joints_[i].upper - joints_[i].lower) * next_uniform(state);
    }
  }

  void clamp(JointVector& q) const {
    for (std::size_t i = 0; i < q.size(); ++i) {
      q[i] = std::clamp(q[i], joints_[i].lower, joints_[i].upper);
    }
  }

 private:
  static constexpr int kStalledMax = 3;
  /// Sugihara has 1/2; a fiftieth needs a third fewer steps on the arms measured here.
  static constexpr double kDamping = 0.02;

  /// q += (J^T J + (kDamping |e|^2 + tiny) I)^-1 J^T e, with lengths in units of the arm.
  void step(const Jacobian& J, const Vec3& p_error, const Vec3& w_error, JointVector& q) const {
    const std::size_t n = q.size();
    const double scale = 1 / length_;
    const Column e{scale * p_error.x, scale * p_error.y, scale * p_error.z,
                   w_error.x,         w_error.y,         w_error.z};
    std::array<Column, kMaxJoints> column;
    Vector g{};
    double error_squared = 0;
    for (const double value : e) error_squared += value * value;
    for (std::size_t i = 0; i < n; ++i) {
      column[i] = {scale * J.v[i].x,
                   scale * J.v[i].y,
                   scale * J.v[i].z,
                   rotation_weight_ * J.w[i].x,
                   rotation_weight_ * J.w[i].y,
                   rotation_weight_ * J.w[i].z};
      for (std::size_t k = 0; k < 6; ++k) g[i] += column[i][k] * e[k];
      // A joint at its limit that would go on is out of this step.
      const bool held =
          (q[i] >= joints_[i].upper && g[i] > 0) || (q[i] <= joints_[i].lower && g[i] < 0);
      if (held) {
        column[i] = {};
        g[i] = 0;
      }
    }
    const double damping = kDamping * error_squared + 1e-12;
    Matrix H;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = 0;
        for (std::size_t k = 0; k < 6; ++k) sum += column[i][k] * column[j][k];
        H[i][j] = sum;
      }
      H[i][i] += damping;
    }
    solve_symmetric(H, g, n);
    for (std::size_t i = 0; i < n; ++i) q[i] += g[i];
    clamp(q);
  }

  const SerialChain& chain_;
  std::span<const Joint> joints_;
  const PoseBF& target_;
  const NumericOptions& options_;
  double length_ = 1;
  double rotation_weight_ = 1;
};

}  // namespace

Expected<NumericSolution> inverse_numeric(const SerialChain& chain, std::span<const Joint> joints,
                                          const PoseBF& X_BF, std::span<const double> start,
                                          const NumericOptions& options) {
  SINEW_ASSERT(joints.size() == chain.size() && start.size() == chain.size());
  if (const double distance = norm(X_BF.p); distance > chain.length()) {
    return std::unexpected(Error{ErrorCode::kOutOfReach, -1, distance, chain.length()});
  }
  const Solver solver(chain, joints, X_BF, options);
  NumericSolution solution{.q = JointVector(start)};
  solver.clamp(solution.q);
  std::uint64_t state = options.seed;
  double least = std::numeric_limits<double>::infinity();
  while (solution.attempts < options.attempts_max) {
    if (solution.attempts > 0) solver.randomise(solution.q, state);
    ++solution.attempts;
    double residual = 0;
    if (solver.attempt(solution.q, solution.iterations, residual)) return solution;
    least = std::min(least, residual);
  }
  return std::unexpected(Error{ErrorCode::kNotConverged, -1, least, options.position_tolerance});
}

}  // namespace sinew::kinematics
