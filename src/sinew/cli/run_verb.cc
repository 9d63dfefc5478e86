#include "sinew/cli/run_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>
#include <vector>

#include "sinew/cli/cell_connection.h"
#include "sinew/cli/commission_verb.h"
#include "sinew/cli/device_argument.h"
#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/program_verb.h"
#include "sinew/cli/progress_line.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/run_journal.h"
#include "sinew/cli/run_outputs.h"
#include "sinew/cli/run_report.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/program/sequence_file.h"
#include "sinew/runtime/machine_thread.h"
#include "sinew/runtime/robot_link.h"
#include "sinew/runtime/robot_machine.h"
#include "sinew/runtime/robot_variant.h"
#include "sinew/runtime/sequence_session.h"

namespace sinew::cli {
namespace {

Outcome plan_refusal(const std::string& file, const sequence::PlanRefusal& refusal,
                     const RobotModel& model) {
  Outcome outcome = could_not(fmt::format("{}:{}: {}; nothing was moved", file, refusal.line,
                                          error_text(refusal.error, model)));
  outcome.json["refusal"] = error_json(refusal.error, model);
  outcome.json["refusal"]["line"] = refusal.line;
  return outcome;
}

/// Patience in a run of scaled time: real delays of this machine do not shrink.
Duration stretched(Duration duration, double scale) {
  return from_seconds(to_seconds(duration) * std::max(1.0, scale));
}

BigRobotArmTiming timing_for(double scale) {
  BigRobotArmTiming timing;
  timing.reply_timeout = stretched(timing.reply_timeout, scale);
  timing.move_margin = stretched(timing.move_margin, scale);
  timing.quiet_limit = stretched(timing.quiet_limit, scale);
  return timing;
}

struct Job {
  const RunRequest& request;
  const RobotModel& model;
  const BigRobotArmDevice& device;
  const sequence::Program& program;
};

/// Why a run did not come to its end, as a sentence; empty where it did.
std::string why_not_done(const Job& job, const sequence::Run& run, const runtime::SessionEnd& end,
                         const std::string& port) {
  if (end.left_at_once) return "left at once; the device finishes the motion under way, unseen";
  if (end.port_failure) {
    return end.port_failure->sentence +
           "; a motion that was under way is finished by the device, unseen";
  }
  if (run.phase() == sequence::Run::Phase::kStopped) {
    return "stopped: no further motion was asked for (the motion under way was finished; "
           "the device has no stop)";
  }
  if (!run.failure()) return {};
  const std::string reason = error_text(run.failure()->error, job.model);
  if (run.failure()->line > 0) {
    return fmt::format("{}:{}: {}", job.request.file, run.failure()->line, reason);
  }
  return fmt::format(
      "{}: {}; is it switched on, is this its port, and does it speak the {} wire (--wire)?", port,
      reason, job.device.wire == BigRobotArmWire::kByte ? "byte" : "text");
}

Outcome drive(const Job& job, io::Port& port, const io::Clock& clock, runtime::ByteLog& log) {
  BigRobotArmDriver driver(job.device, timing_for(clock.scale()));
  sequence::Run run(job.program, job.model, driver,
                    stretched(sequence::Run::kOpeningLimit, clock.scale()));
  runtime::SessionEnd end;
  {
    ProgressLine progress(job.request.quiet);
    const runtime::SessionHooks hooks{
        .progress = [&](const runtime::SessionView& view) { progress.show(view); },
        .interrupts = [] { return io::interrupts(); }};
    end = runtime::run_sequence(run, driver, port, clock, log, hooks);
  }
  Outcome outcome;
  outcome.json = {{"robot", job.model.id}, {"port", port.path()}};
  outcome.json.update(run_json(job.model, run, end));
  outcome.text = run_text(job.model, run, end);
  outcome.complaint = why_not_done(job, run, end, port.path());
  if (run.phase() != sequence::Run::Phase::kDone) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.json["error"] = {{"sentence", outcome.complaint}};
  }
  if (run.looked_like_boot() && job.request.port) {
    outcome.text +=
        "  note: the device answered as just powered up; it counts from where the arm "
        "stood then\n";
  }
  write_outputs(
      job.request,
      {[&] { return run_csv(job.model, run); },
       [&] { return run_svg(job.model, run, job.model.title + ": " + job.request.file); }},
      log, outcome);
  return outcome;
}

/// A sequence counts from where the arm was switched on, and may set its zero anywhere.
void tell_given_up(Outcome& outcome) {
  outcome.text +=
      "  note: a sequence leaves the position journal behind: the next program has to be told "
      "where the arm stands (--standing-at)\n";
  outcome.json["position_journal"] = "given up";
}

/// The settings file that a program would run with on this port, and a sequence does not; empty
/// where there is none.
std::string settings_left_out(const RunRequest& request, const RobotModel& robot) {
  const bool real = request.port && !runtime::may_be_simulated(*request.port);
  if (!real || request.settings) return {};
  const std::string path = usual_settings(robot);
  RobotModel changed = robot;
  if (path.empty()) return {};
  const auto used = use_settings_file(changed, path);
  return used ? used->file : std::string();
}

struct Prepared {
  RobotModel model;
  BigRobotArmDevice device;
  sequence::Program program;
  sequence::Plan plan;
};

/// Everything that can be wrong before a byte leaves.
std::expected<Prepared, Outcome> prepare(const RunRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return std::unexpected(file.error());
  Prepared prepared{.model = file->model, .device = {}, .program = {}, .plan = {}};
  if (const auto fine = check_has_device(file->model); !fine) return std::unexpected(fine.error());
  auto variant = runtime::variant_of(file->model, request.profile, request.wire);
  if (!variant) return std::unexpected(bad_input(variant.error()));
  prepared.model = std::move(*variant);
  const auto* device = std::get_if<BigRobotArmDevice>(&prepared.model.device.settings);
  if (device == nullptr) {
    return std::unexpected(bad_input(request.file +
                                     ": this robot runs programs of the form "
                                     "NAME.sinew; G0 .. sequences are the BigRobotArm's"));
  }
  prepared.device = *device;
  if (device->probe_wire) {
    return std::unexpected(
        bad_input("--wire: a sequence needs byte, text or text2026; programs "
                  "NAME.sinew can find out by themselves (probe)"));
  }
  if (request.standing_at) {
    return std::unexpected(
        bad_input("--standing-at: a sequence counts from where the arm stood "
                  "when it was switched on; a program NAME.sinew takes it"));
  }
  if (request.settings && *request.settings != "none") {
    return std::unexpected(
        bad_input("--settings: a sequence speaks the device's own steps, and what commissioning "
                  "found does not change them; programs NAME.sinew take it"));
  }
  if (request.from_line || request.speed) {
    return std::unexpected(
        bad_input("--from-line, --speed: programs NAME.sinew take them; a sequence counts from "
                  "where the arm stood when it was switched on, and sets its own speeds"));
  }
  if (records_mcap(request)) {
    return std::unexpected(
        bad_input("--record: a sequence is recorded as NAME.csv; programs NAME.sinew as "
                  "NAME.mcap too"));
  }
  if (const auto fine = check_seed(request.seed); !fine) return std::unexpected(fine.error());
  if (const auto fine = check_time_scale(request.time_scale); !fine) {
    return std::unexpected(fine.error());
  }
  if (request.port && request.time_scale != 1) {
    return std::unexpected(
        bad_input("--time-scale: a real port keeps real time; sinew sim has a scale of its own"));
  }
  if (const auto fine = check_outputs(request); !fine) return std::unexpected(fine.error());
  const auto text = io::read_file(request.file);
  if (!text) return std::unexpected(bad_input(text.error().sentence));
  auto program = sequence::parse(*text, request.file, *device);
  if (!program) return std::unexpected(complaints_outcome(program.error()));
  prepared.program = std::move(*program);
  // Checked whole before the first byte leaves; once more when the device has told where it is.
  auto plan = sequence::make_plan(prepared.program, prepared.model, sequence::boot_state(*device));
  if (!plan) return std::unexpected(plan_refusal(request.file, plan.error(), prepared.model));
  prepared.plan = std::move(*plan);
  if (prepared.plan.orders.empty()) {
    return std::unexpected(bad_input(request.file + ": has nothing to do for the arm; a first line "
                                                    "could be: G0 B100"));
  }
  return prepared;
}

}  // namespace

Outcome run_program(const RunRequest& request) {
  if (request.file.ends_with(".sinew")) return run_sinew_program(request);
  const auto prepared = prepare(request);
  if (!prepared) return prepared.error();
  const auto& [model, device, program, plan] = *prepared;
  io::catch_interrupts();
  const io::Clock clock(request.time_scale);
  std::unique_ptr<runtime::MachineThread> simulated;
  std::string path = request.port.value_or("");
  if (!request.port) {
    auto machine = runtime::make_machine(
        model, {.profile = request.profile, .seed = static_cast<std::uint64_t>(request.seed)},
        clock.now());
    if (!machine) return could_not(machine.error());
    auto started = runtime::MachineThread::start(std::move(machine->byte), clock,
                                                 {.baud = model.device.baud, .faults = {}});
    if (!started) return could_not(started.error().sentence);
    simulated = std::move(*started);
    path = simulated->path();
  }
  if (const auto why = runtime::wrong_port(model, path)) return could_not(*why);
  const std::string left_out = settings_left_out(request, model);
  if (!left_out.empty() && !request.quiet) {
    std::fputs(fmt::format("  note: what commissioning found counts for programs NAME.sinew, and "
                           "not for a sequence: {}\n",
                           left_out)
                   .c_str(),
               stderr);
  }
  auto port = io::Port::open_serial(path, model.device.baud);
  if (!port) {
    return could_not(port.error().sentence + (request.port ? held_by_cell(path) : std::string()));
  }
  // Only now: whoever is refused the port must not empty the log of the run that has it.
  runtime::ByteLog log;
  if (request.log) {
    auto created = runtime::ByteLog::create(*request.log);
    if (!created) return could_not("--log: " + created.error().sentence);
    log = std::move(*created);
  }
  if (!request.quiet) {
    std::fputs(fmt::format("  {}: {} orders, {:.1f} s of motion, over {} ({})\n", model.title,
                           plan.orders.size(), plan.duration, path,
                           simulated ? "simulated device" : "real port")
                   .c_str(),
               stderr);
  }
  const auto record = open_journal(request, model);
  if (!record) return record.error();
  if (*record != nullptr) {
    const auto given_up = (*record)->give_up(model, {clock.now(), io::wall_time_ns()});
    if (!given_up) return could_not(given_up.error().sentence);
  }
  Outcome outcome = drive({request, model, device, program}, *port, clock, log);
  if (*record != nullptr) tell_given_up(outcome);
  if (!left_out.empty()) outcome.json["settings_left_out"] = left_out;
  return outcome;
}

}  // namespace sinew::cli
