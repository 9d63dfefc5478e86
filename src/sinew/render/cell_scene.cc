#include "sinew/render/cell_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/core/units.h"
#include "sinew/render/paint.h"
#include "sinew/render/solids.h"
#include "sinew/render/table_scene.h"

namespace sinew::render {
namespace {

constexpr std::array kWoodTops{0xC8A880U, 0xA87848U, 0xB89060U, 0xE0D0B0U};
constexpr std::array kPaperTops{0xF4F4F0U, 0xE8E8E4U, 0xD0CEC8U};
constexpr std::array kMatTops{0x305030U, 0x505052U, 0x284878U, 0x404044U};
constexpr std::array kPlastics{0x303236U, 0xD8D8D8U, 0x606468U, 0x18181CU};
constexpr double kPaperHalf = 5e-5;     // m
constexpr double kPrintScale = 4000;    // px/m
constexpr double kExposureMean = 0.25;  // of white, what automatic exposures aim for

class CellMaker {
 public:
  explicit CellMaker(const CellView& view) : view_(view), random_(view.seed) {}

  Scene make() {
    lay_table();
    // Each part has random numbers of its own: a cube more or less leaves all others as they are.
    restart(1);
    const auto style = static_cast<BlockStyle>(whole(0, 3));
    for (std::size_t i = 0; i < view_.cubes.size(); ++i) {
      restart(100 + i);
      place_cube(view_.cubes[i], style);
    }
    restart(2);
    for (const ViewedBasket& basket : view_.baskets) place_basket(basket);
    restart(3);
    for (const ViewedRobot& robot : view_.robots) place_robot(robot);
    for (const ViewedSheet& sheet : view_.sheets) lay_sheet(sheet);
    restart(4);
    if (view_.hand) reach_in(*view_.hand);
    restart(5);
    hang_lamps();
    restart(6);
    for (const ViewedThing& thing : view_.clutter) lay(thing);
    return std::move(scene_);
  }

 private:
  void restart(std::uint64_t part) {
    random_ = SplitMix64(view_.seed * 0x9E3779B97F4A7C15ULL + part);
  }
  double uniform(double low, double high) { return random_.uniform(low, high); }
  int whole(int low, int high) { return static_cast<int>(uniform(low, high + 1)); }
  void add(std::variant<Polyhedron, Cylinder, Ball, Ground> form,
           const Pose<frame::World, frame::Solid>& X_WS, const Material& material) {
    scene_.solids.push_back({std::move(form), X_WS, material});
  }

  void lay_table() {
    TableTop top = view_.top;
    if (top == TableTop::kBySeed) top = static_cast<TableTop>(whole(1, 3));
    Material table;
    if (top == TableTop::kWood) {
      table = plastic(random_, near_one_of(random_, kWoodTops));
      print_on(table, grain(random_, uniform(0.2, 0.5)), uniform(0.2, 0.5));
    } else if (top == TableTop::kPaper) {
      table = plastic(random_, near_one_of(random_, kPaperTops));
      table.gloss *= 0.3F;
      print_on(table, clouds(random_, uniform(0.03, 0.1)), uniform(0.2, 0.5));
    } else {
      table = plastic(random_, near_one_of(random_, kMatTops));
      table.gloss *= 0.5F;
      print_on(table, grid(random_, whole(8, 16), uniform(-0.3, 0.3)), uniform(0.2, 0.4));
    }
    add(Ground{}, {rotation_z(uniform(0, kPi)), {}}, table);
  }

  void place_cube(const ViewedCube& cube, BlockStyle style) {
    const double half = cube.edge / 2;
    add(box({half, half, half}, 0.04 * cube.edge), cube.X_WS,
        painted_block(random_, cube.color, style, cube.edge));
  }

  void place_basket(const ViewedBasket& basket) {
    const Material material = plastic(random_, from_srgb(basket.srgb));
    const double t = basket.wall / 2;
    const double x = basket.half_x;
    const double y = basket.half_y;
    const double h = basket.height / 2;
    const auto wall = [&](const Vec3& p, const Vec3& half) {
      add(box(half), {basket.X_WS.R, basket.X_WS * p}, material);
    };
    wall({0, 0, t}, {x, y, t});
    wall({x + t, 0, h}, {t, y + 2 * t, h});
    wall({-x - t, 0, h}, {t, y + 2 * t, h});
    wall({0, y + t, h}, {x, t, h});
    wall({0, -y - t, h}, {x, t, h});
  }

  void place_robot(const ViewedRobot& robot) {
    const Material first = plastic(random_, near_one_of(random_, kPlastics));
    const Material second = plastic(random_, near_one_of(random_, kPlastics));
    add_robot(scene_, robot, first, second, plastic(random_, from_srgb(0x202022U)));
  }

  void lay_sheet(const ViewedSheet& sheet) {
    Material paper;
    paper.color = from_srgb(0xFFFFFFU);
    paper.gloss = 0.01F;
    const PrintPicture print = sheet.print ? sheet.print : print_of(sheet.board);
    paper.print = {print, print->width / kPrintScale, print->height / kPrintScale, true};
    const auto X_WS = relabel<frame::World, frame::Solid>(sheet.X_WP);
    add(box({sheet.board.width / 2, sheet.board.height / 2, kPaperHalf}),
        {X_WS.R, X_WS * Vec3{0, 0, -kPaperHalf + paper_lift()}}, paper);
  }
  /// A printed side at the table's height would not be seen: all of it lies this much higher.
  static constexpr double paper_lift() { return 2 * kPaperHalf + 1e-5; }

  void reach_in(const ViewedHand& hand) {
    const Material skin = plastic(random_, near_one_of(random_, skin_swatches()));
    const Material sleeve = plastic(random_, any_color(random_));
    const Vec3 out{std::cos(hand.from), std::sin(hand.from), 0};
    const Vec3 across{-out.y, out.x, 0};
    const Vec3 knuckles = hand.p_W + 0.06 * out + Vec3{0, 0, 0.035};
    const Vec3 wrist = knuckles + 0.09 * out + Vec3{0, 0, 0.02};
    const Vec3 elbow = wrist + 0.3 * out + Vec3{0, 0, uniform(0.04, 0.12)};
    for (int i = 0; i < 4; ++i) {
      const double aside = (i - 1.5) * 0.019;
      const Vec3 tip = hand.p_W + aside * across + Vec3{0, 0, 0.008} - uniform(0, 0.012) * out;
      add_rod(scene_, knuckles + aside * across, tip, 0.008, skin);
      add_rod(scene_, wrist, knuckles + aside * across, 0.013, skin);
    }
    const Vec3 thumb = knuckles + 0.05 * out - 0.03 * across;
    add_rod(scene_, thumb, thumb - 0.05 * out - 0.02 * across - Vec3{0, 0, 0.02}, 0.01, skin);
    add_rod(scene_, wrist, wrist + 0.06 * out, 0.026, skin);
    add_rod(scene_, wrist + 0.06 * out, elbow, 0.04, sleeve);
  }

  void hang_lamps() {
    const int count = std::max(1, view_.lamps);
    const auto bright = static_cast<float>(view_.brightness);
    for (int i = 0; i < count; ++i) {
      const double turn = uniform(0, 2 * kPi);
      const double aside = uniform(0.2, 0.8);
      const double high = uniform(0.9, 1.5);
      const auto power = static_cast<float>(0.8 / count * (aside * aside + high * high)) * bright;
      const auto warm = static_cast<float>(uniform(-0.1, 0.1));
      scene_.lamps.push_back(
          {view_.middle_W + Vec3{aside * std::cos(turn), aside * std::sin(turn), high},
           uniform(0.03, 0.12), power * Rgb{1 + warm, 1, 1 - warm}});
    }
    scene_.above = 0.35F * bright * Rgb{1, 1, 1};
    scene_.below = 0.1F * bright * Rgb{1, 1, 1};
  }

  /// Sheets: of two at one height, which one is seen would change from picture to picture.
  static constexpr double kFlat = 0.001;  // m, half of a sheet's thickness is less
  static constexpr double kLift = 5e-5;   // m, of each one above the one before

  void lay(const ViewedThing& thing) {
    const Material material = plastic(random_, from_srgb(thing.srgb));
    auto X_WS = thing.X_WS;
    if (thing.half.z < kFlat) X_WS.p.z += kLift * static_cast<double>(sheets_laid_++);
    if (thing.form == ViewedThing::Form::kDisc) {
      add(Cylinder{thing.half.x, thing.half.z}, X_WS, material);
    } else {
      add(box(thing.half, std::min(0.001, 0.1 * thing.half.z)), X_WS, material);
    }
  }

  const CellView& view_;
  SplitMix64 random_;
  Scene scene_;
  int sheets_laid_ = 0;
};

/// The robots as they stand so many seconds later.
CellView moved_on(CellView view, double seconds) {
  for (ViewedRobot& robot : view.robots) {
    for (std::size_t j = 0; j < robot.qd.size(); ++j) robot.q[j] += seconds * robot.qd[j];
  }
  return view;
}

/// What falls on the sensor while its rows are exposed, one after the other.
View exposed(const CellView& view, const vision::CameraModel& camera,
             const Pose<frame::World, frame::Camera>& X_WC, const Sensor& sensor,
             std::uint64_t seed) {
  constexpr int kViews = 8;
  constexpr double kStill = 1e-3;  // rad/s; servos tremble
  const bool moves = std::ranges::any_of(view.robots, [](const ViewedRobot& robot) {
    return std::ranges::any_of(robot.qd, [](double qd) { return std::abs(qd) > kStill; });
  });
  const double takes = sensor.shutter + sensor.read_out;
  if (!moves || takes <= 0) return view_of(cell_scene(view), camera, X_WC, seed);
  std::vector<View> views;
  for (int i = 0; i < kViews; ++i) {
    const double later = ((i + 0.5) / kViews - 0.5) * takes;
    views.push_back(view_of(cell_scene(moved_on(view, later)), camera, X_WC, seed));
  }
  return rolling_shutter(views, sensor.shutter / takes);
}

}  // namespace

PrintPicture print_of(const vision::TagBoard& board) {
  return std::make_shared<const vision::Picture>(vision::picture_of(board, kPrintScale));
}

Scene cell_scene(const CellView& view) {
  return CellMaker(view).make();
}

vision::Picture picture_of(const CellView& view, const vision::CameraModel& camera,
                           const Pose<frame::World, frame::Camera>& X_WC, Sensor sensor,
                           std::uint64_t seed) {
  const View seen = exposed(view, camera, X_WC, sensor, seed);
  sensor.exposure *= exposure_for(seen, kExposureMean);
  return taken(seen, sensor, seed);
}

}  // namespace sinew::render
