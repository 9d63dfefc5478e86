#include <algorithm>

#include "sinew/io/file.h"
#include "sinew/runtime/commissioning_file.h"
#include "sinew/runtime/journal/position_record.h"
#include "sinew/server/files/keeper.h"

namespace sinew::server {
namespace {

using runtime::RobotSettings;
using runtime::SettingComplaint;

Json settings_json(const RobotSettings& settings) {
  Json json = Json::object();
  for (const auto& [name, value] : settings) json[name] = value;
  return json;
}

Json complaints_json(const std::vector<SettingComplaint>& complaints) {
  Json list = Json::array();
  for (const SettingComplaint& one : complaints) {
    list.push_back({{"name", one.name}, {"sentence", one.sentence}});
  }
  return list;
}

std::unexpected<RpcError> nothing_is_set() {
  return std::unexpected(RpcError{
      RpcCode::kRefused, "this cell keeps no settings beside its file", {{"code", "none"}}});
}

std::unexpected<RpcError> not_set(const std::string& file, const runtime::ShelfRefusal& why) {
  if (why.code == runtime::ShelfRefusal::Code::kConflict) {
    return std::unexpected(
        RpcError{RpcCode::kRefused,
                 "somebody else has changed the settings since they were read; nothing was changed",
                 {{"code", "conflict"}, {"revision", why.revision}}});
  }
  return std::unexpected(
      RpcError{RpcCode::kRefused,
               file + ": " + runtime::sentence(why.disk) + "; the settings are as they were",
               {{"code", "disk"}}});
}

}  // namespace

Keeper::Keeper(const runtime::RunningCell& cell, runtime::CellSettings* settings)
    : cell_(cell), records_(cell.folders().flight), settings_(settings) {
  for (std::size_t i = 0; settings_ != nullptr && i < cell_.size(); ++i) {
    running_.push_back(settings_->now(i));
  }
}

Keeper::Result Keeper::get_settings(std::size_t robot) {
  if (settings_ == nullptr) return nothing_is_set();
  const RobotSettings now = settings_->now(robot);
  Json json{{"robot", cell_.station(robot).name()},        {"file", settings_->file()},
            {"revision", settings_->revision()},           {"is_set", settings_->is_set(robot)},
            {"own", settings_json(settings_->own(robot))}, {"now", settings_json(now)},
            {"running", settings_json(running_[robot])},   {"restart", now != running_[robot]},
            {"settable", settings_->settable(robot)},      {"wires", settings_->wires(robot)},
            {"profiles", settings_->profiles(robot, now)}};
  const std::string results = runtime::results_file(cell_.folders(), cell_.station(robot));
  if (!results.empty() && io::exists(results)) {
    const auto found = runtime::read_commissioning(results, cell_.station(robot).robot());
    if (found && found->finished) json["found"] = settings_json(found->settings);
  }
  return json;
}

Keeper::Result Keeper::check_settings(std::size_t robot, const RobotSettings& settings) const {
  if (settings_ == nullptr) return nothing_is_set();
  Json json{{"fine", true},
            {"complaints", Json::array()},
            {"profiles", settings_->profiles(robot, settings)}};
  const auto made = settings_->make(robot, settings);
  if (!made) {
    json["fine"] = false;
    json["complaints"] = complaints_json(made.error());
  }
  return json;
}

Keeper::Result Keeper::set_settings(std::size_t robot, const RobotSettings& settings,
                                    std::uint64_t revision) {
  if (settings_ == nullptr) return nothing_is_set();
  if (const auto made = settings_->make(robot, settings); !made) {
    return std::unexpected(
        RpcError{RpcCode::kRefused,
                 made.error().front().sentence + "; nothing was changed",
                 {{"code", "unfit"}, {"complaints", complaints_json(made.error())}}});
  }
  if (const auto saved = settings_->save(robot, settings, revision); !saved) {
    return not_set(settings_->file(), saved.error());
  }
  ++changes_;
  return get_settings(robot);
}

}  // namespace sinew::server
