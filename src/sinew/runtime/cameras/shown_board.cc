#include "sinew/runtime/cameras/shown_board.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/rotation.h"
#include "sinew/core/split_mix.h"
#include "sinew/core/units.h"

namespace sinew::runtime {
namespace {

/// One of the poses that a person has learned to take.
struct Held {
  double across;  ///< of the board's middle: -1 at the picture's left border, 1 at its right one
  double down;    ///< likewise, -1 at the upper border
  double nearer;  ///< share of the usual distance
  double tilt_x;  ///< deg, about the picture's x axis
  double tilt_y;  ///< deg, about its y axis
  double turn;    ///< deg, in the picture
};
constexpr std::array<Held, 12> kPoses{{{0, 0, 1, 3, 3, 0},
                                       {0.05, 0, 0.95, 30, 0, 10},
                                       {-0.05, 0, 0.95, 0, 30, 80},
                                       {-0.55, -0.5, 0.85, 12, -14, 90},
                                       {-0.1, 0.1, 0.72, -22, 16, 20},
                                       {0.1, 0, 1.15, 20, 18, 45},
                                       {0, 0.05, 0.95, -30, 4, -80},
                                       {0, 0, 0.95, 4, -30, -12},
                                       {0.55, -0.5, 0.85, 14, 12, 4},
                                       {0.55, 0.5, 0.85, -14, 14, -92},
                                       {-0.55, 0.5, 0.85, -12, -12, 0},
                                       {0, -0.1, 1.1, 18, -24, -40}}};

}  // namespace

Pose<frame::World, frame::Board> held_board(const vision::TableCamera& camera,
                                            const vision::TagBoard& board, std::uint64_t pose) {
  const vision::CameraModel& model = camera.model;
  SplitMix64 random(pose * 0x9E3779B97F4A7C15ULL + 77);
  const Held& held = kPoses[pose % kPoses.size()];
  const auto about = [&](double value, double spread) {
    return value + random.uniform(-spread, spread);
  };
  // Between the lens and the table, as near as the board fills the picture.
  const Vec3 out = camera.X_WC.R.z;
  constexpr double kShare = 0.66;
  const double table = out.z < -0.1 ? camera.X_WC.p.z / -out.z : kInfinity;
  const double full = board.height * model.fx / (0.9 * model.width);
  const double distance = std::min(kShare * table, full) * about(held.nearer, 0.03);
  const vision::Pixel middle{model.width * (0.5 + about(held.across, 0.06) / 2),
                             model.height * (0.5 + about(held.down, 0.06) / 2)};
  const Vec3 toward = model.direction(middle);
  // Its printed side to the lens, its upper edge up in the picture.
  const Rotation facing{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  Pose<frame::Camera, frame::Board> X_CP;
  X_CP.R = rotation_x(from_deg(about(held.tilt_x, 4))) *
           rotation_y(from_deg(about(held.tilt_y, 4))) * rotation_z(from_deg(about(held.turn, 6))) *
           facing;
  X_CP.p = (distance / toward.z) * toward;
  const auto lowest = [&](const Pose<frame::World, frame::Board>& X_WP) {
    double z = kInfinity;
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        z = std::min(z, (X_WP * Vec3{x * board.width, y * board.height, 0}).z);
      }
    }
    return z;
  };
  constexpr double kAbove = 0.01;  // m
  auto X_WP = camera.X_WC * X_CP;
  for (int tries = 0; tries < 20 && lowest(X_WP) < kAbove; ++tries) {
    X_CP.p = 0.95 * X_CP.p;
    X_WP = camera.X_WC * X_CP;
  }
  return X_WP;
}

render::ViewedHand holding_hand(const vision::TagBoard& board,
                                const Pose<frame::World, frame::Board>& X_WP) {
  constexpr double kGrip = 0.012;  // m, of the fingers on the board's margin
  const Vec3 out = -1.0 * X_WP.R.y;
  return {X_WP * Vec3{0, kGrip - board.height / 2, 0}, std::atan2(out.y, out.x)};
}

}  // namespace sinew::runtime
