#include "sinew/cli/cells/run_outputs.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "sinew/io/file.h"

namespace sinew::cli {
namespace {

void add_failure(Outcome& outcome, const std::string& sentence) {
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + sentence;
}

}  // namespace

bool records_mcap(const RunRequest& request) {
  return request.record && request.record->ends_with(".mcap");
}

std::expected<void, Outcome> check_outputs(const RunRequest& request) {
  // Whoever mistypes a name must not lose the program, the robot's file, or send text to the arm.
  std::vector<std::pair<std::string, std::string>> taken{{"the program", request.file}};
  if (request.robot.name.ends_with(".toml"))
    taken.emplace_back("the robot's file", request.robot.name);
  if (request.robot.port) taken.emplace_back("the port", *request.robot.port);
  const auto check = [&](const std::string& option,
                         const std::optional<std::string>& path) -> std::expected<void, Outcome> {
    if (!path) return {};
    if (const auto fine = io::check_place(*path); !fine) {
      return std::unexpected(bad_input(option + ": " + fine.error().sentence));
    }
    for (const auto& [what, other] : taken) {
      if (!io::same_file(*path, other)) continue;
      return std::unexpected(
          bad_input(fmt::format("{}: {} is {}; choose another name", option, *path, what)));
    }
    taken.emplace_back("the file of " + option, *path);
    return {};
  };
  if (auto fine = check("--log", request.log); !fine) return fine;
  if (auto fine = check("--record", request.record); !fine) return fine;
  return check("--plot", request.plot);
}

void write_outputs(const RunRequest& request, const RunTexts& texts, Outcome& outcome) {
  const auto write = [&](const char* option, const std::optional<std::string>& path,
                         const std::function<std::string()>& text) {
    if (!path) return;
    if (const auto written = io::replace_file(*path, text()); !written) {
      add_failure(outcome, fmt::format("{}: {}", option, written.error().sentence));
    } else {
      outcome.text += "  " + *path + "\n";
    }
  };
  if (!records_mcap(request)) write("--record", request.record, texts.record);
  write("--plot", request.plot, texts.plot);
}

}  // namespace sinew::cli
