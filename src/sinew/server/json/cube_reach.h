#pragma once

#include <chrono>
#include <compare>
#include <condition_variable>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sinew/runtime/running_cell.h"
#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// Where a robot can take cubes on a level surface: planned grasp by grasp over a grid, in a thread
/// of its own. First coarse, then finer where neighbours differ. What no client has asked about for
/// a while rests; what is done is kept.
class CubeReachDesk {
 public:
  struct Query {
    std::size_t robot = 0;  ///< of the cell; its tool takes cubes
    double edge = 0;        ///< m
    double height = 0;      ///< m, z of the surface in the cell
    auto operator<=>(const Query&) const = default;
  };

  /// @param cell  outlives this
  explicit CubeReachDesk(const runtime::RunningCell& cell);

  /// What is known so far; it is gone on with.
  Json look(const Query& query);

 private:
  /// Points of a square grid around the robot's foot, a letter each as `robot.cube_reach` has them.
  struct Grid {
    double x = 0, y = 0;  ///< m in W, of the first point
    std::vector<std::string> rows;
    std::size_t known = 0;
  };

  void work(const std::stop_token& ending);
  std::optional<Query> next(const std::stop_token& ending);
  /// @return false where something else is wanted first
  bool refine(const std::stop_token& ending, const Query& query, std::size_t step);
  bool still_wanted(const std::stop_token& ending, const Query& query);

  const runtime::RunningCell& cell_;
  std::mutex mutex_;
  std::condition_variable_any more_;
  std::map<Query, Grid> grids_;  ///< under the mutex, as all below
  std::vector<Query> asked_;     ///< the latest last
  std::optional<Query> wanted_;  ///< that is worked on
  std::chrono::steady_clock::time_point asked_at_;
  std::jthread thread_;  ///< the last: it ends before what it uses
};

}  // namespace sinew::server
