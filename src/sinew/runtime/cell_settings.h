#pragma once

#include <expected>
#include <string>
#include <vector>

#include "sinew/io/io_error.h"
#include "sinew/model/cell.h"
#include "sinew/program/procedures/procedures.h"
#include "sinew/runtime/journal/text_shelf.h"

namespace sinew::runtime {

/// What was set of a robot beside its cell's file, by name: `port` ("simulated": none), `profile`,
/// `wire`, and what program::use_settings() knows: `joint.base.trim_rad`.
using RobotSettings = program::FoundSettings;

/// What a robot of a cell is made of before anything is set.
struct RobotMaking {
  RobotModel model;       ///< of its own file
  CellRobot place;        ///< as in the cell's file
  RobotSettings found{};  ///< in the settings file that the cell's names
};

/// A robot as it is to run.
struct MadeRobot {
  CellRobot place;
  RobotModel model;
};

/// What is wrong with a setting.
struct SettingComplaint {
  std::string name;  ///< of the setting; empty where all of them together are meant
  std::string sentence;
};

/// Settings of a cell's robots that people make while it runs. They lie in a file of their own and
/// count from the next start on; the cell's file and the robots' are never written. For one thread.
class CellSettings {
 public:
  static constexpr const char* kSimulated = "simulated";

  /// @param file  where they lie
  /// @param cell  whose they are, for people and against a mix-up
  CellSettings(std::string file, std::string cell, double time_scale,
               std::vector<RobotMaking> robots);

  /// Reads the file, where there is one.
  /// @error  a sentence: it cannot be read, or does not fit the cell (any more)
  std::expected<void, std::string> load();

  const std::string& file() const { return file_; }
  std::uint64_t revision() const { return revision_; }
  /// Whether anything is set of this robot; then that counts in place of all that was found of its
  /// device.
  bool is_set(std::size_t robot) const { return saved_.contains(name(robot)); }
  /// All that can be said of this robot, as its own files have it, and with what is set.
  RobotSettings own(std::size_t robot) const;
  RobotSettings now(std::size_t robot) const;
  /// Names of what can be set of its device.
  std::vector<std::string> settable(std::size_t robot) const;
  std::vector<std::string> wires(std::size_t robot) const;
  /// With this wire.
  std::vector<std::string> profiles(std::size_t robot, const RobotSettings& settings) const;

  /// With what is set; as its files say where nothing is.
  std::expected<MadeRobot, std::vector<SettingComplaint>> make(std::size_t robot) const;
  /// With these in place of what is set; what they do not name is as in the cell's file, but of the
  /// device nothing else counts. Held against what a cell's file is held against.
  std::expected<MadeRobot, std::vector<SettingComplaint>> make(std::size_t robot,
                                                               const RobotSettings& settings) const;
  /// Keeps them; none: its own files count again. Nothing is looked at: make() does.
  /// @param revision  of the file as the client knows it
  ShelfResult<void> save(std::size_t robot, const RobotSettings& settings, std::uint64_t revision);

 private:
  const std::string& name(std::size_t robot) const { return robots_[robot].place.name; }
  std::expected<void, std::string> read(const std::string& text);

  std::optional<std::string> who_has(const std::string& port, std::size_t but_for) const;

  std::string file_;
  std::string cell_;
  double time_scale_;
  std::vector<RobotMaking> robots_;
  std::map<std::string, RobotSettings> saved_;  ///< by robot
  std::uint64_t revision_ = 0;
};

/// $XDG_STATE_HOME/sinew/settings/NAME-HASH.json, of the cell's file wherever it is called from.
/// @param cell_file  empty: the built-in cell
io::IoResult<std::string> settings_path(const std::string& cell_file);
/// The same for where its baskets were moved to: settings/NAME-HASH.baskets.json.
io::IoResult<std::string> baskets_path(const std::string& cell_file);
/// The same for its events: events/NAME-HASH.jsonl.
io::IoResult<std::string> events_path(const std::string& cell_file);

}  // namespace sinew::runtime
