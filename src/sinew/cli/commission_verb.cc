#include "sinew/cli/commission_verb.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "sinew/cli/cell_connection.h"
#include "sinew/cli/device_argument.h"
#include "sinew/cli/procedure_dialogue.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/run_journal.h"
#include "sinew/control/machine_identity.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/position_record.h"
#include "sinew/runtime/procedure_session.h"
#include "sinew/runtime/program_session.h"
#include "sinew/runtime/robot_link.h"
#include "sinew/runtime/robot_variant.h"

namespace sinew::cli {
namespace {

using Phase = program::Procedure::Phase;
using State = program::StepResult::State;

struct Job {
  const CommissionRequest& request;
  const RobotModel& model;
  std::string file;  ///< of its results; empty where none are kept
  runtime::CommissioningFile before;
  ScriptedAnswers* script = nullptr;
};

bool simulated(const CommissionRequest& request) {
  return !request.port || *request.port == "simulated";
}

std::expected<program::ProcedurePlan, std::string> plan_for(const CommissionRequest& request,
                                                            const RobotModel& model,
                                                            const program::DeviceFact& fact) {
  const program::Homing homing = runtime::homing_of(model);
  if (request.procedure == "home") return program::homing_procedure(model, homing, fact);
  if (request.procedure == "recover") return program::recovery_procedure(model, homing);
  return program::commissioning_procedure(model, homing, fact);
}

/// Answers are kept, however it ended; settings count when it has come to its end.
void keep_results(const Job& job, const program::Procedure& procedure, Outcome& outcome) {
  if (job.file.empty()) return;
  const auto [file, misfit] = runtime::results_of(procedure, job.before);
  if (!misfit.empty()) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint = misfit;
  }
  const bool done = procedure.phase() == Phase::kDone && misfit.empty();
  if (done) {
    outcome.json["settings"] = Json::object();
    for (const auto& [key, value] : file.settings) {
      outcome.json["settings"][key] = value;
      outcome.text += fmt::format("  other than in the robot's file: {} = {}\n", key, value);
    }
    if (file.settings.empty()) outcome.text += "  everything is as the robot's file says\n";
  }
  if (const auto kept = runtime::write_commissioning(job.file, job.model, file); !kept) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + kept.error().sentence;
    return;
  }
  outcome.json["file"] = job.file;
  outcome.text += "  " + job.file + "\n";
  if (done) return;
  outcome.text += "  what was answered is kept there; the same command goes on from it\n";
  if (file.finished) {
    outcome.text += "  until it has come to its end, the settings that were found before count\n";
  }
}

Outcome told(const Job& job, const program::Procedure& procedure, const ProcedureDialogue& dialogue,
             const runtime::ProcedureEnd& end) {
  Outcome outcome;
  const program::ProcedureView view = program::view_of(procedure, {});
  outcome.text = "\n" + results_text(view);
  if (procedure.phase() != Phase::kDone) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint = procedure.phase() == Phase::kFailed ? procedure.trouble() : "cancelled";
    if (procedure.place() < procedure.plan().steps.size()) {
      outcome.complaint += fmt::format("; at the step '{}'", procedure.step().id);
    }
    if (!dialogue.complaint().empty()) outcome.complaint = dialogue.complaint();
    if (end.wire_failure) outcome.complaint = end.wire_failure->sentence;
    if (end.left_at_once) outcome.complaint = "left at once; what was under way goes on, unseen";
  }
  outcome.json = {{"robot", job.model.id},
                  {"procedure", procedure.plan().id},
                  {"phase", program::name(procedure.phase())},
                  {"steps", results_json(view)}};
  std::string failed;
  for (std::size_t k = 0; k < procedure.results().size(); ++k) {
    if (procedure.results()[k].state != State::kFailed) continue;
    failed += (failed.empty() ? "" : ", ") + procedure.plan().steps[k].id;
  }
  if (!failed.empty()) outcome.text += "  not as it should be: " + failed + "\n";
  keep_results(job, procedure, outcome);
  if (!outcome.complaint.empty()) outcome.json["error"] = {{"sentence", outcome.complaint}};
  return outcome;
}

Outcome drive(const Job& job, runtime::RobotLink& link, runtime::PositionRecord* record,
              const io::Clock& clock) {
  const RobotModel& model = job.model;
  runtime::ControlLoop loop = recorded_loop(model, link.driver(), clock, record);
  auto plan = plan_for(job.request, model, runtime::facts_of(link.driver(), model));
  if (!plan) return could_not(plan.error());
  if (job.script != nullptr) {
    if (const auto unknown = job.script->unknown(step_ids(*plan))) return bad_input(*unknown);
  }
  if (!job.request.json) {
    std::fputs(
        fmt::format("  {}\n  over {} ({}); back goes one step back, cancel or Ctrl-C ends "
                    "it at any time\n",
                    plan->title, link.name(), link.simulated() ? "simulated device" : "real port")
            .c_str(),
        stderr);
  }
  program::Procedure procedure(std::move(*plan), loop.machine());
  for (const auto& [id, result] : job.before.under_way) procedure.keep(id, result);
  runtime::ProcedureEnd end;
  ProcedureDialogue dialogue(job.request.json, job.script);
  end = runtime::run_procedure(
      procedure, loop, link.line(), clock,
      {.turn =
           [&](program::Procedure& one, Instant now) {
             dialogue.turn(
                 program::view_of(one, now),
                 {.answer = [&](const std::string& text) { return one.answer(text, now); },
                  .back = [&] { return one.back(now); },
                  .cancel = [&] { one.cancel(now); }});
           },
       .interrupts = [] { return io::interrupts(); }});
  return told(job, procedure, dialogue, end);
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
        runtime::commissioning_path(job.model.id + (simulated(request) ? ".simulated" : ""));
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
    job.before = std::move(*before);
    if (request.anew) job.before.under_way.clear();
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
  auto variant = runtime::variant_of(file->model, request.profile, request.wire);
  if (!variant) return std::unexpected(bad_input(variant.error()));
  if (const auto fine = check_seed(request.seed); !fine) return std::unexpected(fine.error());
  if (const auto fine = check_time_scale(request.time_scale); !fine) {
    return std::unexpected(fine.error());
  }
  const bool real = !simulated(request) && !runtime::may_be_simulated(*request.port);
  if (real && request.time_scale != 1) {
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
  Job job{request, *model, {}, {}, nullptr};
  if (const auto found = find_file(job); !found) return found.error();
  std::optional<ScriptedAnswers> script;
  if (request.answers) {
    auto read = ScriptedAnswers::read(*request.answers);
    if (!read) return bad_input("--answers: " + read.error());
    script = std::move(*read);
    job.script = &*script;
  }
  io::catch_interrupts();
  const io::Clock clock =
      runtime::clock_for(simulated(request) ? std::nullopt : request.port, request.time_scale);
  runtime::ByteLog log;
  auto link = simulated(request)
                  ? runtime::RobotLink::simulate(*model,
                                                 {.profile = request.profile,
                                                  .seed = static_cast<std::uint64_t>(request.seed)},
                                                 clock, log)
                  : runtime::RobotLink::open(*model, *request.port, clock, log);
  if (!link) {
    const std::string holder = simulated(request) ? std::string() : held_by_cell(*request.port);
    return could_not(link.error().sentence + holder);
  }
  std::unique_ptr<runtime::PositionRecord> record;
  const bool real = !simulated(request) && !runtime::may_be_simulated(*request.port);
  if (request.journal || real) {
    auto folder = runtime::positions_folder();
    if (!folder) return could_not(folder.error().sentence);
    auto opened =
        runtime::PositionRecord::open(*folder, request.journal.value_or(model->id), *model);
    if (!opened) return could_not(opened.error().sentence);
    record = std::move(*opened);
  }
  return drive(job, *link, record.get(), clock);
}

}  // namespace sinew::cli
