#include "sinew/vision/cube_detection.h"

#include <algorithm>

#include "sinew/vision/shapes.h"
#include "sinew/vision/top_belief.h"
#include "sinew/vision/top_search.h"

namespace sinew::vision {
namespace {

constexpr double kSure = 0.55;      ///< belief from which on it is a cube
constexpr double kSureRound = 0.8;  ///< the same of one without corners, as discs have none
constexpr double kPerhaps = 0.15;   ///< from here on its height is likely that of a cube
constexpr double kOtherSure = 0.35;
constexpr double kOtherSize = 2.5;  ///< of what is no cube beside the others

/// The edge that most agree on, px, by how sure they are; nothing of nothing.
double common_edge(const std::vector<Top>& tops) {
  constexpr double kSame = 1.35;
  double best = 0;
  double most = 0;
  for (const Top& one : tops) {
    const double edge = edge_of(one.quad);
    double votes = 0;
    for (const Top& other : tops) {
      const double ratio = edge_of(other.quad) / edge;
      if (ratio < kSame && ratio > 1 / kSame) votes += other.sureness * other.sureness;
    }
    if (votes <= most) continue;
    most = votes;
    best = edge;
  }
  return best;
}

Height height_of(const LikelyOther& other) {
  return other.is_flat ? Height::kFlat : Height::kPerhaps;
}

/// A square of this edge, for what has no corners.
Quad square_around(Pixel middle, double edge) {
  const double half = edge / 2;
  return {middle + Pixel{-half, -half}, middle + Pixel{half, -half}, middle + Pixel{half, half},
          middle + Pixel{-half, half}};
}

}  // namespace

Detection detect_cubes(const Picture& picture, const DetectionSettings& settings) {
  const Things things = things_in(picture);
  const double common = common_edge(things.tops);
  const std::vector<double> believed = beliefs(things.tops);
  Detection detection;
  for (std::size_t i = 0; i < things.tops.size(); ++i) {
    const Top& top = things.tops[i];
    const auto refuse = [&](std::string_view why, Height height = Height::kPerhaps) {
      detection.refused.push_back({top.quad, std::string(why), height});
    };
    const bool is_wanted = settings.colors.empty() || !top.color ||
                           std::ranges::find(settings.colors, *top.color) != settings.colors.end();
    const auto as_cube = [&] {
      return SeenCube{top.color.value_or(ColorName::kRed),
                      top.quad,
                      middle_of(top.quad),
                      edge_of(top.quad),
                      yaw(top.quad),
                      believed[i],
                      {}};
    };
    const auto other = std::ranges::find_if(things.others, [&](const LikelyOther& one) {
      return one.sureness > top.sureness && is_inside(top.quad, one.middle);
    });
    constexpr int kCornersLeast = 2;
    const bool is_round = top.corners < kCornersLeast;
    const double ratio = edge_of(top.quad) / common;
    if (other != things.others.end()) {
      refuse(other->why, height_of(*other));
    } else if (top.is_print) {
      refuse(kIsFlat);  // or a black cube that something light hides in part: it may be as high
    } else if (ratio > kOtherSize) {
      refuse("it is larger than the other cubes");
    } else if (ratio < 1 / kOtherSize) {
      refuse("it is smaller than the other cubes");
    } else if (believed[i] < (is_round ? kSureRound : kSure)) {
      refuse(is_round ? "it has not four corners"
                      : "its top is hardly that of a cube, or mostly hidden",
             believed[i] > kPerhaps && !is_round ? Height::kLikely : Height::kPerhaps);
      if (top.color && is_wanted && !is_round) detection.refused.back().cube = as_cube();
    } else if (!top.color) {
      refuse("it is white or grey", Height::kLikely);
      if (settings.colors.empty()) detection.refused.back().cube = as_cube();
      detection.refused.back().has_color = false;
      detection.refused.back().is_sure = true;
    } else if (!is_wanted) {
      refuse("it is " + std::string(name(*top.color)) + ", which was not asked for",
             Height::kLikely);
      detection.refused.back().is_sure = true;
    } else {
      detection.cubes.push_back(as_cube());
    }
  }
  for (const LikelyOther& other : things.others) {
    const bool top = std::ranges::any_of(
        things.tops, [&](const Top& one) { return is_inside(one.quad, other.middle); });
    if (other.sureness < kOtherSure || top) continue;
    const double edge = common > 0 ? common : 0.04 * std::max(picture.width, picture.height);
    detection.refused.push_back(
        {square_around(other.middle, edge), std::string(other.why), height_of(other)});
  }
  return detection;
}

}  // namespace sinew::vision
