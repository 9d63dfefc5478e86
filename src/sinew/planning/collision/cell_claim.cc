#include "sinew/planning/collision/cell_claim.h"

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/model/collision_links.h"

namespace sinew::planning {
namespace {

/// Bodies of a sweep that follow each other.
constexpr std::size_t kGroup = 12;
/// Intervals of a robot at rest are cut into so many boxes at most.
constexpr std::size_t kRestPartsMax = 256;

/// Bodies of many places, shape by shape: what lies in a group is then one body on its way.
CellClaim claim_of_places(const RobotBodies& robot, std::span<const CellBody> bodies) {
  CellClaim claim;
  const std::size_t shapes = robot.size();
  const std::size_t places = shapes > 0 ? bodies.size() / shapes : 0;
  std::vector<CellBody> track;
  for (std::size_t i = 0; i < shapes; ++i) {
    // What never moves is the same in all of them.
    const std::size_t count = robot.stands(i) ? std::min<std::size_t>(places, 1) : places;
    for (std::size_t p = 0; p < count; ++p) {
      track.push_back(bodies[p * shapes + i]);
      if (track.size() < kGroup && p + 1 < count) continue;
      claim.add(track);
      track.clear();
    }
  }
  return claim;
}

}  // namespace

void CellClaim::add(std::span<const CellBody> bodies) {
  Group group{.block = {}, .begin = bodies_.size(), .end = bodies_.size() + bodies.size()};
  for (const CellBody& body : bodies) {
    group.block.add(block_around(body));
    bodies_.push_back(body);
  }
  block_.add(group.block);
  groups_.push_back(group);
}

void CellClaim::add(const CellClaim& other) {
  for (const Group& group : other.groups_) {
    add(other.bodies().subspan(group.begin, group.end - group.begin));
  }
  sure = sure && other.sure;
}

CellClaim claim_of_reach(const RobotBodies& robot) {
  CellClaim claim;
  for (std::size_t i = 0; i < robot.size(); ++i) {
    const CellBody ball = robot.whole_reach(i);
    if (!robot.stands(i)) claim.add({&ball, 1});
  }
  std::array<CellBody, kCollisionShapesMax> bodies;
  kinematics::PoseBP X_near = robot.start_pose();
  JointBox home;
  for (std::size_t k = 0; k < robot.joints(); ++k) home.q[k] = robot.model().joints[k].home;
  if (robot.place(home, X_near, bodies)) {
    for (std::size_t i = 0; i < robot.size(); ++i) {
      if (robot.stands(i)) claim.add({&bodies[i], 1});
    }
  }
  claim.sure = false;
  return claim;
}

CellClaim claim_of_rest(const RobotBodies& robot, const JointBox& joints, bool surely) {
  // A grid of boxes, finest where an interval moves the bodies most.
  std::array<std::size_t, kMaxJoints> counts{};
  counts.fill(1);
  JointArray half = joints.half;
  std::size_t parts = 1;
  while (parts * 2 <= kRestPartsMax && robot.swell(half) > kSweepSwell) {
    std::size_t best = 0;
    double gain = -1;
    for (std::size_t k = 0; k < robot.joints(); ++k) {
      JointArray alone{};
      alone[k] = half[k];
      if (robot.swell(alone) > gain) {
        gain = robot.swell(alone);
        best = k;
      }
    }
    counts[best] *= 2;
    half[best] /= 2;
    parts *= 2;
  }
  if (!(robot.swell(half) <= kUnsureSwell)) return claim_of_reach(robot);
  std::vector<CellBody> bodies(parts * robot.size());
  kinematics::PoseBP X_near = robot.start_pose();
  for (std::size_t part = 0; part < parts; ++part) {
    JointBox box{joints.q, half};
    std::size_t rest = part;
    for (std::size_t k = 0; k < robot.joints(); ++k) {
      const auto place = static_cast<double>(rest % counts[k]);
      rest /= counts[k];
      box.q[k] += (2 * place + 1 - static_cast<double>(counts[k])) * half[k];
    }
    const std::span out = std::span(bodies).subspan(part * robot.size(), robot.size());
    if (!robot.place(box, X_near, out)) return claim_of_reach(robot);
  }
  CellClaim claim = claim_of_places(robot, bodies);
  claim.sure = surely;
  return claim;
}

CellClaim claim_of_way(const RobotBodies& robot, const CellWay& way) {
  if (!way.known()) return claim_of_reach(robot);
  double allowed = kSweepSwell;
  std::vector<CellBody> bodies;
  for (bool fits = false; !fits; allowed *= 2) {
    bodies.clear();
    kinematics::PoseBP X_near = robot.start_pose();
    std::size_t parts = 0;
    bool posed = true;
    fits = way.walk([&](const CellWay::Part& part) {
      if (robot.swell(part.box.half) > allowed) return CellWay::Next::kFiner;
      if (++parts > kSweepPartsMax) return CellWay::Next::kEnd;
      bodies.resize(parts * robot.size());
      const std::span out = std::span(bodies).subspan((parts - 1) * robot.size());
      posed = robot.place(part.box, X_near, out);
      return posed ? CellWay::Next::kOn : CellWay::Next::kEnd;
    });
    if (!posed) return claim_of_reach(robot);
  }
  CellClaim claim = claim_of_places(robot, bodies);
  claim.sure = false;
  return claim;
}

CellClaim claim_of(const CellObject& object) {
  CellClaim claim;
  const CellBody body = body_of(object);
  claim.add({&body, 1});
  return claim;
}

std::uint32_t links_on(const RobotBodies& robot, const CellBody& object) {
  const RobotModel& model = robot.model();
  const double margin = model.collision.margin;
  const Vec3 foot = robot.X_WB().p;
  CellBody at{.form = PlacedCapsule{foot, foot, 0}, .swell = 0, .centre = foot, .ball = 0};
  bool on = distance(at, object) <= margin;
  std::array<CellBody, kCollisionShapesMax> bodies;
  kinematics::PoseBP X_near = robot.start_pose();
  JointBox home;
  for (std::size_t k = 0; k < robot.joints(); ++k) home.q[k] = model.joints[k].home;
  if (robot.place(home, X_near, bodies)) {
    for (std::size_t i = 0; i < robot.size(); ++i) {
      on = on || (robot.stands(i) && distance(bodies[i], object) <= margin);
    }
  }
  std::uint32_t links = 0;
  for (std::size_t link = 0; on && link < link_count(model); ++link) {
    if (links_joined(model, 0, link)) links |= 1U << link;
  }
  return links;
}

CellContact nearest_obstacle(const RobotBodies& robot, const JointArray& q,
                             std::span<const CellObstacle> obstacles) {
  CellContact nearest{.distance = kInfinity};
  std::array<CellBody, kCollisionShapesMax> own;
  kinematics::PoseBP X_near = robot.start_pose();
  if (!robot.place({q, {}}, X_near, own)) return {.distance = -kInfinity};
  for (std::size_t o = 0; o < obstacles.size(); ++o) {
    for (std::size_t i = 0; i < robot.size(); ++i) {
      if (robot.stands(i) || (obstacles[o].excused >> own[i].link & 1U) != 0) continue;
      for (const CellBody& body : obstacles[o].claim->bodies()) {
        if (ball_distance(own[i], body) >= nearest.distance) continue;
        const double apart = distance(own[i], body);
        if (apart >= nearest.distance) continue;
        nearest = {o, own[i].link, body.link, 0, apart, obstacles[o].margin, true};
      }
    }
  }
  return nearest;
}

}  // namespace sinew::planning
