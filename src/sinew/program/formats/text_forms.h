#pragma once

#include <expected>
#include <string>
#include <string_view>

#include "sinew/program/formats/text_form.h"

namespace sinew::program {

/// "sequence", "pos", "gcode"; nullptr: none has this name. All of these are valid for ever.
const TextForm* text_form(std::string_view name);
/// The names of all forms, or of those that are written too: "sequence, pos or gcode".
std::string form_names(bool written);

/// The pose that the heads in a platform's file mean.
/// @param line  where its numbers begin
std::expected<PlatformFit, NoForm> platform_of(const PoseFile& pose, const RobotModel& robot,
                                               const std::string& file_name, int line);

/// What a file's name says that it is, by its ending; nullptr: a program's own form, or none.
const TextForm* form_of_file(std::string_view name);
/// The same, and where the name says nothing (a pipe), by its first word: G0, M203, BEGIN are of
/// the device's own form where it has one, and G-code elsewhere.
const TextForm* form_of_text(std::string_view name, std::string_view text, const RobotModel& robot);

/// A text of another form as the rows of a program, laid out; parse() takes them.
/// @param file_name  as complaints shall show it
std::expected<Rows, NoForm> rows_of(const TextForm& form, std::string_view text,
                                    const std::string& file_name, const RobotModel& robot);

/// The same as a program whose steps have the lines of the text.
std::expected<Program, NoForm> read_form(const TextForm& form, std::string_view text,
                                         const std::string& file_name, const RobotModel& robot);

/// A text of that form, or where it is nullptr a program with what is around it.
std::expected<Program, NoForm> read_text(const TextForm* form, std::string_view text,
                                         const std::string& file_name, const RobotModel& robot,
                                         const Surroundings& around);

/// A program that can be carried out from home in another form: a sequence, or the pose that its
/// only row moves to.
/// @param form  one that is written
std::expected<std::string, NoForm> text_of(const TextForm& form, const Program& program,
                                           const RobotModel& robot,
                                           DecimalMark mark = DecimalMark::kPoint);

}  // namespace sinew::program
