#pragma once

#include <expected>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/program/formats/text_forms.h"

namespace sinew::cli {

/// Reads a program NAME.sinew with what lies in its folder (points.toml, programs that it calls),
/// or a file of another form (sequence, G-code, .pos), by its ending or first word.
/// @param table  of its cell; null: it is not known
/// @error  everything that is wrong with the texts, at once
std::expected<program::Program, Outcome> read_program(
    const std::string& path, const RobotModel& model,
    std::shared_ptr<const program::TableTop> table = {});

/// A program's text with what lies in its folder, unread, for whoever reads it elsewhere.
struct ProgramTexts {
  std::string text;
  const program::TextForm* form = nullptr;    ///< by its ending; of such a text only this
  std::optional<std::string> points;          ///< points.toml
  std::map<std::string, std::string> called;  ///< by name, those of called programs too
};
/// @error  a file cannot be read
std::expected<ProgramTexts, Outcome> gather_program(const std::string& path);

/// Why a text of another form is no program, as a person asked for it.
/// @param file  of row 0
Outcome no_form(const program::NoForm& why, const RobotModel& model, const std::string& file);

/// "wave.sinew:12", of the file that a refusal or an order means.
std::string file_of(const program::Program& program, int file, const std::string& otherwise);

/// The taught points beside a program; none where there is no such file.
std::expected<std::optional<TaughtPoints>, Outcome> load_points(const std::string& program_path);

}  // namespace sinew::cli
