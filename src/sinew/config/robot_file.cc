#include "sinew/config/robot_file.h"

#include <algorithm>
#include <utility>

#include "sinew/config/read_collision.h"
#include "sinew/config/read_device.h"
#include "sinew/config/read_dynamics.h"
#include "sinew/config/read_geometry.h"
#include "sinew/config/read_joints.h"
#include "sinew/toml/table_reader.h"

namespace sinew {
namespace {

constexpr std::size_t kMaxIdBytes = 32;
constexpr std::size_t kMaxTitleBytes = 120;

bool good_id(std::string_view id) {
  const bool plain = std::ranges::all_of(
      id, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; });
  return plain && id.front() != '-' && id.back() != '-';
}

void read_root(TableReader& root, RobotModel& model) {
  root.source_of_all();
  if (root.text("id", kMaxIdBytes, model.id) && !good_id(model.id)) {
    root.complain("id", "must be lower-case letters, digits and - between them");
  }
  root.text("title", kMaxTitleBytes, model.title);
  if (const std::optional<GeometryKind> kind = read_geometry(root, model.geometry)) {
    read_joints(root, *kind, model);
    read_device(root, model);
    read_dynamics(root, model);
    read_collision(root, model);
    check_device(root, model);
  } else {
    root.ignore_rest();
  }
  root.finish();
}

}  // namespace

std::expected<RobotFile, std::vector<Complaint>> read_robot_file(std::string_view toml,
                                                                 std::string_view file_name) {
  const auto tree = parse_toml_file(toml, file_name);
  if (!tree) return std::unexpected(tree.error());
  Findings findings{std::string(file_name)};
  TableReader root(*tree, Place{}, "", findings);
  RobotFile file;
  read_root(root, file.model);
  if (!findings.clean()) return std::unexpected(findings.take_complaints());
  file.sources = findings.take_sources();
  return file;
}

std::expected<RobotModel, std::vector<Complaint>> read_robot(std::string_view toml,
                                                             std::string_view file_name) {
  std::expected<RobotFile, std::vector<Complaint>> file = read_robot_file(toml, file_name);
  if (!file) return std::unexpected(std::move(file.error()));
  return std::move(file->model);
}

}  // namespace sinew
