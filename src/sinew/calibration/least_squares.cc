#include "sinew/calibration/least_squares.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "sinew/core/assert.h"

namespace sinew::calibration {

NormalEquations::NormalEquations(Eigen::Index parameters, const PointWeights& weights)
    : H(Eigen::MatrixXd::Zero(parameters, parameters)),
      g(Eigen::VectorXd::Zero(parameters)),
      norms(weights.used.size()),
      weights_(&weights) {}

void NormalEquations::add_point(std::size_t point, const Eigen::Vector2d& residual,
                                const PairRows& J, std::initializer_list<Run> runs) {
  const double norm = residual.norm();
  norms[point] = norm;
  if (weights_->used[point] == 0) return;
  const double huber = weights_->huber;
  const bool linear = huber > 0 && norm > huber;
  const double weight = linear ? huber / norm : 1;
  cost += linear ? huber * (2 * norm - huber) : norm * norm;

  const Eigen::Index columns = J.cols();
  const double* u = J.data();
  const double* v = u + columns;
  std::array<Eigen::Index, 32> place{};
  Eigen::Index count = 0;
  for (const Run& run : runs) {
    for (Eigen::Index i = 0; i < run.size; ++i)
      place[static_cast<std::size_t>(count++)] = run.first + i;
  }
  SINEW_ASSERT(count == columns);
  double* const h = H.data();
  double* const gradient = g.data();
  const Eigen::Index rows = H.rows();
  for (Eigen::Index i = 0; i < columns; ++i) {
    const double u_i = weight * u[i];
    const double v_i = weight * v[i];
    const Eigen::Index row = place[static_cast<std::size_t>(i)];
    gradient[row] += u_i * residual.x() + v_i * residual.y();
    for (Eigen::Index j = 0; j <= i; ++j) {
      h[place[static_cast<std::size_t>(j)] * rows + row] += u_i * u[j] + v_i * v[j];
    }
  }
}

void NormalEquations::add_prior(double residual, const Eigen::VectorXd& derivatives) {
  cost += residual * residual;
  g += residual * derivatives;
  H += derivatives * derivatives.transpose();
}

Eigen::MatrixXd NormalEquations::inverse() const {
  Eigen::MatrixXd M = full_H();
  for (Eigen::Index i = 0; i < M.rows(); ++i) {
    if (M(i, i) == 0) M(i, i) = 1;
  }
  // Scaled to a diagonal of ones, so that focal lengths and lens coefficients can be compared.
  const Eigen::VectorXd scale = M.diagonal().cwiseSqrt().cwiseInverse();
  M = (scale.asDiagonal() * M * scale.asDiagonal()).eval();
  // What the residuals do not determine at all gets a huge variance, not a negative one.
  constexpr double kUndetermined = 1e-13;
  M.diagonal().array() += kUndetermined;
  M = M.ldlt().solve(Eigen::MatrixXd::Identity(M.rows(), M.cols())).eval();
  M = (scale.asDiagonal() * M * scale.asDiagonal()).eval();
  for (Eigen::Index i = 0; i < M.rows(); ++i) {
    if (H(i, i) != 0) continue;
    M.row(i).setZero();
    M.col(i).setZero();
  }
  return M;
}

std::optional<Eigen::VectorXd> NormalEquations::step(double damping) const {
  Eigen::MatrixXd M = H;
  for (Eigen::Index i = 0; i < M.rows(); ++i) {
    M(i, i) = M(i, i) == 0 ? 1 : M(i, i) * (1 + damping);
  }
  const Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> llt(M);
  if (llt.info() != Eigen::Success) return std::nullopt;
  Eigen::VectorXd step = llt.solve(-g);
  if (!step.allFinite()) return std::nullopt;
  return step;
}

double robust_sigma(const std::vector<double>& norms) {
  constexpr double kMedianOfRayleigh = 1.17741;  // of the length of two coordinates with sigma 1
  return quantile(norms, 0.5) / kMedianOfRayleigh;
}

std::vector<double> kept_norms(const std::vector<double>& norms, const std::vector<char>& kept) {
  std::vector<double> out;
  for (std::size_t i = 0; i < norms.size(); ++i) {
    if (kept[i] != 0) out.push_back(norms[i]);
  }
  return out;
}

std::vector<char> points_kept(const std::vector<double>& norms, const std::vector<char>& before) {
  constexpr std::size_t kPointsMin = 8;
  constexpr double kOffMin = 0.3;  // px
  const std::vector<char> all(norms.size(), 1);
  if (norms.size() < kPointsMin) return all;
  double sigma = robust_sigma(norms);
  // The median of few points is often too small.
  if (before != all) sigma = std::max(sigma, rms(kept_norms(norms, before)) / std::numbers::sqrt2);
  const double limit = std::max(5 * sigma, kOffMin);
  std::vector<char> kept = all;
  std::transform(norms.begin(), norms.end(), kept.begin(),
                 [&](double norm) { return static_cast<char>(norm <= limit ? 1 : 0); });
  const auto wrong = static_cast<std::size_t>(std::count(kept.begin(), kept.end(), 0));
  return wrong * 4 > norms.size() ? all : kept;
}

}  // namespace sinew::calibration
