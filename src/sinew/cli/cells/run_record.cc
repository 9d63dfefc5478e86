#include "sinew/cli/cells/run_record.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "sinew/cli/cells/local_cell.h"
#include "sinew/cli/cells/run_outputs.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/runtime/journal/position_record.h"

namespace sinew::cli {
namespace {

void add_trouble(Outcome& outcome, const std::string& sentence) {
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + sentence;
}

void tell_run(const RunRequest& request, const runtime::RecordTold& told, Outcome& outcome) {
  const bool asked = records_mcap(request);
  if (!told.trouble.empty() && !asked && !io::exists(told.path)) {
    outcome.text += "  note: no record of this run: " + told.trouble + "\n";
    return;
  }
  outcome.json["record"] = {{"file", told.path}, {"lost", told.lost}};
  if (!told.trouble.empty()) {
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

std::expected<RecordPlan, Outcome> plan_records(const RunRequest& request,
                                                const RobotModel& model) {
  RecordPlan plan;
  const bool keeps = request.robot.journal || is_real(request.robot.port);
  const bool asked = records_mcap(request);
  const auto folder =
      keeps || request.recorded ? runtime::records_folder() : io::IoResult<std::string>("");
  if (!folder && keeps) return std::unexpected(could_not(folder.error().sentence));
  if (keeps) plan.folders.flight = *folder;
  plan.folders.records_jobs = asked || (request.recorded && folder);
  if (asked) {
    const std::filesystem::path path(*request.record);
    const std::string parent = path.has_parent_path() ? path.parent_path().string() : ".";
    plan.place = {parent, path.filename().string(), request.file};
  } else if (plan.folders.records_jobs) {
    plan.place = runtime::run_place(*folder, model.id, request.file, io::wall_time_ns());
  } else if (request.recorded && !request.quiet) {
    // A record that was not asked for keeps no program from running.
    std::fputs(("  note: no record of this run: " + folder.error().sentence + "\n").c_str(),
               stderr);
  }
  return plan;
}

void end_records(const RunRequest& request, runtime::Station& station, Outcome& outcome) {
  station.end_flight();
  while (const auto told = station.take_record()) {
    told->fault ? tell_fault(*told, outcome) : tell_run(request, *told, outcome);
  }
  if (const auto failure = station.log_failure()) {
    add_trouble(outcome, "--log: " + failure->sentence + "; the log is not whole");
  }
}

}  // namespace sinew::cli
