#include "sinew/cli/commission_verb.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <utility>

#include "sinew/cli/cell_connection.h"
#include "sinew/cli/device_argument.h"
#include "sinew/cli/procedure_dialogue.h"
#include "sinew/cli/robot_argument.h"
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
  if (request.procedure == "home") return program::homing_procedure(model, homing);
  if (request.procedure == "recover") return program::recovery_procedure(model, homing);
  return program::commissioning_procedure(model, homing, fact);
}

/// Answers are kept, however it ended; settings count when it has come to its end.
void keep_results(const Job& job, const program::Procedure& procedure, Outcome& outcome) {
  if (job.file.empty()) return;
  runtime::CommissioningFile file = job.before;
  file.finished = procedure.phase() == Phase::kDone;
  file.answers.clear();
  for (std::size_t k = 0; k < procedure.results().size(); ++k) {
    const program::StepResult& result = procedure.results()[k];
    if (result.state != State::kOpen) file.answers[procedure.plan().steps[k].id] = result;
  }
  if (file.finished) {
    file.settings = program::found_settings(procedure);
    RobotModel changed = job.model;
    if (const auto fits = program::use_settings(changed, file.settings); !fits) {
      outcome.exit = ExitCode::kCouldNot;
      outcome.complaint = "what was found does not fit the robot: " + fits.error();
      return;
    }
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
  if (!file.finished) {
    outcome.text += "  what was answered is kept there; the same command goes on from it\n";
  }
}

Outcome told(const Job& job, const program::Procedure& procedure, const ProcedureDialogue& dialogue,
             const runtime::ProcedureEnd& end) {
  Outcome outcome;
  outcome.text = "\n" + results_text(procedure);
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
                  {"steps", results_json(procedure)}};
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
  control::ControllerSettings settings =
      runtime::session_settings(clock, runtime::opening_of(model).limit);
  control::ControllerStart start;
  if (record != nullptr) {
    settings.journal = control::journal_settings(model);
    start = record->start();
  }
  runtime::ControlLoop loop(model, link.driver(), settings, start,
                            record != nullptr ? &record->pump() : nullptr);
  auto plan = plan_for(job.request, model, runtime::facts_of(link.driver(), model));
  if (!plan) return could_not(plan.error());
  if (job.script != nullptr) {
    if (const auto unknown = job.script->unknown(*plan)) return bad_input(*unknown);
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
  for (const auto& [id, result] : job.before.answers) procedure.keep(id, result);
  runtime::ProcedureEnd end;
  ProcedureDialogue dialogue(job.request.json, job.script);
  end = runtime::run_procedure(
      procedure, loop, link.line(), clock,
      {.turn = [&](program::Procedure& one, Instant now) { dialogue.turn(one, now); },
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
  if (!io::exists(job.file)) return {};
  auto before = runtime::read_commissioning(job.file, job.model);
  if (!before && !request.anew) {
    return std::unexpected(could_not(before.error() + " (--anew)"));
  }
  if (!before) return {};
  job.before = std::move(*before);
  if (request.anew || job.before.finished) job.before.answers.clear();
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

std::expected<std::string, Outcome> use_commissioning(RobotModel& robot,
                                                      const std::optional<std::string>& settings,
                                                      bool real) {
  if (settings == "none" || (!settings && !real)) return std::string();
  std::string path = settings.value_or("");
  if (!settings) {
    auto usual = runtime::commissioning_path(robot.id);
    // Without a state folder nothing was ever kept.
    if (!usual || !io::exists(*usual)) return std::string();
    path = std::move(*usual);
  }
  const auto file = runtime::read_commissioning(path, robot);
  const std::string option = settings ? "--settings: " : "";
  const std::string without = settings ? "" : " (--settings none leaves it out)";
  if (!file) return std::unexpected(could_not(option + file.error() + without));
  if (const auto used = program::use_settings(robot, file->settings); !used) {
    return std::unexpected(could_not(option + path + ": " + used.error() + without));
  }
  return file->settings.empty() ? std::string() : path;
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
  const io::Clock clock(request.time_scale);
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
