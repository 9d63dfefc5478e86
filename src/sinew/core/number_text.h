#pragma once

#include <string>

namespace sinew {

/// A number for people: up to `digits` decimals, no trailing zeros, no "-0".
std::string number_text(double value, int digits);
/// The shortest text that shows `value` to six digits.
std::string number_text(double value);

}  // namespace sinew
