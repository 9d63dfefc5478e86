#pragma once

#include "sinew/core/units.h"
#include "sinew/render/table_scene.h"

/// What a camera over a table sees, for tests of verbs that look.
namespace sinew::test {

inline constexpr double kEdge = 0.025;  // m
inline const auto kX_WC = render::looking_at({0.02, -0.05, 0.3}, {0, 0, 0});

/// A white table with a red cube in its middle, on what `levels` below it are.
inline vision::Picture table(int levels = 0) {
  render::Scene scene;
  scene.solids.push_back({render::Ground{}, {}, {.color = render::from_srgb(0xD7D4CD)}});
  for (int i = 0; i <= levels; ++i) {
    scene.solids.push_back({render::box({kEdge / 2, kEdge / 2, kEdge / 2}, 0.03 * kEdge),
                            {rotation_z(0.3), {0, 0, (i + 0.5) * kEdge}},
                            {.color = render::from_srgb(i == levels ? 0xBE1E23 : 0x234BA5)}});
  }
  scene.lamps.push_back({{0.4, 0.3, 0.9}, 0.1, {0.7F, 0.7F, 0.7F}});
  const auto view = render::view_of(scene, vision::pinhole(320, 240, from_deg(50)), kX_WC, 1);
  return render::taken(view, {.exposure = render::exposure_for(view, 0.35)}, 1);
}

}  // namespace sinew::test
