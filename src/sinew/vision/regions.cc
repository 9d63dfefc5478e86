#include "sinew/vision/regions.h"

#include <algorithm>
#include <limits>

namespace sinew::vision {
namespace {

struct Run {
  int y = 0;
  int begin = 0;
  int end = 0;           ///< behind its last pixel
  std::size_t root = 0;  ///< of the runs that hang together: an earlier one, or itself
};

/// Of the runs that hang together, kept with their root.
struct Extent {
  double area = 0;
  int left = std::numeric_limits<int>::max();
  int right = 0;
  int top = std::numeric_limits<int>::max();
  int bottom = 0;

  void add(const Run& run) {
    area += run.end - run.begin;
    left = std::min(left, run.begin);
    right = std::max(right, run.end);
    top = std::min(top, run.y);
    bottom = std::max(bottom, run.y + 1);
  }
};

class Runs {
 public:
  Runs(const Plane& plane, float threshold, bool above) {
    std::size_t row_before = 0;
    for (int y = 0; y < plane.height; ++y) {
      const std::size_t row = runs_.size();
      const float* values =
          &plane.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(plane.width)];
      for (int x = 0; x < plane.width;) {
        while (x < plane.width && (values[x] > threshold) != above) ++x;
        if (x == plane.width) break;
        const int begin = x;
        while (x < plane.width && (values[x] > threshold) == above) ++x;
        runs_.push_back({y, begin, x, runs_.size()});
      }
      join(row_before, row);
      row_before = row;
    }
  }

  std::vector<Run>& all() { return runs_; }
  std::size_t root_of(std::size_t i) {
    while (runs_[i].root != i) {
      runs_[i].root = runs_[runs_[i].root].root;
      i = runs_[i].root;
    }
    return i;
  }

 private:
  /// The runs from `row` on with those above them, which touch them.
  void join(std::size_t before, std::size_t row) {
    for (std::size_t i = row; i < runs_.size(); ++i) {
      while (before < row && runs_[before].end <= runs_[i].begin) ++before;
      for (std::size_t k = before; k < row && runs_[k].begin < runs_[i].end; ++k) {
        const std::size_t one = root_of(k);
        const std::size_t other = root_of(i);
        runs_[std::max(one, other)].root = std::min(one, other);
      }
    }
  }

  std::vector<Run> runs_;
};

bool fits(const Extent& extent, const Plane& plane, const RegionLimits& limits) {
  const bool inside = extent.left > 0 && extent.top > 0 && extent.right < plane.width &&
                      extent.bottom < plane.height;
  const double width = extent.right - extent.left;
  const double height = extent.bottom - extent.top;
  return inside && extent.area >= limits.area_min && extent.area <= limits.area_max &&
         std::max(width, height) <= limits.elongation_max * std::min(width, height);
}

}  // namespace

void for_each_region(const Plane& plane, float threshold, Side side, const RegionLimits& limits,
                     const std::function<void(const Region&)>& look) {
  Runs runs(plane, threshold, side == Side::kAbove);
  std::vector<Run>& all = runs.all();
  std::vector<Extent> extents(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) extents[runs.root_of(i)].add(all[i]);
  // Runs stand by rows, so those of a region do too.
  std::vector<std::vector<Pixel>> edges(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t root = runs.root_of(i);
    if (!fits(extents[root], plane, limits)) continue;
    const Run& run = all[i];
    const double y = run.y;
    for (const double corner_y : {y, y + 1}) {
      edges[root].push_back({static_cast<double>(run.begin), corner_y});
      edges[root].push_back({static_cast<double>(run.end), corner_y});
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (edges[i].empty()) continue;
    std::ranges::sort(edges[i],
                      [](Pixel a, Pixel b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
    look({extents[i].area, std::move(edges[i])});
  }
}

}  // namespace sinew::vision
