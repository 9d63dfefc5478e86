#include "cubes/truth_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/model/collision_links.h"
#include "sinew/sim/cube_world.h"

namespace sinew::cubes {
namespace {

using sim::CubePlace;
using Kind = sim::CubeEvent::Kind;

constexpr double kLimitTolerance = from_deg(0.5);  // a servo stands two of its steps beside
constexpr double kFlat = 1e-3;                     // m; nothing meets what is flatter

double apart(const planning::PlacedShape& body, const planning::PlacedBox& box) {
  return std::visit([&](const auto& shape) { return planning::distance(shape, box); }, body);
}

}  // namespace

TruthWatch::TruthWatch(CubeCell& cell, std::vector<Thing> clutter)
    : cell_(cell), collision_(cell.robot()) {
  const Cell& file = cell.cell().cell();
  X_BT_ = relabel<frame::Base, frame::World>(file.robots[0].X_WB.inverse() * file.cameras[0].X_WT);
  const auto add = [&](const auto& X_TX, const Vec3& half) {
    const auto X = X_BT_ * relabel<frame::World, frame::Box>(X_TX);
    fixed_.push_back({X, half});
  };
  cell.table().cubes().with([&](const sim::CubeWorld& world) {
    for (const sim::Block& block : sim::blocks_of(world.settings().baskets.front())) {
      add(block.X_WX, block.half);
    }
  });
  for (const Thing& thing : clutter) {
    if (2 * thing.half.z <= kFlat) continue;
    if (thing.form == Thing::Form::kBox) {
      add(thing.X_WS, thing.half);
      continue;
    }
    // A disc: rectangles whose corners are on its circle, all around.
    constexpr int kRectangles = 8;
    constexpr double kCorner = kPi / (2 * kRectangles);
    for (int k = 0; k < kRectangles; ++k) {
      auto X_WS = thing.X_WS;
      X_WS.R = X_WS.R * rotation_z(2 * k * kCorner);
      const double r = thing.half.x;
      add(X_WS, Vec3{r * std::cos(kCorner), r * std::sin(kCorner), thing.half.z});
    }
  }
}

void TruthWatch::look() {
  const runtime::StationView view = cell_.cell().station(0).view();
  if (!view.truth) return;
  JointVector q;
  for (const sim::JointTruth& joint : view.truth->joints) q.push_back(joint.q);
  for (std::size_t j = 0; j < q.size(); ++j) {
    const Joint& joint = cell_.robot().joints[j];
    if (q[j] < joint.lower - kLimitTolerance || q[j] > joint.upper + kLimitTolerance) ++outside_;
  }
  std::vector<sim::CubeState> cubes;
  cell_.table().cubes().with([&](const sim::CubeWorld& world) {
    cubes.assign(world.cubes().begin(), world.cubes().end());
    grasps_ = static_cast<std::size_t>(
        std::ranges::count(world.events(), Kind::kGrasped, &sim::CubeEvent::kind));
  });
  collision_.fit({.jaws = view.truth->tool, .held = {}});
  std::vector<planning::PlacedShape> bodies(collision_.shapes());
  auto X_near = collision_.start_pose();
  const std::span<const double> angles{q.begin(), q.size()};
  if (!collision_.bodies(angles, X_near, bodies)) return;
  const auto& shapes = cell_.robot().collision.shapes;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (shapes[i].link < 2 || std::holds_alternative<HeldBall>(shapes[i].form)) continue;
    look_at(bodies[i], shapes[i], cubes);
  }
  const planning::Clearance near = collision_.distance(angles);
  if (near.distance >= 0) return;
  const auto named = [&](std::uint8_t shape) {
    return link_name(cell_.robot(), planning::link_of(cell_.robot(), shape));
  };
  meet(named(near.first), named(near.second), near.distance);
}

void TruthWatch::meet(std::string_view link, std::string_view what, double apart) {
  double& deepest = met_[fmt::format("{} met {} after {} grasps", link, what, grasps_)];
  deepest = std::max(deepest, -apart);
}

void TruthWatch::look_at(const planning::PlacedShape& body, const CollisionShape& shape,
                         const std::vector<sim::CubeState>& cubes) {
  const std::string_view link = link_name(cell_.robot(), shape.link);
  for (std::size_t k = 0; k < fixed_.size(); ++k) {
    const double far = apart(body, fixed_[k]);
    if (far < 0) meet(link, k < 5 ? "the basket" : "a thing on the table", far);
  }
  // The world of cubes itself knows what fingers and cups touch.
  const bool is_tool = std::holds_alternative<JawFinger>(shape.form) ||
                       std::holds_alternative<PalletizerGeometry>(cell_.robot().geometry);
  if (is_tool) return;
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    if (cubes[i].where == CubePlace::kHeld || cubes[i].where == CubePlace::kGone) continue;
    const double half = cubes[i].edge / 2;
    const planning::PlacedBox box{X_BT_ * relabel<frame::World, frame::Box>(cubes[i].X_WO),
                                  {half, half, half}};
    const double far = apart(body, box);
    if (far < 0 && cubes[i].where != CubePlace::kBasket) {
      touched_.push_back({i, grasps_, std::string(link), -far});
    }
  }
}

std::vector<std::string> TruthWatch::contacts(const Ended& ended) const {
  std::vector<std::size_t> taken;
  for (const sim::CubeEvent& event : ended.events) {
    if (event.kind == Kind::kGrasped) taken.push_back(*event.cube);
  }
  std::set<std::string> told;
  std::map<std::string, double> deepest = met_;
  for (const Touch& touch : touched_) {
    if (touch.before < taken.size() && taken[touch.before] == touch.cube) continue;
    double& depth = deepest[fmt::format("{} met cube {} after {} grasps", touch.link, touch.cube,
                                        touch.before)];
    depth = std::max(depth, touch.depth);
  }
  for (const auto& [what, depth] : deepest) {
    told.insert(fmt::format("{}, {:.1f} mm", what, 1e3 * depth));
  }
  std::size_t grasps = 0;
  bool carries = false;
  std::set<std::size_t> released;  // what is pushed in the basket was dropped on
  for (const sim::CubeEvent& event : ended.events) {
    if (event.kind == Kind::kGrasped) ++grasps;
    if (event.kind == Kind::kReleased) released.insert(*event.cube);
    const bool holds_none = event.kind == Kind::kReleased || event.kind == Kind::kSlipped ||
                            event.kind == Kind::kThrown;
    if (event.kind == Kind::kGrasped || holds_none) carries = event.kind == Kind::kGrasped;
    // What is carried may touch nothing; empty fingers the cube that they are about to take.
    const bool is_next =
        !carries && event.cube && grasps < taken.size() && taken[grasps] == *event.cube;
    if (is_next) continue;
    const bool is_pushed = event.kind == Kind::kPushed && event.cube &&
                           !released.contains(*event.cube) &&
                           (grasps == 0 || taken[grasps - 1] != *event.cube);
    if (event.kind == Kind::kCrash || is_pushed) {
      told.insert(fmt::format("{} {} by {:.1f} mm after {} grasps", name(event.kind),
                              event.cube ? std::to_string(*event.cube) : "table or basket",
                              1e3 * event.amount, grasps));
    }
  }
  return {told.begin(), told.end()};
}

}  // namespace sinew::cubes
