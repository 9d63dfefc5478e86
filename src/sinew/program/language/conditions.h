#pragma once

#include <optional>
#include <string>

#include "sinew/model/robot_model.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/language/row_reader.h"

namespace sinew::program {

/// "base>20deg", "z<100mm", "supply>11V", "seen color=red": the words from `first` to `last` (not
/// included) of the row at hand, with or without blanks between them. Complains where it is none.
std::optional<Condition> read_condition(RowReader& row, const RobotModel& robot, std::size_t first,
                                        std::size_t last);

/// How a word begins that names a color.
inline constexpr std::string_view kColorKey = "color=";
/// The color of a word that begins so. Complains where it is none.
std::optional<vision::ColorName> read_color(RowReader& row, const Word& word);

/// "base > 20 deg", "seen color=red".
std::string condition_text(const Condition& condition, const RobotModel& robot);

}  // namespace sinew::program
