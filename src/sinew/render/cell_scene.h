#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sinew/render/prints.h"
#include "sinew/render/robot_body.h"
#include "sinew/render/view.h"
#include "sinew/vision/color_names.h"
#include "sinew/vision/tag_board.h"

namespace sinew::render {

struct ViewedCube {
  Pose<frame::World, frame::Solid> X_WS;  ///< its middle, along its edges
  double edge = 0;                        ///< m
  vision::ColorName color = vision::ColorName::kRed;
};

/// A box without a lid. Its frame: the middle of its floor, on the table; z up.
struct ViewedBasket {
  Pose<frame::World, frame::Solid> X_WS;
  double half_x = 0.06;  ///< m, inside
  double half_y = 0.06;  ///< m
  double height = 0.05;  ///< m, of its walls
  double wall = 0.003;   ///< m, of walls and floor
  unsigned srgb = 0x9098A0;
};

/// A printed sheet of tags that lies on something.
struct ViewedSheet {
  vision::TagBoard board;
  Pose<frame::World, frame::Board> X_WP;  ///< of its printed side
  PrintPicture print;                     ///< print_of(board); nothing: made anew for each scene
};
/// The picture on a sheet, 0.25 mm a pixel. Worth keeping: an A4 sheet takes some 10 ms.
PrintPicture print_of(const vision::TagBoard& board);

/// A person's hand with its forearm.
struct ViewedHand {
  Vec3 p_W;         ///< m, its finger tips
  double from = 0;  ///< rad about z of W, where it comes from: 0 is +x
};

/// Something on the table that is no cube: a paper, a strip of tape, a disc, a brick. Of flat ones
/// that lie on each other the later one is seen.
struct ViewedThing {
  enum class Form : std::uint8_t { kBox, kDisc } form = Form::kBox;
  Pose<frame::World, frame::Solid> X_WS;  ///< its middle, z up
  Vec3 half;  ///< m, of its edges; of a disc x is the radius, y does not count
  unsigned srgb = 0xD8D8D8;
};

enum class TableTop : std::uint8_t { kBySeed, kWood, kPaper, kMat };

/// What stands on a table (z = 0 of W) in front of a camera, by value. The seed chooses what
/// is not given: shades, gloss, grain, lamps.
struct CellView {
  std::uint64_t seed = 1;
  TableTop top = TableTop::kBySeed;
  Vec3 middle_W;       ///< m, of the area that is worked on; lamps hang above it
  double reach = 0.3;  ///< m, from there to its borders
  std::vector<ViewedCube> cubes;
  std::vector<ViewedBasket> baskets;
  std::vector<ViewedRobot> robots;
  std::vector<ViewedSheet> sheets;
  std::optional<ViewedHand> hand;
  std::vector<ViewedThing> clutter;
  int lamps = 2;          ///< 1 or more
  double brightness = 1;  ///< of all light
};

/// Solids in the order of the view: the table, cubes, basket (floor, then walls), robots, sheets,
/// hand, clutter. So cube i is solid i + 1. The same view has the same scene.
Scene cell_scene(const CellView& view);

/// What a camera with automatic exposure makes of it. The same arguments, the same bytes.
/// @param X_WC    z out of the lens, y down the picture
/// @param sensor  its exposure is a factor of the automatic one; robots that move are blurred, and
///                aslant, by its shutter and its read-out; what they carry is not
/// @param seed    of the noise
vision::Picture picture_of(const CellView& view, const vision::CameraModel& camera,
                           const Pose<frame::World, frame::Camera>& X_WC, Sensor sensor,
                           std::uint64_t seed);

}  // namespace sinew::render
