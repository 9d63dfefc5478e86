#include "sinew/calibration/f_distribution.h"

#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::calibration {
namespace {

/// Continued fraction of the incomplete beta function, by Lentz's method.
double beta_fraction(double a, double b, double x) {
  constexpr int kTermsMax = 500;
  constexpr double kTiny = 1e-300;
  constexpr double kSettled = 1e-15;
  const auto away_from_0 = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1;
  double d = 1 / away_from_0(1 - (a + b) * x / (a + 1));
  double fraction = d;
  for (int m = 1; m <= kTermsMax; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / away_from_0(1 + even * d);
    c = away_from_0(1 + even / c);
    fraction *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / away_from_0(1 + odd * d);
    c = away_from_0(1 + odd / c);
    fraction *= d * c;
    if (std::abs(d * c - 1) < kSettled) break;
  }
  return fraction;
}

/// Regularised incomplete beta function.
double beta_share(double a, double b, double x) {
  const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                a * std::log(x) + b * std::log1p(-x));
  // The fraction converges fast on this side of the mean only.
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

}  // namespace

double f_quantile(double share, double freedom, double estimate) {
  SINEW_ASSERT(share > 0 && share < 1 && freedom > 0 && estimate > 0);
  // log of F, which has a range that halving covers.
  double low = -60;
  double high = 60;
  for (int i = 0; i < 80; ++i) {
    const double middle = (low + high) / 2;
    const double ratio = freedom * std::exp(middle);
    const double x = ratio / (ratio + estimate);
    const bool below = x < 1 && beta_share(freedom / 2, estimate / 2, x) < share;
    (below ? low : high) = middle;
  }
  return std::exp((low + high) / 2);
}

}  // namespace sinew::calibration
