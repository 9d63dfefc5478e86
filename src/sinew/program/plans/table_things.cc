#include "sinew/program/plans/table_things.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/rotation.h"
#include "sinew/grasping/grasps.h"

namespace sinew::program {
namespace {

constexpr double kWall = 3e-3;  // m, of a basket
/// Of a cube's edge: from its side to its upright edges, seen from above.
constexpr double kCorner = 0.21;
constexpr double kOff = 3e-3;  // m, that it may be held off the middle

struct Box {
  Pose<frame::Base, frame::Box> X_BX;
  Vec3 half;
};

planning::Surrounding standing(const Box& box) {
  CollisionBox shape;
  shape.X_LX = relabel<frame::Link, frame::Box>(box.X_BX);
  shape.half = box.half;
  return {{0, shape}};
}

std::vector<Box> boxes_of(const Sighting& seen, std::optional<std::size_t> but) {
  std::vector<Box> boxes;
  const auto add = [&](const grasping::Body& body) {
    boxes.push_back({{rotation_z(body.yaw), body.p_BO}, body.half});
  };
  for (std::size_t i = 0; i < seen.cubes.size(); ++i) {
    if (i != but) add(grasping::body_of(seen.cubes[i]));
  }
  for (const OtherThing& other : seen.others) {
    if (other.is_likely) add(other.body);
  }
  const auto certain = boxes.size();
  for (const OtherThing& other : seen.others) {
    if (!other.is_likely) add(other.body);
  }
  const auto far = [](const Box& box) { return std::hypot(box.X_BX.p.x, box.X_BX.p.y); };
  const auto split = boxes.begin() + static_cast<std::ptrdiff_t>(certain);
  std::ranges::sort(boxes.begin(), split, {}, far);
  std::ranges::sort(split, boxes.end(), {}, far);
  return boxes;
}

std::array<Box, 4> walls_of(const Basket& basket) {
  std::array<Box, 4> walls;
  for (std::size_t i = 0; i < 4; ++i) {
    const double side = i < 2 ? 1 : -1;
    const bool along_x = i % 2 == 0;
    const double out = (along_x ? basket.size.x : basket.size.y) / 2 + kWall / 2;
    const double half = (along_x ? basket.size.y : basket.size.x) / 2 + kWall;
    const double up = basket.size.z / 2;
    walls[i] = {basket.X_BK, along_x ? Vec3{kWall / 2, half, up} : Vec3{half, kWall / 2, up}};
    walls[i].X_BX.p = basket.X_BK * (along_x ? Vec3{side * out, 0, up} : Vec3{0, side * out, up});
  }
  return walls;
}

Box grown(Box box, double aside, double up) {
  box.half = box.half + Vec3{aside, aside, up / 2};
  box.X_BX.p.z += up / 2;
  return box;
}

}  // namespace

double things_shrunk_by(const RobotModel& robot) {
  // Grasps are chosen with all of it; a way may come a little nearer.
  constexpr double kNearer = 0.5e-3;  // m
  return std::max(0.0, robot.collision.margin - grasping::kApart + kNearer);
}

TableThings things_on_table(const RobotModel& robot, const Sighting& seen,
                            std::optional<std::size_t> but, std::span<const Basket> baskets,
                            double carried, double room) {
  constexpr std::size_t kMost = planning::CollisionModel::kSurroundMax;
  // A cube between jaws is a ball for the plan; below a cup it is nothing at all.
  const bool is_serial = std::holds_alternative<SerialGeometry>(robot.geometry);
  const double hangs = is_serial ? 0.4 * carried : carried;
  TableThings things;
  const auto add = [&](const Box& box, double less) {
    if (things.bare.size() == kMost) return;
    Box smaller = box;
    smaller.half = {std::max(1e-4, box.half.x - less), std::max(1e-4, box.half.y - less),
                    std::max(1e-4, box.half.z - less)};
    things.bare.push_back(standing(smaller));
    things.aside.push_back(standing(grown(smaller, room, room)));
    things.carrying.push_back(
        standing(grown(smaller, kCorner * carried + kOff + room, hangs + room)));
  };
  for (const Basket& basket : baskets) {
    for (const Box& wall : walls_of(basket)) add(wall, 0);
  }
  for (const Box& box : boxes_of(seen, but)) add(box, things_shrunk_by(robot));
  return things;
}

}  // namespace sinew::program
