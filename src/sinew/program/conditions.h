#pragma once

#include <optional>
#include <string>

#include "sinew/model/robot_model.h"
#include "sinew/program/program_file.h"
#include "sinew/program/row_reader.h"

namespace sinew::program {

/// "base>20deg", "z<100mm", "supply>11V": the words from `first` to `last` (not included) of the
/// row at hand, with or without blanks between them. Complains where it is none.
std::optional<Condition> read_condition(RowReader& row, const RobotModel& robot, std::size_t first,
                                        std::size_t last);

/// "base > 20 deg".
std::string condition_text(const Condition& condition, const RobotModel& robot);

}  // namespace sinew::program
