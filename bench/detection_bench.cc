#include <benchmark/benchmark.h>

#include <algorithm>

#include "sinew/render/table_scene.h"
#include "sinew/vision/cube_detection.h"

namespace sinew::bench {
namespace {

using vision::Picture;

/// A rendered table of 1280 x 720 px, as in docs/vision.md.
const Picture& table() {
  static const Picture picture = [] {
    constexpr std::uint64_t kSeed = 910'003;
    render::TableScene table = render::random_table(kSeed, {.width = 1280, .height = 720});
    const auto view = render::view_of(table.scene, table.camera, table.X_WC, kSeed);
    table.sensor.exposure *= render::exposure_for(view, 0.3);
    return render::taken(view, table.sensor, kSeed);
  }();
  return picture;
}

/// The same in more pixels.
Picture enlarged(const Picture& picture, int width, int height) {
  Picture large = vision::black_picture(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto* from = picture.at(x * picture.width / width, y * picture.height / height);
      std::copy_n(from, 3, large.at(x, y));
    }
  }
  return large;
}

void detect_cubes_720p(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(vision::detect_cubes(table()));
}
BENCHMARK(detect_cubes_720p)->Unit(benchmark::kMillisecond);

void detect_cubes_10_megapixels(benchmark::State& state) {
  const Picture large = enlarged(table(), 4224, 2376);
  for (auto _ : state) benchmark::DoNotOptimize(vision::detect_cubes(large));
}
BENCHMARK(detect_cubes_10_megapixels)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sinew::bench
