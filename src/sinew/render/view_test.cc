#include "sinew/render/view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/render/prints.h"
#include "sinew/render/table_scene.h"
#include "sinew/render/tracer.h"
#include "sinew/vision/shapes.h"
#include "support/property.h"

namespace sinew::render {
namespace {

Scene lit_table() {
  Scene scene;
  scene.solids.push_back({Ground{}, {}, {}});
  scene.lamps.push_back({{0.5, 0, 1}, 0.01, {1, 1, 1}});
  return scene;
}

float grey(const Rgb& light) {
  return (light.r + light.g + light.b) / 3;
}

TEST(Tracer, finds_what_a_look_at_each_solid_alone_finds) {
  test::for_random_cases(60, [](test::Random& random) {
    Scene scene;
    const auto count = random.integer(1, 60);
    for (int i = 0; i < count; ++i) {
      Solid solid;
      const double size = random.uniform(0.01, 0.1);
      switch (random.integer(0, 3)) {
        case 0:
          solid.form = box({size, 0.5 * size, 0.7 * size});
          break;
        case 1:
          solid.form = prism(6, size, 0.5 * size);
          break;
        case 2:
          solid.form = Cylinder{size, 0.6 * size};
          break;
        default:
          solid.form = Ball{size};
      }
      solid.X_WS = {
          rotation_from_vector(
              {random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)}),
          {random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)}};
      scene.solids.push_back(solid);
    }
    const Tracer all(scene);
    for (int k = 0; k < 50; ++k) {
      const Vec3 from{random.uniform(-1, 1), random.uniform(-1, 1), 1.2};
      const Vec3 to{random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4),
                    random.uniform(-0.4, 0.4)};
      const Ray ray{from, normalized(to - from)};
      std::optional<Hit> nearest;
      for (std::size_t i = 0; i < scene.solids.size(); ++i) {
        const Scene alone{{scene.solids[i]}, {}};
        const auto hit = Tracer(alone).nearest(ray);
        if (hit && (!nearest || hit->distance < nearest->distance)) {
          nearest = hit;
          nearest->solid = i;
        }
      }
      const auto hit = all.nearest(ray);
      ASSERT_EQ(hit.has_value(), nearest.has_value());
      if (!hit) continue;
      EXPECT_EQ(hit->solid, nearest->solid);
      EXPECT_DOUBLE_EQ(hit->distance, nearest->distance);
      EXPECT_LT(dot(hit->normal_W, ray.toward), 1e-9);
      EXPECT_TRUE(all.is_blocked(ray, hit->distance + 1e-9));
      EXPECT_FALSE(all.is_blocked(ray, hit->distance - 1e-9));
    }
  });
}

TEST(View, cube_is_seen_where_the_camera_model_says_and_its_shadow_falls_away_from_the_lamp) {
  Scene scene = lit_table();
  const double edge = 0.03;
  scene.solids.push_back({box({edge / 2, edge / 2, edge / 2}),
                          {rotation_z(0.4), {0.02, 0.01, edge / 2}},
                          {from_srgb(0xC02020), 0, 0.3F, {}}});
  const auto camera = vision::pinhole(320, 240, from_deg(50));
  const auto X_WC = looking_at({0.05, -0.2, 0.35}, {0, 0, 0});
  const View view = view_of(scene, camera, X_WC, 1);
  const auto p = camera.project(X_WC.inverse() * Vec3{0.02, 0.01, edge});
  ASSERT_TRUE(p);
  const auto at = [&](double x, double y) {
    return static_cast<std::size_t>(static_cast<int>(y) * view.width + static_cast<int>(x));
  };
  EXPECT_EQ(view.solids[at(p->x, p->y)], 1);
  EXPECT_TRUE(view.upward[at(p->x, p->y)]);
  const Rgb red = view.light[at(p->x, p->y)];
  EXPECT_GT(red.r, 3 * red.g);
  // The lamp is at +x: 25 mm on the other side of the cube its shadow lies on the table.
  const auto shadow = camera.project(X_WC.inverse() * Vec3{-0.004, 0.01, 0});
  const auto sunny = camera.project(X_WC.inverse() * Vec3{-0.05, 0.01, 0});
  ASSERT_TRUE(shadow && sunny);
  EXPECT_LT(grey(view.light[at(shadow->x, shadow->y)]),
            0.6F * grey(view.light[at(sunny->x, sunny->y)]));
}

TEST(View, same_seed_same_bytes_and_another_seed_other_noise) {
  const auto taken_with = [](std::uint64_t scene, std::uint64_t noise) {
    TableScene table = random_table(scene, {.width = 96, .height = 72});
    const View view = view_of(table.scene, table.camera, table.X_WC, scene);
    return taken(view, table.sensor, noise).rgb;
  };
  EXPECT_EQ(taken_with(5, 1), taken_with(5, 1));
  EXPECT_NE(taken_with(5, 1), taken_with(5, 2));
  EXPECT_NE(taken_with(5, 1), taken_with(6, 1));
}

TEST(View, brightness_follows_exposure_and_burns_out) {
  const Scene scene = lit_table();
  const auto camera = vision::pinhole(32, 24, from_deg(40));
  const View view = view_of(scene, camera, looking_at({0, 0, 0.3}, {0, 0, 0}), 1);
  const auto mean = [&](double exposure) {
    const auto picture = taken(view, {.exposure = exposure}, 1);
    double sum = 0;
    for (const std::uint8_t byte : picture.rgb) sum += byte;
    return sum / static_cast<double>(picture.rgb.size());
  };
  EXPECT_LT(mean(0.3), 0.8 * mean(0.6));
  EXPECT_GT(mean(50), 254);
  EXPECT_NEAR(mean(exposure_for(view, 0.18)), 118, 12) << "grey of 18 %";
}

TEST(View, rolling_shutter_shows_what_moves_aslant) {
  std::vector<View> views;
  for (int i = 0; i < 10; ++i) {
    View view{20, 10, std::vector<Rgb>(200), std::vector<std::uint16_t>(200), {}};
    for (int y = 0; y < 10; ++y) view.light[static_cast<std::size_t>(20 * y + 2 * i)] = {1, 1, 1};
    views.push_back(view);
  }
  const View mixed = rolling_shutter(views, 0.1);
  const auto brightest = [&](int y) {
    const auto row = mixed.light.begin() + 20 * y;
    return std::ranges::max_element(row, row + 20, {}, &Rgb::r) - row;
  };
  EXPECT_EQ(brightest(0), 0);
  EXPECT_EQ(brightest(9), 16);
  EXPECT_LT(rolling_shutter(views, 1).light[0].r, 0.11F) << "all of them in every row";
}

TEST(TableScene, tops_are_where_their_pixels_are_and_hidden_ones_say_so) {
  int open = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    TableScene table =
        random_table(seed, {.width = 160, .height = 120, .edge_least = 8, .edge_most = 24});
    const View view = view_of(table.scene, table.camera, table.X_WC, seed);
    measure_tops(table, view);
    for (const PlacedCube& cube : table.cubes) {
      EXPECT_LE(cube.seen, 1.35);
      const vision::Pixel p = vision::middle_of(cube.top);
      if (cube.seen < 0.9 || p.x < 1 || p.y < 1 || p.x > 159 || p.y > 119) continue;
      ++open;
      const auto i = static_cast<std::size_t>(static_cast<int>(p.y) * 160 + static_cast<int>(p.x));
      EXPECT_EQ(view.solids[i], cube.solid) << seed;
    }
  }
  EXPECT_GT(open, 20);
}

}  // namespace
}  // namespace sinew::render
