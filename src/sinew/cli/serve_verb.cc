#include "sinew/cli/serve_verb.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "sinew/cli/cell_socket.h"
#include "sinew/cli/commission_verb.h"
#include "sinew/cli/demonstration_lines.h"
#include "sinew/cli/device_argument.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/config/cell_file.h"
#include "sinew/io/disk_folder.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/standard_streams.h"
#include "sinew/io/thread_share.h"
#include "sinew/runtime/position_record.h"
#include "sinew/runtime/procedure_session.h"
#include "sinew/runtime/robot_variant.h"
#include "sinew/runtime/running_cell.h"
#include "sinew/server/local_server.h"

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

/// What a cell's file names is looked for beside it.
std::string beside(const std::string& cell_file, const std::string& file) {
  return (std::filesystem::path(cell_file).parent_path() / file).string();
}

std::expected<std::vector<RobotModel>, Outcome> find_robots(const ServeRequest& request,
                                                            const Cell& cell) {
  std::vector<RobotModel> robots;
  for (const CellRobot& place : cell.robots) {
    const bool own = place.robot.ends_with(".toml");
    auto file = find_robot(own ? beside(request.file, place.robot) : place.robot);
    if (!file) return std::unexpected(file.error());
    if (auto fine = check_has_device(file->model); !fine) return std::unexpected(fine.error());
    auto variant = runtime::variant_of(file->model, place.profile, place.wire);
    if (!variant) return std::unexpected(bad_input(place.name + ": " + variant.error()));
    if (place.port) {
      if (auto wrong = runtime::wrong_port(*variant, *place.port)) {
        return std::unexpected(bad_input(place.name + ": " + *wrong));
      }
    }
    if (place.settings) {
      const auto used = use_settings_file(*variant, beside(request.file, *place.settings));
      if (!used) return std::unexpected(bad_input(place.name + ": settings: " + used.error()));
      if (!used->note.empty())
        std::fputs(("  " + place.name + ": " + used->note + "\n").c_str(), stderr);
    }
    robots.push_back(std::move(*variant));
  }
  return robots;
}

std::string greeting(const runtime::RunningCell& cell, const std::string& socket,
                     const std::string& web) {
  std::string text = fmt::format("  {}\n", cell.cell().title);
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const runtime::Station& station = cell.station(i);
    text += fmt::format("    {:<12} {:<16} {}\n", station.name(), station.robot().title,
                        station.simulated() ? "simulated" : station.port_name());
  }
  return text + web + fmt::format("  answers on {}; Ctrl-C ends it\n", socket);
}

void serve_until_the_end(const ServeRequest& request, const runtime::RunningCell& cell,
                         server::ServerLoop& loop) {
  if (!request.demonstrate && !request.shown_is_over) {
    return loop.run([] { return io::interrupts() > 0; });
  }
  server::Demonstration shown(loop.api(), cell);
  DemonstrationLines lines(shown);
  loop.run([&] {
    shown.poll(loop.now());
    if (!request.json) lines.show(loop.now());
    return io::interrupts() > 0 || (request.shown_is_over && (shown.over() || shown.shown()));
  });
  shown.end();
}

}  // namespace

Outcome serve(const ServeRequest& request) {
  auto cell = read(request);
  if (!cell) return cell.error();
  auto robots = find_robots(request, *cell);
  if (!robots) return robots.error();
  const auto socket = cell_socket(request.socket);
  if (!socket) return could_not(socket.error().sentence);
  if (request.record_folder) {
    // Learned now, not when the first program has run.
    const auto place = io::DiskFolder::open_folder(*request.record_folder);
    if (!place) return bad_input("--record-folder: " + place.error().sentence);
  }
  const auto folder = runtime::positions_folder();
  if (!folder) return could_not(folder.error().sentence);
  const auto flight = runtime::records_folder();
  if (!flight) return could_not(flight.error().sentence);
  const auto commissioning = runtime::commissioning_folder();
  if (!commissioning) return could_not(commissioning.error().sentence);
  io::catch_interrupts();
  std::optional<io::RealtimeStart> realtime;
  if (request.realtime) {
    auto begun = io::RealtimeStart::begin();
    if (!begun) return could_not("--realtime: " + begun.error().sentence);
    realtime.emplace(std::move(*begun));
  }
  auto running = runtime::RunningCell::start(std::move(*cell), std::move(*robots),
                                             {.journal = *folder,
                                              .flight = *flight,
                                              .record = request.record_folder.value_or(""),
                                              .commissioning = *commissioning});
  realtime.reset();
  if (!running) return could_not(running.error().sentence);
  server::Api api(**running, SINEW_VERSION);
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
  // Whatever clients want, control threads come first.
  io::let_others_go_first();
  serve_until_the_end(request, **running, loop);
  Outcome outcome;
  outcome.json = {{"ended", "interrupted"}};
  outcome.json_line = true;
  return outcome;
}

}  // namespace sinew::cli
