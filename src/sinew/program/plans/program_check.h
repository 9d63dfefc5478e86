#pragma once

#include <vector>

#include "sinew/program/plans/order_planner.h"

namespace sinew::program {

/// Everything but the motion, row by row.
struct CheckedProgram {
  std::vector<RowVerdict> rows;  ///< one per step
  /// Why no more could be checked: the program is too long, or stands at too many places.
  std::optional<Refusal> broken_off;
  double duration_min = 0, duration_max = 0;  ///< s, of the rows that are fine
  double homing_max = 0;                      ///< s, likewise
  bool fine() const;
};

/// As make_plan(), but a refused row does not end it: the rows behind it are checked from where it
/// would have left the machine. Where that is not known they are not, up to a row that names all
/// joints or `home`.
/// @param look  is shown each motion, and may refuse it
CheckedProgram check(const Program& program, const RobotModel& robot, const Standing& start,
                     const Homing& homing = {}, const WayLook& look = {});

}  // namespace sinew::program
