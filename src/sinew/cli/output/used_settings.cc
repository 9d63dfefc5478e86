#include "sinew/cli/output/used_settings.h"

#include <utility>

#include "sinew/io/file.h"
#include "sinew/runtime/commissioning_file.h"

namespace sinew::cli {
namespace {

/// The usual settings file of a robot; empty if there is none.
std::string usual_settings(const RobotModel& robot) {
  const auto usual = runtime::commissioning_path(robot.id);
  // Without a state folder nothing was ever kept.
  return usual && io::exists(*usual) ? *usual : std::string();
}

}  // namespace

void tell_settings(const UsedSettings& settings, Outcome& outcome) {
  if (!settings.file.empty()) {
    outcome.json["settings"] = settings.file;
    outcome.text += "  note: with what commissioning found, " + settings.file + "\n";
  }
  if (!settings.note.empty()) {
    outcome.json["settings_note"] = settings.note;
    outcome.text += "  note: " + settings.note + "\n";
  }
}

std::expected<FileSettings, std::string> read_settings_file(const RobotModel& robot,
                                                            const std::string& path) {
  const auto file = runtime::read_commissioning(path, robot);
  if (!file) return std::unexpected(file.error());
  if (!file->finished) {
    return std::unexpected(path +
                           ": its list was not finished, and what it found does not count: "
                           "sinew commission goes on with it");
  }
  FileSettings settings{file->settings, {}};
  if (!file->under_way.empty()) {
    settings.note =
        "another commissioning was begun and not finished; what the one before it "
        "found counts: " +
        path;
  }
  return settings;
}

std::expected<UsedSettings, std::string> use_settings_file(RobotModel& robot,
                                                           const std::string& path) {
  auto read = read_settings_file(robot, path);
  if (!read) return std::unexpected(read.error());
  if (const auto used = program::use_settings(robot, read->settings); !used) {
    return std::unexpected(path + ": " + used.error());
  }
  return UsedSettings{read->settings.empty() ? std::string() : path, std::move(read->note)};
}

std::expected<UsedSettings, Outcome> use_commissioning(RobotModel& robot,
                                                       const std::optional<std::string>& settings,
                                                       bool real) {
  if (settings == "none" || (!settings && !real)) return UsedSettings{};
  const std::string path = settings ? *settings : usual_settings(robot);
  if (path.empty() && !settings) return UsedSettings{};
  if (!settings) {
    // A commissioning in progress does not keep other programs from running.
    const auto file = runtime::read_commissioning(path, robot);
    if (file && !file->finished) {
      return UsedSettings{{},
                          "the commissioning of this robot was not finished, and what it found "
                          "does not count: " +
                              path};
    }
  }
  auto used = use_settings_file(robot, path);
  if (used) return std::move(*used);
  return std::unexpected(could_not(settings ? "--settings: " + used.error()
                                            : used.error() + " (--settings none leaves it out)"));
}

}  // namespace sinew::cli
