#include "sinew/planning/collision/cell_body.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/model/left_out.h"

namespace sinew::planning {
namespace {

/// Centre, ball and what it is swollen by.
void enclose(CellBody& body, double swell) {
  body.swell = swell;
  if (const auto* capsule = std::get_if<PlacedCapsule>(&body.form)) {
    body.centre = 0.5 * (capsule->a + capsule->b);
    body.ball = 0.5 * norm(capsule->b - capsule->a) + capsule->radius + swell;
  } else {
    const auto& box = std::get<PlacedBox>(body.form);
    body.centre = box.X.p;
    body.ball = norm(box.half) + swell;
  }
}

PlacedShape moved(const PlacedShape& shape, const Pose<frame::World, frame::Base>& X_WB) {
  if (const auto* capsule = std::get_if<PlacedCapsule>(&shape)) {
    return PlacedCapsule{X_WB * capsule->a, X_WB * capsule->b, capsule->radius};
  }
  const auto& box = std::get<PlacedBox>(shape);
  return PlacedBox{relabel<frame::Base, frame::Box>(X_WB * box.X), box.half};
}

}  // namespace

double distance(const CellBody& first, const CellBody& second) {
  const auto* a = std::get_if<PlacedCapsule>(&first.form);
  const auto* b = std::get_if<PlacedCapsule>(&second.form);
  double apart = 0;
  if (a != nullptr && b != nullptr) {
    apart = distance(*a, *b);
  } else if (a != nullptr) {
    apart = distance(*a, std::get<PlacedBox>(second.form));
  } else if (b != nullptr) {
    apart = distance(*b, std::get<PlacedBox>(first.form));
  } else {
    apart = distance(std::get<PlacedBox>(first.form), std::get<PlacedBox>(second.form));
  }
  return apart - first.swell - second.swell;
}

void CellBlock::add(const CellBlock& other) {
  low = {std::min(low.x, other.low.x), std::min(low.y, other.low.y), std::min(low.z, other.low.z)};
  high = {std::max(high.x, other.high.x), std::max(high.y, other.high.y),
          std::max(high.z, other.high.z)};
}

double CellBlock::distance(const CellBlock& other) const {
  const auto gap = [](double low_a, double high_a, double low_b, double high_b) {
    return std::max({low_a - high_b, low_b - high_a, 0.0});
  };
  const double apart = norm({gap(low.x, high.x, other.low.x, other.high.x),
                             gap(low.y, high.y, other.low.y, other.high.y),
                             gap(low.z, high.z, other.low.z, other.high.z)});
  return apart > 0 ? apart : -std::numeric_limits<double>::infinity();
}

CellBlock block_around(const CellBody& body) {
  if (const auto* capsule = std::get_if<PlacedCapsule>(&body.form)) {
    const double r = capsule->radius + body.swell;
    const Vec3 round{r, r, r};
    const Vec3 &a = capsule->a, &b = capsule->b;
    return {Vec3{std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)} - round,
            Vec3{std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)} + round};
  }
  const auto& box = std::get<PlacedBox>(body.form);
  const Rotation& R = box.X.R;
  const auto along = [&](double x, double y, double z) {
    return std::abs(x) * box.half.x + std::abs(y) * box.half.y + std::abs(z) * box.half.z +
           body.swell;
  };
  const Vec3 far{along(R.x.x, R.y.x, R.z.x), along(R.x.y, R.y.y, R.z.y),
                 along(R.x.z, R.y.z, R.z.z)};
  return {box.X.p - far, box.X.p + far};
}

CellBody body_of(const CellObject& object) {
  CellBody body{.form = PlacedBox{relabel<frame::Base, frame::Box>(object.X_WX), object.half},
                .swell = 0,
                .centre = {},
                .ball = 0,
                .link = 0};
  enclose(body, 0);
  return body;
}

RobotBodies::RobotBodies(const RobotModel& model, const Pose<frame::World, frame::Base>& X_WB)
    : collision_(model),
      X_WB_(X_WB),
      hexapod_(std::holds_alternative<HexapodGeometry>(model.geometry)) {
  for (std::size_t i = 0; i < collision_.shapes(); ++i) reach_.push_back(collision_.reach_of(i));
}

double RobotBodies::swell(std::size_t shape, const JointArray& half) const {
  double sum = 0;
  if (hexapod_) {
    for (const double one : half) sum += one * one;
    return std::sqrt(sum) * reach_[shape][0];
  }
  for (std::size_t k = 0; k < kMaxJoints; ++k) sum += half[k] * reach_[shape][k];
  return sum;
}

double RobotBodies::swell(const JointArray& half) const {
  double most = 0;
  for (std::size_t i = 0; i < reach_.size(); ++i) most = std::max(most, swell(i, half));
  return most;
}

bool RobotBodies::place(const JointBox& box, kinematics::PoseBP& X_near,
                        std::span<CellBody> out) const {
  SINEW_ASSERT(out.size() >= size());
  std::array<PlacedShape, kCollisionShapesMax> placed;
  JointArray q = box.q;
  // A joint that is left out may be anywhere: no turn moves a point by more than twice its lever.
  JointArray anywhere{};
  for (std::size_t k = 0; k < joints(); ++k) {
    if (!is_left_out(model(), k)) continue;
    q[k] = assumed_place(model().joints[k]);
    anywhere[k] =
        std::min(2.0, std::max(model().joints[k].upper - q[k], q[k] - model().joints[k].lower));
  }
  if (!collision_.bodies({q.data(), joints()}, X_near, placed)) return false;
  for (std::size_t i = 0; i < size(); ++i) {
    out[i].form = moved(placed[i], X_WB_);
    out[i].link = link(i);
    enclose(out[i], swell(i, box.half) + swell(i, anywhere));
  }
  return true;
}

CellBody RobotBodies::whole_reach(std::size_t shape) const {
  const Capsule ball = collision_.ball_of(shape);
  CellBody body{.form = moved(PlacedCapsule{ball.p_LA, ball.p_LB, ball.radius}, X_WB_),
                .swell = 0,
                .centre = {},
                .ball = 0,
                .link = link(shape)};
  enclose(body, 0);
  return body;
}

}  // namespace sinew::planning
