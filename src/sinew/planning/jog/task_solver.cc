#include "sinew/planning/jog/task_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/units.h"

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
/// Of a task's numbers, those from here on are turns.
constexpr std::size_t kTurnsFrom = 3;
/// How readily the tip's way is left out beside a turn: next to not at all, but a direction without
/// turns has to have a size too.
constexpr double kTipEase = 1e-3;
/// Of the task: less than this is not lost.
constexpr double kNothingLost = 1e-12;
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
  held_ = held != 0;
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

/// What of the task is left undone, so that of each direction k `lost` (where it is not 0) is.
/// @param onward  of the translation, up to what length it is readily left out along itself
TaskArray TaskSolver::left_out(const TaskArray& lost, const TaskArray& onward) const {
  // In units in which all numbers are left out alike, orthogonal directions one after the other.
  const double more = (std::sqrt(kTipEase * kTipEase + product(onward, onward)) - kTipEase) /
                      std::max(product(onward, onward), kTipEase * kTipEase);
  const auto scale = [&](TaskArray& some) {
    const double along = more * product(some, onward);
    for (std::size_t i = 0; i < kTurnsFrom; ++i) some[i] = kTipEase * some[i] + along * onward[i];
  };
  TaskArray out{};
  std::array<TaskArray, kTasksMax> done;
  std::size_t count = 0;
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    if (lost[k] == 0) continue;
    TaskArray along = U_[k];
    scale(along);
    const double left = lost[k] - product(along, out);
    for (std::size_t d = 0; d < count; ++d) {
      const double both = product(along, done[d]);
      for (std::size_t i = 0; i < kTasksMax; ++i) along[i] -= both * done[d][i];
    }
    const double size = std::sqrt(product(along, along));
    for (std::size_t i = 0; i < kTasksMax; ++i) {
      along[i] /= size;
      out[i] += left / size * along[i];
    }
    done[count++] = along;
  }
  scale(out);
  return out;
}

/// In turns; where these would be quicker than all that was asked for, rather along the tip's own
/// way, which it then goes more slowly; beside a joint at its limit in whatever costs least.
TaskArray TaskSolver::possible(const TaskArray& task, const TaskArray& lost) const {
  const double all = product(task, task);
  const TaskArray turns = left_out(lost, {});
  TaskArray rest = task;
  const double turned = product(turns, turns);
  if (turned <= all) {
    for (std::size_t i = 0; i < kTasksMax; ++i) rest[i] -= turns[i];
    return rest;
  }
  const auto blend = [&](TaskArray& from, const TaskArray& to) {
    const double share = std::min(1.0, all / product(to, to));
    for (std::size_t i = 0; i < kTasksMax; ++i) from[i] += share * (to[i] - from[i]);
  };
  TaskArray out{};
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    for (std::size_t i = 0; i < kTasksMax; ++i) out[i] += lost[k] * U_[k][i];
  }
  if (!held_) {
    TaskArray onward{};
    for (std::size_t i = 0; i < kTurnsFrom; ++i) onward[i] = task[i] / std::sqrt(all);
    blend(out, left_out(lost, onward));
  }
  blend(out, turns);
  for (std::size_t i = 0; i < kTasksMax; ++i) rest[i] -= out[i];
  return rest;
}

/// Along each direction, how much of the task the joints do.
TaskArray TaskSolver::driven(const TaskArray& task) const {
  TaskArray done{};
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    done[k] = std::clamp(speed_along(k, task), lower_[k], upper_[k]) * value_[k];
  }
  return done;
}

JointArray TaskSolver::solve(const TaskArray& task) const {
  TaskArray done = driven(task);
  TaskArray lost{};
  const double floor = kNothingLost * std::sqrt(product(task, task));
  bool any = false;
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    // Without limit and damping nothing can be.
    if (gain_[k] * value_[k] * value_[k] > 1 - kNothingLost && !(lower_[k] > -kInfinity) &&
        !(upper_[k] < kInfinity)) {
      continue;
    }
    const double left = product(U_[k], task) - done[k];
    if (!(std::abs(left) > floor)) continue;
    lost[k] = left;
    any = true;
  }
  if (any) {
    const TaskArray others = driven(possible(task, lost));
    for (std::size_t k = 0; k < kTasksMax; ++k) {
      if (lost[k] == 0) done[k] = others[k];
    }
  }
  JointArray u{};
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    if (!(value_[k] > 0)) continue;
    const double share = done[k] / (value_[k] * value_[k]);
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
