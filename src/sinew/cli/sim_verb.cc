#include "sinew/cli/sim_verb.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "sinew/cli/device_argument.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/table.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/standard_streams.h"
#include "sinew/runtime/device_server.h"

namespace sinew::cli {
namespace {

/// Where the simulated arm really stands, which its wire never tells.
Json truth_json(const BigRobotArmFirmware& firmware, const BigRobotArmDevice& device, Instant now) {
  Json steps = Json::array();
  Json joints = Json::array();
  const auto rotor = firmware.rotor_steps(now);
  for (std::size_t i = 0; i < rotor.size(); ++i) {
    steps.push_back(rotor[i]);
    joints.push_back(to_deg(rotor[i] / device.joints[i].steps_per_rad));
  }
  return {{"motor_steps", steps},
          {"joints_deg", joints},
          {"moving", firmware.moving()},
          {"bytes_lost", firmware.bytes_lost()}};
}

}  // namespace

Outcome simulate(const SimRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const auto device = big_robot_arm(file->model);
  if (!device) return device.error();
  if (const auto fine = check_time_scale(request.time_scale); !fine) return fine.error();

  if (request.log && request.robot.ends_with(".toml") &&
      io::same_file(*request.log, request.robot)) {
    return bad_input("--log: " + *request.log + " is the robot's file; choose another name");
  }
  auto port = io::Port::open_pseudo_terminal();
  if (!port) return could_not(port.error().sentence);
  std::optional<io::ScopedLink> link;
  if (request.link) {
    auto created = io::ScopedLink::create(port->path(), *request.link);
    if (!created) return could_not("--link: " + created.error().sentence);
    link.emplace(std::move(*created));
  }

  // Last, so that a simulation that cannot start empties nobody's log.
  runtime::ByteLog log;
  if (request.log) {
    auto created = runtime::ByteLog::create(*request.log);
    if (!created) return could_not("--log: " + created.error().sentence);
    log = std::move(*created);
  }
  io::catch_interrupts();
  const std::string first_line = request.json ? Json{{"port", port->path()}}.dump() : port->path();
  if (const auto told = io::write_stdout(first_line + "\n"); !told) {
    return could_not(told.error().sentence + "; nobody would know the port");
  }
  std::fprintf(stderr, "sinew: %s simulated behind this port, time x%s; Ctrl-C ends it\n",
               file->model.id.c_str(), number(request.time_scale, 4).c_str());

  const io::Clock clock(request.time_scale);
  BigRobotArmFirmware firmware(*device, clock.now());
  const auto served =
      runtime::serve_device(firmware, *port, clock, log, [] { return io::interrupts() > 0; });
  Outcome outcome = served ? Outcome{} : could_not(served.error().sentence);
  if (const auto failure = log.failure()) {
    outcome = could_not("--log: " + failure->sentence + "; the log is not whole");
  }
  outcome.json_line = true;
  const Json truth = truth_json(firmware, *device, clock.now());
  outcome.json["truth"] = truth;
  outcome.text = "motor steps at the end: " + truth["motor_steps"].dump() + "\n";
  return outcome;
}

}  // namespace sinew::cli
