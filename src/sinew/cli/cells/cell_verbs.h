#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/cells/cell_connection.h"
#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// What is asked of a running cell.
struct CellRequest {
  std::optional<std::string> socket;
  std::string robot;                       ///< its name in the cell; may be empty for some
  std::vector<std::string> row;            ///< of `move`: the words of a program's row
  std::optional<std::string> standing_at;  ///< of `recover`, `run`: home, or a value a joint
  std::optional<std::string> moved;        ///< of `recover`: why what was known does not count
  std::string joint;                       ///< of `nudge`
  std::string way;                         ///< of `nudge`
  bool until_probe = false;                ///< of `nudge`
  std::optional<std::string> answers;      ///< of a procedure: a file; else somebody types
  bool zero_counters = false;              ///< of `stands`: the device counts from there
  bool anew = false;                       ///< of `commission`
  bool ends = false;                       ///< of `free`
  bool take_over = false;
  bool guarded = false;                       ///< of `pause`
  std::string file;                           ///< of `run`
  std::optional<int> from_line;               ///< of `run`
  std::optional<std::string> speed;           ///< of `run`: "30%"
  bool single_step = false;                   ///< of `run`
  bool back = false;                          ///< of `step`
  std::string frame = "base";                 ///< of `jog`
  std::string velocity;                       ///< of `jog`
  std::optional<std::string> time;            ///< of `jog`
  double ride_s = 0;                          ///< of a ride
  std::optional<std::string> ride_amplitude;  ///< as the wire allows where absent
  std::int64_t seed = 1;
  bool json = false;
};

Outcome cell_status(const CellRequest& request);
Outcome cell_move(const CellRequest& request);
Outcome cell_home(const CellRequest& request);
Outcome cell_run(const CellRequest& request);
Outcome cell_ride(const CellRequest& request);
Outcome cell_jog(const CellRequest& request);
Outcome cell_stop(const CellRequest& request);
Outcome cell_pause(const CellRequest& request);
Outcome cell_resume(const CellRequest& request);
Outcome cell_nudge(const CellRequest& request);
Outcome cell_free(const CellRequest& request);
Outcome cell_step(const CellRequest& request);
Outcome cell_recover(const CellRequest& request);
/// Where a robot stands, from somebody who has looked; says what was known before.
Outcome cell_stands(const CellRequest& request);
Outcome cell_commission(const CellRequest& request);
Outcome cell_lease(const CellRequest& request);

/// The verbs above with their options, but those that are verbs of one robot too.
void add_cell_verbs(CLI::App& app, ChosenVerb& call);

/// The beginning of a recovery: lease, an acknowledged fault, a machine that is found, and where it
/// stands if somebody says so. @return  its status then
std::expected<Json, Outcome> make_known(CellConnection& cell, const CellRequest& request);
/// That status, and what helps where its place is still not known.
Outcome recovered(const Json& status, const CellRequest& request);

}  // namespace sinew::cli
