#include <fmt/format.h>

#include <algorithm>

#include "sinew/config/points_file.h"
#include "sinew/core/rotation.h"
#include "sinew/io/disk_folder.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/planning/paths/tool_space.h"
#include "sinew/runtime/journal/position_record.h"
#include "sinew/runtime/records/unit_name.h"
#include "sinew/server/files/keeper.h"
#include "sinew/server/json/robot_json.h"

namespace sinew::server {
namespace {

using runtime::ShelfRefusal;
using runtime::TextShelf;

constexpr const char* kPointsFile = "points.toml";
constexpr std::string_view kProgramEnding = ".sinew";
constexpr Duration kTurnPatience = std::chrono::seconds(2);

std::unexpected<RpcError> not_kept(std::string sentence, const char* code) {
  return std::unexpected(RpcError{RpcCode::kRefused, std::move(sentence), {{"code", code}}});
}

/// @param what  "the program 'wave'", "the points"
/// @param known  the revision that the client brought
std::unexpected<RpcError> not_kept(const std::string& what, const ShelfRefusal& why,
                                   std::uint64_t known) {
  switch (why.code) {
    case ShelfRefusal::Code::kMissing:
      return not_kept("there is no file of " + what, "missing");
    case ShelfRefusal::Code::kConflict: {
      std::string how = "somebody else has changed " + what + " since it was opened here";
      if (known == 0) how = "there is a file of " + what + " already";
      if (why.revision == 0)
        how = "somebody else has removed " + what + " since it was opened here";
      return std::unexpected(RpcError{RpcCode::kRefused,
                                      how + "; nothing was changed",
                                      {{"code", "conflict"}, {"revision", why.revision}}});
    }
    case ShelfRefusal::Code::kTooLarge:
      return not_kept(fmt::format("{}: more than {} bytes are not kept", what, TextShelf::kTextMax),
                      "too_large");
    case ShelfRefusal::Code::kTooMany:
      return not_kept(fmt::format("{} would be one more than the {} that are kept; remove some",
                                  what, TextShelf::kTextsMax),
                      "too_many");
    case ShelfRefusal::Code::kDisk:
      break;
  }
  return not_kept(what + ": " + runtime::sentence(why.disk) + "; what was kept is as it was",
                  "disk");
}

bool is_utf8(const std::string& text) {
  using Handler = Json::error_handler_t;
  const Json json(text);
  return json.dump(-1, ' ', false, Handler::ignore) == json.dump(-1, ' ', false, Handler::replace);
}

std::string called(const std::string& name) {
  return "the program '" + name + "'";
}

std::expected<void, RpcError> check_name_of(const char* param, const std::string& name) {
  if (is_point_name(name)) return {};
  return std::unexpected(
      invalid(std::string(param) + " is a letter and then letters, digits, - and _, 40 at most"));
}

Json point_json(const TaughtPoint& point, const RobotModel& model,
                const planning::ToolSpace& space) {
  Json json{{"name", point.name}, {"robot", point.robot}};
  if (const auto* q = std::get_if<JointVector>(&point.place)) {
    json[runtime::with_units("position", model)] = std::vector<double>(q->begin(), q->end());
    if (const auto X_BT = space.forward({q->data(), q->size()}, space.home())) {
      json["pose"] = pose_json(X_BT->p, X_BT->R);
    }
  } else {
    const auto& place = std::get<ToolPlace>(point.place);
    Json tool{{"x_m", place.p_BT.x}, {"y_m", place.p_BT.y}, {"z_m", place.p_BT.z}};
    if (place.R_BT) tool["quaternion_wxyz"] = quaternion_wxyz(*place.R_BT);
    if (place.pitch) tool["pitch_rad"] = *place.pitch;
    if (place.roll) tool["roll_rad"] = *place.roll;
    json["tool"] = std::move(tool);
  }
  if (!point.source.empty()) json["source"] = point.source;
  if (!point.taught_at.empty()) json["taught_at"] = point.taught_at;
  return json;
}

/// Why a point is none of this robot's; empty where it is.
std::string misfit(const TaughtPoint& point, const RobotModel& model) {
  if (point.robot != model.id) {
    return "the point '" + point.name + "' is of " + point.robot + ", not of " + model.id;
  }
  const auto* q = std::get_if<JointVector>(&point.place);
  if (q == nullptr) return {};
  return misfit_of_joints(point, model);
}

}  // namespace

std::string Keeper::shelf_folder(std::size_t robot) const {
  const std::string& folder = cell_.folders().programs;
  return folder.empty() ? folder : folder + "/" + cell_.station(robot).robot().id;
}

/// While nobody else changes files of that folder, in this process or another.
Keeper::Result Keeper::at_shelf(std::size_t robot,
                                const std::function<Result(TextShelf&)>& work) const {
  const std::string folder = shelf_folder(robot);
  if (folder.empty()) return not_kept("this cell keeps no programs and points", "none");
  auto disk = io::DiskFolder::open_folder(folder);
  if (!disk) return not_kept(disk.error().sentence, "disk");
  const auto turn = io::FolderTurn::take(folder + "/" + kPointsFile, kTurnPatience);
  if (!turn) return not_kept(turn.error().sentence, "disk");
  TextShelf shelf(*disk);
  return work(shelf);
}

Keeper::Result Keeper::list_programs(std::size_t robot) {
  return at_shelf(robot, [&](TextShelf& shelf) -> Result {
    const auto entries = shelf.list(kProgramEnding);
    if (!entries) return not_kept("the programs", entries.error(), 0);
    Json rows = Json::array();
    for (const TextShelf::Entry& one : *entries) {
      const std::string name = one.name.substr(0, one.name.size() - kProgramEnding.size());
      if (!is_point_name(name)) continue;
      rows.push_back({{"name", name},
                      {"revision", one.revision},
                      {"size_bytes", one.size},
                      {"changed_ms", one.changed_ns / 1'000'000}});
    }
    return Json{{"folder", shelf_folder(robot)}, {"programs", std::move(rows)}};
  });
}

Keeper::Result Keeper::load_program(std::size_t robot, const std::string& name) {
  if (const auto fine = check_name_of("name", name); !fine) return std::unexpected(fine.error());
  return at_shelf(robot, [&](TextShelf& shelf) -> Result {
    auto text = shelf.read(name + std::string(kProgramEnding));
    if (!text) return not_kept(called(name), text.error(), 0);
    if (!is_utf8(text->text)) return not_kept(called(name) + " is no text in UTF-8", "no_text");
    return Json{{"name", name}, {"text", std::move(text->text)}, {"revision", text->revision}};
  });
}

Keeper::Result Keeper::save_program(std::size_t robot, const std::string& name,
                                    const std::string& text, std::uint64_t revision) {
  if (const auto fine = check_name_of("name", name); !fine) return std::unexpected(fine.error());
  return at_shelf(robot, [&](TextShelf& shelf) -> Result {
    const auto saved = shelf.save(name + std::string(kProgramEnding), text, revision);
    if (!saved) return not_kept(called(name), saved.error(), revision);
    ++changes_;
    return Json{{"name", name}, {"revision", *saved}};
  });
}

Keeper::Result Keeper::remove_program(std::size_t robot, const std::string& name,
                                      std::uint64_t revision) {
  if (const auto fine = check_name_of("name", name); !fine) return std::unexpected(fine.error());
  return at_shelf(robot, [&](TextShelf& shelf) -> Result {
    const auto removed = shelf.remove(name + std::string(kProgramEnding), revision);
    if (!removed) return not_kept(called(name), removed.error(), revision);
    ++changes_;
    return Json::object();
  });
}

Json Keeper::points_json(std::size_t robot, const std::string& toml, std::uint64_t revision,
                         const TaughtPoints& points) const {
  const RobotModel& model = cell_.station(robot).robot();
  const planning::ToolSpace space(model);
  Json rows = Json::array();
  for (const TaughtPoint& one : points) {
    if (misfit(one, model).empty()) rows.push_back(point_json(one, model, space));
  }
  return {{"file", shelf_folder(robot) + "/" + kPointsFile},
          {"revision", revision},
          {"size_bytes", toml.size()},
          {"points", std::move(rows)}};
}

Keeper::Result Keeper::list_points(std::size_t robot) {
  return at_shelf(robot, [&](TextShelf& shelf) -> Result {
    const auto text = shelf.read(kPointsFile);
    const bool none = !text && text.error().code == ShelfRefusal::Code::kMissing;
    if (none) return points_json(robot, "", 0, {});
    if (!text) return not_kept("the points", text.error(), 0);
    const auto points = read_points(text->text, kPointsFile);
    if (!points) return std::unexpected(complained(points.error()));
    return points_json(robot, text->text, text->revision, *points);
  });
}

/// Remarks in the file, and what somebody has written there by hand, stay.
Keeper::Result Keeper::change_points(
    std::size_t robot, std::uint64_t revision,
    const std::function<Changed(const std::string& toml)>& change) {
  return at_shelf(robot, [&](TextShelf& shelf) -> Result {
    auto before = shelf.read(kPointsFile);
    const bool none = !before && before.error().code == ShelfRefusal::Code::kMissing;
    if (!before && !none) return not_kept("the points", before.error(), revision);
    const std::string old = none ? "" : before->text;
    const std::uint64_t there = none ? 0 : before->revision;
    if (there != revision) {
      return not_kept("the points", {ShelfRefusal::Code::kConflict, there, {}}, revision);
    }
    const auto text = change(old);
    if (!text) return std::unexpected(complained(text.error()));
    const auto points = read_points(*text, kPointsFile);
    if (!points) return std::unexpected(complained(points.error()));
    const auto saved = shelf.save(kPointsFile, *text, revision);
    if (!saved) return not_kept("the points", saved.error(), revision);
    ++changes_;
    return points_json(robot, *text, *saved, *points);
  });
}

Keeper::Result Keeper::save_points(std::size_t robot, const std::string& toml,
                                   std::uint64_t revision) {
  const auto more = read_points(toml, "points");
  if (!more) return std::unexpected(complained(more.error()));
  if (more->empty()) return std::unexpected(invalid("points has no point"));
  for (const TaughtPoint& point : *more) {
    const std::string why = misfit(point, cell_.station(robot).robot());
    if (!why.empty()) return std::unexpected(invalid(why));
  }
  return change_points(robot, revision, [&](const std::string& old) -> Changed {
    std::string text = old;
    for (const TaughtPoint& point : *more) {
      auto next = with_point(text, kPointsFile, point);
      if (!next) return next;
      text = std::move(*next);
    }
    return text;
  });
}

Keeper::Result Keeper::remove_point(std::size_t robot, const std::string& name,
                                    std::uint64_t revision) {
  if (const auto fine = check_name_of("name", name); !fine) return std::unexpected(fine.error());
  return change_points(robot, revision, [&](const std::string& old) -> Changed {
    return without_point(old, kPointsFile, name);
  });
}

Keeper::Result Keeper::rename_point(std::size_t robot, const std::string& name,
                                    const std::string& to, std::uint64_t revision) {
  for (const auto& [param, one] : {std::pair{"name", &name}, {"to", &to}}) {
    if (const auto fine = check_name_of(param, *one); !fine) return std::unexpected(fine.error());
  }
  return change_points(robot, revision, [&](const std::string& old) -> Changed {
    return with_point_renamed(old, kPointsFile, name, to);
  });
}

std::expected<std::string, std::string> Keeper::kept_program(std::size_t robot,
                                                             std::string_view name) const {
  const std::string file = shelf_folder(robot) + "/" + std::string(name) + ".sinew";
  auto text = io::read_file(file, TextShelf::kTextMax);
  if (!text) return std::unexpected(text.error().sentence);
  return std::move(*text);
}

std::expected<std::string, std::string> Keeper::kept_points(std::size_t robot) const {
  const std::string file = shelf_folder(robot) + "/" + kPointsFile;
  if (!io::exists(file)) return std::string();
  auto text = io::read_file(file, TextShelf::kTextMax);
  if (!text) return std::unexpected(text.error().sentence);
  return std::move(*text);
}

}  // namespace sinew::server
