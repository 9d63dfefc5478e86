#include "sinew/core/rotation.h"

#include <gtest/gtest.h>

#include "sinew/core/pose.h"
#include "sinew/core/units.h"
#include "support/property.h"

namespace sinew {
namespace {

double largest_difference(const Rotation& A, const Rotation& B) {
  return std::max({norm(A.x - B.x), norm(A.y - B.y), norm(A.z - B.z)});
}

Rotation random_rotation(test::Random& random) {
  const Vec3 axis =
      normalized({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1) + 1e-9});
  return rotation_from_vector(random.uniform(0, kPi) * axis);
}

TEST(Rotation, every_way_of_writing_it_gives_it_back) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const Rotation R = random_rotation(random);
    EXPECT_LT(largest_difference(R, rotation_from_vector(rotation_vector(R))), 1e-9);
    EXPECT_LT(largest_difference(R, rotation_from_quaternion(quaternion_wxyz(R))), 1e-12);
    EXPECT_LT(largest_difference(R, rotation_from_fixed_xyz(fixed_xyz(R))), 1e-9);
    EXPECT_LT(largest_difference(R * R.transposed(), Rotation{}), 1e-12);
  });
}

TEST(Rotation, fixed_xyz_turns_about_x_first) {
  const Rotation R = rotation_from_fixed_xyz({from_deg(90), 0, from_deg(90)});
  // x stays under the first turn and goes to y under the second.
  EXPECT_LT(norm(R * Vec3{1, 0, 0} - Vec3{0, 1, 0}), 1e-15);
  EXPECT_LT(norm(R * Vec3{0, 1, 0} - Vec3{0, 0, 1}), 1e-15);
}

TEST(Rotation, fixed_xyz_at_vertical_pitch_keeps_the_rotation) {
  for (const double pitch_deg : {90.0, -90.0}) {
    const Rotation R = rotation_from_fixed_xyz({0.3, from_deg(pitch_deg), -0.4});
    EXPECT_LT(largest_difference(R, rotation_from_fixed_xyz(fixed_xyz(R))), 1e-9);
  }
}

TEST(Rotation, vector_of_half_a_turn_is_pi_long) {
  EXPECT_NEAR(norm(rotation_vector(rotation_x(kPi))), kPi, 1e-9);
  EXPECT_NEAR(angle_between(rotation_z(1.0), rotation_z(-1.0)), 2.0, 1e-12);
}

TEST(Pose, inverse_undoes_and_product_reads_from_left_to_right) {
  test::for_random_cases(10'000, [](test::Random& random) {
    const Pose<frame::Base, frame::Flange> X_BF{random_rotation(random), {1, -2, 3}};
    const Pose<frame::Flange, frame::Tool> X_FT{random_rotation(random), {0, 0.5, 0}};
    const Pose<frame::Base, frame::Tool> X_BT = X_BF * X_FT;
    EXPECT_LT(norm(X_BT.p - X_BF * X_FT.p), 1e-12);
    const Pose<frame::Base, frame::Base> identity = X_BT * X_BT.inverse();
    EXPECT_LT(norm(identity.p), 1e-12);
    EXPECT_LT(largest_difference(identity.R, Rotation{}), 1e-12);
  });
}

}  // namespace
}  // namespace sinew
