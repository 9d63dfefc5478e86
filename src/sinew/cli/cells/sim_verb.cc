#include "sinew/cli/cells/sim_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>

#include "sinew/cli/output/device_argument.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/truth_text.h"
#include "sinew/core/units.h"
#include "sinew/devices/encoder/encoder_machine.h"
#include "sinew/devices/encoder/encoder_settings.h"
#include "sinew/devices/kinds.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/local_socket.h"
#include "sinew/io/request_lines.h"
#include "sinew/io/standard_streams.h"
#include "sinew/runtime/journal/lasting_file.h"
#include "sinew/runtime/links/machine_server.h"
#include "sinew/runtime/links/robot_variant.h"
#include "sinew/runtime/links/simwire_bus.h"
#include "sinew/runtime/links/simwire_guests.h"
#include "sinew/sim/spi_faults.h"

namespace sinew::cli {
namespace {

constexpr Duration kAcceptSlice = std::chrono::milliseconds(50);
/// With --state a process that is killed loses so much motion.
constexpr Duration kStateSlice = std::chrono::milliseconds(2);

/// In the place of a robot: an encoder node by itself.
constexpr std::string_view kEncoder = "encoder";
constexpr double kShaftSpeed = 30;       // deg/s
constexpr double kShaftSpeedMax = 2880;  // deg/s: 8 turns/s, which the link can report

/// Everything that was asked for and found to make sense.
struct Job {
  const SimRequest& request;
  RobotModel model;
  sim::FaultPlan faults;
  RobotMachine machine;
  std::optional<runtime::LastingFile> state;
  std::optional<io::IoError> state_failure;

  /// Keeps what has changed; false where the simulation has to end, since its file is old now.
  bool keep_state() {
    if (!state || state_failure) return !state_failure;
    if (const auto kept = state->keep(machine.get()); !kept) state_failure = kept.error();
    return !state_failure;
  }
};

/// Answers whoever asks how the machine stands, by SIGUSR1 or a line on stdin.
class StatusReporter {
 public:
  StatusReporter(const Job& job, bool reads_stdin) : job_(job), reads_stdin_(reads_stdin) {}

  void look() {
    const int signals = io::status_requests();
    if (signals != answered_) tell();
    answered_ = signals;
    while (reads_stdin_ && lines_.next()) tell();
  }

 private:
  void tell() const {
    const sim::Truth truth = job_.machine.get().truth();
    const std::string line = job_.request.json
                                 ? Json{{"truth", truth_json(truth, job_.model)}}.dump()
                                 : "truth: " + truth_line(truth, job_.model);
    // stdout carries documents for programs; a person's line goes beside them.
    if (job_.request.json && reads_stdin_) {
      static_cast<void>(io::write_stdout(line + "\n"));
    } else {
      std::fputs((line + "\n").c_str(), stderr);
    }
  }

  const Job& job_;
  bool reads_stdin_;
  io::RequestLines lines_;
  int answered_ = 0;
};

std::expected<void, Outcome> check_spi_options(const SimRequest& request, bool spi) {
  const auto only_spi = [&](const char* option, bool given) -> std::expected<void, Outcome> {
    if (!given || spi) return {};
    return std::unexpected(bad_input(std::string(option) + ": " + request.robot +
                                     " hangs on a serial port, not on SPI"));
  };
  if (auto fine = only_spi("--simwire", request.simwire.has_value()); !fine) return fine;
  if (auto fine = only_spi("--slaves", request.slaves.has_value()); !fine) return fine;
  if (auto fine = only_spi("--nss", request.nss.has_value()); !fine) return fine;
  if (auto fine = only_spi("--ready-high", request.ready_high); !fine) return fine;
  if (spi && request.link) {
    return std::unexpected(
        bad_input("--link: boards on SPI have no port; use --simwire unix:PATH"));
  }
  if (spi && request.time_scale != 1) {
    return std::unexpected(
        bad_input("--time-scale: over simwire the time is the host's, which stamps every request"));
  }
  if (request.nss && *request.nss != "hard" && *request.nss != "soft") {
    return std::unexpected(bad_input("--nss: '" + *request.nss + "' is neither hard nor soft"));
  }
  if (request.simwire && *request.simwire != "stdio" && !request.simwire->starts_with("unix:")) {
    return std::unexpected(
        bad_input("--simwire: '" + *request.simwire + "' is neither unix:PATH nor stdio"));
  }
  return {};
}

/// The robot's file and the log are no place for the state, nor are they one place.
std::expected<void, Outcome> check_places(const SimRequest& request) {
  const bool robot_file = request.robot.ends_with(".toml");
  if (request.log && robot_file && io::same_file(*request.log, request.robot)) {
    return std::unexpected(
        bad_input("--log: " + *request.log + " is the robot's file; choose another name"));
  }
  if (!request.state) return {};
  if ((robot_file && io::same_file(*request.state, request.robot)) ||
      (request.log && io::same_file(*request.state, *request.log))) {
    return std::unexpected(
        bad_input("--state: " + *request.state + " has another use here; choose another name"));
  }
  return {};
}

/// The machine as it was left, with its power back, or a new one.
std::expected<void, Outcome> make_machine(Job& job) {
  const SimRequest& request = job.request;
  const auto seed =
      request.seed ? std::optional(static_cast<std::uint64_t>(*request.seed)) : std::nullopt;
  if (request.state) {
    auto state = runtime::LastingFile::open(*request.state, job.model.id, seed);
    if (!state) return std::unexpected(bad_input("--state: " + state.error()));
    job.state.emplace(std::move(*state));
  }
  const bool again = job.state && job.state->before();
  const auto axes = static_cast<std::int64_t>(job.model.joints.size());
  const Instant boot = again ? Instant{} - sim::kPowerOffTime : Instant{};
  if (request.robot == kEncoder) {
    job.machine.byte = std::make_unique<sim::EncoderMachine>(
        from_deg(request.speed.value_or(kShaftSpeed)), seed.value_or(1), boot);
    return {};
  }
  auto machine =
      sinew::make_machine(job.model,
                          {.profile = request.profile,
                           .seed = job.state ? job.state->seed() : seed.value_or(1),
                           .boards = static_cast<std::size_t>(request.slaves.value_or(axes)),
                           .soft_select = request.nss == "soft",
                           .ready_high = request.ready_high},
                          boot);
  if (!machine) return std::unexpected(could_not(machine.error()));
  job.machine = std::move(*machine);
  if (again && !sim::power_up_from(*job.state->before(), job.machine.get(), Instant{})) {
    return std::unexpected(bad_input("--state: " + *request.state + ": not the state of this " +
                                     job.model.id + "; choose another file"));
  }
  if (!job.keep_state())
    return std::unexpected(could_not("--state: " + job.state_failure->sentence));
  return {};
}

/// The robot's model, or an encoder node's shaft as one.
std::expected<RobotModel, Outcome> model_of(const SimRequest& request) {
  if (request.robot != kEncoder) {
    if (request.speed) return std::unexpected(bad_input("--speed: of sinew sim encoder only"));
    const auto file = find_robot(request.robot);
    if (!file) return std::unexpected(file.error());
    auto variant = runtime::variant_of(file->model, request.profile, request.wire);
    if (!variant) return std::unexpected(bad_input(variant.error()));
    return std::move(*variant);
  }
  if (request.profile || request.wire || request.state) {
    return std::unexpected(
        bad_input("--profile, --wire and --state: an encoder node has none of them"));
  }
  if (!(std::abs(request.speed.value_or(0)) <= kShaftSpeedMax)) {
    return std::unexpected(
        bad_input(fmt::format("--speed: -{0:.0f} to {0:.0f} deg/s", kShaftSpeedMax)));
  }
  return encoder_shaft();
}

std::expected<Job, Outcome> prepare(const SimRequest& request) {
  auto model = model_of(request);
  if (!model) return std::unexpected(model.error());
  Job job{request, std::move(*model), {}, {}, {}, {}};
  const bool spi = is_on_spi(job.model);
  if (const auto fine = check_spi_options(request, spi); !fine) {
    return std::unexpected(fine.error());
  }
  if (const auto fine = check_seed(request.seed.value_or(1)); !fine)
    return std::unexpected(fine.error());
  if (const auto fine = check_time_scale(request.time_scale); !fine) {
    return std::unexpected(fine.error());
  }
  const auto axes = static_cast<std::int64_t>(job.model.joints.size());
  if (request.slaves && (*request.slaves < 1 || *request.slaves > axes)) {
    return std::unexpected(bad_input(fmt::format(
        "--slaves: {} is outside 1..{}, the boards of this robot", *request.slaves, axes)));
  }
  if (request.fault) {
    auto faults = sim::parse_faults(*request.fault, job.model.joints.size());
    if (!faults) return std::unexpected(bad_input("--fault: " + faults.error()));
    job.faults = std::move(*faults);
    if (const auto fine = sim::check_faults(job.faults, job.model); !fine) {
      return std::unexpected(bad_input("--fault: " + fine.error()));
    }
  }
  if (const auto fine = check_places(request); !fine) return std::unexpected(fine.error());
  if (const auto made = make_machine(job); !made) return std::unexpected(made.error());
  return job;
}

std::expected<runtime::ByteLog, Outcome> open_log(const SimRequest& request) {
  if (!request.log) return runtime::ByteLog();
  auto created = runtime::ByteLog::create(*request.log);
  if (!created) return std::unexpected(could_not("--log: " + created.error().sentence));
  return std::move(*created);
}

Outcome finished(Job& job, const io::IoResult<void>& served, const runtime::ByteLog& log) {
  Outcome outcome = served ? Outcome{} : could_not(served.error().sentence);
  if (const auto failure = log.failure()) {
    outcome = could_not("--log: " + failure->sentence + "; the log is not whole");
  }
  if (job.state && !job.state_failure) {
    if (const auto kept = job.state->finish(job.machine.get()); !kept) {
      job.state_failure = kept.error();
    }
  }
  if (job.state_failure) outcome = could_not("--state: " + job.state_failure->sentence);
  outcome.json_line = true;
  const sim::Truth truth = job.machine.get().truth();
  outcome.json["truth"] = truth_json(truth, job.model);
  outcome.text = "at the end: " + truth_line(truth, job.model) + "\n";
  return outcome;
}

/// The first line on stdout: where a host finds the device.
std::expected<void, Outcome> announce(const Job& job, const std::string& place) {
  const std::string line = job.request.json ? Json{{"port", place}}.dump() : place;
  if (const auto told = io::write_stdout(line + "\n"); !told) {
    return std::unexpected(could_not(told.error().sentence + "; nobody would know the port"));
  }
  std::fputs(
      fmt::format("sinew: {} simulated behind this port, {}time x{}; Ctrl-C ends it, Enter "
                  "shows where it really stands\n",
                  job.model.id, job.request.profile ? "profile " + *job.request.profile + ", " : "",
                  number(job.request.time_scale, 4))
          .c_str(),
      stderr);
  return {};
}

Outcome serve_bytes(Job& job) {
  const SimRequest& request = job.request;
  auto port = io::Port::open_pseudo_terminal();
  if (!port) return could_not(port.error().sentence);
  std::optional<io::ScopedLink> link;
  if (request.link) {
    auto created = io::ScopedLink::create(port->path(), *request.link);
    if (!created) return could_not("--link: " + created.error().sentence);
    link.emplace(std::move(*created));
  }
  // Last, so that a simulation that cannot start empties nobody's log.
  auto log = open_log(request);
  if (!log) return log.error();
  io::catch_interrupts();
  if (const auto told = announce(job, port->path()); !told) return told.error();
  StatusReporter status(job, true);
  const io::Clock clock(request.time_scale);
  const auto served = runtime::serve_machine(
      *job.machine.byte, *port, clock, {.baud = job.model.device.baud, .faults = job.faults}, *log,
      {.stop = [&] { return !job.keep_state() || io::interrupts() > 0; },
       .look = [&](Instant) { status.look(); },
       .slice = job.state ? kStateSlice : kAcceptSlice});
  Outcome outcome =
      finished(job, served ? io::IoResult<void>{} : std::unexpected(served.error()), *log);
  if (served && request.fault) {
    const auto& [to_device, to_host] = *served;
    outcome.text +=
        fmt::format("faults: {} dropped, {} doubled, {} flipped, {} delayed, {} lost in cuts\n",
                    to_device.dropped + to_host.dropped, to_device.duplicated + to_host.duplicated,
                    to_device.flipped + to_host.flipped, to_device.delayed + to_host.delayed,
                    to_device.cut + to_host.cut);
  }
  return outcome;
}

std::string default_socket() {
  return fmt::format("{}/sinew-{}.sock", io::runtime_folder(), io::process_id());
}

std::string what_befell(const sim::SpiFaults& faults) {
  return fmt::format("faults: {} transfers lost, {} doubled, {} bits flipped\n", faults.dropped(),
                     faults.duplicated(), faults.flipped());
}

Outcome serve_boards(Job& job) {
  const SimRequest& request = job.request;
  auto faulty = sim::SpiFaults::create(*job.machine.spi, job.faults);
  if (!faulty) return bad_input("--fault: " + faulty.error());
  sim::SimwireServer server(**faulty, boards_of(job.model.device), "sinew-" + job.model.id);
  auto log = open_log(request);
  if (!log) return log.error();
  io::catch_interrupts();
  const bool stdio = request.simwire == "stdio";
  StatusReporter status(job, !stdio);
  const auto stop = [&] {
    status.look();
    return !job.keep_state() || io::interrupts() > 0;
  };
  if (stdio) {
    auto port = io::standard_port();
    if (!port) return could_not(port.error().sentence);
    Outcome outcome = finished(job, runtime::serve_simwire(server, *port, *log, stop), *log);
    if (request.fault) outcome.text += what_befell(**faulty);
    // stdout belongs to the protocol.
    std::fputs(outcome.text.c_str(), stderr);
    outcome.silent = true;
    return outcome;
  }
  const std::string path = request.simwire ? request.simwire->substr(5) : default_socket();
  auto listener = io::LocalListener::create(path);
  if (!listener) return could_not(listener.error().sentence);
  if (const auto told = announce(job, "simwire:unix:" + path); !told) return told.error();
  const io::Clock clock;
  runtime::SimwireGuests guests(*listener, clock);
  const auto stop_or_turn_away = [&] {
    if (guests.look() > 0) {
      std::fputs("sinew: turned a second host away: these boards talk to one at a time\n", stderr);
    }
    return stop();
  };
  while (!stop()) {
    auto client = listener->accept(kAcceptSlice);
    if (!client) return could_not(client.error().sentence);
    if (!*client) continue;
    server.restart();
    // A host that goes away is no failure: the next one may come.
    static_cast<void>(runtime::serve_simwire(server, **client, *log, stop_or_turn_away));
  }
  Outcome outcome = finished(job, {}, *log);
  if (request.fault) outcome.text += what_befell(**faulty);
  return outcome;
}

}  // namespace

Outcome simulate(const SimRequest& request) {
  auto job = prepare(request);
  if (!job) return job.error();
  return job->machine.byte ? serve_bytes(*job) : serve_boards(*job);
}

void add_sim(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<SimRequest>();
  SimRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "sim", "a robot's device, simulated behind a real port",
                            "sinew sim learm --profile bus --link /tmp/arm");
  verb->add_option("ROBOT", request.robot, "id or .toml file; encoder: an encoder node by itself")
      ->required();
  verb->add_option("--speed", request.speed, "encoder: speed of its shaft, deg/s (default 30)");
  verb->add_option("--link", request.link, "a name for the port, kept while the simulation runs");
  verb->add_option("--profile", request.profile,
                   "which variant of the device; an unknown name lists them");
  verb->add_option("--wire", request.wire,
                   "which of the robot's wires; as in its file where left out");
  verb->add_option("--simwire", request.simwire,
                   "boards on SPI: unix:PATH or stdio; a new socket where left out");
  verb->add_option("--slaves", request.slaves, "boards on SPI: how many are there");
  verb->add_option("--nss", request.nss,
                   "boards on SPI: hard, or soft for boards that always listen");
  verb->add_flag("--ready-high", request.ready_high,
                 "boards on SPI: READY never falls, as on measured boards");
  verb->add_option("--fault", request.fault,
                   "bad cables and blows, as in drop=0.001,flip=1e-4,cut@3s:500ms,supply=9V@5s");
  verb->add_option("--state", request.state,
                   "file that keeps where the joints are; each start is a power-up from there");
  verb->add_option("--seed", request.seed, "of all chance in the simulation");
  verb->add_option("--time-scale", request.time_scale, "the device's time against real time");
  verb->add_option("--log", request.log, "every byte both ways, with its time");
  verb->callback([&call, own] {
    call.verb = [&call, own] {
      own->json = call.json;
      return simulate(*own);
    };
  });
}

}  // namespace sinew::cli
