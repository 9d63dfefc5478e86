#pragma once

#include <algorithm>
#include <functional>

namespace sinew {

/// Sorts `range` by its projection; equals keep their order. Quadratic: for lists of people's size.
/// std::stable_sort of libstdc++ 12 calls what C++17 deprecates, and clang refuses that. @rt
template <class Range, class Projection>
void stable_sort_by(Range& range, Projection projection) {
  for (auto next = range.begin(); next != range.end(); ++next) {
    const auto place = std::ranges::upper_bound(range.begin(), next, std::invoke(projection, *next),
                                                {}, projection);
    std::rotate(place, next, next + 1);
  }
}

}  // namespace sinew
