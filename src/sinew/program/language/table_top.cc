#include "sinew/program/language/table_top.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sinew/core/stable_sort.h"

namespace sinew::program {
namespace {

constexpr double kWallGap = 4e-3;  // m, between a cube and a wall, however it is turned
constexpr double kApart = 4e-3;    // m, between two cubes, likewise

/// Places along one side, about its middle; the middle alone where no more fit.
std::vector<double> along(double inside, double edge) {
  const double diagonal = edge * std::numbers::sqrt2;
  const double half = inside / 2 - diagonal / 2 - kWallGap;
  const double step = diagonal + kApart;
  const int gaps = half > 0 ? static_cast<int>(2 * half / step) : 0;
  // Close to the middle: at its walls a camera sees less of a cube.
  std::vector<double> places;
  for (int k = 0; k <= gaps; ++k) places.push_back(step * (k - 0.5 * gaps));
  return places;
}

}  // namespace

bool is_basket_name(std::string_view name) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  return !name.empty() && name.front() >= 'a' && name.front() <= 'z' &&
         std::ranges::all_of(name, fits);
}

const Basket* basket_named(const TableTop& table, std::string_view name) {
  const auto found = std::ranges::find(table.baskets, name, &Basket::name);
  if (found != table.baskets.end()) return &*found;
  const bool only = name == kOnlyBasket && table.baskets.size() == 1;
  return only ? &table.baskets.front() : nullptr;
}

bool is_over(const Basket& basket, const Vec3& p_K) {
  return std::abs(p_K.x) < basket.size.x / 2 && std::abs(p_K.y) < basket.size.y / 2;
}

std::vector<Vec3> spots_in(const Basket& basket, double edge, std::span<const Vec3> taken) {
  std::vector<Vec3> lying;
  for (const Vec3& p_B : taken) {
    const Vec3 p_K = basket.X_BK.inverse() * p_B;
    if (is_over(basket, p_K)) lying.push_back(p_K);
  }
  struct Spot {
    Vec3 p_K;
    std::size_t cubes = 0;
  };
  std::vector<Spot> spots;
  for (const double y : along(basket.size.y, edge)) {
    for (const double x : along(basket.size.x, edge)) {
      const auto near = [&](const Vec3& p) { return std::hypot(p.x - x, p.y - y) < edge; };
      spots.push_back({{x, y, 0}, static_cast<std::size_t>(std::ranges::count_if(lying, near))});
    }
  }
  stable_sort_by(spots, [](const Spot& spot) { return std::hypot(spot.p_K.x, spot.p_K.y); });
  stable_sort_by(spots, [](const Spot& spot) { return spot.cubes; });
  std::vector<Vec3> places;
  for (const Spot& spot : spots) {
    // More than heaps over the rim has been taken out meanwhile, by whoever empties it.
    const double most = std::ceil(basket.size.z / edge) + 1;
    const double cubes = std::min(static_cast<double>(spot.cubes), most);
    places.push_back(spot.p_K + Vec3{0, 0, cubes * edge});
  }
  return places;
}

std::vector<Vec3> lying_in(std::span<const Basket> baskets, std::span<const Vec3> released,
                           std::span<const grasping::Cube> seen) {
  std::vector<Vec3> lying(released.begin(), released.end());
  for (const grasping::Cube& cube : seen) {
    const auto is_near = [&](const Vec3& p) {
      return std::hypot(p.x - cube.p_BO.x, p.y - cube.p_BO.y) < cube.edge;
    };
    auto known = std::ranges::count_if(released, is_near);
    double floor = 0;
    for (const Basket& basket : baskets) {
      if (is_over(basket, basket.X_BK.inverse() * cube.p_BO)) floor = basket.X_BK.p.z;
    }
    const long level = std::lround((cube.p_BO.z - floor) / cube.edge + 0.5);
    for (; known < level; ++known) lying.push_back(cube.p_BO);
  }
  return lying;
}

}  // namespace sinew::program
