#include "sinew/runtime/cameras/simulated_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/runtime/cameras/shown_board.h"
#include "sinew/vision/view_watch.h"

namespace sinew::runtime {
namespace {

constexpr double kTableHalf = 0.6;  // m

const CellCamera& camera_of(const Cell& cell) {
  const CellCamera* camera = cell.simulated_camera();
  SINEW_ASSERT(camera != nullptr);
  return *camera;
}

/// The table as the world of its cubes.
Pose<frame::World, frame::World> table_of(const Cell& cell) {
  return relabel<frame::World, frame::World>(camera_of(cell).X_WT.inverse());
}

sim::CubeWorldSettings settings_of(const Cell& cell, const std::vector<CellBasket>& baskets) {
  sim::CubeWorldSettings settings;
  settings.table_half = {kTableHalf, kTableHalf};
  for (const CellBasket& basket : baskets) {
    settings.baskets.push_back(
        {.X_WK = relabel<frame::World, frame::Basket>(table_of(cell) * basket.X_WK),
         .half = {basket.size.x / 2, basket.size.y / 2},
         .height = basket.size.z});
  }
  return settings;
}

render::ViewedBasket viewed(const sim::Basket& basket) {
  return {.X_WS = relabel<frame::World, frame::Solid>(basket.X_WK),
          .half_x = basket.half.x,
          .half_y = basket.half.y,
          .height = basket.height,
          .wall = basket.wall};
}

}  // namespace

vision::TableCamera usual_camera() {
  vision::TableCamera camera;
  camera.name = "simulated";
  camera.model = vision::pinhole(640, 480, from_deg(45));
  camera.X_WC = render::looking_at({0, -0.16, 0.52}, {0, 0, 0});
  camera.accuracy = 0.5e-3;
  return camera;
}

SimulatedTable::SimulatedTable(const Cell& cell, const std::vector<CellBasket>& baskets)
    : X_WT_(camera_of(cell).X_WT), cubes_(settings_of(cell, baskets)) {
  const auto X_TW = table_of(cell);
  for (const CellRobot& robot : cell.robots) X_TB_.push_back(X_TW * robot.X_WB);
  const double turn = fixed_xyz(X_TW.R).z;
  const double edge = camera_of(cell).cube;
  for (const CellCube& cube : cell.cubes) {
    const Vec3 p_T = X_TW * cube.p_W;
    first_.push_back({.edge = edge,
                      .color = cube.color,
                      .at = {p_T.x, p_T.y},
                      .yaw = cube.turn + turn,
                      .bottom = std::max(0.0, p_T.z)});
  }
  cubes_.with([&](sim::CubeWorld& world) {
    for (const auto& cube : first_) world.add(cube);
  });
  view_.lamps = 2;
  view_.reach = 0.25;
}

std::unique_ptr<sim::ByteMachine> SimulatedTable::under(std::unique_ptr<sim::ByteMachine> machine,
                                                        const RobotModel& model, std::size_t which,
                                                        Instant boot) {
  return std::make_unique<sim::CubeTable>(std::move(machine), model, X_TB_.at(which), cubes_, which,
                                          boot);
}

CameraSource SimulatedTable::pictures(const vision::TableCamera& camera, Robots robots,
                                      std::size_t number, Hangs hangs) {
  if (!camera.sheet.empty()) leave_sheet(camera.sheet);
  {
    const std::scoped_lock lock(mutex_);
    cameras_.insert_or_assign(number, camera);
  }
  return [this, camera = vision::TableCamera(camera), robots = std::move(robots), number,
          hangs = std::move(hangs),
          last = std::optional<vision::Picture>()](const std::stop_token&) mutable {
    if (hangs) {
      const auto X_WC = hangs();
      if (X_WC) camera.X_WC = relabel<frame::World, frame::World>(X_WT_.inverse()) * *X_WC;
    }
    auto taken = picture(camera, robots, number, last);
    if (taken) last = *taken;
    return taken;
  };
}

CameraSource SimulatedTable::glances(const vision::TableCamera& camera, Robots robots,
                                     std::size_t number) {
  vision::TableCamera small = camera;
  small.model = camera.model.shrunk(vision::kCellsAcross);
  small.sheet.clear();  // it lies there already
  return pictures(small, std::move(robots), number);
}

void SimulatedTable::leave_sheet(std::string_view paper) {
  const auto sheet = vision::table_sheet(paper);
  std::vector<render::ViewedSheet> sheets;
  if (sheet) sheets.push_back({*sheet, {}, render::print_of(*sheet)});
  const std::scoped_lock lock(mutex_);
  view_.sheets = std::move(sheets);
}

void SimulatedTable::show(const std::optional<Shown>& shown) {
  const std::scoped_lock lock(mutex_);
  const bool is_new = shown && (!shown_ || shown_->board.first != shown->board.first ||
                                shown_->board.paper != shown->board.paper);
  if (is_new) print_ = render::print_of(shown->board);
  shown_ = shown;
}

void SimulatedTable::begin_again() {
  cubes_.with([&](sim::CubeWorld& world) {
    for (std::size_t i = 0; i < first_.size(); ++i) {
      world.put(i, first_[i].at, first_[i].yaw, first_[i].bottom);
    }
    world.clear_events();
  });
}

void SimulatedTable::move_basket(std::size_t basket, const Pose<frame::World, frame::Box>& X_WK) {
  const auto X_TW = relabel<frame::World, frame::World>(X_WT_.inverse());
  const auto X_TK = relabel<frame::World, frame::Basket>(X_TW * X_WK);
  cubes_.with([&](sim::CubeWorld& world) { world.move_basket(basket, X_TK); });
}

void SimulatedTable::set_trouble(const Trouble& trouble) {
  const std::scoped_lock lock(mutex_);
  trouble_ = trouble;
}

SimulatedTable::Trouble SimulatedTable::trouble() const {
  const std::scoped_lock lock(mutex_);
  return trouble_;
}

render::ViewedHand SimulatedTable::hand_in_view(std::size_t number) const {
  constexpr double kAbove = 0.03;  // m, of its finger tips
  vision::TableCamera camera;
  {
    const std::scoped_lock lock(mutex_);
    camera = cameras_.at(number);
  }
  double farthest = 0;
  render::ViewedHand hand;
  for (const double across : {0.3, 0.5, 0.7}) {
    for (const double down : {0.3, 0.5, 0.7}) {
      const auto p = vision::on_plane(
          camera, {across * camera.model.width, down * camera.model.height}, kAbove);
      if (!p) continue;
      const auto away = [&](const auto& X_TB) {
        return std::hypot(p->x - X_TB.p.x, p->y - X_TB.p.y);
      };
      const auto nearest = std::ranges::min_element(X_TB_, {}, away);
      if (away(*nearest) <= farthest) continue;
      farthest = away(*nearest);
      hand = {*p, std::atan2(p->y - nearest->p.y, p->x - nearest->p.x)};
    }
  }
  return hand;
}

void SimulatedTable::set_surroundings(const render::CellView& view) {
  const std::scoped_lock lock(mutex_);
  view_ = view;
}

void SimulatedTable::put_shown(render::CellView& view, const vision::TableCamera& camera,
                               const Shown& shown, const render::PrintPicture& print) {
  if (!shown.pose) {
    view.sheets = {{shown.board, {}, print}};
    view.baskets.clear();
    return;
  }
  const auto X_WP = held_board(camera, shown.board, *shown.pose);
  view.sheets.push_back({shown.board, X_WP, print});
  view.hand = holding_hand(shown.board, X_WP);
}

Expected<vision::Picture> SimulatedTable::picture(const vision::TableCamera& camera,
                                                  const Robots& robots, std::size_t number,
                                                  const std::optional<vision::Picture>& last) {
  std::unique_lock lock(mutex_);
  const Trouble trouble = trouble_;
  render::CellView view = view_;
  const std::uint64_t taken = ++taken_;
  const auto shown = shown_ && shown_->camera == number ? shown_ : std::nullopt;
  const auto print = print_;
  if (trouble.unplugged) return std::unexpected(Error{ErrorCode::kCameraLost, -1, 0});
  if (trouble.frozen && last) return *last;
  lock.unlock();
  view.hand = trouble.hand;
  view.robots = robots();
  const auto X_TW = relabel<frame::World, frame::World>(X_WT_.inverse());
  for (render::ViewedRobot& robot : view.robots) robot.X_WB = X_TW * robot.X_WB;
  cubes_.with([&](const sim::CubeWorld& world) {
    for (const sim::Basket& basket : world.settings().baskets) {
      view.baskets.push_back(viewed(basket));
    }
    if (shown) return;
    for (const sim::CubeState& cube : world.cubes()) {
      if (cube.where == sim::CubePlace::kGone) continue;
      view.cubes.push_back({relabel<frame::World, frame::Solid>(cube.X_WO), cube.edge,
                            static_cast<vision::ColorName>(cube.color)});
    }
  });
  if (shown) put_shown(view, camera, *shown, print);
  auto X_WC = camera.X_WC;
  X_WC.p = X_WC * trouble.knocked;
  auto picture = render::picture_of(view, camera.model, X_WC, trouble.sensor, taken);
  if (trouble.covered) {
    // Light from a room still leaks in.
    for (std::uint8_t& value : picture.rgb) value = static_cast<std::uint8_t>(8 + value / 64);
  }
  return picture;
}

}  // namespace sinew::runtime
