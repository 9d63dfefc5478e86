#include "sinew/cli/run_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <thread>
#include <utility>
#include <vector>

#include "sinew/cli/device_argument.h"
#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/progress_line.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/run_report.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/program/sequence_file.h"
#include "sinew/runtime/device_server.h"
#include "sinew/runtime/sequence_session.h"

namespace sinew::cli {
namespace {

/// The simulated device in a thread of its own, behind a real pseudo-terminal.
class SimulatedDevice {
 public:
  static io::IoResult<std::unique_ptr<SimulatedDevice>> start(const BigRobotArmDevice& device,
                                                              const io::Clock& clock) {
    auto port = io::Port::open_pseudo_terminal();
    if (!port) return std::unexpected(port.error());
    return std::unique_ptr<SimulatedDevice>(new SimulatedDevice(device, clock, std::move(*port)));
  }
  ~SimulatedDevice() {
    stop_ = true;
    thread_.join();
  }
  SimulatedDevice(const SimulatedDevice&) = delete;
  SimulatedDevice& operator=(const SimulatedDevice&) = delete;

  const std::string& path() const { return port_.path(); }

 private:
  SimulatedDevice(const BigRobotArmDevice& device, const io::Clock& clock, io::Port port)
      : firmware_(device, clock.now()), port_(std::move(port)), thread_([this, clock] {
          // A port that fails shows at the other end, where somebody waits.
          static_cast<void>(runtime::serve_device(firmware_, port_, clock, log_,
                                                  [this] { return stop_.load(); }));
        }) {}

  BigRobotArmFirmware firmware_;
  io::Port port_;
  runtime::ByteLog log_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

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

/// Adds a failure that must not hide what the arm did.
void add_failure(Outcome& outcome, const std::string& sentence) {
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + sentence;
}

/// Files that a run leaves behind.
void write_files(const Job& job, const sequence::Run& run, Outcome& outcome) {
  const auto write = [&](const char* option, const std::optional<std::string>& path,
                         const std::string& text) {
    if (!path) return;
    if (const auto written = io::replace_file(*path, text); !written) {
      add_failure(outcome, fmt::format("{}: {}", option, written.error().sentence));
    } else {
      outcome.text += "  " + *path + "\n";
    }
  };
  if (job.request.record) write("--record", job.request.record, run_csv(job.model, run));
  if (job.request.plot) {
    write("--plot", job.request.plot,
          run_svg(job.model, run, job.model.title + ": " + job.request.file));
  }
}

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
  if (run.phase() != sequence::Run::Phase::kDone) outcome.exit = ExitCode::kCouldNot;
  if (run.looked_like_boot() && job.request.port) {
    outcome.text +=
        "  note: the device answered as just powered up; it counts from where the arm "
        "stood then\n";
  }
  write_files(job, run, outcome);
  if (const auto failure = log.failure()) {
    add_failure(outcome, "--log: " + failure->sentence + "; the log is not whole");
  }
  return outcome;
}

std::expected<BigRobotArmDevice, Outcome> device_for(const RunRequest& request,
                                                     const RobotModel& model) {
  auto device = big_robot_arm(model);
  if (!device || !request.wire) return device;
  if (*request.wire == "byte") {
    device->wire = BigRobotArmWire::kByte;
  } else if (*request.wire == "text") {
    device->wire = BigRobotArmWire::kText;
  } else {
    return std::unexpected(bad_input("--wire: '" + *request.wire + "' is neither byte nor text"));
  }
  return device;
}

/// Whoever mistypes a name must not lose the program, the robot's file, or send text to the arm.
std::expected<void, Outcome> check_outputs(const RunRequest& request) {
  std::vector<std::pair<std::string, std::string>> taken{{"the program", request.file}};
  if (request.robot.ends_with(".toml")) taken.emplace_back("the robot's file", request.robot);
  if (request.port) taken.emplace_back("the port", *request.port);
  const auto check = [&](const std::string& option,
                         const std::optional<std::string>& path) -> std::expected<void, Outcome> {
    if (!path) return {};
    if (const auto fine = io::check_place(*path); !fine) {
      return std::unexpected(bad_input(option + ": " + fine.error().sentence));
    }
    for (const auto& [what, other] : taken) {
      if (!io::same_file(*path, other)) continue;
      return std::unexpected(
          bad_input(fmt::format("{}: {} is {}; choose another name", option, *path, what)));
    }
    taken.emplace_back("the file of " + option, *path);
    return {};
  };
  if (auto fine = check("--log", request.log); !fine) return fine;
  if (auto fine = check("--record", request.record); !fine) return fine;
  return check("--plot", request.plot);
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
  const auto device = device_for(request, prepared.model);
  if (!device) return std::unexpected(device.error());
  prepared.device = *device;
  prepared.model.device.settings = *device;
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
  const auto prepared = prepare(request);
  if (!prepared) return prepared.error();
  const auto& [model, device, program, plan] = *prepared;
  io::catch_interrupts();
  const io::Clock clock(request.time_scale);
  std::unique_ptr<SimulatedDevice> simulated;
  std::string path = request.port.value_or("");
  if (!request.port) {
    auto started = SimulatedDevice::start(device, clock);
    if (!started) return could_not(started.error().sentence);
    simulated = std::move(*started);
    path = simulated->path();
  }
  auto port = io::Port::open_serial(path, model.device.baud);
  if (!port) return could_not(port.error().sentence);
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
  return drive({request, model, device, program}, *port, clock, log);
}

}  // namespace sinew::cli
