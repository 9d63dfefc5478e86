#include "sinew/cli/cells/teach_verb.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "sinew/cli/cells/cell_connection.h"
#include "sinew/cli/cells/taught_way.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/config/points_file.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/planning/paths/tool_space.h"
#include "sinew/program/formats/pose_file.h"

namespace sinew::cli {
namespace {

constexpr Duration kTurnPatience = std::chrono::seconds(10);
constexpr std::string_view kPoseEnding = ".pos";

std::string utc_now() {
  using std::chrono::nanoseconds;
  using std::chrono::system_clock;
  const system_clock::time_point now(
      std::chrono::duration_cast<system_clock::duration>(nanoseconds(io::wall_time_ns())));
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(system_clock::to_time_t(now)));
}

/// The joints where they are, each inside its limits.
/// @error  one of them is not known, or could not be asked for in a program
std::expected<TaughtPoint, Outcome> point_here(const Json& status, const Json& description) {
  TaughtPoint point;
  point.robot = description["robot"];
  JointVector q;
  for (std::size_t j = 0; j < status["joints"].size(); ++j) {
    const Json& joint = status["joints"][j];
    const std::string name = joint["name"];
    const std::string quality = joint["quality"];
    if (quality == "lost" || quality == "uncertain") {
      return std::unexpected(could_not(
          fmt::format("nobody knows for sure where {} is; home it, or say where it is", name)));
    }
    const bool slides = joint.contains("position_m");
    if (slides) point.lengths |= static_cast<std::uint8_t>(1U << j);
    const char* unit = slides ? "_m" : "_rad";
    const double value = joint[std::string("position") + unit];
    const Json& limits = description["joints"][j];
    const double lower = limits[std::string("lower") + unit];
    const double upper = limits[std::string("upper") + unit];
    if (value < lower || value > upper) {
      const double scale = slides ? 1e3 : to_deg(1);
      return std::unexpected(could_not(
          fmt::format("{} is at {} {}, outside its limits {} to {}: no program could go there",
                      name, number(scale * value, 2), slides ? "mm" : "deg",
                      number(scale * lower, 2), number(scale * upper, 2))));
    }
    q.push_back(value);
  }
  point.place = q;
  return point;
}

std::string place_text(const TaughtPoint& point) {
  if (const auto* q = std::get_if<JointVector>(&point.place)) {
    std::string text;
    for (std::size_t j = 0; j < q->size(); ++j) {
      const bool slides = (point.lengths >> j & 1U) != 0;
      const bool last = j + 1 == q->size() || (point.lengths >> (j + 1) & 1U) != slides;
      text += (text.empty() ? "" : " ") + number(slides ? to_mm((*q)[j]) : to_deg((*q)[j]), 2);
      if (last) text += slides ? " mm" : " deg";
    }
    return text;
  }
  const auto& place = std::get<ToolPlace>(point.place);
  std::string text = fmt::format("tool at {} {} {} mm", number(to_mm(place.p_BT.x), 2),
                                 number(to_mm(place.p_BT.y), 2), number(to_mm(place.p_BT.z), 2));
  return text + (place.R_BT || place.pitch ? ", turned" : "");
}

Json point_json(const TaughtPoint& point) {
  Json json{{"name", point.name},
            {"robot", point.robot},
            {"source", point.source},
            {"taught_at", point.taught_at}};
  if (const auto* q = std::get_if<JointVector>(&point.place)) {
    const std::uint8_t all = static_cast<std::uint8_t>((1U << q->size()) - 1);
    const char* key = point.lengths == 0     ? "joints_rad"
                      : point.lengths == all ? "legs_m"
                                             : "joints_rad_m";
    json[key] = std::vector<double>(q->begin(), q->end());
  } else {
    const Vec3& p = std::get<ToolPlace>(point.place).p_BT;
    json["tool_m"] = {p.x, p.y, p.z};
  }
  return json;
}

std::expected<std::string, Outcome> text_of_file(const std::string& path) {
  if (!io::exists(path)) return std::string();
  auto text = io::read_file(path);
  if (!text) return std::unexpected(bad_input(text.error().sentence));
  return std::move(*text);
}

struct Standing {
  Json description;
  TaughtPoint point;
};

/// Where the cell's robot stands at rest.
std::expected<Standing, Outcome> standing_of(const TeachRequest& request) {
  auto cell = CellConnection::open(request.socket);
  if (!cell) return std::unexpected(cell.error());
  const auto description = robot_of_cell(*cell, request.robot);
  if (!description) return std::unexpected(description.error());
  if (request.point.ends_with(kPoseEnding) && !(*description)["joints"][0].contains("home_m")) {
    return std::unexpected(bad_input(request.point + ": a .pos is a platform's; " + request.robot +
                                     " is none. Give its point a name without an ending"));
  }
  const auto status = cell->call("robot.status", {{"robot", request.robot}});
  if (!status) return std::unexpected(status.error());
  const std::string state = (*status)["state"];
  if (state == "moving" || state == "stopping" || state == "recovering") {
    return std::unexpected(
        could_not(request.robot + " is moving; a point is taught where it rests"));
  }
  auto point = point_here(*status, *description);
  if (!point) return std::unexpected(point.error());
  return Standing{*description, std::move(*point)};
}

std::expected<RobotModel, Outcome> model_of(const Json& description) {
  const auto file = find_robot(description["robot"].get<std::string>());
  if (!file) return std::unexpected(file.error());
  return file->model;
}

/// "Save Position As": a platform's pose in the form of its own old program.
Outcome teach_pose(const TeachRequest& request) {
  if (io::exists(request.point) && !request.replace) {
    return bad_input(request.point + ": is there already; --replace writes it anew");
  }
  const auto stands = standing_of(request);
  if (!stands) return stands.error();
  const auto model = model_of(stands->description);
  if (!model) return model.error();
  const auto& q = std::get<JointVector>(stands->point.place);
  const planning::ToolSpace space(*model);
  const auto X_BT = space.forward({q.data(), q.size()}, space.home());
  if (!X_BT) return could_not(error_text(X_BT.error(), *model));
  const auto X_BP = relabel<frame::Base, frame::Platform>(*X_BT);
  const auto text =
      program::pose_text(program::pose_file(X_BP, std::get<HexapodGeometry>(model->geometry)),
                         program::DecimalMark::kPoint);
  if (const auto written = io::replace_file(request.point, text); !written) {
    return could_not(written.error().sentence);
  }
  Outcome outcome;
  outcome.json = {{"file", request.point},
                  {"robot", stands->point.robot},
                  {"legs_m", std::vector<double>(q.begin(), q.end())}};
  outcome.text = fmt::format("  {}: {}\n", request.point, place_text(stands->point));
  return outcome;
}

Outcome teach_point(const TeachRequest& request) {
  if (!is_point_name(request.point)) {
    return bad_input("a point's name has letters, digits, - and _, a letter first, 40 at most");
  }
  // Two who teach at once would each put back a file without the other's point.
  const auto turn = io::FolderTurn::take(request.file, kTurnPatience);
  if (!turn) return could_not(turn.error().sentence);
  const auto text = text_of_file(request.file);
  if (!text) return text.error();
  const auto points = read_points(*text, request.file);
  if (!points) return complaints_outcome(points.error());
  const auto old = std::ranges::find(*points, request.point, &TaughtPoint::name);
  const bool there = old != points->end();
  if (there && !request.replace) {
    return bad_input(fmt::format("{}: there is a point '{}' already; --replace teaches it anew",
                                 request.file, request.point));
  }
  auto stands = standing_of(request);
  if (!stands) return stands.error();
  TaughtPoint* point = &stands->point;
  if (there && old->robot != point->robot) {
    return bad_input(fmt::format("{}: '{}' is a point of {}, not of {}; give this one another name",
                                 request.file, request.point, printable(old->robot), point->robot));
  }
  point->name = request.point;
  point->source = "taught";
  point->taught_at = utc_now();
  const auto changed = with_point(*text, request.file, *point);
  if (!changed) return complaints_outcome(changed.error());
  if (const auto written = io::replace_file(request.file, *changed); !written) {
    return could_not(written.error().sentence);
  }
  Outcome outcome;
  outcome.json = point_json(*point);
  outcome.json["file"] = request.file;
  outcome.text = fmt::format("  {}: {} {}, {}\n", request.file, request.point,
                             there ? "taught anew" : "taught", place_text(*point));
  return outcome;
}

/// Not more often than any of the wires tells something new.
constexpr double kWayRate = 50;           // Hz
constexpr std::size_t kWayMax = 100'000;  // samples: half an hour
constexpr Duration kKeepEach = std::chrono::seconds(3);

/// The way so far, as a program in its file.
class WayFile {
 public:
  WayFile(std::string path, RobotModel robot) : path_(std::move(path)), robot_(std::move(robot)) {}

  void add(const Json& status) {
    const double t = status["at_s"];
    const auto q = known_joints(status["joints"], robot_);
    if (q && (way_.empty() || t > way_.back().t)) way_.push_back({t, *q});
  }
  bool full() const { return way_.size() >= kWayMax; }

  /// @return how it is told; @error  nothing moved, or the file cannot be written
  std::expected<Outcome, Outcome> write() const {
    const auto taught = program_of_way(way_, robot_);
    if (!taught) return std::unexpected(taught.error());
    if (const auto written = io::replace_file(path_, taught->text); !written) {
      return std::unexpected(could_not(written.error().sentence));
    }
    const auto rows = std::ranges::count(taught->text, '\n') - std::ssize(taught->notes);
    const double length = way_.back().t - way_.front().t;
    Outcome outcome;
    outcome.json = {{"file", path_},
                    {"samples", way_.size()},
                    {"rows", rows},
                    {"length_s", length},
                    {"notes", taught->notes}};
    outcome.text = fmt::format("  {}: {} rows, of {:.1f} s\n", path_, rows, length);
    for (const std::string& note : taught->notes) outcome.text += "  note: " + note + "\n";
    return outcome;
  }

 private:
  std::string path_;
  RobotModel robot_;
  std::vector<program::WaySample> way_;
};

/// Looks at the robot until Ctrl-C. Nothing is sent that moves it, and no lease is needed. What
/// was seen is in the file every few seconds: whatever ends this program, little is lost.
/// @return false where the server has gone away
bool watch_way(CellConnection& cell, WayFile& file) {
  const io::Clock clock;
  Instant kept = clock.now();
  while (io::interrupts() == 0 && !file.full()) {
    const auto message = cell.client().next(std::chrono::milliseconds(50));
    if (cell.client().broken()) return false;
    if (message && (*message)["method"] == "status") file.add((*message)["params"]["robots"][0]);
    if (clock.now() - kept < kKeepEach) continue;
    static_cast<void>(file.write());
    kept = clock.now();
  }
  return true;
}

Outcome teach_way(const TeachRequest& request) {
  const std::string& path = *request.way;
  if (!path.ends_with(".sinew")) return bad_input("--way: is a program's name, NAME.sinew");
  if (io::exists(path) && !request.replace) {
    return bad_input(path + ": is there already; --replace writes it anew");
  }
  if (const auto fine = io::check_place(path); !fine) return bad_input(fine.error().sentence);
  auto cell = CellConnection::open(request.socket);
  if (!cell) return cell.error();
  const auto description = robot_of_cell(*cell, request.robot);
  if (!description) return description.error();
  auto robot = model_of(*description);
  if (!robot) return robot.error();
  io::catch_interrupts();
  const Json what{{"rate_hz", kWayRate}, {"robot", request.robot}};
  if (const auto watched = cell->call("watch", what); !watched) return watched.error();
  if (!request.quiet) {
    std::fputs(fmt::format("  looks at {}: lead it (sinew jog {} --cell ..), Ctrl-C ends\n",
                           request.robot, request.robot)
                   .c_str(),
               stderr);
  }
  WayFile file(path, std::move(*robot));
  const bool served = watch_way(*cell, file);
  auto written = file.write();
  Outcome outcome = written ? std::move(*written) : std::move(written.error());
  if (served) return outcome;
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint = fmt::format("the server has gone away; {}",
                                  written ? path + " has the way until then" : outcome.complaint);
  return outcome;
}

}  // namespace

Outcome teach(const TeachRequest& request) {
  if (request.way && !request.point.empty()) {
    return bad_input("teach: a POINT where it stands, or a --way, not both");
  }
  if (!request.way && request.point.empty()) {
    return bad_input("teach: say what the place shall be called, or --way NAME.sinew");
  }
  if (request.point.ends_with(kPoseEnding)) return teach_pose(request);
  return request.way ? teach_way(request) : teach_point(request);
}

Outcome show_points(const PointsRequest& request) {
  const auto text = io::read_file(request.file);
  if (!text) return bad_input(text.error().sentence);
  const auto points = read_points(*text, request.file);
  if (!points) return complaints_outcome(points.error());
  Outcome outcome;
  outcome.json["points"] = Json::array();
  Table table({"point", "robot", "place", "source", "taught"});
  for (const std::size_t column : {1, 2, 3, 4}) table.left(column);
  for (const TaughtPoint& point : *points) {
    outcome.json["points"].push_back(point_json(point));
    table.add({point.name, point.robot, place_text(point), point.source, point.taught_at});
  }
  outcome.text = points->empty() ? "  no points\n" : table.text();
  return outcome;
}

void add_teach(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<TeachRequest>();
  CLI::App* verb = add_verb(app, call, "teach",
                            "where a robot of a running cell stands, or its way, for programs",
                            "sinew teach learm above_bin");
  verb->add_option("ROBOT", own->robot, "its name in the cell")->required();
  verb->add_option("POINT", own->point,
                   "what the place shall be called; of a platform also FILE.pos");
  verb->add_option("--way", own->way,
                   "instead: the program NAME.sinew that its way until Ctrl-C becomes");
  verb->add_option("--points", own->file, "its file; points.toml where left out");
  verb->add_flag("--replace", own->replace,
                 "where there is a point, or a program, of that name already");
  verb->add_option("--socket", own->socket,
                   "where the cell answers; the user's own place where left out");
  verb->callback([&call, own] {
    call.verb = [&call, own] {
      own->quiet = call.json;
      return teach(*own);
    };
  });
}

void add_points(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<PointsRequest>();
  CLI::App* verb =
      add_verb(app, call, "points", "the taught points of a file", "sinew points points.toml");
  verb->add_option("FILE", own->file, "points.toml where left out");
  verb->callback([&call, own] { call.verb = [own] { return show_points(*own); }; });
}

}  // namespace sinew::cli
