#pragma once

#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/used_settings.h"
#include "sinew/runtime/running_cell.h"

namespace sinew::cli {

/// The robot that a verb works on, and its device, as its options name them.
struct RobotOptions {
  std::string name;                 ///< id or .toml file
  std::optional<std::string> port;  ///< nothing: a simulated device
  std::optional<std::string> wire;
  std::optional<std::string> profile;
  std::vector<std::string> without;  ///< joints that are left out
  /// What commissioning found: a file, "none", or that of the state folder where left out, which
  /// counts on real ports only.
  std::optional<std::string> settings;
  std::optional<std::string> journal;  ///< its name; nothing: the robot's id, on a real port only
  std::int64_t seed = 1;               ///< of the simulated device
  double time_scale = 1;
};

/// The variant that is meant, with what commissioning found.
struct ChosenRobot {
  RobotModel model;
  UsedSettings settings;
};
/// @error  ready to be printed: no such robot, or its options do not fit it
std::expected<ChosenRobot, Outcome> choose_robot(const RobotOptions& options);

/// `NAME` as a position journal may be called.
/// @error  bad input: what a name is
std::expected<void, Outcome> check_journal_name(const std::optional<std::string>& name);

/// How a verb wants its cell.
struct LocalCellOptions {
  runtime::CellFolders folders{};  ///< where records go; positions are kept in the state folder
  std::string byte_log{};          ///< a file for every byte of the wire; empty: none
  bool assumes_start = false;      ///< as StationOptions::assumes_start
};

/// A cell of one robot in this process: the station, controller, collision check and journal of
/// `sinew serve`, for verbs that work without a running cell. This thread is its one client.
class LocalCell {
 public:
  static constexpr control::ClientId kClient = 1;

  /// @param robot  as chosen by `where`
  /// @error  the port cannot be opened, or is held by a cell that runs; the journal cannot be had
  static std::expected<std::unique_ptr<LocalCell>, Outcome> start(const RobotModel& robot,
                                                                  const RobotOptions& where,
                                                                  LocalCellOptions options = {});
  LocalCell(const LocalCell&) = delete;
  LocalCell& operator=(const LocalCell&) = delete;

  runtime::Station& station() const { return running_->station(0); }
  runtime::JobRunner& jobs() const { return running_->jobs(0); }
  /// Renews the lease of what runs here, and waits for the next cycle.
  void turn();
  /// Gives a command and waits for its end; Ctrl-C stops what is under way.
  /// @return  the event that ended it
  control::ControlEvent carry_out(const control::CommandWhat& what);
  /// Takes control and enables the machine. @return  why it is not ready; nothing where it is
  std::optional<Error> enable();
  /// Why a command of it failed, for people: with its port, and what to check.
  std::string sentence(const Error& error) const;

 private:
  LocalCell() = default;
  void renew();

  std::unique_ptr<runtime::RunningCell> running_;
  std::unique_ptr<runtime::StationClient> client_;
  io::Clock real_;
};

/// Leaves a cell as it is, for a process that ends at once: what is under way goes on, unseen.
void abandon(std::unique_ptr<LocalCell> cell);

/// Whether it is a machine, and not a simulated device on some kind of port.
bool is_real(const std::optional<std::string>& port);

}  // namespace sinew::cli
