#include "sinew/cli/cells/commission_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "sinew/cli/cells/device_verb.h"
#include "sinew/cli/cells/in_cell.h"
#include "sinew/cli/cells/procedure_dialogue.h"
#include "sinew/cli/cells/robot_verb_options.h"
#include "sinew/cli/output/verb_options.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/runtime/commissioning_file.h"

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

/// Also a device of `sinew sim`: what is found there says nothing about the real robot.
bool rehearses(const CommissionRequest& request) {
  return !is_real(request.robot.port);
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
  Outcome outcome = told(job, runner->status(), trouble.empty() ? dialogue.complaint() : trouble);
  const bool done = runner->status().view.phase == Phase::kDone;
  runner.reset();
  if (done && job.request.robot.port && job.request.procedure == "commission") {
    add_boards(job.request.robot, job.model, cell, outcome);
  }
  return outcome;
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

std::expected<void, Outcome> check_procedure(const CommissionRequest& request) {
  constexpr std::array<std::string_view, 3> kProcedures{"commission", "home", "recover"};
  if (std::ranges::find(kProcedures, request.procedure) != kProcedures.end()) return {};
  return std::unexpected(bad_input("--procedure: '" + printable(request.procedure) +
                                   "' is none of commission, home, recover"));
}

}  // namespace

Outcome commission(CommissionRequest request) {
  if (request.robot.port == "simulated") request.robot.port.reset();
  if (const auto fine = check_procedure(request); !fine) return fine.error();
  if (request.procedure == "commission") {
    if (request.robot.settings) {
      return bad_input(
          "--settings: goes with --procedure home or recover; commissioning finds them");
    }
    request.robot.settings = "none";
  }
  const auto chosen = choose_robot(request.robot);
  if (!chosen) return chosen.error();
  Job job{request, chosen->model, {}, false, nullptr};
  if (const auto found = find_file(job); !found) return found.error();
  std::optional<ScriptedAnswers> script;
  if (request.answers) {
    auto read = ScriptedAnswers::read(*request.answers);
    if (!read) return bad_input("--answers: " + read.error());
    script = std::move(*read);
    job.script = &*script;
  }
  io::catch_interrupts();
  auto cell = LocalCell::start(chosen->model, request.robot);
  if (!cell) return cell.error();
  Outcome outcome = drive(job, std::move(*cell));
  if (request.procedure != "commission") tell_settings(chosen->settings, outcome);
  return outcome;
}

void add_commission(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<WithCell<CommissionRequest>>();
  CommissionRequest& request = own->request;
  CLI::App* verb = add_verb(app, call, "commission",
                            "a guided checklist for a robot's first day; also homing and recovery",
                            "sinew commission hexapod --port /dev/ttyUSB0");
  RobotOptions& robot = request.robot;
  verb->add_option("ROBOT", robot.name, "id or .toml file")->required();
  verb->add_option("--port", robot.port, "as of run; a simulated device where left out");
  verb->add_option("--procedure", request.procedure, "commission, home or recover");
  add_variant(*verb, robot);
  verb->add_option("--answers", request.answers, "a file of STEP = ANSWER, instead of typing");
  verb->add_option("--save", request.save, "where the results go; the state folder where left out");
  verb->add_flag("--anew", request.anew, "asks again what was answered before");
  add_journal(*verb, robot);
  add_settings(*verb, robot);
  add_seed(*verb, robot);
  add_time_scale(*verb, robot);
  add_cell_options(*verb, *own);
  verb->callback([&call, own, verb] {
    call.verb = [&call, own, verb] {
      own->request.json = call.json;
      if (!on_cell(*own, call)) return commission(own->request);
      const auto heard = check_heard(*verb, {"ROBOT", "--answers", "--anew"});
      if (!heard) return heard.error();
      own->cell.robot = own->request.robot.name;
      own->cell.answers = own->request.answers;
      own->cell.anew = own->request.anew;
      return cell_commission(own->cell);
    };
  });
}

}  // namespace sinew::cli
