#pragma once

namespace sinew::calibration {

/// The value that a ratio of two estimated variances does not exceed with probability `share`
/// (Fisher's F distribution). Also 95 % of the length of an error whose standard deviation was
/// estimated from few residuals: sqrt of it, times the standard deviation.
///
/// Source: W. Press et al., Numerical Recipes, 3rd ed., 6.4 (incomplete beta function).
/// @param share     0 < share < 1
/// @param freedom   > 0, of the numerator; need not be whole
/// @param estimate  > 0, of the denominator
/// @return  relative error below 1e-9
double f_quantile(double share, double freedom, double estimate);

}  // namespace sinew::calibration
