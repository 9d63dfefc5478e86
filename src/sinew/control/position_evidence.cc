#include "sinew/control/position_evidence.h"

#include <algorithm>

namespace sinew::control {

Expected<JointInterval> agree(std::size_t joint, std::span<const Evidence> known,
                              const JointPosition& said) {
  JointInterval where{said.lower, said.upper};
  for (const Evidence& one : known) {
    const double lower = one.where.lower - one.slack;
    const double upper = one.where.upper + one.slack;
    if (where.upper < lower || where.lower > upper) {
      const bool counted = one.source == Evidence::Source::kCounters;
      const double middle = (one.where.lower + one.where.upper) / 2;
      const double nearest = said.q < one.where.lower ? one.where.lower : one.where.upper;
      return std::unexpected(
          Error{counted ? ErrorCode::kCountedElsewhere : ErrorCode::kDeclaredElsewhere,
                static_cast<std::int8_t>(joint), said.q, counted ? middle : nearest});
    }
    where = {std::max(where.lower, lower), std::min(where.upper, upper)};
  }
  return where;
}

}  // namespace sinew::control
