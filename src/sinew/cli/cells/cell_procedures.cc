// Homing, recovery and commissioning of a robot of a running cell, with somebody at a terminal, or
// a file, that answers.
#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "sinew/cli/cells/cell_connection.h"
#include "sinew/cli/cells/cell_verbs.h"
#include "sinew/cli/cells/procedure_dialogue.h"
#include "sinew/io/clock.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/standard_streams.h"
#include "sinew/server/json/procedure_json.h"

namespace sinew::cli {
namespace {

using runtime::ProcedureStatus;

/// The order itself, where nobody is there to be asked: one search.
constexpr const char* kHomeOnce = "* = yes\nagain = skip\n";

/// One procedure, from its beginning to its end.
class Passage {
 public:
  Passage(CellConnection& cell, const CellRequest& request, ScriptedAnswers* script)
      : cell_(cell), request_(request), script_(script), dialogue_(request.json, script) {}

  Outcome go(const char* kind) {
    const Json watched{{"rate_hz", 0}, {"robot", request_.robot}};
    if (auto watch = cell_.call("watch", watched); !watch) return watch.error();
    const auto begun = cell_.call("procedure.start", {{"robot", request_.robot},
                                                      {"kind", kind},
                                                      {"take_over", request_.take_over},
                                                      {"anew", request_.anew}});
    if (!begun) return begun.error();
    if (!read(*begun)) return could_not("the server's answer is no procedure");
    if (const auto unknown = unknown_step()) {
      ask("procedure.cancel");
      return bad_input(*unknown);
    }
    if (!request_.json) {
      std::fputs(fmt::format("  {}\n  back goes one step back, cancel or Ctrl-C ends it at any "
                             "time\n",
                             status_.view.title)
                     .c_str(),
                 stderr);
    }
    return follow();
  }

 private:
  bool read(const Json& json) {
    auto status = server::read_procedure(json);
    if (!status) return false;
    // Told before an answer that has been taken since.
    const bool old = status->number != status_.number || status->answers < status_.answers;
    if (status_.number != 0 && old) return true;
    status_ = std::move(*status);
    json_ = json;
    return true;
  }

  std::optional<std::string> unknown_step() const {
    if (script_ == nullptr || !request_.answers) return std::nullopt;
    std::vector<std::string> steps;
    for (const auto& step : status_.view.steps) steps.push_back(step.step);
    return script_->unknown(steps);
  }

  std::expected<void, std::string> ask(const char* method, Json params = Json::object()) {
    params["robot"] = request_.robot;
    const auto done = cell_.client().call(method, params);
    if (!done) return std::unexpected(done.error().message);
    read(*done);
    return {};
  }

  Outcome follow() {
    const ProcedureHands hands{
        .answer =
            [this](const std::string& text) { return ask("procedure.answer", {{"answer", text}}); },
        .back = [this] { return ask("procedure.back"); },
        .cancel = [this] { static_cast<void>(ask("procedure.cancel")); }};
    const io::Clock clock;
    Instant alive = clock.now();
    int interrupts = 0;
    const control::ClientId own = status_.client;
    bool had = false;
    while (true) {
      const program::ProcedureView view = status_.view;
      had = had || !view.left;
      if (status_.client != own || (had && view.left)) return taken_away();
      if (had) dialogue_.turn(view, hands);
      if (status_.over) return outcome();
      const auto message = cell_.client().next(kSlice);
      if (cell_.client().broken()) return could_not("the server has gone away; the robot stops");
      if (message && (*message)["method"] == "procedure") read((*message)["params"]);
      if (io::interrupts() > interrupts) {
        interrupts = io::interrupts();
        if (interrupts > 1) return could_not("left at once; the procedure waits at its step");
        hands.cancel();
      }
      if (clock.now() - alive < kAlive) continue;
      alive = clock.now();
      cell_.client().send("lease.renew");
    }
  }

  Outcome taken_away() const {
    return could_not(fmt::format(
        "control was lost; {} waits at the step '{}', and the same command with --take-over goes "
        "on "
        "there",
        status_.view.title,
        status_.view.place < status_.view.steps.size() ? status_.view.steps[status_.view.place].step
                                                       : ""));
  }

  Outcome outcome() const {
    using Phase = program::Procedure::Phase;
    const program::ProcedureView& view = status_.view;
    Outcome outcome;
    outcome.json = json_;
    outcome.text = "\n" + results_text(view);
    for (const auto& [key, value] : status_.settings) {
      outcome.text += fmt::format("  other than in the robot's file: {} = {}\n", key, value);
    }
    if (!status_.file.empty()) outcome.text += "  " + status_.file + "\n";
    if (view.phase != Phase::kDone) {
      outcome.exit = ExitCode::kCouldNot;
      outcome.complaint = view.phase == Phase::kFailed ? view.trouble : "cancelled";
      if (view.place < view.steps.size()) {
        outcome.complaint += fmt::format("; at the step '{}'", view.steps[view.place].step);
      }
      if (!dialogue_.complaint().empty()) outcome.complaint = dialogue_.complaint();
    } else if (!status_.note.empty()) {
      outcome.exit = ExitCode::kCouldNot;
      outcome.complaint = status_.note;
    }
    if (!outcome.complaint.empty()) outcome.json["error"] = {{"sentence", outcome.complaint}};
    return outcome;
  }

  CellConnection& cell_;
  const CellRequest& request_;
  ScriptedAnswers* script_;
  ProcedureDialogue dialogue_;
  ProcedureStatus status_;
  Json json_;
};

std::expected<std::optional<ScriptedAnswers>, Outcome> answers_of(const CellRequest& request) {
  if (!request.answers) return std::nullopt;
  auto read = ScriptedAnswers::read(*request.answers);
  if (!read) return std::unexpected(bad_input("--answers: " + read.error()));
  return std::move(*read);
}

/// Nobody is there to be asked.
bool unattended(const CellRequest& request) {
  return !request.answers && (request.json || !io::stdin_is_terminal());
}

}  // namespace

Outcome cell_home(const CellRequest& request) {
  auto script = answers_of(request);
  if (!script) return script.error();
  if (unattended(request)) *script = *ScriptedAnswers::parse(kHomeOnce, "home");
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  io::catch_interrupts();
  return Passage(*cell, request, *script ? &**script : nullptr).go("home");
}

Outcome cell_commission(const CellRequest& request) {
  auto script = answers_of(request);
  if (!script) return script.error();
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  io::catch_interrupts();
  return Passage(*cell, request, *script ? &**script : nullptr).go("commission");
}

Outcome cell_recover(const CellRequest& request) {
  if (request.answers && request.standing_at) {
    return bad_input(
        "--answers: go with the steps of a recovery; --standing-at is one word for it");
  }
  auto script = answers_of(request);
  if (!script) return script.error();
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  const auto status = make_known(*cell, request);
  if (!status) return status.error();
  const std::string position = (*status)["position"];
  const bool lost = position == "lost" || position == "uncertain";
  const bool goes_on = request.answers || (lost && !request.standing_at && !unattended(request));
  if (!goes_on) return recovered(*status, request);
  io::catch_interrupts();
  return Passage(*cell, request, *script ? &**script : nullptr).go("recover");
}

}  // namespace sinew::cli
