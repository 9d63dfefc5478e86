#include "sinew/cli/plans/dry_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "sinew/cli/output/cell_cameras.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/plan_report.h"
#include "sinew/cli/output/program_folder.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/config/cell_file.h"
#include "sinew/core/units.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/model/hand.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/foresight.h"
#include "sinew/runtime/cameras/camera_place.h"
#include "sinew/runtime/cameras/cube_eyes.h"
#include "sinew/runtime/cameras/open_camera.h"
#include "sinew/runtime/cameras/read_picture.h"
#include "sinew/runtime/cameras/simulated_table.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/links/robot_variant.h"

namespace sinew::cli {
namespace {

using program::Foreseen;

template <class Value>
using Or = std::expected<Value, Outcome>;

/// A robot of the cell that takes cubes, and its model.
struct Chosen {
  const CellRobot* place = nullptr;
  RobotModel model;
};

/// What becomes of one cube.
struct Fate {
  grasping::Cube cube;
  int line = 0;                ///< of the `pick`; 0: it is left
  double tilt = 0;             ///< rad
  std::string into{};          ///< where it is released
  std::optional<Vec3> p_BT{};  ///< m, of the tool there
  std::optional<program::Refusal> why{};
};

Or<RobotModel> model_of(const CellRobot& place, const std::string& cell_file) {
  auto file = find_robot(place, cell_file);
  if (!file) return std::unexpected(file.error());
  auto model = runtime::variant_of(file->model, place.profile, place.wire, place.without);
  if (!model) return std::unexpected(bad_input(place.name + ": " + model.error()));
  return std::move(*model);
}

/// By its name or kind; where it is not named the first one that takes cubes.
Or<Chosen> choose(const PlanRequest& request, const Cell& cell) {
  std::string names;
  for (const CellRobot& place : cell.robots) {
    names += (names.empty() ? "" : ", ") + place.name;
    const bool named =
        !request.robot || *request.robot == place.name || *request.robot == place.robot;
    if (!named) continue;
    auto model = model_of(place, *request.cell);
    if (!model) return std::unexpected(model.error());
    if (!request.robot && !program::can_pick(*model)) continue;
    return Chosen{&place, std::move(*model)};
  }
  if (!request.robot) {
    return std::unexpected(bad_input(*request.cell + ": no robot of this cell takes cubes"));
  }
  return std::unexpected(
      bad_input("--robot: '" + *request.robot + "' is no robot of this cell; there are " + names));
}

/// A stored image as it is; of all other devices one picture.
std::expected<vision::Picture, std::string> one_picture(const Cell& cell, const CellCamera& camera,
                                                        const vision::TableCamera& lens,
                                                        const std::string& cell_file) {
  if (camera.device == kSimulatedCamera) {
    runtime::SimulatedTable table(cell, cell.baskets);
    auto picture = table.pictures(lens, [] { return std::vector<render::ViewedRobot>{}; })({});
    if (!picture) return std::unexpected(describe(picture.error()));
    return std::move(*picture);
  }
  const std::string device =
      camera.device.contains("://") ? camera.device : beside(cell_file, camera.device);
  const auto is = [&](std::string_view ending) { return device.ends_with(ending); };
  if (is(".jpg") || is(".jpeg") || is(".png")) return runtime::read_picture(device);
  auto source = runtime::open_camera(device, {lens.model.width, lens.model.height});
  if (!source) return std::unexpected(source.error());
  auto picture = (*source)({});
  if (!picture) return std::unexpected(describe(picture.error()));
  return std::move(*picture);
}

std::string cubes_text(std::size_t cubes, std::size_t in_baskets) {
  std::string text = fmt::format("{} cube{}", cubes, cubes == 1 ? "" : "s");
  if (in_baskets > 0) text += fmt::format(", {} more in baskets", in_baskets);
  return text;
}

/// Of a calibration file, and where the camera hangs while the robot stands so.
Or<vision::TableCamera> calibration_of(const PlanRequest& request, const Cell& cell,
                                       const CellCamera& camera, const Chosen& chosen,
                                       const JointVector& q) {
  auto lens = read_calibration(camera, beside(*request.cell, *camera.calibration));
  if (!lens) return lens;
  if (const auto missing = missing_robot(cell, *lens)) {
    return std::unexpected(bad_input(*camera.calibration + ": " + *missing));
  }
  if (!camera.hand_eye) return lens;
  const auto carrier = std::ranges::find(cell.robots, camera.robot, &CellRobot::name);
  Or<RobotModel> model = chosen.model;
  if (&*carrier != chosen.place) model = model_of(*carrier, *request.cell);
  if (!model) return std::unexpected(model.error());
  const auto robot = static_cast<std::size_t>(carrier - cell.robots.begin());
  const auto read =
      read_hand_eye_of(camera, beside(*request.cell, *camera.hand_eye), robot, *model);
  if (!read) return std::unexpected(read.error());
  if (!read->mount) {
    runtime::place_beside(read->file, camera.robot, *lens);
    return lens;
  }
  if (&*carrier != chosen.place || !request.from) {
    return std::unexpected(bad_input(fmt::format(
        "{} is on the arm of {}: say where that stood as the picture was taken, --robot {} "
        "--from-joints",
        camera.name, camera.robot, camera.robot)));
  }
  const auto X_WC = runtime::pose_on(*read->mount, {*model, carrier->X_WB, q});
  if (!X_WC) return std::unexpected(could_not(camera.robot + ": its legs have no such pose"));
  const auto X_TW = runtime::table_of(cell, camera, &*lens).inverse();
  lens->X_WC = relabel<frame::World, frame::World>(X_TW) * *X_WC;
  return lens;
}

/// One picture of the first camera that is calibrated, with the cubes in it.
/// @param q  joints of the robot that is chosen, as the picture is taken
Or<program::TableTop> look(const PlanRequest& request, const Cell& cell, const Chosen& chosen,
                           const JointVector& q, std::string& said) {
  const CellRobot& place = *chosen.place;
  program::TableTop table;
  const auto X_BW = place.X_WB.inverse();
  for (const CellBasket& one : cell.baskets) {
    table.baskets.push_back({one.name, X_BW * one.X_WK, one.size});
  }
  for (const CellCamera& camera : cell.cameras) {
    const bool simulated = camera.device == kSimulatedCamera;
    if (!camera.calibration && !simulated) continue;
    table.cameras.push_back(camera.name);
    if (table.seen) continue;
    vision::TableCamera lens = runtime::usual_camera();
    if (camera.calibration) {
      auto read = calibration_of(request, cell, camera, chosen, q);
      if (!read) return std::unexpected(read.error());
      lens = std::move(*read);
    }
    const auto picture = one_picture(cell, camera, lens, *request.cell);
    if (!picture) return std::unexpected(could_not(camera.name + ": " + picture.error()));
    if (picture->width != lens.model.width || picture->height != lens.model.height) {
      return std::unexpected(bad_input(fmt::format(
          "{}: the picture has {} x {} px, and the camera was calibrated with {} x {} px",
          camera.name, picture->width, picture->height, lens.model.width, lens.model.height)));
    }
    auto seen = vision::detect_cubes(*picture);
    vision::place_on_table(seen, *picture, lens, camera.cube);
    const auto X_WT = runtime::table_of(cell, camera, &lens);
    table.seen = runtime::sighting_of(seen, camera.cube, {X_WT, place.X_WB, cell.baskets});
    said = fmt::format("{}: {}, {}", camera.name, camera.device,
                       cubes_text(table.seen->cubes.size(), table.seen->in_baskets.size()));
  }
  if (table.seen) return table;
  return std::unexpected(
      bad_input(*request.cell + ": no calibrated camera; [[camera]] with calibration names one"));
}

/// Follows the plan and writes down what becomes of each cube.
class Fates {
 public:
  explicit Fates(const RobotModel& model) : model_(model) {}

  std::expected<void, program::Refusal> take(const Foreseen& now) {
    if (now.why != nullptr) return std::unexpected(*now.why);
    if (now.rows == nullptr) return {};
    if (std::holds_alternative<program::PickOrder>(now.order.what)) {
      all_.push_back({.cube = now.rows->cube, .line = now.order.line, .tilt = now.rows->tilt});
      return {};
    }
    if (all_.empty()) return {};
    const auto& place = std::get<program::PlaceOrder>(now.order.what).row;
    const auto* basket = std::get_if<program::BasketGoal>(&place.there);
    all_.back().into = basket != nullptr ? basket->name : "its place";
    if (basket != nullptr) all_.back().p_BT = now.rows->p_BO;
    return {};
  }
  /// What is left on the table, and why it cannot be had there.
  void leave(program::RowPlanner& planner, const program::Standing& from,
             const std::vector<grasping::Cube>& left) {
    const program::Sighting seen{left};
    for (auto& verdict : program::judge_cubes(planner, from, seen)) {
      Fate fate{.cube = seen.cubes[verdict.which]};
      if (!verdict.rows) fate.why = verdict.rows.error();
      all_.push_back(std::move(fate));
    }
  }

  std::string text() const {
    Table table({"#", "color", "top at, mm", "line", "grasp", "into", "released at, mm"});
    table.left(1).left(4).left(5);
    std::string others;
    int number = 0;
    for (const Fate& one : all_) {
      if (one.line == 0) {
        others += fmt::format("  {} at {}: {}\n", color(one), at(top(one)), reason(one));
        continue;
      }
      const std::string grasp = jaws_of(model_) != nullptr
                                    ? fmt::format("tilted by {:.0f} deg", to_deg(one.tilt))
                                    : "by suction";
      table.add({std::to_string(++number), color(one), at(top(one)), std::to_string(one.line),
                 one.tilt < from_deg(1) && jaws_of(model_) != nullptr ? "straight down" : grasp,
                 one.into, one.p_BT ? at(*one.p_BT) : ""});
    }
    return (number > 0 ? table.text() : std::string("  no cube is picked\n")) + others;
  }

  Json json() const {
    Json picked = Json::array(), left = Json::array();
    for (const Fate& one : all_) {
      const Vec3 p = top(one);
      Json cube{{"color", color(one)}, {"top_mm", {to_mm(p.x), to_mm(p.y), to_mm(p.z)}}};
      if (one.line == 0) {
        if (one.why) {
          cube["error"] = error_json(one.why->error, model_);
          cube["help"] = program::help_with_cube(one.why->error.code);
        }
        left.push_back(std::move(cube));
        continue;
      }
      cube["line"] = one.line;
      cube["tilt_deg"] = to_deg(one.tilt);
      if (!one.into.empty()) cube["into"] = one.into;
      if (const auto& r = one.p_BT) cube["released_mm"] = {to_mm(r->x), to_mm(r->y), to_mm(r->z)};
      picked.push_back(std::move(cube));
    }
    return {{"picked", picked}, {"left", left}};
  }

 private:
  static std::string color(const Fate& one) {
    return std::string(vision::name(static_cast<vision::ColorName>(one.cube.color)));
  }
  static Vec3 top(const Fate& one) { return one.cube.p_BO + Vec3{0, 0, one.cube.edge / 2}; }
  static std::string at(const Vec3& p) {
    return fmt::format("{:.0f}, {:.0f}, {:.0f}", to_mm(p.x), to_mm(p.y), to_mm(p.z));
  }
  std::string reason(const Fate& one) const {
    if (!one.why) return "the program leaves it";
    const auto help = program::help_with_cube(one.why->error.code);
    return error_text(one.why->error, model_) +
           (help.empty() ? std::string() : fmt::format(". To fix: {}", help));
  }

  const RobotModel& model_;
  std::vector<Fate> all_;
};

}  // namespace

Outcome dry_run(const PlanRequest& request) {
  const auto text = io::read_file(*request.cell);
  if (!text) return bad_input(text.error().sentence);
  const auto cell = read_cell(*text, *request.cell);
  if (!cell) return complaints_outcome(cell.error());
  const auto chosen = choose(request, *cell);
  if (!chosen) return chosen.error();
  const RobotModel& model = chosen->model;
  program::Standing from(home_joints(model));
  if (request.from) {
    const auto joints = parse_joints("--from-joints", *request.from, model);
    if (!joints) return bad_input(joints.error());
    from.q = *joints;
  }
  std::string said;
  auto table = look(request, *cell, *chosen, *from.q, said);
  if (!table) return table.error();
  const auto wanted = read_program(request.subject, model,
                                   std::make_shared<const program::TableTop>(std::move(*table)));
  if (!wanted) return wanted.error();
  const auto plan = program::make_plan(*wanted, model, from, runtime::homing_of(model));
  if (!plan) {
    return plan_refusal(model, file_of(*wanted, plan.error().file, request.subject), plan.error());
  }
  program::RowPlanner planner(model);
  Fates fates(model);
  program::Standing last = from;
  const auto left = program::foresee(*plan, *wanted, planner, from, [&](const Foreseen& now) {
    if (now.from.q) last = now.from;
    return fates.take(now);
  });
  Outcome outcome;
  // A `pick` that finds nothing ends the program there, as it would end the run.
  if (!left) {
    outcome =
        plan_refusal(model, file_of(*wanted, left.error().file, request.subject), left.error());
  } else {
    fates.leave(planner, {last.q, {}}, *left);
  }
  outcome.text = fmt::format("  {}; {} would do, nothing moves:\n", said, chosen->place->name) +
                 fates.text() + outcome.text;
  Json json{{"robot", chosen->place->name}, {"camera", said}, {"duration_s", plan->duration}};
  json.update(fates.json());
  json.update(outcome.json);
  outcome.json = std::move(json);
  return outcome;
}

}  // namespace sinew::cli
