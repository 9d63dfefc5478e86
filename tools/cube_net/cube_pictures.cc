// cube_pictures SEED COUNT FOLDER [WIDTH HEIGHT]: random tables as PNG pictures with what is on
// them, to train on and to test with.
//
// FOLDER/NUMBER.png, and a line in FOLDER/SEED.txt for each cube whose top is seen:
// NUMBER color(0..8, 9: white or grey) share-seen x0 y0 x1 y1 x2 y2 x3 y3 (px, clockwise).
// and for each other thing NUMBER kind(10..14) 1 x y x y x y x y: a square of what is seen of it.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "sinew/render/table_scene.h"
#include "sinew/vision/picture_file.h"

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: cube_pictures SEED COUNT FOLDER [WIDTH HEIGHT]\n");
    return 2;
  }
  const std::uint64_t seed = std::strtoull(argv[1], nullptr, 10);
  const std::uint64_t count = std::strtoull(argv[2], nullptr, 10);
  const std::string folder = argv[3];
  sinew::render::TableSettings settings;
  if (argc > 5) {
    settings.width = std::atoi(argv[4]);
    settings.height = std::atoi(argv[5]);
    settings.edge_least = 0.018 * settings.width;
    settings.edge_most = 0.15 * settings.width;
  }
  std::FILE* list = std::fopen((folder + "/" + argv[1] + ".txt").c_str(), "w");
  if (!list) return 1;
  for (std::uint64_t number = seed; number < seed + count; ++number) {
    sinew::render::TableScene table = sinew::render::random_table(number, settings);
    const auto view = sinew::render::view_of(table.scene, table.camera, table.X_WC, number);
    sinew::render::measure_tops(table, view);
    table.sensor.exposure *= sinew::render::exposure_for(view, 0.3);
    const auto picture = sinew::render::taken(view, table.sensor, number);
    const auto png = sinew::vision::encode_png(picture);
    std::FILE* file = std::fopen((folder + "/" + std::to_string(number) + ".png").c_str(), "wb");
    if (!file) return 1;
    std::fwrite(png.data(), 1, png.size(), file);
    std::fclose(file);
    for (const auto& cube : table.cubes) {
      std::fprintf(list, "%llu %d %.3f", static_cast<unsigned long long>(number),
                   cube.is_pale ? 9 : static_cast<int>(cube.color), cube.seen);
      for (const auto& p : cube.top) std::fprintf(list, " %.2f %.2f", p.x, p.y);
      std::fprintf(list, "\n");
    }
    for (const auto& other : table.others) {
      std::fprintf(list, "%llu %d 1", static_cast<unsigned long long>(number),
                   10 + static_cast<int>(other.kind));
      for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
        std::fprintf(list, " %.2f %.2f", other.middle.x + x * other.size / 2,
                     other.middle.y + y * other.size / 2);
      }
      std::fprintf(list, "\n");
    }
    std::fflush(list);
  }
  std::fclose(list);
}
