#include "sinew/cli/program_verb.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "sinew/cli/cell_connection.h"
#include "sinew/cli/commission_verb.h"
#include "sinew/cli/device_argument.h"
#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/plan_report.h"
#include "sinew/cli/program_folder.h"
#include "sinew/cli/program_report.h"
#include "sinew/cli/progress_line.h"
#include "sinew/cli/quantity.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/run_journal.h"
#include "sinew/cli/run_outputs.h"
#include "sinew/cli/run_record.h"
#include "sinew/cli/table.h"
#include "sinew/control/machine_identity.h"
#include "sinew/io/interrupt.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/program_part.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/position_record.h"
#include "sinew/runtime/robot_link.h"
#include "sinew/runtime/robot_variant.h"
#include "sinew/runtime/run_recorder.h"

namespace sinew::cli {
namespace {

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
    const bool known = !request.port && runtime::begins_at_home(model);
    return known ? std::optional(q) : std::nullopt;
  }
  if (*request.standing_at == "home") return q;
  const bool legs = model.joints[0].kind == JointKind::kPrismatic;
  const auto values =
      parse_quantities("--standing-at", *request.standing_at,
                       std::vector(model.joints.size(), legs ? Measure::kLength : Measure::kAngle),
                       joint_names(model));
  if (!values) return std::unexpected(bad_input(values.error()));
  q.clear();
  for (std::size_t i = 0; i < values->size(); ++i) {
    if (!within_limits(model.joints[i], (*values)[i])) {
      const double limit =
          (*values)[i] < model.joints[i].lower ? model.joints[i].lower : model.joints[i].upper;
      const Error error{legs ? ErrorCode::kLegLength : ErrorCode::kJointLimit,
                        static_cast<std::int8_t>(i), (*values)[i], limit};
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
  const auto& [settings, note] = prepared.settings;
  if (!settings.empty()) {
    outcome.json["settings"] = settings;
    outcome.text += "  note: with what commissioning found, " + settings + "\n";
  }
  if (!note.empty()) {
    outcome.json["settings_note"] = note;
    outcome.text += "  note: " + note + "\n";
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
  const auto file = find_robot(request.robot);
  if (!file) return std::unexpected(file.error());
  if (const auto fine = check_has_device(file->model); !fine) return std::unexpected(fine.error());
  auto variant = runtime::variant_of(file->model, request.profile, request.wire);
  if (!variant) return std::unexpected(bad_input(variant.error()));
  const bool real = request.port && !runtime::may_be_simulated(*request.port);
  const auto settings = use_commissioning(*variant, request.settings, real);
  if (!settings) return std::unexpected(settings.error());
  Prepared prepared{std::move(*variant), {}, {}, 0, 1, *settings};
  const RobotModel& model = prepared.model;
  if (const auto fine = check_seed(request.seed); !fine) return std::unexpected(fine.error());
  if (const auto fine = check_time_scale(request.time_scale); !fine) {
    return std::unexpected(fine.error());
  }
  if (request.port && request.time_scale != 1 && !runtime::may_be_simulated(*request.port)) {
    return std::unexpected(bad_input("--time-scale: a real port keeps real time"));
  }
  if (const auto fine = check_outputs(request); !fine) return std::unexpected(fine.error());
  auto parsed = read_program(request.file, model);
  if (!parsed) return std::unexpected(parsed.error());
  prepared.program = std::move(*parsed);
  if (prepared.program.steps.empty()) {
    return std::unexpected(bad_input(request.file + ": has no step; a first line could be: joint " +
                                     model.joints[0].name + "=10deg"));
  }
  if (const auto fine = take_part(request, prepared); !fine) return std::unexpected(fine.error());
  const auto standing = standing_at(request, model);
  if (!standing) return std::unexpected(standing.error());
  prepared.standing_at = *standing;
  // Checked whole before the first byte leaves; once more when the machine has told where it is.
  const auto plan =
      program::make_plan(prepared.program, model, prepared.standing_at.value_or(home_joints(model)),
                         runtime::homing_of(model));
  // A run that goes on in the middle begins where only the machine knows.
  const bool begins_elsewhere = request.from_line && !prepared.standing_at;
  if (!plan && !begins_elsewhere) {
    return std::unexpected(plan_refusal(
        model, file_of(prepared.program, plan.error().file, request.file), plan.error()));
  }
  if (plan) prepared.homing_max = plan->homing_max;
  return prepared;
}

/// Why a run did not come to its end, as a sentence; empty where it did.
/// @param suspicion  of boards that are none, or others than was said
std::string why_not_done(const RunRequest& request, const ProgramReport& report,
                         const std::string& port, const std::string& suspicion) {
  const auto& [model, run, driver, end, truth, now] = report;
  if (end.left_at_once) return "left at once; what was under way goes on, unseen";
  const std::string goes_on = goes_on_text(report);
  if (end.wire_failure) return end.wire_failure->sentence + goes_on;
  if (run.phase() == program::Run::Phase::kStopped) return "stopped" + goes_on;
  if (!run.failure()) return {};
  std::string reason = error_text(run.failure()->error, model);
  if (!suspicion.empty()) reason += "; " + suspicion;
  if (run.failure()->line > 0) {
    const std::string file = file_of(run.program(), run.failure()->file, request.file);
    return fmt::format("{}:{}: {}{}", file, run.failure()->line, reason, goes_on);
  }
  return fmt::format("{}: {}{}", port, reason,
                     silence_hint(model, run.failure()->error, driver.health()));
}

/// What the journal knew when the run began, and what that means where it was not enough.
void tell_record(const runtime::PositionRecord& record, const ProgramReport& report,
                 Outcome& outcome) {
  const JournalRecovery& recovery = record.recovery();
  const std::string found(sentence(recovery.finding));
  outcome.json["position_journal"] = {{"found", found},
                                      {"way_out", std::string(sentence(recovery.way_out))},
                                      {"damaged_slots", recovery.damaged_slots}};
  const auto& failure = report.run.failure();
  if (failure && failure->error.code == ErrorCode::kPositionUnknown) {
    outcome.complaint += fmt::format("; {}: {}", found, sentence(recovery.way_out));
    if (recovery.way_out != WayOut::kHome) outcome.complaint += " (--standing-at)";
  }
}

/// What is waited for while nobody has answered yet.
std::string opening_text(const runtime::Opening& opening) {
  return fmt::format("the device{} (at most {:.0f} s)", opening.waits_for,
                     to_seconds(opening.limit));
}

/// What a run goes over, and what it leaves behind.
struct Equipment {
  runtime::RobotLink& link;
  runtime::PositionRecord* record;  ///< null: none
  runtime::RunRecorder* recorder;   ///< null: none
  const io::Clock& clock;
  const runtime::ByteLog& log;
};

void set_up(program::Run& run, const RunRequest& request, const Prepared& prepared,
            const runtime::RobotLink& link) {
  run.expect_homing(runtime::homing_of(prepared.model));
  if (prepared.speed != 1 && prepared.streams()) {
    run.make_changeable();
    run.feed(prepared.speed);
  }
  run.measure_by([&link] { return link.driver().health(); });
  // Who says where it stands has looked.
  if (prepared.standing_at) run.declare(*prepared.standing_at, request.standing_at.has_value());
}

Outcome drive(const RunRequest& request, const Prepared& prepared, const Equipment& equipment) {
  const auto& [link, record, recorder, clock, log] = equipment;
  const RobotModel& model = prepared.model;
  const runtime::Opening opening = runtime::opening_of(model);
  runtime::ControlLoop loop = recorded_loop(model, link.driver(), clock, record);
  if (recorder != nullptr) {
    loop.look = [to = recorder](const control::Outputs& outputs, Instant at) {
      for (const control::ControlEvent& event : outputs.events) to->offer(event, at);
    };
  }
  program::Run run(prepared.program, loop.machine());
  set_up(run, request, prepared, link);
  SampleRecorder samples;
  std::string suspicion;
  runtime::ProgramEnd end;
  {
    ProgressLine progress(request.quiet, opening_text(opening));
    end = runtime::run_program(
        run, loop, link.line(), clock,
        {.progress =
             [&](const program::Run& view, Instant now) {
               samples.look(view, now);
               if (equipment.recorder != nullptr && equipment.recorder->due(now)) {
                 equipment.recorder->offer(runtime::sample_of(
                     loop.controller(), equipment.link.line().count(), true, now));
               }
               // Boards that were stopped for a failure tell less.
               auto more = runtime::suspicion(equipment.link.driver());
               if (more.size() >= suspicion.size()) suspicion = more;
               progress.show(view, model, now);
             },
         .interrupts = [] { return io::interrupts(); }});
  }
  const Instant now = clock.now();
  const ProgramReport report{model, run, link.driver(), end, link.truth(), now};
  Outcome outcome;
  outcome.json = {{"robot", model.id}, {"port", link.name()}};
  outcome.json.update(program_json(report));
  outcome.text = program_text(report);
  tell_part(request, prepared, outcome);
  outcome.complaint = why_not_done(request, report, link.name(), suspicion);
  if (record != nullptr) tell_record(*record, report, outcome);
  if (run.phase() != program::Run::Phase::kDone) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.json["error"] = {{"sentence", outcome.complaint}};
  }
  write_outputs(
      request,
      {[&] { return program_csv(model, samples.samples()); },
       [&] { return program_svg(model, samples.samples(), model.title + ": " + request.file); }},
      log, outcome);
  if (recorder != nullptr) {
    recorder->offer(runtime::sample_of(loop.controller(), end.bytes, !end.wire_failure, now));
    end_record(request, *recorder, outcome);
  }
  return outcome;
}

}  // namespace

Outcome run_sinew_program(const RunRequest& request) {
  const auto prepared = prepare(request);
  if (!prepared) return prepared.error();
  const RobotModel& model = prepared->model;
  io::catch_interrupts();
  const io::Clock clock = runtime::clock_for(request.port, request.time_scale);
  runtime::ByteLog log;
  auto link = request.port
                  ? runtime::RobotLink::open(model, *request.port, clock, log)
                  : runtime::RobotLink::simulate(model,
                                                 {.profile = request.profile,
                                                  .seed = static_cast<std::uint64_t>(request.seed)},
                                                 clock, log);
  if (!link) {
    const std::string holder = request.port ? held_by_cell(*request.port) : std::string();
    return could_not(link.error().sentence + holder);
  }
  // Only now: whoever is refused the port must not empty the log of the run that has it.
  if (request.log) {
    auto created = runtime::ByteLog::create(*request.log);
    if (!created) return could_not("--log: " + created.error().sentence);
    log = std::move(*created);
  }
  if (!request.quiet) {
    std::fputs(
        fmt::format(
            "  {}: {} steps, over {} ({}){}\n", model.title, prepared->program.steps.size(),
            link->name(), link->simulated() ? "simulated device" : "real port",
            prepared->homing_max > 0 ? "; homing takes " + at_most_text(prepared->homing_max) : "")
            .c_str(),
        stderr);
  }
  const auto record = open_journal(request, model);
  if (!record) return record.error();
  const auto recorder = begin_record(request, model, *record != nullptr, clock);
  if (!recorder) return recorder.error();
  return drive(request, *prepared, {*link, record->get(), recorder->get(), clock, log});
}

}  // namespace sinew::cli
