#include "sinew/cli/run_record.h"

#include <fmt/format.h>

#include <filesystem>

#include "sinew/cli/run_outputs.h"
#include "sinew/io/clock.h"
#include "sinew/runtime/position_record.h"

namespace sinew::cli {
namespace {

void add_trouble(Outcome& outcome, const std::string& sentence) {
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + sentence;
}

void tell_asked(const RunRequest& request, const runtime::RecordTold& told, Outcome& outcome) {
  outcome.json["record"] = {{"file", *request.record}, {"lost", told.lost}};
  if (!told.trouble.empty()) {
    return add_trouble(outcome, fmt::format("--record: {}: {}; the record is not whole",
                                            *request.record, told.trouble));
  }
  outcome.text += "  " + *request.record;
  if (told.lost > 0) outcome.text += fmt::format(" ({} samples and events lost)", told.lost);
  outcome.text += "\n";
}

void tell_fault(const runtime::RecordTold& told, Outcome& outcome) {
  outcome.json["fault_records"].push_back({{"file", told.path}, {"trouble", told.trouble}});
  if (!told.trouble.empty()) {
    return add_trouble(
        outcome, fmt::format("the seconds before the fault: {}: {}", told.path, told.trouble));
  }
  outcome.text += fmt::format("  the seconds before the fault: {}\n", told.path);
}

}  // namespace

std::expected<std::unique_ptr<runtime::RunRecorder>, Outcome> begin_record(
    const RunRequest& request, const RobotModel& model, bool real, const io::Clock& clock) {
  if (!records_mcap(request) && !real) return nullptr;
  const auto folder = real ? runtime::records_folder() : std::string();
  if (!folder) return std::unexpected(could_not(folder.error().sentence));
  auto recorder = std::make_unique<runtime::RunRecorder>(
      model, runtime::RecorderOptions{model.id, "sinew " SINEW_VERSION, *folder}, clock.now(),
      io::wall_time_ns());
  if (!records_mcap(request)) return recorder;
  const std::filesystem::path path(*request.record);
  const std::string parent = path.has_parent_path() ? path.parent_path().string() : ".";
  const auto begun = recorder->begin({parent, path.filename().string(), request.file});
  if (!begun) return std::unexpected(could_not("--record: " + begun.error().sentence));
  return recorder;
}

void end_record(const RunRequest& request, runtime::RunRecorder& recorder, Outcome& outcome) {
  recorder.end_flight();
  recorder.end();
  while (const auto told = recorder.take_told()) {
    told->fault ? tell_fault(*told, outcome) : tell_asked(request, *told, outcome);
  }
}

}  // namespace sinew::cli
