#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/sim/cube_world.h"

/// Hands that do anything: what always holds of cubes.
namespace sinew::sim {
namespace {

using namespace std::chrono_literals;

constexpr double kEdge = 0.025;

HandTruth anywhere(SplitMix64& random, bool cup) {
  const Vec3 tip{random.uniform(-0.12, 0.2), random.uniform(-0.12, 0.12),
                 random.uniform(-0.002, 0.09)};
  const Rotation R = rotation_z(random.uniform(-kPi, kPi)) * rotation_y(random.uniform(-0.4, 0.4)) *
                     rotation_x(kPi);
  if (cup) return {{R, tip}, CupTruth{0.008, 0.04, random.uniform(0, 1) < 0.6}};
  return {{R, tip}, JawTruth{random.uniform(0.02, 0.06), {0.007, 0.006, 0.03}}};
}

/// How deep the worst pair is in each other, m.
double deepest(const CubeWorld& world) {
  double worst = 0;
  const auto cubes = world.cubes();
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const auto free = [](const CubeState& cube) {
        return cube.where != CubePlace::kGone && cube.where != CubePlace::kHeld;
      };
      if (!free(cubes[i]) || !free(cubes[k])) continue;
      const double high = kEdge - std::abs(cubes[i].X_WO.p.z - cubes[k].X_WO.p.z);
      if (high <= 0) continue;
      const auto square = [](const CubeState& cube) {
        return rectangle(seen_from_above(cube.X_WO.p), std::atan2(cube.X_WO.R.x.y, cube.X_WO.R.x.x),
                         {kEdge / 2, kEdge / 2});
      };
      if (const auto out = step_out(square(cubes[i]), square(cubes[k]))) {
        worst = std::max(worst, std::min(high, length(*out)));
      }
    }
  }
  return worst;
}

struct Outcome {
  std::vector<CubeState> cubes;
  std::vector<CubeEvent> events;
  double deepest_in_each_other = 0;
};

Outcome disorder(std::uint64_t seed, bool cup) {
  SplitMix64 random(seed);
  CubeWorldSettings settings;
  settings.seed = seed;
  settings.baskets = {Basket{{rotation_z(0.3), {0.2, 0, 0}}}};
  CubeWorld world(settings);
  for (int i = 0; i < 12; ++i) world.add_somewhere(kEdge, i, {0, 0}, {0.09, 0.09}, 0.002);
  for (std::size_t i = 0; i < 4; ++i) {  // towers of two
    const PlanPoint at = seen_from_above(world.cubes()[i].X_WO.p);
    world.add({.edge = kEdge, .at = at, .yaw = random.uniform(-kPi, kPi), .bottom = 0.03});
  }
  Instant now{};
  Outcome run;
  for (int i = 0; i < 40; ++i) {
    const HandTruth hand = anywhere(random, cup);
    now += 300ms;
    world.advance(now, hand);
    run.deepest_in_each_other = std::max(run.deepest_in_each_other, deepest(world));
    for (std::size_t k = 0; k < world.cubes().size(); ++k) {
      const CubeState& cube = world.cubes()[k];
      EXPECT_EQ(cube.where == CubePlace::kHeld, world.is_held(k));
      if (cube.where == CubePlace::kHeld || cube.where == CubePlace::kGone) continue;
      EXPECT_NEAR(cube.X_WO.R.z.z, 1, 1e-12) << "flat";
      EXPECT_GE(cube.X_WO.p.z, kEdge / 2 - 1e-12) << "on or above the table";
      if (cube.where == CubePlace::kTable) {
        EXPECT_NEAR(cube.X_WO.p.z, kEdge / 2, 1e-9);
      }
      EXPECT_TRUE(cube.where != CubePlace::kOnCube || cube.on);
    }
  }
  run.cubes.assign(world.cubes().begin(), world.cubes().end());
  run.events.assign(world.events().begin(), world.events().end());
  return run;
}

TEST(CubeDisorder, cubes_stay_flat_above_the_table_and_apart) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    for (const bool cup : {false, true}) {
      EXPECT_LT(disorder(seed, cup).deepest_in_each_other, 1e-4) << seed;
    }
  }
}

TEST(CubeDisorder, the_same_hands_and_seed_make_the_same_disorder) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Outcome first = disorder(seed, seed % 2 == 0);
    const Outcome second = disorder(seed, seed % 2 == 0);
    ASSERT_EQ(first.events.size(), second.events.size());
    EXPECT_GT(first.events.size(), 5U);
    for (std::size_t i = 0; i < first.events.size(); ++i) {
      EXPECT_EQ(first.events[i].time, second.events[i].time);
      EXPECT_EQ(first.events[i].kind, second.events[i].kind);
      EXPECT_EQ(first.events[i].cube, second.events[i].cube);
    }
    for (std::size_t i = 0; i < first.cubes.size(); ++i) {
      EXPECT_EQ(first.cubes[i].X_WO, second.cubes[i].X_WO);
    }
  }
}

TEST(CubeDisorder, everything_happens) {
  std::array<int, 9> kinds{};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    for (const bool cup : {false, true}) {
      for (const CubeEvent& event : disorder(seed, cup).events) {
        ++kinds[static_cast<std::size_t>(event.kind)];
      }
    }
  }
  for (std::size_t kind = 0; kind + 1 < kinds.size(); ++kind) {
    EXPECT_GT(kinds[kind], 0) << name(static_cast<CubeEvent::Kind>(kind));
  }
}

}  // namespace
}  // namespace sinew::sim
