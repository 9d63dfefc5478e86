#include "sinew/cli/run_record.h"

#include <fmt/format.h>

#include <cstdio>
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

void tell_run(const RunRequest& request, const runtime::RecordTold& told, Outcome& outcome) {
  outcome.json["record"] = {{"file", told.path}, {"lost", told.lost}};
  if (!told.trouble.empty()) {
    const bool asked = records_mcap(request);
    const std::string what =
        fmt::format("{}: {}; the record is not whole",
                    asked ? "--record: " + *request.record : told.path, told.trouble);
    if (asked) return add_trouble(outcome, what);
    outcome.json["record"]["trouble"] = told.trouble;
    outcome.text += "  " + what + "\n";
    return;
  }
  outcome.text += records_mcap(request) ? "  " + *request.record : "  recorded: " + told.path;
  if (told.full) outcome.text += " (up to the size that it may have)";
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
  const bool asked = records_mcap(request);
  if (!asked && !request.recorded && !real) return nullptr;
  const auto folder = asked && !real ? std::string() : runtime::records_folder();
  if (!folder && real) return std::unexpected(could_not(folder.error().sentence));
  // What nobody asked for keeps nobody from running.
  const auto unrecorded = [&](const std::string& why) {
    if (!request.quiet)
      std::fputs(("  note: no record of this run: " + why + "\n").c_str(), stderr);
  };
  if (!folder) {
    unrecorded(folder.error().sentence);
    return nullptr;
  }
  const std::int64_t wall = io::wall_time_ns();
  auto recorder = std::make_unique<runtime::RunRecorder>(
      model,
      runtime::RecorderOptions{model.id, "sinew " SINEW_VERSION, real ? *folder : std::string()},
      clock.now(), wall);
  if (asked) {
    const std::filesystem::path path(*request.record);
    const std::string parent = path.has_parent_path() ? path.parent_path().string() : ".";
    const auto begun = recorder->begin({parent, path.filename().string(), request.file});
    if (!begun) return std::unexpected(could_not("--record: " + begun.error().sentence));
  } else if (request.recorded) {
    const auto begun = recorder->begin(runtime::run_place(*folder, model.id, request.file, wall));
    if (!begun) unrecorded(begun.error().sentence);
  }
  return recorder;
}

void end_record(const RunRequest& request, runtime::RunRecorder& recorder, Outcome& outcome) {
  recorder.end_flight();
  recorder.end();
  while (const auto told = recorder.take_told()) {
    told->fault ? tell_fault(*told, outcome) : tell_run(request, *told, outcome);
  }
}

}  // namespace sinew::cli
