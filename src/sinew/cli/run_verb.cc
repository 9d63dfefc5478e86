#include "sinew/cli/run_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <thread>

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

/// Timing of the driver for a run of scaled time: real delays of this machine do not shrink.
BigRobotArmTiming timing_for(double scale) {
  BigRobotArmTiming timing;
  const auto stretched = [&](Duration duration) {
    return from_seconds(to_seconds(duration) * std::max(1.0, scale));
  };
  timing.reply_timeout = stretched(timing.reply_timeout);
  timing.move_margin = stretched(timing.move_margin);
  timing.quiet_limit = stretched(timing.quiet_limit);
  return timing;
}

struct Job {
  const RunRequest& request;
  const RobotModel& model;
  const BigRobotArmDevice& device;
  const sequence::Program& program;
};

/// Files that a run leaves behind; their failure must not hide what the arm did.
void write_files(const Job& job, const sequence::Run& run, Outcome& outcome) {
  const auto write = [&](const std::optional<std::string>& path, const std::string& text) {
    if (!path) return;
    if (const auto written = io::replace_file(*path, text); !written) {
      outcome.exit = ExitCode::kCouldNot;
      outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + written.error().sentence;
    } else {
      outcome.text += "  " + *path + "\n";
    }
  };
  if (job.request.record) write(job.request.record, run_csv(job.model, run));
  if (job.request.plot) {
    write(job.request.plot, run_svg(job.model, run, job.model.title + ": " + job.request.file));
  }
}

Outcome drive(const Job& job, io::Port& port, const io::Clock& clock, runtime::ByteLog& log) {
  BigRobotArmDriver driver(job.device, timing_for(clock.scale()));
  sequence::Run run(job.program, job.model, driver);
  io::IoResult<runtime::SessionEnd> end;
  {
    ProgressLine progress(job.request.quiet);
    runtime::SessionHooks hooks{
        .progress = [&](const runtime::SessionView& view) { progress.show(view); },
        .interrupts = [] { return io::interrupts(); }};
    end = runtime::run_sequence(run, driver, port, clock, log, hooks);
  }
  if (!end) {
    return could_not(end.error().sentence +
                     "; a motion that was under way is finished by the device, unseen");
  }
  Outcome outcome;
  outcome.json = {{"robot", job.model.id}, {"port", port.path()}};
  outcome.json.update(run_json(job.model, run, *end));
  outcome.text = run_text(job.model, run, *end);
  using Phase = sequence::Run::Phase;
  if (end->left_at_once) {
    outcome.complaint = "left at once; the device finishes the motion under way, unseen";
  } else if (run.phase() == Phase::kStopped) {
    outcome.complaint =
        "stopped: no further orders were sent (the motion under way was finished; "
        "the device has no stop)";
  } else if (run.failure() && run.failure()->line > 0) {
    outcome.complaint = fmt::format("{}:{}: {}", job.request.file, run.failure()->line,
                                    error_text(run.failure()->error, job.model));
  } else if (run.failure()) {
    outcome.complaint = fmt::format(
        "{}: {}; is it switched on, is this its port, and does it speak the {} wire (--wire)?",
        port.path(), error_text(run.failure()->error, job.model),
        job.device.wire == BigRobotArmWire::kByte ? "byte" : "text");
  }
  if (run.phase() != Phase::kDone) outcome.exit = ExitCode::kCouldNot;
  if (run.looked_like_boot() && job.request.port) {
    outcome.text +=
        "  note: the device answered as just powered up; it counts from where the arm "
        "stood then\n";
  }
  write_files(job, run, outcome);
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

}  // namespace

Outcome run_program(const RunRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  RobotModel model = file->model;
  const auto device = device_for(request, model);
  if (!device) return device.error();
  model.device.settings = *device;
  if (const auto fine = check_time_scale(request.time_scale); !fine) return fine.error();
  if (request.port && request.time_scale != 1) {
    return bad_input("--time-scale: a real port keeps real time; sinew sim has a scale of its own");
  }
  const auto text = io::read_file(request.file);
  if (!text) return bad_input(text.error().sentence);
  const auto program = sequence::parse(*text, request.file, *device);
  if (!program) return complaints_outcome(program.error());
  // Checked whole before the first byte leaves; once more when the device has told where it is.
  const auto plan = sequence::make_plan(*program, model, sequence::boot_state(*device));
  if (!plan) return plan_refusal(request.file, plan.error(), model);

  runtime::ByteLog log;
  if (request.log) {
    auto created = runtime::ByteLog::create(*request.log);
    if (!created) return could_not("--log: " + created.error().sentence);
    log = std::move(*created);
  }
  io::catch_interrupts();
  const io::Clock clock(request.time_scale);
  std::unique_ptr<SimulatedDevice> simulated;
  std::string path = request.port.value_or("");
  if (!request.port) {
    auto started = SimulatedDevice::start(*device, clock);
    if (!started) return could_not(started.error().sentence);
    simulated = std::move(*started);
    path = simulated->path();
  }
  auto port = io::Port::open_serial(path, model.device.baud);
  if (!port) return could_not(port.error().sentence);
  if (!request.quiet) {
    std::fputs(fmt::format("  {}: {} orders, {:.1f} s of motion, over {} ({})\n", model.title,
                           plan->orders.size(), plan->duration, path,
                           simulated ? "simulated device" : "real port")
                   .c_str(),
               stderr);
  }
  return drive({request, model, *device, *program}, *port, clock, log);
}

}  // namespace sinew::cli
