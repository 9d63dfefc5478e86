#include "sinew/vision/top_search.h"

#include <algorithm>
#include <utility>

#include "sinew/vision/edge_fit.h"
#include "sinew/vision/lab.h"
#include "sinew/vision/shapes.h"
#include "sinew/vision/white_balance.h"

namespace sinew::vision {
namespace {

/// px, the longer side of the picture that is searched, and of the one for larger cubes.
constexpr int kFine = 960;
constexpr int kCoarse = 400;
/// px of the fine picture: up to this edge it is believed, from somewhat less on the coarse one.
constexpr double kBorder = 56;
constexpr double kCommon = 0.65;   ///< of that
constexpr double kUnsure = 0.12;   ///< from here on it is worth a word
constexpr double kPrinted = 0.33;  ///< a black top with a larger light share is a print
constexpr double kShared = 0.3;    ///< of the smaller of two tops that are the same

bool is_same(const Quad& one, const Quad& other) {
  return common_area(one, other) > kShared * std::min(area_of(one), area_of(other));
}

/// From the picture that was searched to the one that was given.
Quad enlarged(Quad quad, double scale) {
  for (Pixel& corner : quad) corner = scale * corner;
  return quad;
}

/// The surest first, without those that lie on a surer one.
std::vector<Top> without_repeats(std::vector<Top> tops) {
  std::ranges::stable_sort(tops, std::ranges::greater{}, &LikelyTop::sureness);
  std::vector<Top> kept;
  for (const Top& top : tops) {
    const bool seen =
        std::ranges::any_of(kept, [&](const Top& one) { return is_same(one.quad, top.quad); });
    if (!seen) kept.push_back(top);
  }
  return kept;
}

}  // namespace

Things things_in(const Picture& picture) {
  const Picture fine = shrunk(picture, kFine);
  const Picture coarse = shrunk(fine, kCoarse);
  const WhiteBalance balance(coarse);
  const double scale = static_cast<double>(picture.width) / fine.width;
  const double from_coarse = static_cast<double>(fine.width) / coarse.width;
  const LabPicture lab(fine);
  Things all;
  const auto add = [&](const LikelyTop& likely, double to_fine) {
    Top top{likely};
    top.quad = turned_to_edges(lab, enlarged(top.quad, to_fine));
    // What the network says of a size is right to about a tenth.
    top.quad = fitted_to_edges(lab, top.quad, std::max(4.0, 0.09 * edge_of(top.quad)));
    top.quad = fitted_to_edges(lab, top.quad, 4);
    top.corners = corners_filled(lab, top.quad);
    top.is_print = top.color == ColorName::kBlack && light_share(lab, top.quad) > kPrinted;
    top.quad = enlarged(top.quad, scale);
    all.tops.push_back(top);
  };
  const bool both = coarse.width < fine.width;
  const Likely in_fine = likely_things(fine, balance, kUnsure);
  for (const LikelyTop& top : in_fine.tops) {
    if (!both || edge_of(top.quad) < kBorder) add(top, 1);
  }
  all.others = in_fine.others;
  for (LikelyOther& other : all.others) other.middle = scale * other.middle;
  const Likely in_coarse = both ? likely_things(coarse, balance, kUnsure) : Likely{};
  for (const LikelyTop& top : in_coarse.tops) {
    if (from_coarse * edge_of(top.quad) > kCommon * kBorder) add(top, from_coarse);
  }
  all.tops = without_repeats(std::move(all.tops));
  return all;
}

}  // namespace sinew::vision
