#include "sinew/cli/cells/in_cell.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace sinew::cli {

void add_cell_options(CLI::App& verb, InCell& in) {
  verb.add_flag("--cell", in.named, "on a robot of the running cell, by its name there");
  verb.add_option("--socket", in.cell.socket, "the same, and where the cell answers");
}

bool on_cell(InCell& in, const ChosenVerb& call) {
  in.cell.json = call.json;
  return in.named || in.cell.socket.has_value();
}

std::expected<void, Outcome> check_heard(const CLI::App& verb,
                                         std::initializer_list<std::string_view> heard) {
  for (const CLI::Option* option : verb.get_options()) {
    const std::string name = option->get_name();
    const bool known = name == "--cell" || name == "--socket" || name == "--json" ||
                       std::ranges::find(heard, name) != heard.end();
    if (known || option->count() == 0) continue;
    return std::unexpected(
        bad_input(name + ": not in a running cell, where the cell's file and the robot's say so"));
  }
  return {};
}

}  // namespace sinew::cli
