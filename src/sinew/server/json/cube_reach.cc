#include "sinew/server/json/cube_reach.h"

#include <algorithm>
#include <chrono>

#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/foresight.h"

namespace sinew::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kStep = 0.01;        // m, of the finest grid
constexpr std::size_t kCoarsest = 4;  // of these steps
constexpr std::size_t kSide = 121;    // points a side: 0.6 m to each side; kCoarsest fits it
constexpr std::size_t kKept = 8;      // grids
constexpr auto kPatience = std::chrono::seconds(5);
constexpr char kUnknown = '.';
constexpr char kNone = '-';

char letter(program::Grasp grasp) {
  switch (grasp) {
    case program::Grasp::kStraightDown:
      return 's';
    case program::Grasp::kTilted:
      return 't';
    default:
      return kNone;
  }
}

/// What a point is where those around it on the coarser grid are all the same.
char between(const std::vector<std::string>& rows, std::size_t row, std::size_t column,
             std::size_t coarser) {
  const std::size_t top = row / coarser * coarser, left = column / coarser * coarser;
  const std::size_t bottom = row % coarser == 0 ? top : top + coarser;
  const std::size_t right = column % coarser == 0 ? left : left + coarser;
  const char first = rows[top][left];
  const bool same =
      rows[top][right] == first && rows[bottom][left] == first && rows[bottom][right] == first;
  return same ? first : kUnknown;
}

}  // namespace

CubeReachDesk::CubeReachDesk(const runtime::RunningCell& cell)
    : cell_(cell), thread_([this](const std::stop_token& ending) { work(ending); }) {}

Json CubeReachDesk::look(const Query& query) {
  const std::scoped_lock lock(mutex_);
  const auto [place, is_new] = grids_.try_emplace(query);
  Grid& grid = place->second;
  if (is_new) {
    const Vec3& p_WB = cell_.cell().robots[query.robot].X_WB.p;
    const double half = kStep * static_cast<double>(kSide - 1) / 2;
    grid.x = p_WB.x - half;
    grid.y = p_WB.y - half;
    grid.rows.assign(kSide, std::string(kSide, kUnknown));
  }
  std::erase(asked_, query);
  asked_.push_back(query);
  if (asked_.size() > kKept) {
    grids_.erase(asked_.front());
    asked_.erase(asked_.begin());
  }
  asked_at_ = Clock::now();
  wanted_ = query;
  more_.notify_all();
  const double all = static_cast<double>(kSide) * static_cast<double>(kSide);
  return {{"robot", cell_.cell().robots[query.robot].name},
          {"edge_m", query.edge},
          {"z_m", query.height},
          {"step_m", kStep},
          {"x_m", grid.x},
          {"y_m", grid.y},
          {"columns", kSide},
          {"done", static_cast<double>(grid.known) / all},
          {"rows", grid.rows}};
}

void CubeReachDesk::work(const std::stop_token& ending) {
  while (const auto query = next(ending)) {
    bool whole = true;
    for (std::size_t step = kCoarsest; step > 0 && whole; step /= 2) {
      whole = refine(ending, *query, step);
    }
    if (!whole) continue;
    const std::scoped_lock lock(mutex_);
    if (wanted_ == query) wanted_.reset();
  }
}

std::optional<CubeReachDesk::Query> CubeReachDesk::next(const std::stop_token& ending) {
  std::unique_lock lock(mutex_);
  more_.wait(lock, ending, [this] {
    return wanted_ && grids_.contains(*wanted_) && Clock::now() - asked_at_ < kPatience;
  });
  return ending.stop_requested() ? std::nullopt : wanted_;
}

bool CubeReachDesk::still_wanted(const std::stop_token& ending, const Query& query) {
  const std::scoped_lock lock(mutex_);
  return !ending.stop_requested() && wanted_ == query && grids_.contains(query) &&
         Clock::now() - asked_at_ < kPatience;
}

bool CubeReachDesk::refine(const std::stop_token& ending, const Query& query, std::size_t step) {
  const RobotModel& robot = cell_.station(query.robot).robot();
  const auto X_BW = cell_.cell().robots[query.robot].X_WB.inverse();
  program::RowPlanner planner(robot);
  const program::Standing home(home_joints(robot));
  std::unique_lock lock(mutex_);
  for (std::size_t row = 0; row < kSide; row += step) {
    for (std::size_t column = 0; column < kSide; column += step) {
      const auto grid = grids_.find(query);
      if (grid == grids_.end()) return false;
      if (grid->second.rows[row][column] != kUnknown) continue;
      char found = kUnknown;
      if (step < kCoarsest) found = between(grid->second.rows, row, column, 2 * step);
      if (found == kUnknown) {
        const Vec3 p_WO{grid->second.x + kStep * static_cast<double>(column),
                        grid->second.y + kStep * static_cast<double>(row),
                        query.height + query.edge / 2};
        lock.unlock();
        if (!still_wanted(ending, query)) return false;
        found = letter(program::best_grasp(planner, home, X_BW * p_WO, query.edge));
        lock.lock();
      }
      const auto again = grids_.find(query);
      if (again == grids_.end()) return false;
      again->second.rows[row][column] = found;
      ++again->second.known;
    }
  }
  return true;
}

}  // namespace sinew::server
