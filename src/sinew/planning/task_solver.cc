#include "sinew/planning/task_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew::planning {
namespace {

template <std::size_t N>
double product(const std::array<double, N>& a, const std::array<double, N>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < N; ++i) sum += a[i] * b[i];
  return sum;
}

template <std::size_t N>
void rotate(std::array<double, N>& a, std::array<double, N>& b, double c, double s) {
  for (std::size_t i = 0; i < N; ++i) {
    const double before = a[i];
    a[i] = c * before - s * b[i];
    b[i] = s * before + c * b[i];
  }
}

constexpr int kSweepsMax = 12;
/// Cosine between two joint directions from which on they count as orthogonal: what is left of it
/// is an error of the velocities of the same part.
constexpr double kOrthogonal = 1e-9;
/// Rotations begin with what the last call ended with; this many calls later their rounding is
/// taken out.
constexpr unsigned kCallsFresh = 64;

}  // namespace

TaskArray TaskJacobian::times(const JointArray& qd) const {
  TaskArray sum{};
  for (std::size_t j = 0; j < joints; ++j) {
    for (std::size_t k = 0; k < kTasksMax; ++k) sum[k] += column[j][k] * qd[j];
  }
  return sum;
}

TaskSolver::TaskSolver() {
  start_again();
}

void TaskSolver::start_again() {
  U_ = {};
  for (std::size_t k = 0; k < kTasksMax; ++k) U_[k][k] = 1;
  calls_ = 0;
}

void TaskSolver::factor(const TaskJacobian& J, unsigned held) {
  if (++calls_ > kCallsFresh) {
    calls_ = 0;
    for (std::size_t k = 0; k < kTasksMax; ++k) {
      for (std::size_t l = 0; l < k; ++l) {
        const double along = product(U_[k], U_[l]);
        for (std::size_t i = 0; i < kTasksMax; ++i) U_[k][i] -= along * U_[l][i];
      }
      const double scale = 1 / std::sqrt(product(U_[k], U_[k]));
      for (double& number : U_[k]) number *= scale;
    }
  }
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    G_[k] = {};
    for (std::size_t j = 0; j < J.joints; ++j) {
      if ((held >> j & 1U) == 0) G_[k][j] = product(U_[k], J.column[j]);
    }
  }
  TaskArray squares;
  for (std::size_t k = 0; k < kTasksMax; ++k) squares[k] = product(G_[k], G_[k]);
  const double floor = 1e-30 * *std::max_element(squares.begin(), squares.end());
  bool rotated = true;
  for (int sweep = 0; sweep < kSweepsMax && rotated; ++sweep) {
    rotated = false;
    for (std::size_t k = 0; k + 1 < kTasksMax; ++k) {
      for (std::size_t l = k + 1; l < kTasksMax; ++l) {
        const double both = product(G_[k], G_[l]);
        if (both * both <= kOrthogonal * kOrthogonal * squares[k] * squares[l] + floor * floor) {
          continue;
        }
        rotated = true;
        const double zeta = (squares[l] - squares[k]) / (2 * both);
        const double t = std::copysign(1 / (std::abs(zeta) + std::sqrt(1 + zeta * zeta)), zeta);
        const double c = 1 / std::sqrt(1 + t * t);
        rotate(G_[k], G_[l], c, c * t);
        rotate(U_[k], U_[l], c, c * t);
        squares[k] = product(G_[k], G_[k]);
        squares[l] = product(G_[l], G_[l]);
      }
    }
  }
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    value_[k] = std::sqrt(squares[k]);
    const double depth = std::max(0.0, 1 - value_[k] / kNearSingular);
    const double damping = kDamping * depth;
    gain_[k] = 1 / (squares[k] + damping * damping);
    lower_[k] = -std::numeric_limits<double>::infinity();
    upper_[k] = std::numeric_limits<double>::infinity();
  }
}

void TaskSolver::limit(std::size_t k, double lower, double upper) {
  lower_[k] = lower;
  upper_[k] = upper;
}

double TaskSolver::speed_along(std::size_t k, const TaskArray& task) const {
  return gain_[k] * product(U_[k], task) * value_[k];
}

bool TaskSolver::limited(const TaskArray& task) const {
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    const double speed = speed_along(k, task);
    if (speed > 1.001 * upper_[k] || speed < 1.001 * lower_[k]) return true;
  }
  return false;
}

JointArray TaskSolver::solve(const TaskArray& task) const {
  JointArray u{};
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    if (!(value_[k] > 0)) continue;
    const double share = std::clamp(speed_along(k, task), lower_[k], upper_[k]) / value_[k];
    for (std::size_t j = 0; j < kMaxJoints; ++j) u[j] += share * G_[k][j];
  }
  return u;
}

double TaskSolver::lost_share(const TaskArray& task) const {
  double lost = 0;
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    const double driven = std::clamp(speed_along(k, task), lower_[k], upper_[k]) * value_[k];
    const double left = product(U_[k], task) - driven;
    lost += left * left;
  }
  const double all = product(task, task);
  return all > 0 ? std::sqrt(lost / all) : 0;
}

}  // namespace sinew::planning
