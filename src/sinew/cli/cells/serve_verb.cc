#include "sinew/cli/cells/serve_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "sinew/cli/cells/cell_socket.h"
#include "sinew/cli/cells/demonstration_lines.h"
#include "sinew/cli/output/cell_cameras.h"
#include "sinew/cli/output/device_argument.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/used_settings.h"
#include "sinew/config/cell_file.h"
#include "sinew/io/disk_folder.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/standard_streams.h"
#include "sinew/io/thread_share.h"
#include "sinew/runtime/cell_settings.h"
#include "sinew/runtime/commissioning_file.h"
#include "sinew/runtime/journal/position_record.h"
#include "sinew/runtime/running_cell.h"
#include "sinew/server/web/local_server.h"

namespace sinew::cli {
namespace {

constexpr const char* kBuiltinName = "cells/five.toml";

std::expected<Cell, Outcome> read(const ServeRequest& request) {
  std::string text(builtin_cell());
  if (!request.file.empty()) {
    auto read = io::read_file(request.file);
    if (!read) return std::unexpected(bad_input(read.error().sentence));
    text = std::move(*read);
  }
  auto cell = read_cell(text, request.file.empty() ? kBuiltinName : request.file);
  if (!cell) return std::unexpected(complaints_outcome(cell.error()));
  return std::move(*cell);
}

std::expected<std::vector<runtime::RobotMaking>, Outcome> find_robots(const ServeRequest& request,
                                                                      const Cell& cell) {
  std::vector<runtime::RobotMaking> robots;
  for (const CellRobot& place : cell.robots) {
    auto file = find_robot(place, request.file);
    if (!file) return std::unexpected(file.error());
    runtime::RobotMaking making{file->model, place};
    if (place.settings) {
      const auto read = read_settings_file(file->model, beside(request.file, *place.settings));
      if (!read) return std::unexpected(bad_input(place.name + ": settings: " + read.error()));
      if (!read->note.empty()) {
        std::fputs(("  " + place.name + ": " + read->note + "\n").c_str(), stderr);
      }
      making.found = read->settings;
    }
    robots.push_back(std::move(making));
  }
  return robots;
}

/// The cell's file, the robots' own, and on top of them what somebody has set in a panel.
std::expected<runtime::CellSettings, Outcome> find_settings(const ServeRequest& request,
                                                            const Cell& cell) {
  auto robots = find_robots(request, cell);
  if (!robots) return std::unexpected(robots.error());
  const auto file = runtime::settings_path(request.file);
  if (!file) return std::unexpected(could_not(file.error().sentence));
  std::error_code error;
  const std::string whose = request.file.empty()
                                ? kBuiltinName
                                : std::filesystem::weakly_canonical(request.file, error).string();
  runtime::CellSettings settings(*file, whose, cell.time_scale, std::move(*robots));
  if (const auto loaded = settings.load(); !loaded) {
    return std::unexpected(bad_input(loaded.error() + "; mend it, or move it away"));
  }
  return settings;
}

/// Robots as they run; their places in the cell as they then are.
std::expected<std::vector<RobotModel>, Outcome> make_robots(const runtime::CellSettings& settings,
                                                            Cell& cell) {
  std::vector<RobotModel> models;
  for (std::size_t i = 0; i < cell.robots.size(); ++i) {
    auto made = settings.make(i);
    const std::string name = cell.robots[i].name;
    if (!made) {
      const std::string where = settings.is_set(i) ? settings.file() + ": " : std::string();
      return std::unexpected(bad_input(where + name + ": " + made.error().front().sentence));
    }
    if (settings.is_set(i)) {
      std::fputs(("  " + name + ": as set in " + settings.file() + "\n").c_str(), stderr);
    }
    cell.robots[i] = std::move(made->place);
    models.push_back(std::move(made->model));
  }
  return models;
}

std::string greeting(const runtime::RunningCell& cell, const std::string& socket,
                     const std::string& web) {
  std::string text = fmt::format("  {}\n", cell.cell().title);
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const runtime::Station& station = cell.station(i);
    text += fmt::format("    {:<12} {:<16} {}\n", station.name(), station.robot().title,
                        station.simulated() ? "simulated" : station.port_name());
    if (const std::string note = station.journal_note(); !note.empty()) {
      text += fmt::format("      {}\n", note);
    }
  }
  return text + web + fmt::format("  answers on {}; Ctrl-C ends it\n", socket);
}

/// Where its events are kept; empty where there is no place for them.
std::string event_file(const ServeRequest& request) {
  return runtime::events_path(request.file).value_or("");
}

/// @return  the robots that could not show anything, where the demonstration was all that was
/// wanted
std::vector<std::string> serve_until_the_end(const ServeRequest& request,
                                             const runtime::RunningCell& cell,
                                             server::ServerLoop& loop) {
  if (!request.demonstrate && !request.shown_is_over) {
    loop.run([] { return io::interrupts() > 0; });
    return {};
  }
  server::Demonstration shown(loop.api(), cell);
  DemonstrationLines lines(shown);
  loop.run([&] {
    shown.poll(loop.now());
    if (!request.json) lines.show(loop.now());
    // A visitor who has taken a robot keeps the cell.
    return io::interrupts() > 0 || (request.shown_is_over && !shown.over() && shown.shown());
  });
  std::vector<std::string> idle;
  for (const auto& part : shown.parts()) {
    if (request.shown_is_over && io::interrupts() == 0 && part.rounds == 0) {
      idle.push_back(part.robot);
    }
  }
  shown.end();
  return idle;
}

}  // namespace

Outcome serve(const ServeRequest& request) {
  auto cell = read(request);
  if (!cell) return cell.error();
  auto settings = find_settings(request, *cell);
  if (!settings) return settings.error();
  auto robots = make_robots(*settings, *cell);
  if (!robots) return robots.error();
  const auto socket = cell_socket(request.socket);
  if (!socket) return could_not(socket.error().sentence);
  const bool records_jobs = request.record_folder != "none";
  if (records_jobs && request.record_folder) {  // learned now, not when a program has run
    const auto place = io::DiskFolder::open_folder(*request.record_folder);
    if (!place) return bad_input("--record-folder: " + place.error().sentence);
  }
  const auto folder = runtime::positions_folder();
  if (!folder) return could_not(folder.error().sentence);
  const auto flight = runtime::records_folder();
  if (!flight) return could_not(flight.error().sentence);
  const auto commissioning = runtime::commissioning_folder();
  if (!commissioning) return could_not(commissioning.error().sentence);
  const auto programs = request.program_folder ? io::IoResult<std::string>(*request.program_folder)
                                               : runtime::programs_folder();
  if (!programs) return could_not(programs.error().sentence);
  if (request.program_folder) {
    const auto place = io::DiskFolder::open_folder(*programs);
    if (!place) return bad_input("--program-folder: " + place.error().sentence);
  }
  io::catch_interrupts();
  std::optional<io::RealtimeStart> realtime;
  if (request.realtime) {
    auto begun = io::RealtimeStart::begin();
    if (!begun) return could_not("--realtime: " + begun.error().sentence);
    realtime.emplace(std::move(*begun));
  }
  auto running = runtime::RunningCell::start(
      std::move(*cell), std::move(*robots),
      {.journal = *folder,
       .flight = *flight,
       .record = records_jobs ? request.record_folder.value_or("") : std::string(),
       .records_jobs = records_jobs,
       .commissioning = *commissioning,
       .programs = *programs,
       .baskets = runtime::baskets_path(request.file).value_or("")});
  realtime.reset();
  if (!running) return could_not(running.error().sentence);
  if (auto seeing = open_cameras(**running, request.file); !seeing) return seeing.error();
  // Whatever clients want, control threads come first: also before the threads that the Api begins.
  io::let_others_go_first(io::Share::kServing);
  server::Api api(**running, SINEW_VERSION, &*settings, event_file(request));
  server::ServerLoop loop(api);
  auto listening = server::LocalServer::listen(*socket, loop);
  if (!listening) return could_not(listening.error().sentence);
  auto web = open_web_door(request.web, loop);
  if (!web) return web.error();
  if (request.json) {
    Json begun{{"listening", *socket}};
    if (!web->json.is_null()) begun["web"] = web->json;
    static_cast<void>(io::write_stdout(begun.dump() + "\n"));
  } else {
    std::fputs(greeting(**running, *socket, web->text).c_str(), stderr);
  }
  const auto idle = serve_until_the_end(request, **running, loop);
  if (!idle.empty()) return could_not(fmt::format("not shown: {}", fmt::join(idle, ", ")));
  Outcome outcome;
  outcome.json = {{"ended", io::interrupts() > 0 ? "interrupted" : "shown"}};
  outcome.json_line = true;
  return outcome;
}

void add_serve(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<ServeRequest>();
  ServeRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "serve", "runs a cell of robots, which others then steer",
                            "sinew serve my_cell.toml");
  verb->add_option("CELL", request.file,
                   "a cell's .toml file; all five robots simulated where left out");
  verb->add_option("--socket", request.socket,
                   "where it answers; the user's own place where left out");
  verb->add_option("--record-folder", request.record_folder,
                   "each program that runs leaves a record there (MCAP, for viewers), or none; "
                   "the newest 20 in the state folder where left out");
  verb->add_option("--program-folder", request.program_folder,
                   "where programs and points are kept, in a folder for each robot's id; the state "
                   "folder where left out");
  verb->add_flag("--realtime", request.realtime,
                 "control threads come before everything else on this computer (SCHED_FIFO)");
  verb->add_flag("--demo", request.demonstrate,
                 "simulated robots show what they can do, until somebody moves one");
  verb->add_flag("--demo-once", request.shown_is_over, "the same, and ends when all was shown");
  WebDoorRequest& web = request.web;
  verb->add_option("--listen", web.listen,
                   "where browsers reach it, HOST:PORT, or none; 127.0.0.1:8700 where left out");
  verb->add_option("--host", web.hosts, "HOST:PORT by which it may be called besides")
      ->allow_extra_args(false);
  verb->add_option("--tls-cert", web.tls_certificate, "certificate chain (PEM), for networks");
  verb->add_option("--tls-key", web.tls_key, "its private key (PEM)");
  verb->add_flag("--insecure-network", web.insecure_network,
                 "may listen beyond this machine without TLS: everybody on the way can read the "
                 "token, and then move the robots");
  verb->callback([&call, own] {
    call.verb = [&call, own] {
      own->json = call.json;
      return serve(*own);
    };
  });
}

}  // namespace sinew::cli
