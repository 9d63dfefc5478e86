#include "sinew/cli/cells/cell_connection.h"

#include <fmt/format.h>

#include "sinew/cli/cells/cell_socket.h"
#include "sinew/cli/output/quantity.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"

namespace sinew::cli {

std::expected<CellConnection, Outcome> CellConnection::open(
    const std::optional<std::string>& socket) {
  auto path = cell_socket(socket);
  if (!path) return std::unexpected(could_not(path.error().sentence));
  auto client = server::RpcClient::connect(*path);
  if (!client) {
    return std::unexpected(
        could_not(client.error().sentence + "; no cell runs there: sinew serve starts one"));
  }
  return CellConnection(std::move(*client), std::move(*path));
}

std::expected<Json, Outcome> CellConnection::call(std::string_view method, const Json& params) {
  auto result = client_.call(method, params);
  if (!result) return std::unexpected(refused(result.error()));
  return std::move(*result);
}

Outcome refused(const server::RpcError& error) {
  const bool bad = error.code == server::RpcCode::kInvalidParams;
  Outcome outcome = bad ? bad_input(error.message) : could_not(error.message);
  if (error.data.is_object()) outcome.json["error"].update(error.data);
  outcome.json["error"]["sentence"] = error.message;
  return outcome;
}

std::expected<Json, Outcome> robot_of_cell(CellConnection& cell, const std::string& name) {
  const auto description = cell.call("cell.describe");
  if (!description) return std::unexpected(description.error());
  std::vector<std::string> names;
  for (const Json& robot : (*description)["robots"]) {
    names.push_back(robot["name"]);
    if (robot["name"] == name) return robot;
  }
  const std::vector<std::string_view> known(names.begin(), names.end());
  const std::string_view meant = nearest_spelling(name, known);
  std::string list;
  for (const std::string& one : names) list += (list.empty() ? "" : ", ") + one;
  return std::unexpected(bad_input(
      fmt::format("the cell has no robot '{}'{}; there are {}", printable(name),
                  meant.empty() ? "" : fmt::format(", did you mean '{}'?", meant), list)));
}

std::string held_by_cell(const std::string& port) {
  auto cell = CellConnection::open(std::nullopt);
  if (!cell) return {};
  const auto description = cell->call("cell.describe");
  if (!description) return {};
  for (const Json& robot : (*description)["robots"]) {
    const std::string other = robot["port"];
    if (robot["simulated"].get<bool>() || !io::same_file(other, port)) continue;
    return fmt::format(
        "; the cell that answers on {0} holds it, as '{1}': sinew status {1} shows it, and sinew "
        "run moves it with --cell --robot {1}",
        cell->path(), std::string(robot["name"]));
  }
  return {};
}

std::expected<Json, Outcome> positions_of(CellConnection& cell, const std::string& robot,
                                          std::string_view option, const std::string& text) {
  const auto description = robot_of_cell(cell, robot);
  if (!description) return std::unexpected(description.error());
  Json positions = Json::array();
  std::vector<Measure> measures;
  std::vector<std::string> names;
  for (const Json& joint : (*description)["joints"]) {
    const bool leg = joint.contains("home_m");
    measures.push_back(leg ? Measure::kLength : Measure::kAngle);
    names.push_back(joint["name"]);
    const bool lowered = leg && text == "lowered";
    positions.push_back(leg ? joint[lowered ? "lower_m" : "home_m"] : joint["home_rad"]);
  }
  const bool legs = std::ranges::count(measures, Measure::kLength) == std::ssize(measures);
  if (text == "lowered" && legs) return positions;
  if (text == "home") return positions;
  const auto values = parse_quantities(option, text, measures, names);
  if (!values) return std::unexpected(bad_input(values.error()));
  return Json(*values);
}

std::string place_of(const Json& joint, const char* lost) {
  if (joint["quality"] == "lost") return lost;
  const auto shown = [&](const std::string& what) {
    const auto metres = joint.find(what + "_m");
    return metres != joint.end() ? to_mm(metres->get<double>())
                                 : to_deg(joint[what + "_rad"].get<double>());
  };
  if (joint["quality"] != "uncertain") return number(shown("position"), 2);
  return number(shown("lower"), 2) + ".." + number(shown("upper"), 2);
}

}  // namespace sinew::cli
