#include "sinew/cli/output/program_folder.h"

#include <sstream>

#include "sinew/cli/output/plan_report.h"
#include "sinew/config/points_file.h"
#include "sinew/io/file.h"

namespace sinew::cli {
namespace {

/// "a/b/" of "a/b/c.sinew"; empty where it lies here.
std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? std::string() : path.substr(0, slash + 1);
}

constexpr std::size_t kCalledMax = 63;

/// The programs that a text calls; the reader of programs says what is wrong with their rows.
std::vector<std::string> called_in(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string word;
    std::string name;
    if (words >> word >> name && word == "call" && is_point_name(name)) names.push_back(name);
  }
  return names;
}

}  // namespace

std::expected<std::optional<TaughtPoints>, Outcome> load_points(const std::string& program_path) {
  const std::string path = folder_of(program_path) + "points.toml";
  if (!io::exists(path)) return std::nullopt;
  const auto text = io::read_file(path);
  if (!text) return std::unexpected(bad_input(text.error().sentence));
  return usable_points(*text, path);
}

std::expected<program::Program, Outcome> read_program(
    const std::string& path, const RobotModel& model,
    std::shared_ptr<const program::TableTop> table) {
  const auto text = io::read_file(path);
  if (!text) return std::unexpected(bad_input(text.error().sentence));
  const auto* form = program::form_of_text(path, *text, model);
  const auto points = load_points(path);
  if (!points) return std::unexpected(points.error());
  program::Surroundings around;
  around.points = *points ? &**points : nullptr;
  around.table = std::move(table);
  around.load = [&](std::string_view name) -> std::expected<program::CalledFile, std::string> {
    const std::string called = folder_of(path) + std::string(name) + ".sinew";
    auto body = io::read_file(called);
    if (!body) return std::unexpected(body.error().sentence);
    return program::CalledFile{called, std::move(*body)};
  };
  auto program = program::read_text(form, *text, path, model, around);
  if (!program) return std::unexpected(no_form(program.error(), model, path));
  return std::move(*program);
}

Outcome no_form(const program::NoForm& why, const RobotModel& model, const std::string& file) {
  if (!why.complaints.empty()) return complaints_outcome(why.complaints);
  if (why.refusal) return plan_refusal(model, file, *why.refusal);
  return bad_input(file + ": " + why.sentence);
}

std::expected<ProgramTexts, Outcome> gather_program(const std::string& path) {
  const auto text = io::read_file(path);
  if (!text) return std::unexpected(bad_input(text.error().sentence));
  ProgramTexts all{
      .text = *text, .form = program::form_of_file(path), .points = std::nullopt, .called = {}};
  if (all.form != nullptr) return all;
  const std::string points = folder_of(path) + "points.toml";
  if (io::exists(points)) {
    auto read = io::read_file(points);
    if (!read) return std::unexpected(bad_input(read.error().sentence));
    all.points = std::move(*read);
  }
  std::vector<std::string> unread = called_in(*text);
  while (!unread.empty() && all.called.size() < kCalledMax) {
    const std::string name = unread.back();
    unread.pop_back();
    if (all.called.contains(name)) continue;
    const auto body = io::read_file(folder_of(path) + name + ".sinew");
    if (!body) return std::unexpected(bad_input(body.error().sentence));
    all.called.emplace(name, *body);
    for (const std::string& more : called_in(*body)) unread.push_back(more);
  }
  return all;
}

std::string file_of(const program::Program& program, int file, const std::string& otherwise) {
  const auto place = static_cast<std::size_t>(file);
  return place < program.files.size() ? program.files[place] : otherwise;
}

}  // namespace sinew::cli
