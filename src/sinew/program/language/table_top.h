#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/error.h"
#include "sinew/core/pose.h"
#include "sinew/core/vec3.h"
#include "sinew/program/language/eyes.h"

namespace sinew::program {

/// A box without a lid in front of a robot.
struct Basket {
  std::string name;
  Pose<frame::Base, frame::Box> X_BK;  ///< middle of its floor, upright
  Vec3 size;                           ///< m, inside: along x, along y, and its walls' height
};

/// What a cell has on the table in front of one robot, as a program is read there.
struct TableTop {
  std::vector<Basket> baskets;
  std::vector<std::string> cameras;  ///< calibrated ones; `look` means the first
  std::optional<Sighting> seen;      ///< in a picture that was taken before, for what is predicted
};

/// `basket` without another name: what a row says where a cell has only one.
inline constexpr std::string_view kOnlyBasket = "basket";

/// As a cell's file names them: lower-case letters, digits, -.
bool is_basket_name(std::string_view name);

/// The basket that a row means; null where there is none of that name.
const Basket* basket_named(const TableTop& table, std::string_view name);

/// Those of a table; none where it is null.
inline std::span<const Basket> baskets_on(const TableTop* table) {
  return table != nullptr ? std::span<const Basket>(table->baskets) : std::span<const Basket>();
}

/// Whether a place lies between its walls or above, whatever its height. m, in K
bool is_over(const Basket& basket, const Vec3& p_K);

/// Where cubes are released over a basket's floor so that they do not lie on each other, as long as
/// there is room: in the order in which they are tried, those first that have the fewest cubes.
/// @param edge  m, of the cubes  @param taken  where cubes lie already, m in B
/// @return m, in K, on the floor or on as many cubes as lie there; at least one
std::vector<Vec3> spots_in(const Basket& basket, double edge, std::span<const Vec3> taken);

/// Where cubes lie in baskets, m in B: those that were released there, and those that are seen
/// where none was, each on as many others as its height says.
std::vector<Vec3> lying_in(std::span<const Basket> baskets, std::span<const Vec3> released,
                           std::span<const grasping::Cube> seen);

}  // namespace sinew::program
