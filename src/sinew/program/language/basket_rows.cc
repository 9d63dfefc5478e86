// How `place` rows use baskets of the cell.
#include <algorithm>

#include "sinew/core/spelling.h"
#include "sinew/program/language/motion_rows.h"

namespace sinew::program {
namespace {

constexpr std::string_view kTo = "to=";

std::vector<std::string> names_of(const std::vector<Basket>& baskets) {
  std::vector<std::string> names;
  for (const Basket& one : baskets) names.push_back(one.name);
  return names;
}

}  // namespace

/// A taught point comes first: a program's folder is nearer to it than the cell.
std::optional<std::string_view> MotionRows::basket_word() const {
  for (const Word& word : row_.words()) {
    if (&word == row_.words().data()) continue;
    std::string_view name = word.text;
    if (name.starts_with(kTo)) name.remove_prefix(kTo.size());
    if (!is_basket_name(name)) continue;
    if (table_ != nullptr && basket_named(*table_, name) != nullptr && !has_point(name)) {
      return name;
    }
    if (has_point(name)) return std::nullopt;
    if (table_ != nullptr || points_ == nullptr) return name;
    // Read without a cell: any name may be a basket's, but that of a point misspelt.
    std::vector<std::string_view> points;
    for (const TaughtPoint& point : *points_) {
      if (point.robot == robot_.id) points.push_back(point.name);
    }
    if (name != kOnlyBasket && !nearest_spelling(name, points).empty()) return std::nullopt;
    return name;
  }
  return std::nullopt;
}

bool MotionRows::has_point(std::string_view name) const {
  return points_ != nullptr &&
         std::ranges::find(*points_, name, &TaughtPoint::name) != points_->end();
}

bool MotionRows::knows_basket(const Word& word, std::string_view name) {
  if (table_ == nullptr || basket_named(*table_, name) != nullptr) return true;
  if (table_->baskets.empty()) {
    row_.complain(word,
                  "this cell has no basket: write the lines [basket], name = \"basket\", x_mm = 60 "
                  "and y_mm = 180 into the cell's file (cells/README.md) and start sinew serve "
                  "again, or place NAME with a taught point");
    return false;
  }
  const std::string known = listed(names_of(table_->baskets));
  row_.complain(word, in_quotes(name) +
                          (name == kOnlyBasket ? ": this cell has several baskets; name one of "
                                               : " is no basket of this cell and no taught point; "
                                                 "its baskets are ") +
                          known);
  return false;
}

std::optional<BasketGoal> MotionRows::basket_row(std::string_view name) {
  BasketGoal goal{std::string(name), {}};
  Given given;
  bool good = true;
  for (std::size_t w = 1; w < row_.words().size(); ++w) {
    const Word& word = row_.words()[w];
    if (word.text == name || word.text == std::string(kTo) + std::string(name)) {
      good = knows_basket(word, name) && good;
      continue;
    }
    const auto one = argument(word, "speed=50%");
    const auto taken = one ? option(*one, goal.how, given) : std::optional(false);
    if (!taken) {
      row_.complain(word, in_quotes(word.text) +
                              ": a basket's place is the cell's; beside it stand speed= and "
                              "accel=");
    }
    good = taken.value_or(false) && good;
  }
  if (good && (goal.how.blends() || goal.how.time > 0)) {
    row_.complain(row_.words()[0], "place stops where it releases: without blend= and time=");
    return std::nullopt;
  }
  return good ? std::optional(std::move(goal)) : std::nullopt;
}

}  // namespace sinew::program
