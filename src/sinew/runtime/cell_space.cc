#include "sinew/runtime/cell_space.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/model/collision_links.h"
#include "sinew/planning/paths/motion_limits.h"

namespace sinew::runtime {

using planning::CellClaim;
using planning::CellContact;
using planning::CellObstacle;
using planning::CellWay;

namespace {

/// What is farther than this from all that a jog can come to does not concern it yet, m.
constexpr double kNear = 0.1;

/// How far the outermost body of a robot goes on the first `share` of a way, m.
double gone(const planning::RobotBodies& robot, const CellWay& way, double share) {
  std::vector<planning::CellBody> bodies(robot.size());
  kinematics::PoseBP X_near = robot.start_pose();
  std::optional<Vec3> last;
  double sum = 0;
  constexpr double kStep = 5e-3;  // m that a body may move between two looks
  way.walk([&](const CellWay::Part& part) {
    if (part.begin >= share) return CellWay::Next::kEnd;
    if (robot.swell(part.box.half) > kStep) return CellWay::Next::kFiner;
    if (!robot.place({part.box.q, {}}, X_near, bodies)) return CellWay::Next::kOn;
    if (last) sum += norm(bodies.back().centre - *last);
    last = bodies.back().centre;
    return CellWay::Next::kOn;
  });
  return sum;
}

}  // namespace

std::string CellRefusal::sentence() const {
  const std::string whom = other_link.empty() ? other : other + " (" + other_link + ")";
  if (asker_unknown) {
    return fmt::format(
        "nobody knows where this robot is or goes, and {} is in its reach: move {} away, or say "
        "where this one stands",
        whom, other);
  }
  if (unknown) {
    return fmt::format(
        "{} may come to {}, and nobody knows where that one is: home it, or say "
        "where it stands",
        link, whom);
  }
  const std::string where =
      share > 0 ? fmt::format("{:.0f} % of the way ({:.0f} mm)", 100 * share, to_mm(way))
                : std::string("the beginning");
  const std::string how =
      !std::isfinite(distance) ? "come too near to " + whom
      : distance < 0 ? fmt::format("overlap {} by {:.0f} mm", whom, std::ceil(-to_mm(distance)))
                     : fmt::format("come within {:.0f} mm of {}", to_mm(distance), whom);
  const std::string then = moving ? "wait until it has moved away, or take another way"
                                  : "move it away, or take another way";
  return fmt::format("{} would {} at {}, at least {:.0f} mm is asked for: {}", link, how, where,
                     to_mm(margin), other_link.empty() ? "take another way" : then);
}

CellSpace::CellSpace(const Cell& cell, std::span<const RobotModel> models) {
  SINEW_ASSERT(models.size() == cell.robots.size());
  for (const CellObject& object : cell.objects) {
    objects_.push_back(planning::claim_of(object));
    object_names_.push_back(object.name);
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    robots_.push_back(std::make_unique<Robot>(models[i], cell.robots[i]));
    for (const CellObject& object : cell.objects) {
      robots_[i]->on.push_back(planning::links_on(robots_[i]->bodies, planning::body_of(object)));
    }
  }
}

void CellSpace::stands(std::size_t robot, const CellStand& stand) {
  const std::scoped_lock lock(said_mutex_);
  Robot& one = *robots_[robot];
  one.stand = stand;
  if (one.ended && stand.rests) one.rested = true;
}

void CellSpace::ended(std::size_t robot, std::uint32_t command) {
  const std::scoped_lock lock(said_mutex_);
  if (robots_[robot]->command == command) robots_[robot]->ended = true;
}

void CellSpace::works(std::size_t robot, bool busy) {
  const std::scoped_lock lock(mutex_);
  robots_[robot]->busy = busy;
}

std::optional<CellRefusal> CellSpace::refusal(std::size_t robot) const {
  const std::scoped_lock lock(mutex_);
  return robots_[robot]->refusal;
}

/// What a jog can come to before it is looked at again, and on its way to rest behind that.
planning::JointBox CellSpace::jog_box(const Robot& robot, const CellStand& stand) const {
  planning::JointBox box = stand.joints;
  const auto limits = planning::motion_limits(robot.model);
  for (std::size_t j = 0; j < limits.size(); ++j) {
    const double a = limits[j].acceleration;
    const double v = std::min(limits[j].velocity, std::abs(stand.speeds[j]) + a * stand.ahead);
    box.half[j] += v * stand.ahead + v * (v / a + a / limits[j].jerk) / 2;
  }
  return box;
}

CellSpace::Filled CellSpace::filled(std::size_t place) {
  Robot& robot = *robots_[place];
  CellStand stand;
  bool granted = false;
  {
    const std::scoped_lock lock(said_mutex_);
    stand = robot.stand;
    if (robot.command != 0 && robot.rested) robot.command = 0;
    granted = robot.command != 0;
  }
  if (!granted) robot.granted = {};
  Filled filled{.claim = {}, .robot = place, .moving = granted || !stand.rests, .unknown = false};
  if (granted) {
    // And where it stands: a setpoint that is kept may be a little beside that, and what jogs when
    // it is given a motion does not get it, and goes on.
    filled.claim = robot.granted;
    const planning::JointBox here = stand.jogs ? jog_box(robot, stand) : stand.joints;
    if (stand.sure) filled.claim.add(planning::claim_of_rest(robot.bodies, here, false));
    return filled;
  }
  const bool somewhere = stand.known && (stand.rests || stand.jogs);
  if (!somewhere) {
    filled.claim = planning::claim_of_reach(robot.bodies);
    filled.unknown = stand.rests;
  } else if (stand.jogs) {
    filled.claim = planning::claim_of_rest(robot.bodies, jog_box(robot, stand), false);
  } else {
    filled.claim = planning::claim_of_rest(robot.bodies, stand.joints, stand.sure);
    filled.unknown = !stand.sure;
  }
  return filled;
}

std::vector<CellObstacle> CellSpace::obstacles(std::size_t robot, std::span<const Filled> others,
                                               bool objects) const {
  std::vector<CellObstacle> all;
  const double own = robots_[robot]->model.collision.margin;
  for (const Filled& other : others) {
    all.push_back({&other.claim, std::max(own, robots_[other.robot]->model.collision.margin), 0});
  }
  for (std::size_t o = 0; objects && o < objects_.size(); ++o) {
    all.push_back({&objects_[o], own, robots_[robot]->on[o]});
  }
  return all;
}

CellRefusal CellSpace::refused(std::size_t robot, const CellWay* way, const CellContact& contact,
                               std::span<const Filled> others) const {
  const Robot& asker = *robots_[robot];
  CellRefusal refusal;
  refusal.link = link_name(asker.model, contact.link);
  refusal.share = contact.share;
  refusal.distance = contact.distance;
  refusal.margin = contact.margin;
  refusal.asker_unknown = way == nullptr;
  if (way != nullptr && contact.share > 0) refusal.way = gone(asker.bodies, *way, contact.share);
  if (contact.obstacle >= others.size()) {
    refusal.other = object_names_[contact.obstacle - others.size()];
    return refusal;
  }
  const Filled& other = others[contact.obstacle];
  refusal.other = robots_[other.robot]->name;
  refusal.other_link = link_name(robots_[other.robot]->model, contact.other);
  refusal.moving = other.moving;
  refusal.unknown = other.unknown;
  return refusal;
}

Error CellSpace::error_of(const CellContact& contact, bool taken) {
  return {
      .code = taken ? ErrorCode::kCellTaken : ErrorCode::kCellContact,
      .index = static_cast<std::int8_t>(contact.link),
      .measured = std::isfinite(contact.distance) ? std::min(contact.distance, contact.margin) : 0,
      .limit = contact.margin};
}

Expected<void> CellSpace::ask(std::size_t place, std::uint32_t command, const CellWay* way,
                              bool recovering) {
  const std::scoped_lock lock(mutex_);
  Robot& robot = *robots_[place];
  std::vector<Filled> others;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (i != place) others.push_back(filled(i));
  }
  const CellWay nowhere;
  const CellWay& asked = way != nullptr ? *way : nowhere;
  const bool objects = way != nullptr && !recovering;
  const auto contact =
      planning::first_contact(robot.bodies, asked, obstacles(place, others, objects));
  if (contact) {
    robot.refusal = refused(place, way, *contact, others);
    return std::unexpected(error_of(*contact, robot.refusal->moving));
  }
  CellClaim claim = planning::claim_of_way(robot.bodies, asked);
  const std::scoped_lock said(said_mutex_);
  // What it was granted before and has not come to rest from.
  if (robot.command != 0 && !robot.rested) {
    if (!robot.ended) return std::unexpected(Error{ErrorCode::kBusy});
    claim.add(robot.granted);
  }
  robot.granted = std::move(claim);
  robot.command = command;
  robot.ended = robot.rested = false;
  return {};
}

Expected<void> CellSpace::look(std::size_t place, const CellWay& way) {
  const std::scoped_lock lock(mutex_);
  const auto met = meeting(place, way);
  if (!met) return {};
  robots_[place]->refusal = met->refusal;
  return std::unexpected(met->error);
}

std::optional<CellMeeting> CellSpace::meets(std::size_t place, const CellWay& way) {
  const std::scoped_lock lock(mutex_);
  return meeting(place, way);
}

std::optional<CellMeeting> CellSpace::meeting(std::size_t place, const CellWay& way) {
  std::vector<Filled> others;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (i == place || robots_[i]->busy) continue;
    others.push_back(filled(i));
    if (others.back().moving) others.pop_back();
  }
  const auto contact =
      planning::first_contact(robots_[place]->bodies, way, obstacles(place, others, true));
  if (!contact) return std::nullopt;
  return CellMeeting{error_of(*contact, false), refused(place, &way, *contact, others)};
}

/// What of a claim is near: its bodies, or boxes around several where there are many.
bool CellSpace::gather(const Robot& robot, const planning::CellBlock& near, const CellClaim& claim,
                       double wider, std::uint32_t excused, bool coarse, Surroundings& out) const {
  const auto X_BW = robot.bodies.X_WB().inverse();
  const auto add = [&](const planning::PlacedShape& form, double swell) {
    if (out.full()) return false;
    planning::Surrounding one{.shape = {.link = 0, .form = {}}, .excused = excused};
    if (const auto* capsule = std::get_if<planning::PlacedCapsule>(&form)) {
      one.shape.form = Capsule{X_BW * capsule->a, X_BW * capsule->b, capsule->radius + swell};
    } else {
      const auto& box = std::get<planning::PlacedBox>(form);
      const auto X_BX = X_BW * relabel<frame::World, frame::Box>(box.X);
      one.shape.form = CollisionBox{relabel<frame::Link, frame::Box>(X_BX),
                                    box.half + Vec3{swell, swell, swell}};
    }
    out.push_back(one);
    return true;
  };
  const auto block_box = [](const planning::CellBlock& block) {
    planning::PlacedBox box;
    box.X.p = 0.5 * (block.low + block.high);
    box.half = 0.5 * (block.high - block.low);
    return box;
  };
  if (near.distance(claim.block()) > kNear) return true;
  if (coarse) return add(block_box(claim.block()), wider);
  constexpr std::size_t kBodiesMax = 12;
  const bool all = claim.bodies().size() <= kBodiesMax;
  for (const CellClaim::Group& group : claim.groups()) {
    if (near.distance(group.block) > kNear) continue;
    if (!all && group.end - group.begin > 1) {
      if (!add(block_box(group.block), wider)) return false;
      continue;
    }
    for (std::size_t b = group.begin; b < group.end; ++b) {
      const planning::CellBody& body = claim.bodies()[b];
      if (near.distance(planning::block_around(body)) > kNear) continue;
      if (!add(body.form, body.swell + wider)) return false;
    }
  }
  return true;
}

std::optional<Surroundings> CellSpace::jogs(std::size_t place, const CellStand& stand) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return std::nullopt;
  Robot& robot = *robots_[place];
  {
    const std::scoped_lock said(said_mutex_);
    robot.stand = stand;
  }
  const CellClaim own = planning::claim_of_rest(robot.bodies, jog_box(robot, stand), false);
  std::vector<Filled> others;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (i != place) others.push_back(filled(i));
  }
  const double margin = robot.model.collision.margin;
  const auto all = obstacles(place, others, true);
  for (const bool coarse : {false, true}) {
    Surroundings out;
    const bool fits = std::ranges::all_of(all, [&](const CellObstacle& one) {
      return gather(robot, own.block(), *one.claim, one.margin - margin, one.excused, coarse, out);
    });
    if (fits) return out;
  }
  // More than anybody has room for: all that is near, as one.
  CellClaim heap;
  for (const CellObstacle& one : all) {
    if (own.block().distance(one.claim->block()) <= kNear) heap.add(*one.claim);
  }
  Surroundings out;
  gather(robot, own.block(), heap, margin, 0, true, out);
  return out;
}

}  // namespace sinew::runtime
