#include "sinew/config/cell_file.h"

#include <algorithm>

#include "sinew/core/rotation.h"
#include "sinew/toml/table_reader.h"
#include "sinew/vision/color_names.h"

namespace sinew {
namespace {

constexpr std::size_t kNameMax = 32;
constexpr std::size_t kTitleMax = 120;
constexpr std::size_t kPathMax = 1024;
constexpr std::size_t kThingsMax = 64;
constexpr Range kReach = between(-100, 100);  // m
constexpr Range kTurn = between(-2 * kPi, 2 * kPi);
constexpr Range kScale = between(0.01, 1000);

bool good_name(std::string_view name) {
  return std::ranges::all_of(
      name, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; });
}

std::optional<std::string> optional_text(TableReader& reader, std::string_view key,
                                         std::size_t max_bytes) {
  std::string text;
  if (!reader.optional().text(key, max_bytes, text)) return std::nullopt;
  return text;
}

/// The name of one of several; what it is called in complaints from here on.
void read_name(TableReader& reader, std::string_view kind, std::vector<std::string>& taken,
               std::string& out) {
  if (!reader.text("name", kNameMax, out)) return;
  if (!good_name(out)) {
    reader.complain("name", "must be lower-case letters, digits and -");
  } else if (std::ranges::find(taken, out) != taken.end()) {
    reader.complain("name", "there is another one of this name");
  }
  taken.push_back(out);
  reader.rename(std::string(kind) + "." + out);
}

template <class A, class B>
void read_pose(TableReader& reader, Pose<A, B>& X) {
  reader.optional().quantity("x_*", kLength, kReach, X.p.x);
  reader.optional().quantity("y_*", kLength, kReach, X.p.y);
  reader.optional().quantity("z_*", kLength, kReach, X.p.z);
  Vec3 rpy;
  reader.optional().quantity("rx_*", kAngle, kTurn, rpy.x);
  reader.optional().quantity("ry_*", kAngle, kTurn, rpy.y);
  reader.optional().quantity("rz_*", kAngle, kTurn, rpy.z);
  X.R = rotation_from_fixed_xyz(rpy);
}

CellRobot read_cell_robot(TableReader& reader, std::vector<std::string>& taken) {
  CellRobot robot;
  reader.needs_no_source();
  read_name(reader, "robot", taken, robot.name);
  reader.text("robot", kPathMax, robot.robot);
  robot.profile = optional_text(reader, "profile", kNameMax);
  robot.wire = optional_text(reader, "wire", kNameMax);
  reader.optional().texts("without", kNameMax, robot.without);
  robot.settings = optional_text(reader, "settings", kPathMax);
  robot.port = optional_text(reader, "port", kPathMax);
  robot.journal = optional_text(reader, "journal", kNameMax);
  reader.optional().integer("seed", 0, INT64_MAX, robot.seed);
  double scale = 0;
  if (reader.optional().number("time_scale", kScale, scale)) robot.time_scale = scale;
  if (const auto loss = optional_text(reader, "on_client_loss", kNameMax)) {
    robot.on_client_loss = *loss == "continue" ? ClientLoss::kContinue : ClientLoss::kPause;
    if (*loss != "continue" && *loss != "pause") {
      reader.complain("on_client_loss", "has to be \"pause\" or \"continue\"");
    }
  }
  if (robot.port && robot.time_scale.value_or(1) != 1) {
    reader.complain("time_scale", "a robot on a real port keeps real time");
  }
  read_pose(reader, robot.X_WB);
  reader.finish();
  return robot;
}

CellObject read_object(TableReader& reader, std::vector<std::string>& taken) {
  constexpr Range kEdge = above_zero_to(100);
  CellObject object;
  reader.needs_no_source();
  read_name(reader, "object", taken, object.name);
  Vec3 edges;
  reader.quantity("length_*", kLength, kEdge, edges.x);
  reader.quantity("width_*", kLength, kEdge, edges.y);
  reader.quantity("height_*", kLength, kEdge, edges.z);
  object.half = 0.5 * edges;
  read_pose(reader, object.X_WX);
  reader.finish();
  return object;
}

CellCamera read_camera(TableReader& reader, std::vector<std::string>& taken) {
  constexpr Range kCube = between(0.005, 0.5);  // m
  CellCamera camera;
  read_name(reader, "camera", taken, camera.name);
  reader.needs_no_source();
  reader.text("device", kPathMax, camera.device);
  camera.calibration = optional_text(reader, "calibration", kPathMax);
  camera.hand_eye = optional_text(reader, "hand_eye", kPathMax);
  reader.optional().text("robot", kNameMax, camera.robot);
  if (camera.hand_eye.has_value() != !camera.robot.empty()) {
    reader.complain(
        "hand_eye and robot stand together: the file of sinew camera hand-eye, and the "
        "name of the robot in this cell that it was measured on");
  }
  if (camera.hand_eye && !camera.calibration) {
    reader.complain("hand_eye needs calibration, the file of sinew camera calibrate, for its lens");
  }
  reader.optional().quantity("cube_*", kLength, kCube, camera.cube);
  reader.optional().boolean("watch", camera.watch);
  read_pose(reader, camera.X_WT);
  reader.finish();
  return camera;
}

CellCube read_cube(TableReader& reader) {
  CellCube cube;
  reader.needs_no_source();
  std::string color;
  if (reader.text("color", kNameMax, color)) {
    const auto named = vision::color_named(color);
    if (!named) reader.complain("color", "has to be " + vision::color_list());
    cube.color = static_cast<int>(named.value_or(vision::ColorName::kRed));
  }
  reader.optional().quantity("x_*", kLength, kReach, cube.p_W.x);
  reader.optional().quantity("y_*", kLength, kReach, cube.p_W.y);
  reader.optional().quantity("z_*", kLength, kReach, cube.p_W.z);
  reader.optional().quantity("rz_*", kAngle, kTurn, cube.turn);
  reader.finish();
  return cube;
}

CellBasket read_basket(TableReader& reader, std::vector<std::string>& taken) {
  constexpr Range kInside = between(0.01, 1);
  CellBasket basket;
  reader.needs_no_source();
  read_name(reader, "basket", taken, basket.name);
  reader.quantity("length_*", kLength, kInside, basket.size.x);
  reader.quantity("width_*", kLength, kInside, basket.size.y);
  reader.quantity("height_*", kLength, kInside, basket.size.z);
  reader.optional().quantity("x_*", kLength, kReach, basket.X_WK.p.x);
  reader.optional().quantity("y_*", kLength, kReach, basket.X_WK.p.y);
  reader.optional().quantity("z_*", kLength, kReach, basket.X_WK.p.z);
  double turn = 0;
  reader.optional().quantity("rz_*", kAngle, kTurn, turn);
  basket.X_WK.R = rotation_z(turn);
  reader.finish();
  return basket;
}

/// What lies on the table of a camera.
void read_table_top(TableReader& root, Cell& cell, std::vector<std::string>& taken) {
  // One is written [basket], several [[basket]].
  for (TableReader& reader : root.table_or_tables("basket")) {
    if (cell.baskets.size() == kCellBasketsMax) {
      root.complain("basket", "a cell has at most " + std::to_string(kCellBasketsMax) + " baskets");
      break;
    }
    cell.baskets.push_back(read_basket(reader, taken));
  }
  std::vector<TableReader> cubes = root.tables("cube", Presence::kOptional);
  if (cubes.size() > kCellCubesMax) {
    root.complain("cube", "a cell has at most " + std::to_string(kCellCubesMax) + " cubes");
    return;
  }
  for (TableReader& reader : cubes) cell.cubes.push_back(read_cube(reader));
  if (!cubes.empty() && cell.simulated_camera() == nullptr) {
    root.complain("cube", "cubes are for a camera with device = \"" +
                              std::string(kSimulatedCamera) + "\"; there is none");
  }
}

Cell read_root(TableReader& root) {
  Cell cell;
  std::vector<std::string> taken;  // names are unique over robots, objects and cameras
  root.needs_no_source();
  root.text("title", kTitleMax, cell.title);
  root.optional().number("time_scale", kScale, cell.time_scale);
  std::vector<TableReader> robots = root.tables("robot");
  if (robots.size() > kCellRobotsMax) {
    root.complain("robot", "a cell has at most " + std::to_string(kCellRobotsMax) + " robots");
    robots.erase(robots.begin() + kCellRobotsMax, robots.end());
  }
  for (TableReader& reader : robots) cell.robots.push_back(read_cell_robot(reader, taken));
  std::vector<TableReader> objects = root.tables("object", Presence::kOptional);
  std::vector<TableReader> cameras = root.tables("camera", Presence::kOptional);
  if (objects.size() + cameras.size() > kThingsMax) {
    root.complain("a cell has at most " + std::to_string(kThingsMax) + " objects and cameras");
  } else {
    for (TableReader& reader : objects) cell.objects.push_back(read_object(reader, taken));
    for (TableReader& reader : cameras) cell.cameras.push_back(read_camera(reader, taken));
  }
  for (const CellCamera& camera : cell.cameras) {
    const bool is_there =
        camera.robot.empty() || std::ranges::any_of(cell.robots, [&](const CellRobot& robot) {
          return robot.name == camera.robot;
        });
    if (!is_there) {
      root.complain("camera", camera.name + ": robot is '" + camera.robot +
                                  "', and this cell has no robot of that name");
    }
  }
  read_table_top(root, cell, taken);
  if (root.clean() && cell.time_scale != 1 &&
      std::ranges::any_of(cell.robots,
                          [](const CellRobot& robot) { return robot.port.has_value(); })) {
    root.complain("time_scale", "a robot on a real port keeps real time");
  }
  root.finish();
  return cell;
}

}  // namespace

std::expected<Cell, std::vector<Complaint>> read_cell(std::string_view toml,
                                                      std::string_view file_name) {
  return read_toml_file(toml, file_name, read_root);
}

}  // namespace sinew
