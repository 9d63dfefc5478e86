#include "sinew/cli/commission_verb.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "sinew/cli/device_argument.h"
#include "sinew/cli/local_cell.h"
#include "sinew/cli/procedure_dialogue.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/runtime/commissioning_file.h"
#include "sinew/runtime/robot_variant.h"

namespace sinew::cli {
namespace {

using Phase = program::Procedure::Phase;
using State = program::StepResult::State;

struct Job {
  const CommissionRequest& request;
  const RobotModel& model;
  std::string file;      ///< of its results; empty where none are kept
  bool finished_before;  ///< a list before this one has come to its end
  ScriptedAnswers* script = nullptr;
};

/// The device that is meant; nothing: simulated.
std::optional<std::string> port_of(const CommissionRequest& request) {
  return request.port == "simulated" ? std::nullopt : request.port;
}

/// Also a device of `sinew sim`: what is found there says nothing about the real robot.
bool rehearses(const CommissionRequest& request) {
  return !is_real(port_of(request));
}

/// What was kept: answers, however it ended; settings count when it has come to its end.
void tell_results(const Job& job, const runtime::ProcedureStatus& status, Outcome& outcome) {
  if (job.file.empty()) return;
  if (!status.note.empty()) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + status.note;
  }
  if (status.file.empty()) return;
  const bool done = status.view.phase == Phase::kDone && status.note.empty();
  if (done) {
    outcome.json["settings"] = Json::object();
    for (const auto& [key, value] : status.settings) {
      outcome.json["settings"][key] = value;
      outcome.text += fmt::format("  other than in the robot's file: {} = {}\n", key, value);
    }
    if (status.settings.empty()) outcome.text += "  everything is as the robot's file says\n";
  }
  outcome.json["file"] = status.file;
  outcome.text += "  " + status.file + "\n";
  const bool rehearsal = rehearses(job.request) && !job.request.save;
  outcome.json["rehearsal"] = rehearsal;
  if (rehearsal) {
    outcome.text += "  a rehearsal on a simulated device; the real robot's settings stay\n";
  }
  if (done) return;
  outcome.text += "  what was answered is kept there; the same command goes on from it\n";
  if (job.finished_before) {
    outcome.text += "  until it has come to its end, the settings that were found before count\n";
  }
}

/// @param why  it was broken off, other than by an answer; empty where it was not
Outcome told(const Job& job, const runtime::ProcedureStatus& status, const std::string& why) {
  Outcome outcome;
  const program::ProcedureView& view = status.view;
  outcome.text = "\n" + results_text(view);
  if (view.phase != Phase::kDone) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint = view.phase == Phase::kFailed ? view.trouble : "cancelled";
    if (view.place < view.steps.size()) {
      outcome.complaint += fmt::format("; at the step '{}'", view.steps[view.place].step);
    }
    if (!why.empty()) outcome.complaint = why;
  }
  outcome.json = {{"robot", job.model.id},
                  {"procedure", view.id},
                  {"phase", program::name(view.phase)},
                  {"steps", results_json(view)}};
  std::string failed;
  for (const auto& step : view.steps) {
    if (step.result.state != State::kFailed) continue;
    failed += (failed.empty() ? "" : ", ") + step.step;
  }
  if (!failed.empty()) outcome.text += "  not as it should be: " + failed + "\n";
  tell_results(job, status, outcome);
  if (!outcome.complaint.empty()) outcome.json["error"] = {{"sentence", outcome.complaint}};
  return outcome;
}

Outcome drive(const Job& job, std::unique_ptr<LocalCell> cell) {
  runtime::Station& station = cell->station();
  auto runner = std::make_unique<runtime::ProcedureRunner>(station, station.clock(),
                                                           runtime::ResultsPlace{job.file, ""});
  if (const auto begun =
          runner->start({job.request.procedure, false, job.request.anew}, LocalCell::kClient);
      !begun) {
    return could_not(begun.error());
  }
  if (job.script != nullptr) {
    const auto unknown = job.script->unknown(step_ids(runner->status().view));
    if (unknown) return bad_input(*unknown);
  }
  if (!job.request.json) {
    std::fputs(fmt::format("  {}\n  over {} ({}); back goes one step back, cancel or Ctrl-C ends "
                           "it at any time\n",
                           runner->status().view.title, station.port_name(),
                           station.simulated() ? "simulated device" : "real port")
                   .c_str(),
               stderr);
  }
  ProcedureDialogue dialogue(job.request.json, job.script);
  std::string trouble;
  while (!runner->over()) {
    cell->turn();
    runner->poll();
    if (trouble.empty()) trouble = station.trouble();
    dialogue.turn(runner->status().view,
                  {.answer = [&](const std::string& text) { return runner->answer(text); },
                   .back = [&] { return runner->back(); },
                   .cancel = [&] { runner->cancel(); }});
    const int interrupts = io::interrupts();
    if (interrupts == 1) runner->cancel();
    if (interrupts < 2) continue;
    Outcome outcome =
        told(job, runner->status(), "left at once; what was under way goes on, unseen");
    outcome.at_once = true;
    (void)runner.release();
    abandon(std::move(cell));
    return outcome;
  }
  return told(job, runner->status(), trouble.empty() ? dialogue.complaint() : trouble);
}

/// Where the results go, and those of an unfinished time before.
std::expected<void, Outcome> find_file(Job& job) {
  const CommissionRequest& request = job.request;
  if (request.procedure != "commission") return {};
  if (request.save) {
    job.file = *request.save;
  } else {
    // A simulated device is not the one on the bench.
    auto path =
        runtime::commissioning_path(job.model.id + (rehearses(request) ? ".simulated" : ""));
    if (!path) return std::unexpected(could_not(path.error().sentence));
    job.file = std::move(*path);
  }
  const std::string option = request.save ? "--save: " : "";
  if (io::exists(job.file)) {
    auto before = runtime::read_commissioning(job.file, job.model);
    if (!before && std::filesystem::is_directory(job.file)) {
      return std::unexpected(
          bad_input(option + job.file + " is a folder; name a file in it, as in " +
                    (std::filesystem::path(job.file) / (job.model.id + ".json")).string()));
    }
    if (!before) {
      return std::unexpected(could_not(option + before.error() +
                                       "; only a settings file of this robot is replaced: name "
                                       "another file with --save, or move this one away"));
    }
    job.finished_before = before->finished;
  }
  // Learned now, not when everything has been answered.
  if (const auto place = runtime::check_commissioning_place(job.file); !place) {
    return std::unexpected(could_not(option + place.error().sentence));
  }
  return {};
}

std::expected<RobotModel, Outcome> model_for(const CommissionRequest& request) {
  constexpr std::string_view kProcedures[] = {"commission", "home", "recover"};
  bool known = false;
  for (const std::string_view one : kProcedures) known = known || one == request.procedure;
  if (!known) {
    return std::unexpected(bad_input("--procedure: '" + printable(request.procedure) +
                                     "' is none of commission, home, recover"));
  }
  const auto file = find_robot(request.robot);
  if (!file) return std::unexpected(file.error());
  if (const auto fine = check_has_device(file->model); !fine) return std::unexpected(fine.error());
  auto variant = runtime::variant_of(file->model, request.profile, request.wire, request.without);
  if (!variant) return std::unexpected(bad_input(variant.error()));
  if (const auto fine = check_seed(request.seed); !fine) return std::unexpected(fine.error());
  if (const auto fine = check_time_scale(request.time_scale); !fine) {
    return std::unexpected(fine.error());
  }
  if (!rehearses(request) && request.time_scale != 1) {
    return std::unexpected(bad_input("--time-scale: a real port keeps real time"));
  }
  return std::move(*variant);
}

}  // namespace

std::expected<FileSettings, std::string> read_settings_file(const RobotModel& robot,
                                                            const std::string& path) {
  const auto file = runtime::read_commissioning(path, robot);
  if (!file) return std::unexpected(file.error());
  if (!file->finished) {
    return std::unexpected(path +
                           ": its list was not finished, and what it found does not count: "
                           "sinew commission goes on with it");
  }
  FileSettings settings{file->settings, {}};
  if (!file->under_way.empty()) {
    settings.note =
        "another commissioning was begun and not finished; what the one before it "
        "found counts: " +
        path;
  }
  return settings;
}

std::expected<UsedSettings, std::string> use_settings_file(RobotModel& robot,
                                                           const std::string& path) {
  auto read = read_settings_file(robot, path);
  if (!read) return std::unexpected(read.error());
  if (const auto used = program::use_settings(robot, read->settings); !used) {
    return std::unexpected(path + ": " + used.error());
  }
  return UsedSettings{read->settings.empty() ? std::string() : path, std::move(read->note)};
}

std::string usual_settings(const RobotModel& robot) {
  const auto usual = runtime::commissioning_path(robot.id);
  // Without a state folder nothing was ever kept.
  return usual && io::exists(*usual) ? *usual : std::string();
}

std::expected<UsedSettings, Outcome> use_commissioning(RobotModel& robot,
                                                       const std::optional<std::string>& settings,
                                                       bool real) {
  if (settings == "none" || (!settings && !real)) return UsedSettings{};
  const std::string path = settings ? *settings : usual_settings(robot);
  if (path.empty() && !settings) return UsedSettings{};
  if (!settings) {
    // Somebody is in the middle of it; that is no reason to run nothing.
    const auto file = runtime::read_commissioning(path, robot);
    if (file && !file->finished) {
      return UsedSettings{{},
                          "the commissioning of this robot was not finished, and what it found "
                          "does not count: " +
                              path};
    }
  }
  auto used = use_settings_file(robot, path);
  if (used) return std::move(*used);
  return std::unexpected(could_not(settings ? "--settings: " + used.error()
                                            : used.error() + " (--settings none leaves it out)"));
}

Outcome commission(const CommissionRequest& request) {
  const auto model = model_for(request);
  if (!model) return model.error();
  Job job{request, *model, {}, false, nullptr};
  if (const auto found = find_file(job); !found) return found.error();
  std::optional<ScriptedAnswers> script;
  if (request.answers) {
    auto read = ScriptedAnswers::read(*request.answers);
    if (!read) return bad_input("--answers: " + read.error());
    script = std::move(*read);
    job.script = &*script;
  }
  io::catch_interrupts();
  auto cell = LocalCell::start(*model,
                               {.port = port_of(request),
                                .profile = request.profile,
                                .journal = request.journal,
                                .seed = request.seed,
                                .time_scale = request.time_scale,
                                .byte_log = {},
                                .assumes_start = false},
                               {});
  if (!cell) return cell.error();
  return drive(job, std::move(*cell));
}

}  // namespace sinew::cli
