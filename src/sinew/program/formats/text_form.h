#pragma once

#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/program/formats/pose_file.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/language/program_rows.h"
#include "sinew/program/plans/program_plan.h"

namespace sinew::program {

/// Why a text has no other form: one of these.
struct NoForm {
  std::string sentence;
  std::vector<Complaint> complaints;
  std::optional<Refusal> refusal;  ///< a row that cannot be carried out
};
inline std::unexpected<NoForm> no_form(std::string sentence) {
  return std::unexpected(NoForm{std::move(sentence), {}, {}});
}
inline std::unexpected<NoForm> no_form(std::vector<Complaint> complaints) {
  return std::unexpected(NoForm{{}, std::move(complaints), {}});
}

/// What other programs write their motions in. One of a kind of device is in its
/// devices/KIND/KIND_format.cc; text_forms.cc has the list.
struct TextForm {
  std::string_view name;                      ///< "sequence", "pos", "gcode"
  std::span<const std::string_view> endings;  ///< of files' names, as ".pos"
  /// It is what the robot's own programs are written in; nullptr: of none.
  bool (*is_own)(const RobotModel& robot) = nullptr;
  /// The rows of a program; parse() takes them.
  /// @param file_name  as complaints shall show it
  std::expected<Rows, NoForm> (*rows)(std::string_view text, const std::string& file_name,
                                      const RobotModel& robot);
  /// A program from home as such a text; nullptr: it is only read.
  std::expected<std::string, NoForm> (*text)(const Program& program, const RobotModel& robot,
                                             DecimalMark mark) = nullptr;
};

}  // namespace sinew::program
