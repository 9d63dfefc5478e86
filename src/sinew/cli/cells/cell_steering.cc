// The verbs by which a person takes a machine of a running cell in hand: jog, recover, lease.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "sinew/cli/cells/cell_connection.h"
#include "sinew/cli/cells/cell_verbs.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/quantity.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/clock.h"
#include "sinew/io/interrupt.h"
#include "sinew/planning/jog/jog.h"

namespace sinew::cli {
namespace {

constexpr Duration kJogInterval = std::chrono::milliseconds(40);
constexpr double kJogTime = 1;       // s
constexpr double kJogTimeMax = 600;  // s
constexpr Duration kRestWait = std::chrono::seconds(10);

/// "20mm/s,0,5deg/s" in m/s and rad/s; each number says what it is.
std::expected<Json, std::string> velocity_of(const std::string& text) {
  Json numbers = Json::array();
  std::size_t at = 0;
  while (at <= text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    std::string word = text.substr(at, comma - at);
    at = comma + 1;
    if (word.ends_with("/s")) word.resize(word.size() - 2);
    if (word == "0") {
      numbers.push_back(0);
      continue;
    }
    auto value = parse_quantity(word, Measure::kLength, UnitRule::kRequired);
    if (!value) value = parse_quantity(word, Measure::kAngle, UnitRule::kRequired);
    if (!value) {
      return std::unexpected("--velocity: '" + printable(word) +
                             "' is no speed; write 20mm/s or 5deg/s, or 0");
    }
    numbers.push_back(*value);
  }
  return numbers;
}

std::expected<double, std::string> time_of(const std::optional<std::string>& text) {
  if (!text) return kJogTime;
  const auto time = parse_quantity(*text, Measure::kTime, UnitRule::kOptional);
  if (!time) return std::unexpected("--time: " + time.error());
  if (!(*time > 0 && *time <= kJogTimeMax)) {
    return std::unexpected(fmt::format("--time: has to be above 0 and at most {} s", kJogTimeMax));
  }
  return *time;
}

std::expected<Json, Outcome> take_lease(CellConnection& cell, const CellRequest& request) {
  return cell.call("lease.take", {{"robot", request.robot}, {"take_over", request.take_over}});
}

/// A machine that was off is found.
std::expected<void, Outcome> make_ready(CellConnection& cell, const std::string& robot) {
  const auto status = cell.call("robot.status", {{"robot", robot}});
  if (!status) return std::unexpected(status.error());
  if ((*status)["state"] != "off") return {};
  const auto enabled = cell.call("robot.enable", {{"robot", robot}});
  if (!enabled) return std::unexpected(enabled.error());
  return {};
}

/// The status behind a motion, once it has come to rest.
std::expected<Json, Outcome> at_rest(CellConnection& cell, const std::string& robot) {
  const io::Clock clock;
  const Instant end = clock.now() + kRestWait;
  while (true) {
    auto status = cell.call("robot.status", {{"robot", robot}});
    if (!status) return status;
    const std::string state = (*status)["state"];
    const bool moves = state == "moving" || state == "recovering" || state == "stopping";
    if (!moves || clock.now() > end) return status;
    clock.pause(kJogInterval);
  }
}

std::string place_text(const Json& status) {
  std::string text;
  for (const Json& joint : status["joints"]) {
    text += fmt::format("  {} {}", joint["name"].get<std::string>(), place_of(joint, "lost"));
  }
  return text;
}

Outcome status_outcome(const Json& status) {
  Outcome outcome;
  outcome.json = status;
  outcome.text = fmt::format("  {}, position {}:{}\n", status["state"].get<std::string>(),
                             status["position"].get<std::string>(), place_text(status));
  return outcome;
}

/// Whether the joint of that name, or of a number as in J2, is measured in metres.
bool is_length(const std::string& name, const Json& joints) {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const bool meant = joints[i]["name"] == name || name == fmt::format("J{}", i + 1);
    if (meant) return joints[i].contains("home_m");
  }
  return joints[0].contains("home_m");
}

/// Where the joint was when the probe closed; no success where it did not.
void add_touch(CellConnection& cell, const CellRequest& request, Outcome& outcome) {
  const auto device = cell.call("device.status", {{"robot", request.robot}});
  if (!device) {
    outcome = device.error();
    return;
  }
  if (!device->contains("touched")) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint = "the probe input did not close within " + request.way;
    return;
  }
  const Json& touched = (*device)["touched"];
  const std::string joint = touched["joint"];
  outcome.json["touched"] = touched;
  const bool slides = touched.contains("position_m");
  if (!slides && !touched.contains("position_rad")) {
    outcome.text += "  the probe closed; where " + joint + " is is not known\n";
    return;
  }
  const double at = touched[slides ? "position_m" : "position_rad"];
  outcome.text += fmt::format("  the probe closed at {} {:.3f} {}\n", joint,
                              slides ? 1e3 * at : to_deg(at), slides ? "mm" : "deg");
}

}  // namespace

Outcome cell_jog(const CellRequest& request) {
  const auto velocity = velocity_of(request.velocity);
  if (!velocity) return bad_input(velocity.error());
  const auto time = time_of(request.time);
  if (!time) return bad_input(time.error());
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  io::catch_interrupts();
  if (const auto taken = take_lease(*cell, request); !taken) return taken.error();
  if (const auto ready = make_ready(*cell, request.robot); !ready) return ready.error();
  const auto description = cell->call("cell.describe");
  if (!description) return description.error();
  // --time is the robot's; a simulated cell may run faster than this program.
  const double scale = (*description)["time_scale"];
  const io::Clock clock;
  const Instant end = clock.now() + from_seconds(*time / scale);
  Json params{{"robot", request.robot}, {"frame", request.frame}, {"velocity", *velocity}};
  // Letting go is enough: a command that nobody renews ends by itself, the last one at its end.
  for (Duration left = end - clock.now(); left > Duration{0} && io::interrupts() == 0;
       left = end - clock.now()) {
    params["expiry_s"] = to_seconds(std::min(left, planning::kJogExpiry));
    if (const auto jogs = cell->call("robot.jog", params); !jogs) return jogs.error();
    clock.pause(std::min(left, kJogInterval));
  }
  if (io::interrupts() > 0) {
    const auto stopped = cell->call("robot.stop", {{"robot", request.robot}});
    if (!stopped) return stopped.error();
  }
  const auto status = at_rest(*cell, request.robot);
  return status ? status_outcome(*status) : status.error();
}

Outcome cell_nudge(const CellRequest& request) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  const auto description = robot_of_cell(*cell, request.robot);
  if (!description) return description.error();
  const bool slides = is_length(request.joint, (*description)["joints"]);
  const auto way =
      parse_quantity(request.way, slides ? Measure::kLength : Measure::kAngle, UnitRule::kRequired);
  if (!way) return bad_input("WAY: " + way.error());
  io::catch_interrupts();
  const io::Clock clock;
  if (const auto taken = take_lease(*cell, request); !taken) return taken.error();
  if (const auto ready = make_ready(*cell, request.robot); !ready) return ready.error();
  const Json params{{"robot", request.robot},
                    {"joint", request.joint},
                    {"way", *way},
                    {"until_probe", request.until_probe}};
  if (const auto begun = cell->call("robot.nudge", params); !begun) return begun.error();
  bool stopped = false;
  while (true) {
    const auto status = cell->call("robot.status", {{"robot", request.robot}});
    if (!status) return status.error();
    const std::string state = (*status)["state"];
    if (state != "recovering" && state != "stopping") {
      Outcome outcome = status_outcome(*status);
      if (status->contains("fault")) {
        outcome.exit = ExitCode::kCouldNot;
        outcome.complaint = (*status)["fault"]["error"]["sentence"];
      } else if (stopped) {
        outcome.exit = ExitCode::kCouldNot;
        outcome.complaint = "stopped on the way";
      } else if (request.until_probe) {
        add_touch(*cell, request, outcome);
      }
      return outcome;
    }
    if (io::interrupts() > 0 && !std::exchange(stopped, true)) {
      const auto told = cell->call("robot.stop", {{"robot", request.robot}});
      if (!told) return told.error();
    }
    clock.pause(kJogInterval);
  }
}

Outcome cell_free(const CellRequest& request) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  if (const auto known = robot_of_cell(*cell, request.robot); !known) return known.error();
  if (const auto taken = take_lease(*cell, request); !taken) return taken.error();
  if (const auto ready = make_ready(*cell, request.robot); !ready) return ready.error();
  const Json params{{"robot", request.robot}, {"on", !request.ends}};
  if (const auto done = cell->call("robot.free_drive", params); !done) return done.error();
  const auto status = cell->call("robot.status", {{"robot", request.robot}});
  if (!status) return status.error();
  Outcome outcome = status_outcome(*status);
  const std::string& robot = request.robot;
  outcome.text += request.ends
                      ? "  " + robot + " holds each joint where it is\n"
                      : "  " + robot +
                            " is in free drive: guide it by hand; it falls where no hand holds it. "
                            "sinew teach " +
                            robot + " POINT saves where it is, sinew free " + robot +
                            " --end holds it there\n";
  return outcome;
}

std::expected<Json, Outcome> make_known(CellConnection& cell, const CellRequest& request) {
  const Json robot{{"robot", request.robot}};
  Json declaration = robot;
  if (request.standing_at == "shown") {
    declaration["shown"] = true;
  } else if (request.standing_at) {
    const auto positions = positions_of(cell, request.robot, "--standing-at", *request.standing_at);
    if (!positions) return std::unexpected(positions.error());
    declaration["positions"] = *positions;
  }
  if (request.moved) {
    if (!request.standing_at) {
      return std::unexpected(bad_input("--moved: goes with --standing-at"));
    }
    declaration["moved"] = *request.moved;
  }
  if (request.zero_counters) declaration["zero_counters"] = true;
  const auto before = cell.call("robot.status", robot);
  if (!before) return before;
  if (const auto taken = take_lease(cell, request); !taken) return taken;
  if ((*before)["state"] == "fault") {
    if (const auto done = cell.call("robot.acknowledge", robot); !done) return done;
  }
  if (const auto ready = make_ready(cell, request.robot); !ready) {
    return std::unexpected(ready.error());
  }
  if (request.standing_at) {
    if (const auto done = cell.call("robot.declare", declaration); !done) return done;
  }
  return at_rest(cell, request.robot);
}

Outcome recovered(const Json& status, const CellRequest& request) {
  Outcome outcome = status_outcome(status);
  const std::string position = status["position"];
  if (position == "lost" || position == "uncertain") {
    outcome.text += fmt::format(
        "  to find its position again: sinew recover {0} in a terminal asks step by step; sinew "
        "home {0} where it has end stops; a first row `joint` that names all joints on servos; "
        "sinew recover {0} --standing-at ... where you know it\n",
        request.robot);
  }
  return outcome;
}

Outcome cell_stands(const CellRequest& request) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  const auto before = cell->call("robot.status", {{"robot", request.robot}});
  if (!before) return before.error();
  const std::string was = fmt::format(
      "  known before, {}:{}\n", (*before)["position"].get<std::string>(), place_text(*before));
  // Also where what is said is refused: it is what contradicts it.
  if (!request.json) std::fputs(was.c_str(), stderr);
  const auto status = make_known(*cell, request);
  if (!status) return status.error();
  return recovered(*status, request);
}

/// Holds the lease until Ctrl-C, so that nobody else moves the machine: somebody stands beside it.
Outcome cell_lease(const CellRequest& request) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  io::catch_interrupts();
  const auto taken = take_lease(*cell, request);
  if (!taken) return taken.error();
  if (!request.json) {
    std::fputs(
        fmt::format("  {} is yours, and nobody else's to move, until Ctrl-C\n", request.robot)
            .c_str(),
        stderr);
  }
  const io::Clock clock;
  while (io::interrupts() == 0) {
    clock.pause(std::chrono::milliseconds(50));
    const auto status = cell->call("robot.status", {{"robot", request.robot}});
    if (!status) return status.error();
    const Json lease = status->value("lease", Json::object());
    if (lease.value("epoch", std::uint64_t{0}) != (*taken)["epoch"].get<std::uint64_t>()) {
      return could_not("somebody else took the lease over");
    }
  }
  Outcome outcome;
  outcome.json = *taken;
  return outcome;
}

}  // namespace sinew::cli
