#include "sinew/runtime/commissioning_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "sinew/core/spelling.h"
#include "sinew/io/disk_folder.h"
#include "sinew/io/file.h"
#include "sinew/runtime/journal/position_record.h"

namespace sinew::runtime {
namespace {

using Json = nlohmann::ordered_json;
using State = program::StepResult::State;

constexpr int kCommissioningVersion = 1;

std::optional<State> state_named(const std::string& word) {
  for (const State state : {State::kOpen, State::kDone, State::kSkipped, State::kFailed}) {
    if (program::name(state) == word) return state;
  }
  return std::nullopt;
}

bool read_answers(const Json& json, CommissioningFile::Answers& answers) {
  if (!json.is_object()) return false;
  for (const auto& [id, one] : json.items()) {
    if (!one.is_object() || !one.contains("state") || !one["state"].is_string()) return false;
    const auto state = state_named(one["state"]);
    if (!state) return false;
    program::StepResult result{.state = *state, .answer = {}, .words = {}};
    for (const auto& [key, to] : {std::pair{"answer", &result.answer}, {"words", &result.words}}) {
      if (!one.contains(key)) continue;
      if (!one[key].is_string()) return false;
      *to = printable(one[key].get<std::string>());
    }
    if (one.contains("number")) {
      if (!one["number"].is_number()) return false;
      result.number = one["number"].get<double>();
    }
    answers[id] = std::move(result);
  }
  return true;
}

Json answers_json(const CommissioningFile::Answers& answers) {
  Json json = Json::object();
  for (const auto& [id, result] : answers) {
    Json one{{"state", program::name(result.state)}};
    if (!result.answer.empty()) one["answer"] = result.answer;
    if (!result.words.empty()) one["words"] = result.words;
    if (result.number) one["number"] = *result.number;
    json[id] = std::move(one);
  }
  return json;
}

}  // namespace

io::IoResult<std::string> commissioning_folder() {
  auto positions = positions_folder();
  if (!positions) return std::unexpected(positions.error());
  return (std::filesystem::path(*positions).parent_path() / "commissioning").string();
}

io::IoResult<std::string> commissioning_path(const std::string& name) {
  auto folder = commissioning_folder();
  if (!folder) return folder;
  return *folder + "/" + name + ".json";
}

std::expected<CommissioningFile, std::string> read_commissioning(const std::string& path,
                                                                 const RobotModel& robot) {
  const auto text = io::read_file(path);
  if (!text) return std::unexpected(text.error().sentence);
  const Json json = Json::parse(*text, nullptr, false);
  const auto wrong = [&](const std::string& what) { return std::unexpected(path + ": " + what); };
  if (!json.is_object() || json.value("version", Json()) != kCommissioningVersion) {
    return wrong("is no settings file of this version");
  }
  if (json.value("robot", Json()) != robot.id) return wrong("is another robot's than " + robot.id);
  CommissioningFile file;
  file.finished = json.value("finished", Json()) == true;
  const Json answers = json.value("answers", Json::object());
  const Json settings = json.value("settings", Json::object());
  const Json under_way = json.value("under_way", Json::object());
  if (!settings.is_object() || !read_answers(answers, file.answers) ||
      !read_answers(under_way, file.under_way)) {
    return wrong("its answers or settings cannot be read");
  }
  for (const auto& [key, value] : settings.items()) {
    if (!value.is_string()) return wrong("the setting '" + printable(key) + "' is no text");
    file.settings[key] = value.get<std::string>();
  }
  if (!file.finished) file.under_way.swap(file.answers);
  return file;
}

io::IoResult<void> check_commissioning_place(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (!folder.empty()) {
    if (const auto made = io::DiskFolder::open_folder(folder); !made) {
      return std::unexpected(made.error());
    }
  }
  return io::check_place(path);
}

CommissioningResults results_of(const program::Procedure& procedure, CommissioningFile before) {
  CommissioningFile::Answers answers;
  for (std::size_t k = 0; k < procedure.results().size(); ++k) {
    const program::StepResult& result = procedure.results()[k];
    if (result.state != State::kOpen) answers[procedure.plan().steps[k].id] = result;
  }
  CommissioningResults results;
  if (procedure.phase() == program::Procedure::Phase::kDone) {
    const program::FoundSettings found = program::found_settings(procedure);
    RobotModel changed = procedure.machine().robot();
    if (const auto fits = program::use_settings(changed, found); fits) {
      results.file.finished = true;
      results.file.answers = std::move(answers);
      results.file.settings = found;
      return results;
    } else {
      results.misfit = "what was found does not fit the robot: " + fits.error();
    }
  }
  results.file = std::move(before);
  results.file.under_way = std::move(answers);
  return results;
}

io::IoResult<void> write_commissioning(const std::string& path, const RobotModel& robot,
                                       const CommissioningFile& file) {
  if (const auto place = check_commissioning_place(path); !place) return place;
  Json json{{"version", kCommissioningVersion}, {"robot", robot.id}, {"finished", file.finished}};
  json["settings"] = Json::object();
  for (const auto& [key, value] : file.settings) json["settings"][key] = value;
  json["answers"] = answers_json(file.finished ? file.answers : file.under_way);
  if (file.finished && !file.under_way.empty()) json["under_way"] = answers_json(file.under_way);
  return io::replace_file(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace sinew::runtime
