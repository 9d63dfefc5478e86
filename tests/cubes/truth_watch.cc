#include "cubes/truth_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
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
    if (2 * thing.half.z > kFlat) add(thing.X_WS, thing.half);
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
    const bool is_finger = std::holds_alternative<JawFinger>(shapes[i].form);
    look_at(bodies[i], is_finger, cubes);
  }
  if (collision_.distance(angles).distance < 0) met_.insert("table or itself");
}

void TruthWatch::look_at(const planning::PlacedShape& body, bool is_finger,
                         const std::vector<sim::CubeState>& cubes) {
  for (std::size_t k = 0; k < fixed_.size(); ++k) {
    if (apart(body, fixed_[k]) < 0) met_.insert(k < 5 ? "basket" : "a thing on the table");
  }
  // The world of cubes itself knows what fingers and cups touch.
  const bool is_tool =
      is_finger || std::holds_alternative<PalletizerGeometry>(cell_.robot().geometry);
  if (is_tool) return;
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    if (cubes[i].where == CubePlace::kHeld || cubes[i].where == CubePlace::kGone) continue;
    const double half = cubes[i].edge / 2;
    const planning::PlacedBox box{X_BT_ * relabel<frame::World, frame::Box>(cubes[i].X_WO),
                                  {half, half, half}};
    if (apart(body, box) < 0 && cubes[i].where != CubePlace::kBasket) {
      touched_.emplace_back(i, grasps_);
    }
  }
}

std::vector<std::string> TruthWatch::contacts(const Ended& ended) const {
  std::vector<std::string> all(met_.begin(), met_.end());
  std::vector<std::size_t> taken;
  for (const sim::CubeEvent& event : ended.events) {
    if (event.kind == Kind::kGrasped) taken.push_back(*event.cube);
  }
  std::set<std::string> told;
  for (const auto& [cube, before] : touched_) {
    if (before < taken.size() && taken[before] == cube) continue;
    told.insert(fmt::format("the arm met cube {} after {} grasps", cube, before));
  }
  std::size_t grasps = 0;
  std::set<std::size_t> released;  // what is pushed in the basket was dropped on
  for (const sim::CubeEvent& event : ended.events) {
    if (event.kind == Kind::kGrasped) ++grasps;
    if (event.kind == Kind::kReleased) released.insert(*event.cube);
    const bool is_next = event.cube && grasps < taken.size() && taken[grasps] == *event.cube;
    const bool is_pushed = event.kind == Kind::kPushed && event.cube &&
                           !released.contains(*event.cube) && !is_next &&
                           (grasps == 0 || taken[grasps - 1] != *event.cube);
    if (event.kind == Kind::kCrash || is_pushed) {
      told.insert(fmt::format("{} {} by {:.1f} mm after {} grasps", name(event.kind),
                              event.cube ? std::to_string(*event.cube) : "table or basket",
                              1e3 * event.amount, grasps));
    }
  }
  all.insert(all.end(), told.begin(), told.end());
  return all;
}

}  // namespace sinew::cubes
