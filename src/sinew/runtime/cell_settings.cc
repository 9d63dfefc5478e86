#include "sinew/runtime/cell_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "sinew/config/cell_file.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/disk_folder.h"
#include "sinew/io/file.h"
#include "sinew/runtime/journal/position_record.h"
#include "sinew/runtime/links/robot_link.h"
#include "sinew/runtime/links/robot_variant.h"

namespace sinew::runtime {
namespace {

using Json = nlohmann::ordered_json;
using Complaints = std::vector<SettingComplaint>;

constexpr int kSettingsVersion = 1;
constexpr std::string_view kOfPlace[] = {"port", "profile", "wire"};
constexpr Duration kTurnPatience = std::chrono::seconds(2);

bool of_place(std::string_view name) {
  return std::ranges::find(kOfPlace, name) != std::end(kOfPlace);
}

/// What TOML and JSON write alike.
std::string quoted_text(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// A robot's row of a cell's file, read as such a file is.
void check_as_cell_file(const CellRobot& place, double time_scale, Complaints& complaints) {
  std::string toml = fmt::format("title = \"settings\"\ntime_scale = {:f}\n[[robot]]\nname = {}\n",
                                 time_scale, quoted_text(place.name));
  toml += "robot = " + quoted_text(place.robot) + "\n";
  if (place.port) toml += "port = " + quoted_text(*place.port) + "\n";
  if (place.profile) toml += "profile = " + quoted_text(*place.profile) + "\n";
  if (place.time_scale) toml += fmt::format("time_scale = {:f}\n", *place.time_scale);
  if (place.wire) toml += "wire = " + quoted_text(*place.wire) + "\n";
  const auto read = read_cell(toml, "settings");
  if (read) return;
  for (const Complaint& one : read.error()) {
    const std::string name = one.key.substr(one.key.rfind('.') + 1);
    complaints.push_back({name == "time_scale" ? "port" : name, one.message});
  }
}

/// Whoever reaches the panel sets this: no file of the computer is opened as if it were a device.
bool may_be_set_as_port(const std::string& port) {
  const bool device = port.starts_with("/dev/") && !port.contains("..");
  return device || port == "spidev" || port.starts_with("simwire:") || port.starts_with("tcp:");
}

std::string without_option(std::string sentence) {
  for (const char* option : {"--profile: ", "--wire: ", "--without: "}) {
    if (sentence.starts_with(option)) sentence.erase(0, std::string_view(option).size());
  }
  return sentence;
}

std::string device_sentence(const std::string& name, const std::string& value,
                            const RobotModel& model) {
  if (name.ends_with(".trim_rad") && model.device.settings->trim_max() > 0) {
    const double most = to_deg(model.device.settings->trim_max());
    return fmt::format("a trim is a number from {:.0f} to {:.0f} degrees", -most, most);
  }
  if (name.ends_with(".servo_id")) return "a servo's number is 1 to 253";
  if (name.ends_with("turn")) return "the sense of rotation is 'other', or not set";
  return "'" + printable(value) + "' is no setting of " + model.id;
}

/// Each by itself, so that all that is wrong is told at its place; then all together, since two
/// servos may change their numbers with each other.
void use_device(const RobotSettings& device, RobotModel& model, Complaints& complaints) {
  const std::size_t before = complaints.size();
  for (const auto& [name, value] : device) {
    RobotModel alone = model;
    const auto used = program::use_settings(alone, {{name, value}});
    if (used || used.error().contains(" would be ")) continue;
    complaints.push_back({name, device_sentence(name, value, model)});
  }
  if (complaints.size() != before) return;
  if (const auto used = program::use_settings(model, device); !used) {
    complaints.push_back({"", used.error()});
  }
}

}  // namespace

CellSettings::CellSettings(std::string file, std::string cell, double time_scale,
                           std::vector<RobotMaking> robots)
    : file_(std::move(file)),
      cell_(std::move(cell)),
      time_scale_(time_scale),
      robots_(std::move(robots)) {}

std::expected<void, std::string> CellSettings::load() {
  saved_.clear();
  revision_ = 0;
  if (!io::exists(file_)) return {};
  const auto text = io::read_file(file_, TextShelf::kTextMax);
  if (!text) return std::unexpected(text.error().sentence);
  if (auto fine = read(*text); !fine) {
    saved_.clear();
    return std::unexpected(file_ + ": " + fine.error());
  }
  revision_ = revision_of(*text);
  return {};
}

std::expected<void, std::string> CellSettings::read(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  const Json robots = json.is_object() ? json.value("robots", Json()) : Json();
  if (!robots.is_object() || json.value("version", Json()) != kSettingsVersion) {
    return std::unexpected("is no file of settings of this version");
  }
  if (json.value("cell", Json()) != cell_) {
    return std::unexpected("is another cell's than " + cell_);
  }
  for (const auto& [robot, one] : robots.items()) {
    const auto found = std::ranges::find(
        robots_, robot, [](const RobotMaking& making) { return making.place.name; });
    if (found == robots_.end()) continue;  // it has been taken out of the cell
    const Json settings = one.is_object() ? one.value("settings", Json()) : Json();
    if (!settings.is_object()) return std::unexpected(robot + ": its settings cannot be read");
    if (one.value("robot", Json()) != found->model.id) {
      return std::unexpected(robot + " is another robot than these settings are for; it is " +
                             found->model.id + " now");
    }
    RobotSettings& saved = saved_[robot];
    for (const auto& [name, value] : settings.items()) {
      if (!value.is_string())
        return std::unexpected(robot + ": " + printable(name) + " is no text");
      saved[name] = value.get<std::string>();
    }
  }
  return {};
}

RobotSettings CellSettings::own(std::size_t robot) const {
  const RobotMaking& making = robots_[robot];
  RobotSettings settings = making.found;
  settings["port"] = making.place.port.value_or(kSimulated);
  const auto all_wires = wires(robot);
  if (!all_wires.empty()) settings["wire"] = making.place.wire.value_or(all_wires.front());
  const auto all_profiles = profiles(robot, settings);
  if (!all_profiles.empty()) {
    settings["profile"] = making.place.profile.value_or(all_profiles.front());
  }
  return settings;
}

RobotSettings CellSettings::now(std::size_t robot) const {
  const auto saved = saved_.find(name(robot));
  RobotSettings settings = own(robot);
  if (saved == saved_.end()) return settings;
  std::erase_if(settings, [](const auto& one) { return !of_place(one.first); });
  for (const auto& [name, value] : saved->second) settings[name] = value;
  return settings;
}

std::vector<std::string> CellSettings::settable(std::size_t robot) const {
  std::vector<std::string> names;
  const auto try_out = [&](const std::string& name, const char* value) {
    RobotModel model = robots_[robot].model;
    if (program::use_settings(model, {{name, value}})) names.push_back(name);
  };
  for (const Joint& joint : robots_[robot].model.joints) {
    const std::string head = "joint." + joint.name + ".";
    try_out(head + "turn", "other");
    try_out(head + "trim_rad", "0");
    try_out(head + "servo_id", "253");
  }
  try_out("jaws_turn", "other");
  try_out("units_per_down", "1");
  try_out("way_factor", "1");
  return names;
}

std::vector<std::string> CellSettings::wires(std::size_t robot) const {
  return robots_[robot].model.device.settings->wires();
}

std::vector<std::string> CellSettings::profiles(std::size_t robot,
                                                const RobotSettings& settings) const {
  const auto wire = settings.find("wire");
  const auto model =
      variant_of(robots_[robot].model, std::nullopt,
                 wire != settings.end() ? std::optional(wire->second) : robots_[robot].place.wire);
  return model ? model->device.settings->profiles() : std::vector<std::string>();
}

/// Of a device, which belongs to one robot; boards behind simwire may share it.
std::optional<std::string> CellSettings::who_has(const std::string& port,
                                                 std::size_t but_for) const {
  const bool shared = !port.starts_with("/dev/") && !port.starts_with("tcp:");
  if (shared) return std::nullopt;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    // What the cell's own file says of both is not for us to judge.
    const bool set = is_set(i) || robots_[but_for].place.port != port;
    if (i == but_for || !set) continue;
    const RobotSettings settings = now(i);
    const auto theirs = settings.find("port");
    if (theirs == settings.end()) continue;
    if (theirs->second == port || io::same_file(theirs->second, port)) return name(i);
  }
  return std::nullopt;
}

std::expected<MadeRobot, Complaints> CellSettings::make(std::size_t robot) const {
  const auto saved = saved_.find(name(robot));
  if (saved != saved_.end()) return make(robot, saved->second);
  RobotSettings settings = robots_[robot].found;
  auto made = make(robot, settings);
  if (made) made->place.settings = robots_[robot].place.settings;
  return made;
}

std::expected<MadeRobot, Complaints> CellSettings::make(std::size_t robot,
                                                        const RobotSettings& settings) const {
  const RobotMaking& making = robots_[robot];
  MadeRobot made{making.place, {}};
  RobotSettings device;
  for (const auto& [name, value] : settings) {
    if (name == "port") made.place.port = value;
    if (name == "profile") made.place.profile = value;
    if (name == "wire") made.place.wire = value;
    if (!of_place(name)) device[name] = value;
  }
  if (made.place.port == kSimulated) made.place.port.reset();
  made.place.settings = device.empty() ? std::nullopt : std::optional(file_);
  Complaints complaints;
  check_as_cell_file(made.place, time_scale_, complaints);
  const auto& port = made.place.port;
  if (port && port != making.place.port && !may_be_set_as_port(*port)) {
    complaints.push_back(
        {"port",
         "a port is 'simulated', a device as /dev/ttyUSB0, tcp:HOST:PORT, spidev, or "
         "simwire:unix:PATH or simwire:tcp:HOST:PORT"});
  }
  if (port) {
    if (const auto other = who_has(*port, robot)) {
      complaints.push_back({"port", *other + " has this port already"});
    }
  }
  auto variant = variant_of(making.model, made.place.profile, made.place.wire, made.place.without);
  if (!variant) {
    std::string name = variant.error().starts_with("--wire") ? "wire" : "profile";
    if (variant.error().starts_with("--without")) name = "without";
    complaints.push_back({name, without_option(variant.error())});
    return std::unexpected(std::move(complaints));
  }
  if (port && complaints.empty()) {
    if (auto wrong = wrong_port(*variant, *port)) complaints.push_back({"port", *wrong});
  }
  use_device(device, *variant, complaints);
  if (!complaints.empty()) return std::unexpected(std::move(complaints));
  made.model = std::move(*variant);
  return made;
}

ShelfResult<void> CellSettings::save(std::size_t robot, const RobotSettings& settings,
                                     std::uint64_t revision) {
  const std::filesystem::path path(file_);
  const auto denied = [] {
    return std::unexpected(ShelfRefusal{ShelfRefusal::Code::kDisk, 0, {DiskErrorCode::kDenied, 0}});
  };
  auto disk = io::DiskFolder::open_folder(path.parent_path().string());
  if (!disk) return denied();
  const auto turn = io::FolderTurn::take(file_, kTurnPatience);
  if (!turn) return denied();
  auto saved = saved_;
  if (settings.empty()) {
    saved.erase(name(robot));
  } else {
    saved[name(robot)] = settings;
  }
  Json robots = Json::object();
  for (const RobotMaking& one : robots_) {
    const auto found = saved.find(one.place.name);
    if (found == saved.end()) continue;
    Json rows = Json::object();
    for (const auto& [key, value] : found->second) rows[key] = value;
    robots[one.place.name] = {{"robot", one.model.id}, {"settings", std::move(rows)}};
  }
  const Json json{{"version", kSettingsVersion}, {"cell", cell_}, {"robots", std::move(robots)}};
  const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  const auto kept = TextShelf(*disk).save(path.filename().string(), text, revision);
  if (!kept) return std::unexpected(kept.error());
  saved_.swap(saved);
  revision_ = *kept;
  return {};
}

namespace {

/// What a cell's files are called by: one name wherever its own is called from.
std::string name_of_cell(const std::string& cell_file) {
  if (cell_file.empty()) return "builtin";
  std::error_code error;
  const auto path = std::filesystem::weakly_canonical(cell_file, error);
  std::string stem = path.stem().string().substr(0, 40);
  std::ranges::replace_if(
      stem,
      [](char c) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        return !letter && !(c >= '0' && c <= '9') && c != '-' && c != '_';
      },
      '-');
  return fmt::format("{}-{:013x}", stem, revision_of(path.string()));
}

}  // namespace

io::IoResult<std::string> settings_path(const std::string& cell_file) {
  const auto folder = settings_folder();
  if (!folder) return folder;
  return *folder + "/" + name_of_cell(cell_file) + ".json";
}

io::IoResult<std::string> baskets_path(const std::string& cell_file) {
  const auto folder = settings_folder();
  if (!folder) return folder;
  return *folder + "/" + name_of_cell(cell_file) + ".baskets.json";
}

io::IoResult<std::string> events_path(const std::string& cell_file) {
  const auto folder = events_folder();
  if (!folder) return folder;
  return *folder + "/" + name_of_cell(cell_file) + ".jsonl";
}

}  // namespace sinew::runtime
