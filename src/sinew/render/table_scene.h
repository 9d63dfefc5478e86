#pragma once

#include <cstdint>
#include <vector>

#include "sinew/render/view.h"
#include "sinew/vision/color_names.h"

namespace sinew::render {

/// A block with a square top on a table, or on another one.
struct PlacedCube {
  vision::ColorName color = vision::ColorName::kRed;
  bool is_pale = false;  ///< white or grey: it has no colour that people would name
  std::size_t solid = 0;
  Vec3 top_W;          ///< m, middle of its top face
  double edge = 0;     ///< m, of its top
  vision::Quad top{};  ///< px, corners of its top face in the picture, clockwise
  double seen = 0;     ///< share of its top that the picture shows
};

/// Something on the table that is no such block.
enum class OtherKind : std::uint8_t { kLong, kRound, kManySided, kLarge, kFlat };

struct PlacedOther {
  OtherKind kind = OtherKind::kLong;
  std::size_t solid = 0;
  vision::Pixel middle;  ///< px, of what is seen of its upper side
  double size = 0;       ///< px, root of that area
};

struct TableScene {
  Scene scene;
  vision::CameraModel camera;
  Pose<frame::World, frame::Camera> X_WC;
  Sensor sensor;
  std::vector<PlacedCube> cubes;
  std::vector<PlacedOther> others;
};

struct TableSettings {
  int width = 416;
  int height = 320;
  double edge_least = 12;  ///< px, of a cube near the middle of the picture
  double edge_most = 110;  ///< px
  int cubes_most = 36;
};

/// A table with blocks and with much that is none: bricks, discs, bars, balls, papers, tags, boards
/// with prints, arms, hands, cables. Cameras from straight above to 55 deg aside, lamps of all
/// kinds, and a sensor with its faults: harder than most tables are. Every seed is another one.
TableScene random_table(std::uint64_t seed, const TableSettings& settings);

/// What the camera shows of each cube's top, and of the others; those that it does not show go.
void measure_tops(TableScene& table, const View& view);

/// An exposure with which the picture's mean is about `mean` of white.
double exposure_for(const View& view, double mean);

}  // namespace sinew::render
