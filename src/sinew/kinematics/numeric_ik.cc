#include "sinew/kinematics/numeric_ik.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/dispatch.h"
#include "sinew/core/error_code.h"
#include "sinew/core/split_mix.h"
#include "sinew/core/trig.h"
#include "sinew/core/unrolled.h"
#include "sinew/kinematics/serial_walk.h"

namespace sinew::kinematics {
namespace {

/// 2 sin(angle / 2) times the axis of the rotation from one orientation to another: to third order
/// the rotation vector, without an arc tangent.
inline Vec3 rotation_error(const Rotation& from, const Rotation& to) {
  // sum of cross products of the axes = 2 sin(angle) axis; trace = 1 + 2 cos(angle).
  const Vec3 s = 0.5 * (cross(from.x, to.x) + cross(from.y, to.y) + cross(from.z, to.z));
  const double trace = dot(from.x, to.x) + dot(from.y, to.y) + dot(from.z, to.z);
  const double one_and_cos = 0.5 * (trace + 1);
  if (one_and_cos < 1e-6) return rotation_vector(to * from.transposed());
  return std::sqrt(2 / one_and_cos) * s;
}

template <std::size_t N>
using Vector = std::array<double, N>;
template <std::size_t N>
using Matrix = std::array<Vector<N>, N>;

/// Solves H x = g for a symmetric positive definite H, of which only the lower triangle is read, by
/// L D L^T; x overwrites g.
template <std::size_t N>
void solve_symmetric(Matrix<N>& H, Vector<N>& g) {
  Vector<N> inverse_diagonal;
  unrolled<N>([&](auto j) {
    inverse_diagonal[j] = 1 / H[j][j];
    unrolled<N - 1 - j>([&](auto below) {
      const std::size_t i = j + 1 + below;
      const double factor = H[i][j] * inverse_diagonal[j];
      unrolled<below + 1>([&](auto k) { H[i][j + 1 + k] -= factor * H[j + 1 + k][j]; });
      g[i] -= factor * g[j];
    });
  });
  // L D becomes L, and D^-1 is applied at once: each later step is then one multiply-add.
  unrolled<N>([&](auto j) {
    unrolled<j>([&](auto i) { H[j][i] *= inverse_diagonal[i]; });
    g[j] *= inverse_diagonal[j];
  });
  unrolled<N>([&](auto step) {
    const std::size_t j = N - 1 - step;
    unrolled<j>([&](auto i) { g[i] -= H[j][i] * g[j]; });
  });
}

/// The solver of chains with N joints; V is the vector type of the walk, a Vec3 or Column.
template <std::size_t N, class V>
class Solver {
 public:
  Solver(const SerialChain& chain, std::span<const Joint> joints, const PoseBF& target,
         const NumericOptions& options)
      : chain_(chain), target_(target), options_(options), length_(chain.reach(joints)) {
    std::copy_n(chain.links().begin(), N, links_.begin());
    for (std::size_t i = 0; i < N; ++i) {
      theta_offset_[i] = chain.rows()[i].theta_offset;
      lower_[i] = joints[i].lower;
      upper_[i] = joints[i].upper;
    }
    scale_ = 1 / length_;
    rotation_weight_ = options.task == NumericTask::kPose ? 1 : 0;
    position_end_ = options.position_tolerance * options.position_tolerance * scale_ * scale_;
    rotation_end_ = options.rotation_tolerance * options.rotation_tolerance;
  }

  Expected<NumericSolution> solve(std::span<const double> start) const {
    Vector<N> q;
    for (std::size_t i = 0; i < N; ++i) q[i] = std::clamp(start[i], lower_[i], upper_[i]);
    NumericSolution solution;
    SplitMix64 numbers(options_.seed);
    double least = std::numeric_limits<double>::infinity();
    while (solution.attempts < options_.attempts_max) {
      if (solution.attempts > 0) q = random_joints(numbers);
      ++solution.attempts;
      double squared_error = 0;
      if (attempt(q, solution.iterations, squared_error)) {
        solution.q = JointVector(std::span<const double>(q));
        return solution;
      }
      least = std::min(least, squared_error);
    }
    return std::unexpected(Error{ErrorCode::kNotConverged, -1, std::sqrt(least) * length_,
                                 options_.position_tolerance});
  }

 private:
  /// Steps without a tenth of progress after which an attempt is given up: it is in a valley of
  /// the limits, and a restart costs less.
  static constexpr int kStalledMax = 3;
  /// Sugihara has 1/2; a fiftieth needs 13 to 38 % fewer steps on the four arms measured here.
  static constexpr double kDamping = 0.02;

  using Rows = std::array<Vector<N>, 6>;
  using Links = std::array<SerialLink, N>;
  /// How far the flange is from the target; lengths in units of the arm.
  struct Residual {
    Vec3 p, w;
    double p_squared = 0, w_squared = 0;
    double squared() const { return p_squared + w_squared; }
  };

  /// One attempt from q; true when it converged. `squared_error` is that of the last step.
  bool attempt(Vector<N>& q, int& iterations, double& squared_error) const {
    double best = std::numeric_limits<double>::infinity();
    int stalled = 0;
    for (int i = 0; i < options_.iterations_max; ++i) {
      Rows J;
      const Residual e = residual(q, J);
      squared_error = e.squared();
      if (e.p_squared <= position_end_ && e.w_squared <= rotation_end_) return true;
      stalled = squared_error < 0.81 * best ? 0 : stalled + 1;
      best = std::min(best, squared_error);
      if (stalled > kStalledMax) return false;
      ++iterations;
      step(J, e, q);
    }
    return false;
  }

  Residual residual(const Vector<N>& q, Rows& J) const {
    if (!chain_.has_slide()) return residual(q, links_, J);
    Vector<N> theta{};
    Links links = links_;
    for (std::size_t i = 0; i < N; ++i) (chain_.slides(i) ? links[i].d : theta[i]) += q[i];
    return residual(theta, links, J);
  }

  /// @param theta  rad, without theta_offset
  Residual residual(const Vector<N>& theta, const Links& links, Rows& J) const {
    std::array<double, kLanes> s, c;
    sines(theta.data(), theta_offset_, N, s, c);
    WalkFrame<V> frame;
    std::array<Vec3, N> axis, origin;
    for (std::size_t i = 0; i < N; ++i) {
      axis[i] = vec3(frame.z);
      origin[i] = vec3(frame.p);
      frame.pass(links[i], s[i], c[i]);
    }
    const Vec3 p_BF = vec3(frame.p);
    for (std::size_t i = 0; i < N; ++i) {
      const bool slides = chain_.slides(i);
      const Vec3 v = scale_ * (slides ? axis[i] : cross(axis[i], p_BF - origin[i]));
      const Vec3 w = slides ? Vec3{} : rotation_weight_ * axis[i];
      J[0][i] = v.x;
      J[1][i] = v.y;
      J[2][i] = v.z;
      J[3][i] = w.x;
      J[4][i] = w.y;
      J[5][i] = w.z;
    }
    const Rotation R_BF{vec3(frame.x), vec3(frame.y), vec3(frame.z)};
    Residual e{.p = scale_ * (target_.p - p_BF),
               .w = rotation_weight_ * rotation_error(R_BF, target_.R)};
    e.p_squared = dot(e.p, e.p);
    e.w_squared = dot(e.w, e.w);
    return e;
  }

  /// q += (J^T J + (kDamping |e|^2 + tiny) I)^-1 J^T e.
  void step(Rows& J, const Residual& e, Vector<N>& q) const {
    Vector<N> g;
    for (std::size_t i = 0; i < N; ++i) {
      g[i] = (J[0][i] * e.p.x + J[1][i] * e.p.y) + (J[2][i] * e.p.z + J[3][i] * e.w.x) +
             (J[4][i] * e.w.y + J[5][i] * e.w.z);
    }
    for (std::size_t i = 0; i < N; ++i) {
      // A joint at its limit that would go on is out of this step. Asked with integers, because the
      // branches of a short-circuit are guessed wrong half of the time.
      const int stuck_up = static_cast<int>(q[i] >= upper_[i]) & static_cast<int>(g[i] > 0);
      const int stuck_down = static_cast<int>(q[i] <= lower_[i]) & static_cast<int>(g[i] < 0);
      const double moves = (stuck_up | stuck_down) != 0 ? 0 : 1;
      g[i] *= moves;
      for (Vector<N>& row : J) row[i] *= moves;
    }
    const double damping = kDamping * e.squared() + 1e-12;
    Matrix<N> H;
    unrolled<N>([&](auto i) {
      unrolled<i + 1>([&](auto j) {
        H[i][j] = (J[0][i] * J[0][j] + J[1][i] * J[1][j]) +
                  (J[2][i] * J[2][j] + J[3][i] * J[3][j]) + (J[4][i] * J[4][j] + J[5][i] * J[5][j]);
      });
      H[i][i] += damping;
    });
    solve_symmetric(H, g);
    move(q, g);
  }

  /// A joint that would leave its limits goes on from their other end where that is nearer on the
  /// circle, else, and where it slides, it stops at the limit.
  void move(Vector<N>& q, const Vector<N>& dq) const {
    for (std::size_t i = 0; i < N; ++i) {
      const double to = q[i] + dq[i];
      const double past = std::max(std::max(to - upper_[i], lower_[i] - to), 0.0);
      const double turned = to > upper_[i] ? to - 2 * kPi : to + 2 * kPi;
      const double missing = std::max(lower_[i] - turned, turned - upper_[i]);
      const bool turns = missing < past && !chain_.slides(i);
      q[i] = std::clamp(turns ? turned : to, lower_[i], upper_[i]);
    }
  }

  Vector<N> random_joints(SplitMix64& numbers) const {
    Vector<N> q;
    for (std::size_t i = 0; i < N; ++i) {
      q[i] = numbers.uniform(lower_[i], upper_[i]);
    }
    return q;
  }

  static constexpr std::size_t kLanes = N + N % 2;
  const SerialChain& chain_;
  const PoseBF& target_;
  const NumericOptions& options_;
  double length_, scale_ = 1, rotation_weight_ = 1;
  double position_end_ = 0, rotation_end_ = 0;  // squared, in units of the arm and rad
  Links links_;
  std::array<double, kLanes> theta_offset_{};
  Vector<N> lower_, upper_;
};

template <std::size_t N>
Expected<NumericSolution> solve(const SerialChain& chain, std::span<const Joint> joints,
                                const PoseBF& X_BF, std::span<const double> start,
                                const NumericOptions& options) {
  return dispatched([&] { return Solver<N, Vec3>(chain, joints, X_BF, options).solve(start); },
                    [&] { return Solver<N, Column>(chain, joints, X_BF, options).solve(start); });
}

/// One solver for each number of joints: with the sizes known, every loop is straight code.
template <std::size_t N>
Expected<NumericSolution> solve_sized(const SerialChain& chain, std::span<const Joint> joints,
                                      const PoseBF& X_BF, std::span<const double> start,
                                      const NumericOptions& options) {
  if (chain.size() == N) return solve<N>(chain, joints, X_BF, start, options);
  if constexpr (N > 1) return solve_sized<N - 1>(chain, joints, X_BF, start, options);
  SINEW_ASSERT(chain.size() > 0);
  return {};
}

}  // namespace

Expected<NumericSolution> inverse_numeric(const SerialChain& chain, std::span<const Joint> joints,
                                          const PoseBF& X_BF, std::span<const double> start,
                                          const NumericOptions& options) {
  SINEW_ASSERT(joints.size() == chain.size() && start.size() == chain.size());
  const double reach = chain.reach(joints);
  if (const double distance = norm(X_BF.p); distance > reach + kReachTolerance) {
    return std::unexpected(Error{ErrorCode::kOutOfReach, -1, distance, reach});
  }
  return solve_sized<kMaxJoints>(chain, joints, X_BF, start, options);
}

}  // namespace sinew::kinematics
