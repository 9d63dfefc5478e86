#include "sinew/cli/cells/run_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "sinew/cli/cells/in_cell.h"
#include "sinew/cli/cells/robot_verb_options.h"
#include "sinew/cli/cells/run_outputs.h"
#include "sinew/cli/cells/run_record.h"
#include "sinew/cli/output/device_argument.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/plan_report.h"
#include "sinew/cli/output/program_folder.h"
#include "sinew/cli/output/program_report.h"
#include "sinew/cli/output/progress_line.h"
#include "sinew/cli/output/quantity.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/cli/output/verb_options.h"
#include "sinew/control/position_evidence.h"
#include "sinew/control/stop_rules.h"
#include "sinew/core/error_code.h"
#include "sinew/io/interrupt.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/joint_value.h"
#include "sinew/program/language/program_part.h"
#include "sinew/runtime/homing_time.h"

namespace sinew::cli {
namespace {

/// As its intervals, or the journal, show it.
constexpr std::string_view kShown = "shown";

struct Prepared {
  RobotModel model;
  program::Program program;
  std::optional<JointVector> standing_at;
  double homing_max = 0;  ///< s, of all its `home` rows
  double speed = 1;       ///< of all rows
  UsedSettings settings;  ///< what commissioning found
  bool streams() const { return model.device.capability.motion == MotionKind::kStream; }
};

std::expected<std::optional<JointVector>, Outcome> standing_at(const RunRequest& request,
                                                               const RobotModel& model) {
  JointVector q = home_joints(model);
  if (!request.standing_at) {
    const bool known = !request.robot.port && model.device.settings->counts_from_power_up();
    return known ? std::optional(q) : std::nullopt;
  }
  if (*request.standing_at == "home") return q;
  if (*request.standing_at == kShown) return std::nullopt;
  const bool legs = std::holds_alternative<HexapodGeometry>(model.geometry);
  if (legs && *request.standing_at == "lowered") {
    for (std::size_t j = 0; j < q.size(); ++j) q[j] = model.joints[j].lower;
    return q;
  }
  const auto values = parse_joints("--standing-at", *request.standing_at, model);
  if (!values) return std::unexpected(bad_input(values.error()));
  q.clear();
  for (std::size_t i = 0; i < values->size(); ++i) {
    const Joint& joint = model.joints[i];
    const double beyond = control::reach_beyond_limits(joint);
    if ((*values)[i] < joint.lower - beyond || (*values)[i] > joint.upper + beyond) {
      const Error error = beyond_limit(joint, i, (*values)[i]);
      return std::unexpected(bad_input("--standing-at: " + error_text(error, model)));
    }
    q.push_back((*values)[i]);
  }
  return q;
}

/// --from-line and --speed.
std::expected<void, Outcome> take_part(const RunRequest& request, Prepared& prepared) {
  if (request.from_line) {
    auto part = program::from_line(prepared.program, *request.from_line);
    if (!part) return std::unexpected(bad_input("--from-line: " + part.error()));
    prepared.program = std::move(*part);
  }
  if (!request.speed) return {};
  const auto share = speed_share(*request.speed);
  if (!share) return std::unexpected(bad_input(share.error()));
  if (!prepared.model.device.capability.takes_speed) {
    return std::unexpected(bad_input("--speed: this device has one speed of its own"));
  }
  prepared.speed = *share;
  if (!prepared.streams()) prepared.program = program::slowed(prepared.program, *share);
  return {};
}

/// How a run is another one than its file says.
void tell_part(const RunRequest& request, const Prepared& prepared, Outcome& outcome) {
  tell_settings(prepared.settings, outcome);
  for (const program::ProgramNote& one : prepared.program.notes) {
    const std::string sentence = fmt::format("line {}: {}", one.line, one.sentence);
    outcome.json["notes"].push_back(sentence);
    outcome.text += "  note: " + sentence + "\n";
  }
  if (request.from_line) {
    outcome.json["from_line"] = *request.from_line;
    outcome.text += fmt::format("  note: from line {} on, planned from where the arm stood\n",
                                *request.from_line);
  }
  if (!request.speed) return;
  const bool feed = prepared.streams();
  outcome.json["speed"] = {{"share", prepared.speed}, {"through", feed ? "feed" : "plan"}};
  outcome.text +=
      fmt::format("  note: at {} % of the speed of all rows, {}\n", number(100 * prepared.speed, 1),
                  feed ? "through the feed: every motion keeps its way and takes longer"
                       : "planned so: this device takes whole moves");
}

/// Everything that can be wrong before a byte leaves.
std::expected<Prepared, Outcome> prepare(const RunRequest& request) {
  auto chosen = choose_robot(request.robot);
  if (!chosen) return std::unexpected(chosen.error());
  Prepared prepared{std::move(chosen->model), {}, {}, 0, 1, std::move(chosen->settings)};
  const RobotModel& model = prepared.model;
  if (request.moved && !request.standing_at) {
    return std::unexpected(bad_input("--moved: goes with --standing-at"));
  }
  if (const auto fine = check_outputs(request); !fine) return std::unexpected(fine.error());
  auto parsed = read_program(request.file, model);
  if (!parsed) return std::unexpected(parsed.error());
  prepared.program = std::move(*parsed);
  if (prepared.program.steps.empty()) {
    return std::unexpected(bad_input(request.file + ": has no step; a first line could be: joint " +
                                     model.joints[0].name +
                                     (model.joints[0].slides() ? "=200mm" : "=10deg")));
  }
  if (const auto fine = take_part(request, prepared); !fine) return std::unexpected(fine.error());
  const auto standing = standing_at(request, model);
  if (!standing) return std::unexpected(standing.error());
  prepared.standing_at = *standing;
  // Checked whole before the first byte leaves; once more when the machine has told where it is.
  const auto plan =
      program::make_plan(prepared.program, model, prepared.standing_at.value_or(home_joints(model)),
                         runtime::homing_of(model));
  // A run that goes on in the middle, or where it is shown, begins where only the machine knows.
  const bool begins_elsewhere =
      (request.from_line || request.standing_at == kShown) && !prepared.standing_at;
  if (!plan && !begins_elsewhere) {
    return std::unexpected(plan_refusal(
        model, file_of(prepared.program, plan.error().file, request.file), plan.error()));
  }
  if (plan) prepared.homing_max = plan->homing_max;
  return prepared;
}

/// Behind "stopped", where it was not asked for.
std::string reason_text(const std::optional<control::StopCause>& cause) {
  const std::string_view sentence = cause ? control::stop_rule(*cause).sentence : "";
  return sentence.empty() ? std::string() : fmt::format(": {}", sentence);
}

/// Why a run did not come to its end, as a sentence; empty where it did.
/// @param trouble    of the port, where it was lost
/// @param suspicion  of boards that are none, or others than was said
std::string why_not_done(const RunRequest& request, const ProgramReport& report,
                         const runtime::Station& station, const std::string& trouble) {
  const auto& [model, run, health, bytes, left_at_once, truth, now] = report;
  if (left_at_once) return "left at once; what was under way goes on, unseen";
  const std::string goes_on = goes_on_text(report);
  if (!trouble.empty()) return trouble + goes_on;
  if (run.phase() == program::Run::Phase::kStopped) {
    return "stopped" + reason_text(run.stopped_by()) + goes_on;
  }
  if (!run.failure()) return {};
  std::string reason = error_text(run.failure()->error, model);
  const std::string suspicion = station.suspicion();
  if (!suspicion.empty()) reason += "; " + suspicion;
  if (run.failure()->line > 0) {
    const std::string file = file_of(run.program(), run.failure()->file, request.file);
    return fmt::format("{}:{}: {}{}", file, run.failure()->line, reason, goes_on);
  }
  return fmt::format("{}: {}{}", station.port_name(), reason,
                     silence_hint(model, run.failure()->error, health));
}

/// What the journal knew when the run began, and what that means where it was not enough.
void tell_record(const runtime::Station& station, const program::Run& run, Outcome& outcome) {
  const JournalRecovery& recovery = *station.recovery();
  const std::string found = station.journal_found();
  outcome.json["position_journal"] = {{"found", found},
                                      {"way_out", std::string(sentence(recovery.way_out))},
                                      {"damaged_slots", recovery.damaged_slots}};
  const auto& failure = run.failure();
  if (failure && failure->error.code == ErrorCode::kPositionUnknown) {
    const bool forgot = recovery.way_out == WayOut::kNothing;
    outcome.complaint += fmt::format(
        "; {}: {}", found,
        forgot ? "but the device has restarted since, or was moved; home it, or state the position"
               : sentence(recovery.way_out));
    if (recovery.way_out != WayOut::kHome) outcome.complaint += " (--standing-at)";
  }
}

/// What is waited for while nothing has answered yet.
std::string opening_text(const Opening& opening) {
  return fmt::format("the device{} (at most {:.0f} s)", opening.waits_for,
                     to_seconds(opening.limit));
}

/// A run as the thread of its job sees it: its progress, its samples, and at its end the outcome.
class RunWatch {
 public:
  RunWatch(const RunRequest& request, const Prepared& prepared, LocalCell& cell)
      : request_(request),
        prepared_(prepared),
        cell_(cell),
        progress_(request.quiet, opening_text(prepared.model.device.settings->opening())) {}

  runtime::JobOrder order() {
    runtime::JobOrder order;
    order.title = request_.file;
    order.on_client_loss = ClientLoss::kContinue;  // this process ends it itself
    order.program = prepared_.program;
    if (request_.standing_at) {
      order.standing_at = {.q = prepared_.standing_at, .moved = request_.moved.has_value()};
      const JournalRecovery* recovery = cell_.station().recovery();
      if (recovery != nullptr) order.standing_at->last_said = recovery->last_said;
    }
    // Nobody slows it down under way: the quickest profiles will do.
    order.changeable = prepared_.streams() && prepared_.speed != 1;
    if (order.changeable) order.feed = prepared_.speed;
    order.look = [this](const program::Run& run, Instant now) { look(run, now); };
    order.ended = [this](const program::Run& run, Instant now) { report(run, now, false); };
    return order;
  }

  /// The outcome as it is in a moment, for a process that ends at once.
  void leave() { leaves_ = true; }
  bool reported() const { return reported_; }
  /// Once it is reported.
  Outcome take() { return std::move(outcome_); }

 private:
  void look(const program::Run& run, Instant now) {
    samples_.look(run, now);
    if (trouble_.empty()) trouble_ = cell_.station().trouble();
    if (leaves_) return report(run, now, true);
    progress_.show(run, prepared_.model, now);
  }

  void report(const program::Run& run, Instant now, bool left) {
    if (reported_) return;
    progress_.end();
    samples_.end(run, now);
    const runtime::Station& station = cell_.station();
    const RobotModel& model = prepared_.model;
    const runtime::StationView view = station.view();
    const ProgramReport report{model, run, view.health, view.bytes, left, view.truth, now};
    Outcome& outcome = outcome_;
    outcome.json = {{"robot", model.id}, {"port", station.port_name()}};
    outcome.json.update(program_json(report));
    outcome.text = program_text(report);
    tell_part(request_, prepared_, outcome);
    outcome.complaint = why_not_done(request_, report, station, trouble_);
    if (station.recovery() != nullptr) tell_record(station, run, outcome);
    if (run.phase() != program::Run::Phase::kDone) {
      outcome.exit = ExitCode::kCouldNot;
      outcome.json["error"] = {{"sentence", outcome.complaint}};
    }
    write_outputs(request_,
                  {[&] { return program_csv(model, samples_.samples()); },
                   [&] {
                     return program_svg(model, samples_.samples(),
                                        model.title + ": " + request_.file);
                   }},
                  outcome);
    reported_ = true;
  }

  const RunRequest& request_;
  const Prepared& prepared_;
  LocalCell& cell_;
  ProgressLine progress_;
  SampleRecorder samples_;
  std::string trouble_;  ///< of the port
  Outcome outcome_;
  std::atomic<bool> leaves_ = false;
  std::atomic<bool> reported_ = false;
};

/// Until the run is over. @return  false: left at once
bool drive(LocalCell& cell, RunWatch& watch, std::uint32_t job) {
  bool stopped = false;
  while (true) {
    cell.turn();
    const runtime::JobView view = cell.jobs().view();
    if (view.over) return true;
    const int interrupts = io::interrupts();
    if (interrupts > 1) watch.leave();
    if (interrupts > 1 && watch.reported()) return false;
    if (interrupts == 1 && !stopped) {
      cell.jobs().stop(job);
      stopped = true;
    }
    // This is its only client: what a late cycle holds goes on.
    if (view.paused) cell.jobs().resume(job);
  }
}

}  // namespace

Outcome run_program(const RunRequest& request) {
  const auto prepared = prepare(request);
  if (!prepared) return prepared.error();
  const RobotModel& model = prepared->model;
  io::catch_interrupts();
  const auto records = plan_records(request, model);
  if (!records) return records.error();
  auto started = LocalCell::start(
      model, request.robot,
      {.folders = records->folders, .byte_log = request.log.value_or(""), .assumes_start = true});
  if (!started) return started.error();
  std::unique_ptr<LocalCell> cell = std::move(*started);
  runtime::Station& station = cell->station();
  if (!request.quiet) {
    std::fputs(
        fmt::format(
            "  {}: {} steps, over {} ({}){}\n", model.title, prepared->program.steps.size(),
            station.port_name(), station.simulated() ? "simulated device" : "real port",
            prepared->homing_max > 0 ? "; homing takes " + at_most_text(prepared->homing_max) : "")
            .c_str(),
        stderr);
    if (const std::string note = station.journal_note(); !note.empty()) {
      std::fputs(("  note: " + note + "\n").c_str(), stderr);
    }
  }
  RunWatch watch(request, *prepared, *cell);
  runtime::JobOrder order = watch.order();
  order.record = records->place;
  const auto job = cell->jobs().start(std::move(order), LocalCell::kClient);
  if (!job) return could_not(error_text(job.error(), model));
  if (!drive(*cell, watch, *job)) {
    abandon(std::move(cell));
    Outcome outcome = watch.take();
    outcome.at_once = true;
    return outcome;
  }
  Outcome outcome = watch.take();
  end_records(request, station, outcome);
  return outcome;
}

void add_run(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<WithCell<RunRequest>>();
  RunRequest& request = own->request;
  CLI::App* verb = add_verb(app, call, "run", "a program on a robot, or on its simulated device",
                            "sinew run robots/bigrobotarm/sequence.txt --robot bigrobotarm");
  verb->add_option("FILE", request.file, "the program")->required();
  RobotOptions& robot = request.robot;
  verb->add_option("--robot", robot.name, "id or .toml file")->required();
  verb->add_option("--port", robot.port, kPorts + "; a simulated device where left out");
  add_variant(*verb, robot);
  verb->add_option("--standing-at", request.standing_at,
                   "where a machine without sensors stands: home, lowered (legs), shown (as its "
                   "journal shows it), or a value per joint (deg, mm)");
  verb->add_option("--moved", request.moved,
                   "with --standing-at: who moved it; what was known does not count then");
  add_settings(*verb, robot);
  verb->add_option("--from-line", request.from_line,
                   "goes on from this row, planned from where the arm stands then");
  verb->add_option("--speed", request.speed,
                   "of all rows, 1% to 100%; through the feed where the device streams");
  add_journal(*verb, robot);
  add_seed(*verb, robot);
  verb->add_option("--record", request.record,
                   "NAME.csv: the joints over time; NAME.mcap: everything, for viewers, which is "
                   "else in the state folder (the newest 20 runs); none: nowhere");
  verb->add_option("--plot", request.plot, "SVG file: the same, drawn");
  verb->add_option("--log", request.log, "every byte both ways, with its time");
  add_time_scale(*verb, robot);
  verb->add_flag("--single-step", own->cell.single_step,
                 "in a running cell: a pause behind each order, until sinew step");
  add_cell_options(*verb, *own);
  verb->callback([&call, own, verb] {
    call.verb = [&call, own, verb] {
      own->request.quiet = call.json;
      if (own->request.record == "none") {
        own->request.record.reset();
        own->request.recorded = false;
      }
      if (!on_cell(*own, call)) {
        if (!own->cell.single_step) return run_program(own->request);
        return bad_input("--single-step: in a running cell (--cell), where sinew step goes on");
      }
      if (own->request.record) {
        return bad_input("--record: a running cell records by itself: sinew serve --record-folder");
      }
      if (const auto fine = check_heard(*verb, {"FILE", "--robot", "--standing-at", "--moved",
                                                "--from-line", "--speed", "--single-step"});
          !fine) {
        return fine.error();
      }
      own->cell.from_line = own->request.from_line;
      own->cell.speed = own->request.speed;
      own->cell.robot = own->request.robot.name;
      own->cell.file = own->request.file;
      own->cell.standing_at = own->request.standing_at;
      own->cell.moved = own->request.moved;
      return cell_run(own->cell);
    };
  });
}

}  // namespace sinew::cli
