// The first contact of a motion: parts of its way, as finely as their surroundings ask.

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/planning/collision/cell_claim.h"

namespace sinew::planning {
namespace {

/// Looks at parts of one way. Who needs more goes along something for so long that nobody can tell
/// in time whether it touches: refused.
constexpr std::size_t kLooksMax = 50'000;
/// Pairs that begin too near.
constexpr std::size_t kLeavingMax = 512;

/// A shape and a body that begin nearer than the margin, and how near they may be from here on.
struct Leaving {
  std::size_t shape = 0;
  std::size_t obstacle = 0;
  std::size_t body = 0;
  double least = 0;
};

class Search {
 public:
  Search(const RobotBodies& robot, std::span<const CellObstacle> obstacles)
      : robot_(robot), obstacles_(obstacles), X_near_(robot.start_pose()) {}

  std::optional<CellContact> begin(const JointArray& q);
  std::optional<CellContact> along(const CellWay& way);

 private:
  struct Slack {
    double slack = kInfinity;  ///< m that are left beyond what is asked for
    CellContact contact;
  };
  Slack look(const JointBox& box, bool any);
  void look_at(std::size_t obstacle, std::size_t shape, const CellBlock& block, Slack& worst) const;
  double least(std::size_t shape, std::size_t obstacle, std::size_t body) const;
  void go_on();

  const RobotBodies& robot_;
  std::span<const CellObstacle> obstacles_;
  kinematics::PoseBP X_near_;
  std::array<CellBody, kCollisionShapesMax> own_;
  std::vector<Leaving> leaving_;
};

double Search::least(std::size_t shape, std::size_t obstacle, std::size_t body) const {
  for (const Leaving& pair : leaving_) {
    if (pair.shape == shape && pair.obstacle == obstacle && pair.body == body) return pair.least;
  }
  return obstacles_[obstacle].margin;
}

/// What is nearer than its margin already may only come apart, where it is known what that means.
std::optional<CellContact> Search::begin(const JointArray& q) {
  if (!robot_.place({q, {}}, X_near_, own_)) return CellContact{.distance = -kInfinity};
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    const CellObstacle& obstacle = obstacles_[o];
    const auto bodies = obstacle.claim->bodies();
    for (std::size_t i = 0; i < robot_.size(); ++i) {
      if (robot_.stands(i) || (obstacle.excused >> own_[i].link & 1U) != 0) continue;
      const CellBlock block = block_around(own_[i]);
      if (block.distance(obstacle.claim->block()) >= obstacle.margin) continue;
      for (std::size_t b = 0; b < bodies.size(); ++b) {
        if (ball_distance(own_[i], bodies[b]) >= obstacle.margin) continue;
        const double apart = distance(own_[i], bodies[b]);
        if (apart >= obstacle.margin) continue;
        if (!obstacle.claim->sure || leaving_.size() == kLeavingMax) {
          return CellContact{o, own_[i].link, bodies[b].link, 0, apart, obstacle.margin, true};
        }
        leaving_.push_back({i, o, b, apart - 2 * kCellResolution});
      }
    }
  }
  return std::nullopt;
}

void Search::look_at(std::size_t o, std::size_t shape, const CellBlock& block, Slack& worst) const {
  const CellObstacle& obstacle = obstacles_[o];
  const double enough = std::min(worst.slack, 0.0) + obstacle.margin;
  const CellClaim& claim = *obstacle.claim;
  for (const CellClaim::Group& group : claim.groups()) {
    if (block.distance(group.block) >= enough) continue;
    for (std::size_t b = group.begin; b < group.end; ++b) {
      const CellBody& body = claim.bodies()[b];
      if (ball_distance(own_[shape], body) >= std::min(worst.slack, 0.0) + obstacle.margin) {
        continue;
      }
      const double apart = distance(own_[shape], body);
      const double asked = leaving_.empty() ? obstacle.margin : least(shape, o, b);
      if (apart - asked >= worst.slack) continue;
      worst.slack = apart - asked;
      worst.contact = {
          o, own_[shape].link, body.link, 0, apart + own_[shape].swell, obstacle.margin, false};
    }
  }
}

/// Everything that a box of joints may be, against everything.
/// @param any  the first that is too near will do, and not the one that is most so
Search::Slack Search::look(const JointBox& box, bool any) {
  Slack worst;
  if (!robot_.place(box, X_near_, own_)) {
    worst.slack = worst.contact.distance = -kInfinity;
    return worst;
  }
  CellBlock all;
  std::array<CellBlock, kCollisionShapesMax> blocks;
  for (std::size_t i = 0; i < robot_.size(); ++i) {
    if (robot_.stands(i)) continue;
    blocks[i] = block_around(own_[i]);
    all.add(blocks[i]);
  }
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    const CellObstacle& obstacle = obstacles_[o];
    if (all.distance(obstacle.claim->block()) >= obstacle.margin) continue;
    for (std::size_t i = 0; i < robot_.size(); ++i) {
      if (robot_.stands(i) || (obstacle.excused >> own_[i].link & 1U) != 0) continue;
      if (blocks[i].distance(obstacle.claim->block()) >= obstacle.margin) continue;
      look_at(o, i, blocks[i], worst);
      if (any && worst.slack < 0) return worst;
    }
  }
  return worst;
}

/// The bodies are where the last part has its middle: what has come apart stays so.
void Search::go_on() {
  for (Leaving& pair : leaving_) {
    const CellObstacle& obstacle = obstacles_[pair.obstacle];
    const double apart =
        distance(own_[pair.shape], obstacle.claim->bodies()[pair.body]) + own_[pair.shape].swell;
    pair.least = std::max(pair.least, std::min(obstacle.margin, apart - 2 * kCellResolution));
  }
}

std::optional<CellContact> Search::along(const CellWay& way) {
  std::optional<CellContact> found;
  std::size_t looks = 0;
  way.walk([&](const CellWay::Part& part) {
    const bool fine = robot_.swell(part.box.half) <= kCellResolution || ++looks >= kLooksMax;
    const Slack worst = look(part.box, !fine);
    if (worst.slack >= 0) {
      go_on();
      return CellWay::Next::kOn;
    }
    if (!fine) return CellWay::Next::kFiner;
    found = worst.contact;
    found->share = part.begin;
    return CellWay::Next::kEnd;
  });
  return found;
}

}  // namespace

std::optional<CellContact> first_contact(const RobotBodies& robot, const CellWay& way,
                                         std::span<const CellObstacle> obstacles) {
  if (robot.size() == 0 || obstacles.empty() || way.empty()) return std::nullopt;
  if (!way.known()) {
    // Nothing is known but how far it reaches.
    const CellClaim all = claim_of_reach(robot);
    std::optional<CellContact> nearest;
    for (std::size_t o = 0; o < obstacles.size(); ++o) {
      for (const CellBody& own : all.bodies()) {
        if (own.link == 0 || (obstacles[o].excused >> own.link & 1U) != 0) continue;
        for (const CellBody& body : obstacles[o].claim->bodies()) {
          const double apart = distance(own, body);
          if (apart >= obstacles[o].margin || (nearest && apart >= nearest->distance)) continue;
          nearest = {o, own.link, body.link, 0, apart, obstacles[o].margin, true};
        }
      }
    }
    return nearest;
  }
  Search search(robot, obstacles);
  if (const auto contact = search.begin(way.start())) return contact;
  return search.along(way);
}

}  // namespace sinew::planning
