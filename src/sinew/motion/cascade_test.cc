#include "sinew/motion/cascade.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/property.h"

namespace sinew::motion {
namespace {

CascadeSettings settings() {
  return {.rate_max = 0.5, .dead_band = 1e-4};
}

/// A motor that makes every step, behind a load that bends its field by `bend`.
struct Motor {
  double q = 0;
  double qd = 0;
  double field = 0;
  void advance(double rate, double bend, double dt) {
    field += rate * dt;
    const double next = field - bend;
    qd = (next - q) / dt;
    q = next;
  }
};

TEST(Cascade, reference_is_fed_forward_without_a_lag) {
  Cascade cascade(settings());
  Motor motor;
  double worst = 0;
  for (int i = 1; i <= 3000; ++i) {
    const double q_ref = 0.2 * i * 1e-3;
    motor.advance(cascade.rate(q_ref, 0.2, motor.q, motor.qd, 1e-3), 0, 1e-3);
    if (i > 1000) worst = std::max(worst, std::abs(q_ref - motor.q));
  }
  EXPECT_LT(worst, 3e-4);
}

TEST(Cascade, without_feed_forward_it_lags_by_speed_over_gain) {
  CascadeSettings blind = settings();
  blind.feed_forward = 0;
  blind.integral_gain = 0;
  Cascade cascade(blind);
  Motor motor;
  double lag = 0;
  for (int i = 1; i <= 3000; ++i) {
    const double q_ref = 0.2 * i * 1e-3;
    motor.advance(cascade.rate(q_ref, 0.2, motor.q, motor.qd, 1e-3), 0, 1e-3);
    lag = q_ref - motor.q;
  }
  EXPECT_NEAR(lag, 0.2 / blind.position_gain, 1e-3);
}

TEST(Cascade, load_is_taken_out_in_a_second) {
  Cascade cascade(settings());
  Motor motor;
  for (int i = 0; i < 1000; ++i) {
    motor.advance(cascade.rate(0, 0, motor.q, motor.qd, 1e-3), 0.01, 1e-3);
  }
  EXPECT_LT(std::abs(motor.q), 2e-4);
}

TEST(Cascade, small_errors_at_rest_are_left_alone) {
  Cascade cascade(settings());
  EXPECT_EQ(cascade.rate(1, 0, 1 + 0.9e-4, 0, 1e-3), 0);
  EXPECT_EQ(cascade.rate(1, 0, 1 - 0.9e-4, 0, 1e-3), 0);
  EXPECT_NE(cascade.rate(1, 0, 1 - 1.1e-4, 0, 1e-3), 0);
  EXPECT_NE(cascade.rate(1, 0.1, 1, 0, 1e-3), 0);
}

TEST(Cascade, integral_does_not_wind_up_against_the_limit) {
  Cascade cascade(settings());
  for (int i = 0; i < 10'000; ++i) EXPECT_LE(cascade.rate(10, 0, 0, 0, 1e-3), 0.5);
  EXPECT_LE(std::abs(cascade.integral()), 0.05 * 0.5);
  // What was blocked for ten seconds comes free and is there without a swing.
  Motor motor{.q = 9.9, .qd = 0, .field = 9.9};
  double most = 0;
  for (int i = 0; i < 3000; ++i) {
    motor.advance(cascade.rate(10, 0, motor.q, motor.qd, 1e-3), 0, 1e-3);
    most = std::max(most, motor.q);
  }
  EXPECT_LT(most, 10.002);
  EXPECT_NEAR(motor.q, 10, 3e-4);
}

TEST(Cascade, output_never_passes_its_limit) {
  test::for_random_cases(20'000, [](test::Random& random) {
    Cascade cascade(settings());
    for (int i = 0; i < 20; ++i) {
      const double rate =
          cascade.rate(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9),
                       random.uniform(-9, 9), random.uniform(1e-4, 1e-2));
      ASSERT_LE(std::abs(rate), 0.5);
    }
  });
}

}  // namespace
}  // namespace sinew::motion
