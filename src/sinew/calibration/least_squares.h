#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <vector>

#include "sinew/calibration/geometry.h"

namespace sinew::calibration {

/// Derivatives of a residual of two rows (px), a column per parameter that it depends on.
using PairRows = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor, 2, 32>;

/// Consecutive parameters.
struct Run {
  Eigen::Index first = 0;
  Eigen::Index size = 0;
};

/// How points enter a fit.
struct PointWeights {
  double huber = 0;        ///< px, beyond which a residual counts linearly; 0: never
  std::vector<char> used;  ///< by point
};

/// Normal equations H step = -g of a sum of squares, built residual by residual. Only the lower
/// triangle of H is filled.
class NormalEquations {
 public:
  NormalEquations(Eigen::Index parameters, const PointWeights& weights);

  /// Adds a point that is seen `residual` (px) from its picture, with J's columns for the
  /// parameters of `runs`, in rising order.
  void add_point(std::size_t point, const Eigen::Vector2d& residual, const PairRows& J,
                 std::initializer_list<Run> runs);

  /// Adds one residual, with derivatives to all parameters.
  void add_prior(double residual, const Eigen::VectorXd& derivatives);

  Eigen::MatrixXd full_H() const { return H.selfadjointView<Eigen::Lower>(); }

  /// Inverse of H; zero rows for parameters that no residual depends on.
  Eigen::MatrixXd inverse() const;

  /// Step of Levenberg and Marquardt; nothing where the damped H is not positive definite.
  /// Parameters that no residual depends on stay.
  std::optional<Eigen::VectorXd> step(double damping) const;

  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double cost = 0;            ///< px^2, of used points (Huber's where it is on) and priors
  std::vector<double> norms;  ///< px, length of every point's residual, used or not

 private:
  const PointWeights* weights_;
};

/// Result of a fit of a problem P. A problem is a type with
///   State                            a value
///   std::size_t points() const       number of points
///   Eigen::Index size() const        number of parameters
///   bool add_to(NormalEquations&, const State&) const   false where a point is not in view
///   State moved(const State&, const Eigen::VectorXd& step) const
template <class P>
struct Fit {
  typename P::State state;
  PointWeights weights;
  bool converged = false;
  double cost = 0;            ///< px^2
  std::vector<double> norms;  ///< px, of every point's residual
};

/// Minimum by Levenberg-Marquardt steps from `state`.
///
/// Source: D. Marquardt, An Algorithm for Least-Squares Estimation of Nonlinear Parameters, 1963.
template <class P>
Fit<P> minimise(const P& problem, typename P::State state, PointWeights weights) {
  constexpr int kStepsMax = 100;
  constexpr double kDampingMin = 1e-10;
  constexpr double kDampingMax = 1e12;
  constexpr double kFloor = 1e-20;  // px^2, what rounding leaves
  Fit<P> fit{std::move(state), std::move(weights), false, kInfinity, {}};
  NormalEquations now(problem.size(), fit.weights);
  if (!problem.add_to(now, fit.state)) return fit;
  double damping = 1e-3;
  for (int i = 0; i < kStepsMax && !fit.converged && damping < kDampingMax; ++i) {
    const std::optional<Eigen::VectorXd> step = now.step(damping);
    if (!step) {
      damping *= 10;
      continue;
    }
    const double gain = -now.g.dot(*step);
    const bool last = damping < 0.1 && gain <= 1e-8 * now.cost + kFloor;
    typename P::State next = problem.moved(fit.state, *step);
    NormalEquations there(problem.size(), fit.weights);
    if (problem.add_to(there, next) && there.cost <= now.cost) {
      fit.state = std::move(next);
      now = std::move(there);
      damping = std::max(damping / 10, kDampingMin);
    } else {
      damping *= 8;
    }
    fit.converged = last;
  }
  fit.cost = now.cost;
  fit.norms = std::move(now.norms);
  return fit;
}

/// Standard deviation of one coordinate (px) by the median of residuals; sound with a third of the
/// points wrong.
double robust_sigma(const std::vector<double>& norms);

/// The norms of points that are kept.
std::vector<double> kept_norms(const std::vector<double>& norms, const std::vector<char>& kept);

/// The points that a fit keeps: all, except up to a quarter that are off by more than 5 sigma and
/// more than 0.3 px. Sigma is robust_sigma(), or that of the points kept before where it is larger
/// and some were dropped. Fewer than 8 points are all kept.
std::vector<char> points_kept(const std::vector<double>& norms, const std::vector<char>& before);

/// Drops wrong points and fits again, until the same points are kept.
template <class P>
Fit<P> fit_without_wrong_points(const P& problem, Fit<P> fit) {
  constexpr int kRoundsMax = 5;
  for (int round = 0; round < kRoundsMax; ++round) {
    std::vector<char> kept = points_kept(fit.norms, fit.weights.used);
    if (fit.weights.huber == 0 && kept == fit.weights.used) break;
    fit = minimise(problem, std::move(fit.state), {0, std::move(kept)});
  }
  return fit;
}

/// From a start far from the solution and with wrong points: Huber's weights first.
template <class P>
Fit<P> robust_fit(const P& problem, typename P::State start) {
  constexpr double kHuberMin = 1e-3;  // px
  const std::vector<char> all(problem.points(), 1);
  PointWeights weights{0, all};
  NormalEquations first(problem.size(), weights);
  if (!problem.add_to(first, start)) return {std::move(start), weights, false, kInfinity, {}};
  Fit<P> fit{std::move(start), std::move(weights), false, first.cost, first.norms};
  for (int round = 0; round < 2; ++round) {
    const double huber = std::max(1.5 * robust_sigma(fit.norms), kHuberMin);
    fit = minimise(problem, std::move(fit.state), {huber, all});
  }
  return fit_without_wrong_points(problem, std::move(fit));
}

template <class P>
std::vector<double> kept_norms(const Fit<P>& fit) {
  return kept_norms(fit.norms, fit.weights.used);
}

/// Standard deviation of one coordinate of a pixel (px), of what a fit left over; 0 where it has
/// no more residuals than parameters.
template <class P>
double sigma_of(const Fit<P>& fit, Eigen::Index parameters) {
  const auto used = std::count(fit.weights.used.begin(), fit.weights.used.end(), 1);
  const Eigen::Index free = 2 * used - parameters;
  return free <= 0 ? 0 : std::sqrt(fit.cost / static_cast<double>(free));
}

}  // namespace sinew::calibration
