#include "sinew/planning/collision/collision.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/model/collision_links.h"
#include "sinew/model/left_out.h"

namespace sinew::planning {
namespace {

using kinematics::PoseBL;
using kinematics::PoseBP;

const JawGripper* gripper_of(const RobotModel& model) {
  const auto* serial = std::get_if<SerialGeometry>(&model.geometry);
  return serial != nullptr && serial->gripper ? &*serial->gripper : nullptr;
}

bool of_gripper(const CollisionShape& shape) {
  return std::holds_alternative<JawFinger>(shape.form) ||
         std::holds_alternative<HeldBall>(shape.form);
}

/// The shapes as this model places them: those of a chain's tool stand on its last link.
std::vector<CollisionShape> placed_shapes(const RobotModel& model) {
  std::vector<CollisionShape> shapes = model.collision.shapes;
  SINEW_ASSERT(shapes.size() <= kCollisionShapesMax);
  const auto* serial = std::get_if<SerialGeometry>(&model.geometry);
  if (serial == nullptr) return shapes;
  const auto X_LT = relabel<frame::Link, frame::Link>(serial->X_FT);
  for (CollisionShape& shape : shapes) {
    if (shape.link <= model.joints.size()) continue;
    shape.link = static_cast<std::uint8_t>(model.joints.size());
    if (auto* capsule = std::get_if<Capsule>(&shape.form)) {
      capsule->p_LA = X_LT * capsule->p_LA;
      capsule->p_LB = X_LT * capsule->p_LB;
    } else if (auto* box = std::get_if<CollisionBox>(&shape.form)) {
      box->X_LX = X_LT * box->X_LX;
    }
    if (of_gripper(shape)) shape.form = Capsule{};  // fit() makes it
  }
  return shapes;
}

double radius_of(const CollisionShape& shape) {
  if (const auto* capsule = std::get_if<Capsule>(&shape.form)) return capsule->radius;
  if (const auto* leg = std::get_if<LegCapsule>(&shape.form)) return leg->radius;
  return 0;
}

bool is_box(const CollisionShape& shape) {
  return std::holds_alternative<CollisionBox>(shape.form);
}

std::variant<kinematics::SerialChain, PalletizerGeometry, kinematics::Hexapod> kinematics_of(
    const Geometry& geometry) {
  if (const auto* serial = std::get_if<SerialGeometry>(&geometry)) {
    return kinematics::SerialChain(*serial);
  }
  if (const auto* palletizer = std::get_if<PalletizerGeometry>(&geometry)) return *palletizer;
  return kinematics::Hexapod(std::get<HexapodGeometry>(geometry));
}

}  // namespace

std::uint8_t link_of(const RobotModel& model, std::uint8_t shape) {
  if (shape == kTableShape) return kTableLink;
  const auto& shapes = model.collision.shapes;
  return shape < shapes.size() ? shapes[shape].link : kObstacleLink;
}

Error contact_error(const RobotModel& model, const Clearance& nearest) {
  const double margin = model.collision.margin;
  return {.code = ErrorCode::kCollision,
          .index = static_cast<std::int8_t>(link_of(model, nearest.first)),
          // What counts as at the margin may lie a hair beyond it.
          .measured = std::isfinite(nearest.distance) ? std::min(nearest.distance, margin) : 0,
          .limit = margin,
          .other = static_cast<std::int16_t>(link_of(model, nearest.second))};
}

CollisionModel::CollisionModel(const RobotModel& model)
    : model_(&model), robot_(kinematics_of(model.geometry)), shapes_(placed_shapes(model)) {
  own_shapes_ = shapes_.size();
  lay_poses();
  for (const CollisionShape& shape : shapes_) radii_.push_back(radius_of(shape));
  const std::vector<CollisionShape>& named = model.collision.shapes;
  const auto checked = [&](std::size_t first, std::size_t second) {
    return !links_joined(model, first, second) && !holds(model.collision.ignored, first, second);
  };
  for (std::size_t i = 0; i < named.size(); ++i) {
    for (std::size_t j = i + 1; j < named.size(); ++j) {
      if (!checked(named[i].link, named[j].link)) continue;
      pairs_.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(j), {}});
    }
    if (!model.collision.table_height || !checked(named[i].link, kTableLink)) continue;
    pairs_.push_back({static_cast<std::uint8_t>(i), kTableShape, {}});
  }
  own_pairs_ = pairs_.size();
  shapes_.reserve(own_shapes_ + kSurroundMax);
  radii_.reserve(own_shapes_ + kSurroundMax);
  pairs_.reserve(own_pairs_ + own_shapes_ * kSurroundMax);
  fit({});
  for (Pair& pair : pairs_) set_reach(pair);
}

/// The range of each joint that is left out in equal parts, each with each; a turn is enough.
void CollisionModel::lay_poses() {
  poses_.resize(1);
  for (std::size_t j = 0; j < model_->joints.size(); ++j) {
    if (is_left_out(*model_, j)) left_out_.push_back(static_cast<std::uint8_t>(j));
  }
  if (left_out_.empty()) return;
  constexpr double kRounding = 1e-9;
  const double share = 1.0 / static_cast<double>(left_out_.size());
  const auto parts =
      static_cast<std::size_t>(std::pow(static_cast<double>(kPosesMax), share) + kRounding);
  for (const std::uint8_t j : left_out_) {
    const Joint& joint = model_->joints[j];
    const bool turns = joint.kind == JointKind::kRevolute;
    const double all = joint.upper - joint.lower;
    const double range = turns ? std::min(all, 2 * kPi) : all;
    const double half = range / static_cast<double>(2 * parts);
    pose_half_[j] = half;
    const std::vector<JointArray> before = std::exchange(poses_, {});
    for (JointArray pose : before) {
      for (std::size_t k = 0; k < parts; ++k) {
        pose[j] = joint.lower + half * static_cast<double>(2 * k + 1);
        poses_.push_back(pose);
      }
    }
  }
}

void CollisionModel::set_reach(Pair& pair) const {
  pair.reach = pair_reach(pair);
  pair.blur = 0;
  for (const std::uint8_t j : left_out_) pair.blur += pose_half_[j] * pair.reach[j];
}

JointArray CollisionModel::posed(std::span<const double> q, std::size_t pose) const {
  JointArray at{};
  std::ranges::copy(q, at.begin());
  for (const std::uint8_t j : left_out_) at[j] = poses_[pose][j];
  return at;
}

JointReach CollisionModel::pair_reach(const Pair& pair) const {
  if (pair.second >= own_shapes_ && pair.second != kTableShape) return reach_of(pair.first);
  const CollisionShape* second = pair.second == kTableShape ? nullptr : &shapes_[pair.second];
  return joint_reach(*model_, shapes_[pair.first], second);
}

void CollisionModel::fit_fingers(double least, double most) {
  const auto& geometry = std::get<SerialGeometry>(model_->geometry);
  const auto X_LT = relabel<frame::Link, frame::Link>(geometry.X_FT);
  for (std::size_t i = 0; i < own_shapes_; ++i) {
    const auto* finger = std::get_if<JawFinger>(&model_->collision.shapes[i].form);
    if (finger == nullptr) continue;
    CollisionBox box = finger_box(*finger, *geometry.gripper, least, most);
    box.X_LX = X_LT * box.X_LX;
    shapes_[i].form = box;
  }
}

void CollisionModel::fit_held(double held, double width) {
  const auto& geometry = std::get<SerialGeometry>(model_->geometry);
  const auto X_LT = relabel<frame::Link, frame::Link>(geometry.X_FT);
  for (std::size_t i = 0; i < own_shapes_; ++i) {
    if (!std::holds_alternative<HeldBall>(model_->collision.shapes[i].form)) continue;
    Capsule ball = held_ball(held, *geometry.gripper, width, margin());
    ball.p_LA = ball.p_LB = X_LT * ball.p_LA;
    shapes_[i].form = ball;
    radii_[i] = ball.radius;
  }
}

void CollisionModel::fit(const ToolState& tool) {
  const JawGripper* gripper = gripper_of(*model_);
  if (gripper == nullptr) return;
  fit_fingers(tool.jaws.value_or(0), tool.jaws.value_or(gripper->width_max));
  fit_held(tool.held.value_or(0), tool.jaws.value_or(gripper->width_max));
  const auto moved = [&](std::uint8_t shape) {
    return shape < own_shapes_ && of_gripper(model_->collision.shapes[shape]);
  };
  for (Pair& pair : pairs_) {
    if (moved(pair.first) || moved(pair.second)) set_reach(pair);
  }
}

std::optional<Error> CollisionModel::jaws_contact(std::span<const double> q, const ToolState& from,
                                                  double to) {
  const JawGripper* gripper = gripper_of(*model_);
  if (gripper == nullptr) return std::nullopt;
  fit(from);
  const double least = std::min(margin(), distance(q).distance) - kResolution;
  fit_fingers(std::min(from.jaws.value_or(0), to),
              std::max(from.jaws.value_or(gripper->width_max), to));
  fit_held(0, to);
  const Clearance near = distance(q);
  fit(from);
  if (near.distance >= least) return std::nullopt;
  Error error = contact_error(*model_, near);
  const double farther =
      jaw_reach(*gripper, to) - jaw_reach(*gripper, from.jaws.value_or(gripper->width_max));
  if (farther <= 0) return error;
  error.code = ErrorCode::kJawsContact;
  error.limit = farther;
  return error;
}

void CollisionModel::surround(std::span<const Surrounding> bodies) {
  SINEW_ASSERT(bodies.size() <= kSurroundMax);
  shapes_.resize(own_shapes_);
  radii_.resize(own_shapes_);
  pairs_.resize(own_pairs_);
  for (const Surrounding& body : bodies) {
    const auto place = static_cast<std::uint8_t>(shapes_.size());
    shapes_.push_back(body.shape);
    radii_.push_back(radius_of(body.shape));
    for (std::size_t i = 0; i < own_shapes_; ++i) {
      const std::uint8_t link = model_->collision.shapes[i].link;
      if (link == 0 || (body.excused >> link & 1U) != 0) continue;
      pairs_.push_back({static_cast<std::uint8_t>(i), place, {}});
      set_reach(pairs_.back());
    }
  }
}

PoseBP CollisionModel::start(const PoseBP* X_near) const {
  if (X_near != nullptr) return *X_near;
  const auto* geometry = std::get_if<HexapodGeometry>(&model_->geometry);
  return geometry != nullptr ? geometry->X_BP_home : PoseBP{};
}

void CollisionModel::place_shapes(Scene& scene) const {
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    const PoseBL& X_BL = scene.X_BL[shapes_[i].link];
    Placed& placed = scene.shapes[i];
    if (const auto* capsule = std::get_if<Capsule>(&shapes_[i].form)) {
      placed.a = X_BL * capsule->p_LA;
      placed.b = X_BL * capsule->p_LB;
    } else if (const auto* box = std::get_if<CollisionBox>(&shapes_[i].form)) {
      placed.centre = X_BL * box->X_LX.p;
      placed.ball = norm(box->half);
      continue;
    }
    placed.centre = 0.5 * (placed.a + placed.b);
    placed.ball = 0.5 * norm(placed.b - placed.a) + radii_[i];
  }
}

void CollisionModel::place_platform(const PoseBP& X_BP, Scene& scene) const {
  const auto& geometry = std::get<HexapodGeometry>(model_->geometry);
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    if (!std::holds_alternative<LegCapsule>(shapes_[i].form)) continue;
    const std::size_t leg = shapes_[i].link - 1U;
    scene.shapes[i].a = geometry.p_BA[leg];
    scene.shapes[i].b = X_BP * geometry.p_PA[leg];
  }
  scene.X_BL[kLegs + 1] = relabel<frame::Base, frame::Link>(X_BP);
  place_shapes(scene);
}

bool CollisionModel::place(std::span<const double> q, PoseBP& X_near, Scene& scene) const {
  SINEW_ASSERT(q.size() == model_->joints.size());
  if (const auto* chain = std::get_if<kinematics::SerialChain>(&robot_)) {
    chain->frames(q, {scene.X_BL.data() + 1, q.size()});
    place_shapes(scene);
    return true;
  }
  if (const auto* geometry = std::get_if<PalletizerGeometry>(&robot_)) {
    std::ranges::copy(kinematics::palletizer_links(*geometry, q), scene.X_BL.begin() + 1);
    place_shapes(scene);
    return true;
  }
  const auto found = std::get<kinematics::Hexapod>(robot_).forward(JointVector(q), X_near);
  if (!found) return false;
  X_near = found->X_BP;
  place_platform(X_near, scene);
  return true;
}

PlacedCapsule CollisionModel::capsule(const Scene& scene, std::size_t shape) const {
  return {scene.shapes[shape].a, scene.shapes[shape].b, radii_[shape]};
}

PlacedBox CollisionModel::box(const Scene& scene, std::size_t shape) const {
  const auto& form = std::get<CollisionBox>(shapes_[shape].form);
  return {scene.X_BL[shapes_[shape].link] * form.X_LX, form.half};
}

double CollisionModel::distance(const Scene& scene, const Pair& pair) const {
  const std::size_t i = pair.first, j = pair.second;
  const bool first_box = is_box(shapes_[i]);
  if (pair.second == kTableShape) {
    const double height = *model_->collision.table_height;
    return (first_box ? distance_above(box(scene, i), height)
                      : distance_above(capsule(scene, i), height)) -
           pair.blur;
  }
  const auto apart = [&] {
    const bool second_box = is_box(shapes_[j]);
    if (first_box && second_box) return planning::distance(box(scene, i), box(scene, j));
    if (first_box) return planning::distance(capsule(scene, j), box(scene, i));
    if (second_box) return planning::distance(capsule(scene, i), box(scene, j));
    return planning::distance(capsule(scene, i), capsule(scene, j));
  };
  return apart() - pair.blur;
}

double CollisionModel::ball_distance(const Scene& scene, const Pair& pair) const {
  const Placed& first = scene.shapes[pair.first];
  if (pair.second == kTableShape) {
    return first.centre.z - first.ball - *model_->collision.table_height - pair.blur;
  }
  const Placed& second = scene.shapes[pair.second];
  return norm(first.centre - second.centre) - first.ball - second.ball - pair.blur;
}

Clearance CollisionModel::nearest(const Scene& scene, std::span<const LinkPair> but) const {
  Clearance nearest;
  for (const Pair& pair : pairs_) {
    if (ball_distance(scene, pair) >= nearest.distance) continue;
    if (!but.empty() && holds(but, link_of(*model_, pair.first), link_of(*model_, pair.second))) {
      continue;
    }
    const double apart = distance(scene, pair);
    // Bodies that no joint that is left out moves say nothing of where it is.
    const bool surely = pair.blur > 0 && apart + 2 * pair.blur < -margin();
    if (apart < nearest.distance) nearest = {apart, pair.first, pair.second, nearest.surely};
    nearest.surely = nearest.surely || surely;
  }
  return nearest;
}

Clearance CollisionModel::distance(std::span<const double> q, const PoseBP* X_near,
                                   std::span<const LinkPair> but) const {
  if (left_out_.empty()) return distance_in(0, q, X_near, but);
  Clearance nearest, nearest_of_all;
  bool any = false;
  for (std::size_t pose = 0; pose < poses_.size(); ++pose) {
    const Clearance here = distance_in(pose, q, X_near, but);
    any = any || !here.surely;
    if (here.distance < nearest_of_all.distance) nearest_of_all = here;
    if (!here.surely && here.distance < nearest.distance) nearest = here;
  }
  return any ? nearest : nearest_of_all;
}

Clearance CollisionModel::distance_in(std::size_t pose, std::span<const double> q,
                                      const PoseBP* X_near, std::span<const LinkPair> but) const {
  SINEW_ASSERT(but.empty() || shapes_.size() == own_shapes_);
  Scene scene;
  PoseBP X_BP = start(X_near);
  const JointArray at = posed(q, pose);
  if (!place({at.data(), q.size()}, X_BP, scene)) {
    return {-std::numeric_limits<double>::infinity()};
  }
  return nearest(scene, but);
}

/// Where none is possible, the file's shapes are wrong: then each counts.
bool CollisionModel::possible(std::size_t pose, std::span<const double> q,
                              const PoseBP* X_near) const {
  if (left_out_.empty() || !distance_in(pose, q, X_near).surely) return true;
  for (std::size_t other = 0; other < poses_.size(); ++other) {
    if (!distance_in(other, q, X_near).surely) return false;
  }
  return true;
}

bool CollisionModel::bodies(std::span<const double> q, PoseBP& X_near,
                            std::span<PlacedShape> out) const {
  SINEW_ASSERT(out.size() >= own_shapes_);
  Scene scene;
  if (!place(q, X_near, scene)) return false;
  for (std::size_t i = 0; i < own_shapes_; ++i) {
    if (is_box(shapes_[i])) {
      out[i] = box(scene, i);
    } else {
      out[i] = capsule(scene, i);
    }
  }
  return true;
}

Clearance CollisionModel::distance(const PoseBP& X_BP) const {
  SINEW_ASSERT(std::holds_alternative<HexapodGeometry>(model_->geometry));
  Scene scene;
  place_platform(X_BP, scene);
  return nearest(scene);
}

}  // namespace sinew::planning
