#include "sinew/cli/output/svg_parts.h"

#include <algorithm>
#include <cmath>

#include "sinew/cli/output/shown_text.h"

namespace sinew::cli {

std::string svg_escaped(const std::string& text) {
  std::string result;
  for (const char c : shown(text)) {
    if (c == '<') {
      result += "&lt;";
    } else if (c == '&') {
      result += "&amp;";
    } else {
      result += c;
    }
  }
  return result;
}

std::vector<double> PlotScale::ticks() const {
  std::vector<double> values;
  const double first = std::ceil(lower / step - 1e-6);
  const auto count = static_cast<int>(std::floor((upper - lower) / step + 0.5)) + 1;
  for (int i = 0; i < count; ++i) {
    const double value = (first + i) * step;
    if (value <= upper + step / 1e6) values.push_back(value);
  }
  return values;
}

PlotScale scale_for(double lower, double upper, int ticks) {
  const PlotScale tight = tight_scale(lower, upper, ticks);
  return {std::floor(tight.lower / tight.step) * tight.step,
          std::ceil(tight.upper / tight.step) * tight.step, tight.step};
}

PlotScale tight_scale(double lower, double upper, int ticks) {
  if (upper - lower < 1e-9) {
    lower -= 1;
    upper += 1;
  }
  const double raw = (upper - lower) / ticks;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double nice : {1.0, 2.0, 5.0}) {
    if (raw <= nice * power) {
      step = nice * power;
      break;
    }
  }
  return {lower, upper, step};
}

}  // namespace sinew::cli
