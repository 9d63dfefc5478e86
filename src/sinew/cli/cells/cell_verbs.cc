#include "sinew/cli/cells/cell_verbs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "sinew/cli/cells/cell_connection.h"
#include "sinew/cli/output/plan_report.h"
#include "sinew/cli/output/program_folder.h"
#include "sinew/cli/output/progress_line.h"
#include "sinew/cli/output/quantity.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/plans/bullride_verb.h"
#include "sinew/core/units.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

constexpr const char* kGoneAway =
    "the server has gone away; what streams holds, and a device that takes whole moves ends the "
    "one that it is at";

std::string joints_text(const Json& status) {
  std::string text;
  for (const Json& joint : status["joints"]) {
    text += (text.empty() ? "" : " ") + place_of(joint, "?");
  }
  return text;
}

/// Of a program or procedure.
const char* gone(const Json& what) {
  return what.value("client_lost", false) ? ", its client is gone" : "";
}

/// What a person should know beside the state.
std::string remark(const Json& status) {
  if (status.contains("trouble")) return status["trouble"];
  if (status.contains("fault")) return status["fault"]["error"]["sentence"];
  if (status.contains("job") && !status["job"]["over"].get<bool>()) {
    const Json& job = status["job"];
    return fmt::format("{} {}, line {}, {:.0f} %{}", job["title"].get<std::string>(),
                       job["phase"].get<std::string>(), job["line"].get<int>(),
                       100 * job["progress"].get<double>(), gone(job));
  }
  if (status.contains("procedure")) {
    const Json& procedure = status["procedure"];
    return fmt::format("{}, step {} of {}{}", procedure["kind"].get<std::string>(),
                       procedure["step"].get<int>(), procedure["of"].get<int>(), gone(procedure));
  }
  return status.contains("homing") ? "homing " + status["homing"].get<std::string>() : "";
}

std::string status_text(const Json& robots) {
  Table table({"robot", "state", "position", "joints, deg or mm", "lease", ""});
  for (std::size_t column : {1, 2, 3, 4, 5}) table.left(column);
  for (const Json& one : robots) {
    const std::string lease =
        one.contains("lease") ? fmt::format("client {}", one["lease"]["client"].get<int>()) : "-";
    table.add({one["robot"], one["connected"].get<bool>() ? one["state"] : Json("no port"),
               one["position"], joints_text(one), lease, remark(one)});
  }
  return table.text();
}

/// How a job gets on, on stderr: one line that is written over on a terminal.
class JobLine {
 public:
  explicit JobLine(bool quiet) : quiet_(quiet), live_(io::stderr_is_terminal()) {}
  ~JobLine() {
    if (dirty_) std::fputs("\r\033[K", stderr);
  }
  JobLine(const JobLine&) = delete;
  JobLine& operator=(const JobLine&) = delete;

  void show(const Json& job) {
    if (quiet_) return;
    const std::string text = fmt::format(
        "{}: {}, order {} of {}, line {}, {:.1f} of {:.1f} s", std::string(job["robot"]),
        std::string(job["phase"]), job["orders_done"].get<int>(), job["orders"].get<int>(),
        job["line"].get<int>(), job["elapsed_s"].get<double>(), job["predicted_s"].get<double>());
    if (live_) {
      std::fputs(("\r\033[K  " + text).c_str(), stderr);
      dirty_ = true;
    } else if (job["phase"] != phase_) {
      std::fputs(("  " + text + "\n").c_str(), stderr);
    }
    phase_ = job["phase"];
  }

 private:
  bool quiet_;
  bool live_;
  bool dirty_ = false;
  std::string phase_;
};

/// "wave.sinew:3, at 40 mm (25 %): why", and what would work instead.
std::string refusal_text(const Json& error, const std::string& title) {
  const int line = error.value("line", 0);
  std::string text = line > 0 ? fmt::format("{}:{}", title, line) : std::string();
  const bool metres = error.contains("way_m");
  const planning::MovePlace place{0, error.value("way_m", 0.0), error.value("share", 0.0), metres};
  if (line > 0 && error.contains("share")) {
    // What is told of a contact in the cell says where it is.
    if (!error.contains("other")) text += ", " + cli::place_text(place);
  }
  text += (line > 0 ? ": " : "") + std::string(error["sentence"]);
  if (error.contains("nearest_behind_m")) text += behind_text(error["nearest_behind_m"], place);
  for (const Json& row : error.value("remedies", Json::array())) {
    text += "\n  would work: " + std::string(row);
  }
  return text;
}

Outcome job_outcome(const Json& job) {
  Outcome outcome;
  outcome.json = job;
  const std::string phase = job["phase"];
  for (const Json& note : job.value("notes", Json::array())) {
    outcome.text += fmt::format("  note: line {}: {}\n", note["line"].get<int>(),
                                std::string(note["sentence"]));
  }
  if (phase == "done") {
    outcome.text += fmt::format("  done: {} of {} orders, {:.2f} s predicted, {:.2f} s taken\n",
                                job["orders_done"].get<int>(), job["orders"].get<int>(),
                                job["predicted_s"].get<double>(), job["elapsed_s"].get<double>());
    return outcome;
  }
  outcome.exit = ExitCode::kCouldNot;
  if (job.contains("error")) {
    outcome.complaint = refusal_text(job["error"], job["title"]);
  } else {
    outcome.complaint =
        "stopped" +
        (job.contains("stopped_by") ? ": " + std::string(job["stopped_by"]) : std::string());
  }
  return outcome;
}

Outcome step_outcome(const Json& job) {
  Outcome outcome;
  outcome.json = job;
  if (job.contains("wish_refused")) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint = "cannot go back: " + std::string(job["wish_refused"]["sentence"]);
    return outcome;
  }
  outcome.text = fmt::format("  paused: {} of {} orders done\n", job["orders_done"].get<int>(),
                             job["orders"].get<int>());
  return outcome;
}

/// Waits for the end of a job, alive; Ctrl-C stops it.
/// @param wishes  so many it has heard when what it says of its client counts, this process's own
///                wish the last of them; 0: it had none
Outcome follow(CellConnection& cell, const std::string& robot, std::uint64_t number, bool quiet,
               std::uint64_t wishes = 0) {
  const io::Clock clock;
  Instant alive = clock.now();
  int interrupts = 0;
  JobLine line(quiet);
  while (true) {
    const auto message = cell.client().next(kSlice);
    if (cell.client().broken()) return could_not(kGoneAway);
    if (message && (*message)["method"] == "job") {
      const Json& job = (*message)["params"];
      if (job["job"] == number) {
        line.show(job);
        if (job["over"].get<bool>()) return job_outcome(job);
        const auto told = job["wishes"].get<std::uint64_t>();
        const bool heard = told >= wishes;
        // What another client wished in vain is that one's concern.
        if (told == wishes && job.contains("wish_refused")) {
          return could_not(job["wish_refused"]["sentence"]);
        }
        if (heard && job.value("client_lost", false)) {
          return could_not(
              fmt::format("control was lost; '{0}' is paused at line {1}: sinew resume "
                          "{2} goes on with it, sinew stop {2} ends it",
                          std::string(job["title"]), job["line"].get<int>(), robot));
        }
      }
    }
    if (io::interrupts() > interrupts) {
      interrupts = io::interrupts();
      if (interrupts > 1) return could_not("left at once; the program is paused without control");
      cell.client().send("robot.stop", {{"robot", robot}});
    }
    if (clock.now() - alive < kAlive) continue;
    alive = clock.now();
    cell.client().send("lease.renew");
  }
}

/// Begins a job and waits for its end.
Outcome run_job(const CellRequest& request, const char* method, Json params) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  params["robot"] = request.robot;
  params["take_over"] = request.take_over;
  if (request.standing_at == "shown") {
    params["shown"] = true;
  } else if (request.standing_at) {
    const auto standing = positions_of(*cell, request.robot, "--standing-at", *request.standing_at);
    if (!standing) return standing.error();
    params["standing_at"] = *standing;
  }
  if (request.moved) params["moved"] = *request.moved;
  io::catch_interrupts();
  if (auto watched = cell->call("watch", {{"rate_hz", 0}, {"robot", request.robot}}); !watched) {
    return watched.error();
  }
  const auto job = cell->call(method, params);
  if (!job) return job.error();
  return follow(*cell, request.robot, (*job)["job"], request.json);
}

/// A request that is one call.
Outcome call_once(const CellRequest& request, const char* method, const std::string& done,
                  Json params = Json::object()) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  if (!request.robot.empty()) params["robot"] = request.robot;
  const auto result = cell->call(method, params);
  if (!result) return result.error();
  Outcome outcome;
  outcome.json = *result;
  outcome.text = "  " + done + "\n";
  return outcome;
}

}  // namespace

Outcome cell_status(const CellRequest& request) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  const auto status = cell->call("cell.status");
  if (!status) return status.error();
  Json robots = (*status)["robots"];
  if (!request.robot.empty()) {
    if (auto known = robot_of_cell(*cell, request.robot); !known) return known.error();
    std::erase_if(robots.get_ref<Json::array_t&>(),
                  [&](const Json& one) { return one["robot"] != request.robot; });
  }
  Outcome outcome;
  outcome.json = {{"robots", robots}};
  outcome.text = status_text(robots);
  return outcome;
}

Outcome cell_move(const CellRequest& request) {
  const std::string row = joined(request.row, " ");
  Json params{{"text", row}, {"name", "move"}};
  // Where `sinew teach` writes them. A row that names none does not care what is in there.
  const bool names_points = std::ranges::any_of(
      std::array{"to=", "via=", "spline"}, [&](const char* word) { return row.contains(word); });
  if (names_points && io::exists("points.toml")) {
    const auto points = io::read_file("points.toml");
    if (!points) return bad_input(points.error().sentence);
    params["points"] = *points;
  }
  return run_job(request, "program.run", std::move(params));
}

Outcome cell_run(const CellRequest& request) {
  const auto texts = gather_program(request.file);
  if (!texts) return texts.error();
  Json params{{"text", texts->text}, {"name", request.file}};
  if (texts->form != nullptr) params["form"] = texts->form->name;
  if (texts->points) params["points"] = *texts->points;
  if (!texts->called.empty()) params["called"] = texts->called;
  if (request.single_step) params["single_step"] = true;
  if (request.from_line) params["from_line"] = *request.from_line;
  if (request.speed) {
    const auto share = speed_share(*request.speed);
    if (!share) return bad_input(share.error());
    params["speed"] = *share;
  }
  return run_job(request, "program.run", std::move(params));
}

Outcome cell_ride(const CellRequest& request) {
  Json params{{"duration_s", request.ride_s}, {"seed", request.seed}};
  if (request.ride_amplitude) {
    auto cell = CellConnection::open(request.socket);
    if (!cell) return cell.error();
    const auto description = robot_of_cell(*cell, request.robot);
    if (!description) return description.error();
    const Json& joint = (*description)["joints"][0];
    const double stroke = joint.value("upper_m", 0.0) - joint.value("lower_m", 0.0);
    const auto amplitude = ride_amplitude(request.ride_amplitude, stroke);
    if (!amplitude) return amplitude.error();
    params["amplitude"] = *amplitude;
  }
  return run_job(request, "robot.bullride", std::move(params));
}

Outcome cell_stop(const CellRequest& request) {
  return call_once(request, "robot.stop",
                   request.robot.empty() ? "all robots stop" : request.robot + " stops");
}

Outcome cell_pause(const CellRequest& request) {
  Json params = Json::object();
  if (request.guarded) params["guarded"] = true;
  return call_once(request, "robot.hold", request.robot + " pauses", std::move(params));
}

/// A program whose client is gone goes on under the lease of this process, until its end.
Outcome cell_resume(const CellRequest& request) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  const Json robot{{"robot", request.robot}};
  const auto job = cell->call("job.status", robot);
  if (!job) return job.error();
  const Json resume{{"robot", request.robot}, {"take_over", request.take_over}};
  if (!job->value("client_lost", false)) {
    return call_once(request, "robot.resume", request.robot + " goes on", resume);
  }
  io::catch_interrupts();
  const Json events{{"rate_hz", 0}, {"robot", request.robot}};
  if (const auto watched = cell->call("watch", events); !watched) return watched.error();
  if (const auto taken = cell->call("lease.take", resume); !taken) return taken.error();
  const auto resumed = cell->call("robot.resume", resume);
  if (!resumed) return resumed.error();
  return follow(*cell, request.robot, (*job)["job"], request.json,
                (*resumed)["wishes"].get<std::uint64_t>() + 1);
}

/// One order of the program that somebody runs there; waits until it is paused again.
Outcome cell_step(const CellRequest& request) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  io::catch_interrupts();
  const auto stepped =
      cell->call("program.step", {{"robot", request.robot}, {"back", request.back}});
  if (!stepped) return stepped.error();
  const io::Clock clock;
  while (io::interrupts() == 0) {
    const auto job = cell->call("job.status", {{"robot", request.robot}});
    if (!job) return job.error();
    if ((*job)["job"] != (*stepped)["job"]) return could_not("another program runs there by now");
    const bool heard =
        (*job)["wishes"].get<std::uint64_t>() > (*stepped)["wishes"].get<std::uint64_t>();
    if ((*job)["over"].get<bool>()) return job_outcome(*job);
    if (heard && (*job)["phase"] == "paused") return step_outcome(*job);
    clock.pause(kSlice);
  }
  return could_not("left; the order goes on, and the program pauses behind it");
}

}  // namespace sinew::cli
