#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/program/formats/pose_file.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/language/program_rows.h"
#include "sinew/program/plans/program_plan.h"

namespace sinew::program {

/// What other programs write their motions in.
enum class TextForm : std::uint8_t {
  kSequence,  ///< the BigRobotArm's own, .txt
  kPose,      ///< a platform's pose, .pos
  kGcode,     ///< plain G-code; it is only read
};

/// "sequence", "pos", "gcode".
std::string_view name(TextForm form);
std::optional<TextForm> text_form(std::string_view name);

/// Why a text has no other form: one of these.
struct NoForm {
  std::string sentence;
  std::vector<Complaint> complaints;
  std::optional<Refusal> refusal;  ///< a row that cannot be carried out
};

/// The pose that the heads in a platform's file mean.
/// @param line  where its numbers begin
std::expected<PlatformFit, NoForm> platform_of(const PoseFile& pose, const RobotModel& robot,
                                               const std::string& file_name, int line);

/// What a file's name says that it is, by its ending; nothing: a program's own form, or none.
std::optional<TextForm> form_of_file(std::string_view name);
/// The same, and where the name says nothing (a pipe), by its first word: G0, M203, BEGIN are of a
/// sequence on a BigRobotArm, and G-code elsewhere.
std::optional<TextForm> form_of_text(std::string_view name, std::string_view text,
                                     const RobotModel& robot);

/// A text of another form as the rows of a program, laid out; parse() takes them.
/// @param file_name  as complaints shall show it
std::expected<Rows, NoForm> rows_of(TextForm form, std::string_view text,
                                    const std::string& file_name, const RobotModel& robot);

/// The same as a program whose steps have the lines of the text.
std::expected<Program, NoForm> read_form(TextForm form, std::string_view text,
                                         const std::string& file_name, const RobotModel& robot);

/// A text of that form, or where there is none a program with what is around it.
std::expected<Program, NoForm> read_text(std::optional<TextForm> form, std::string_view text,
                                         const std::string& file_name, const RobotModel& robot,
                                         const Surroundings& around);

/// A program that can be carried out from home in another form: a sequence, or the pose that its
/// only row moves to.
/// @param form  kSequence or kPose
std::expected<std::string, NoForm> text_of(TextForm form, const Program& program,
                                           const RobotModel& robot,
                                           DecimalMark mark = DecimalMark::kPoint);

}  // namespace sinew::program
