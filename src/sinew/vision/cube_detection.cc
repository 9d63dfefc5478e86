#include "sinew/vision/cube_detection.h"

#include <algorithm>
#include <cmath>

#include "sinew/vision/cube_net.h"
#include "sinew/vision/edge_fit.h"
#include "sinew/vision/lab.h"
#include "sinew/vision/shapes.h"

namespace sinew::vision {
namespace {

/// px, the longer side of the picture that is searched, and of the one for larger cubes.
constexpr int kFine = 960;
constexpr int kCoarse = 400;
/// px of the fine picture: up to this edge it is believed, from somewhat less on the coarse one.
constexpr double kBorder = 56;
constexpr double kCommon = 0.65;  ///< of that
constexpr double kSure = 0.47;    ///< from here on it is a cube
constexpr double kUnsure = 0.12;  ///< from here on it is worth a word
constexpr double kOtherSure = 0.35;
constexpr double kOtherSize = 2.5;  ///< of what is no cube beside the others
constexpr double kShared = 0.3;     ///< of the smaller of two tops that are the same

bool is_same(const Quad& one, const Quad& other) {
  return common_area(one, other) > kShared * std::min(area_of(one), area_of(other));
}

double edge_of(const Quad& quad) {
  return std::sqrt(area_of(quad));
}

/// From the picture that was searched to the one that was given.
Quad enlarged(Quad quad, double scale) {
  for (Pixel& corner : quad) corner = scale * corner;
  return quad;
}

/// What looks like a top, with its sides where the picture has edges.
struct Top : LikelyTop {
  int corners = 0;  ///< that are filled, of four
};

struct Things {
  std::vector<Top> tops;
  std::vector<LikelyOther> others;
};

/// All that looks like a top or like something else, in px of `picture`; of tops that lie on each
/// other the surest.
Things things_in(const Picture& picture) {
  const Picture fine = shrunk(picture, kFine);
  const Picture coarse = shrunk(fine, kCoarse);
  const double scale = static_cast<double>(picture.width) / fine.width;
  const double from_coarse = static_cast<double>(fine.width) / coarse.width;
  const LabPicture lab = to_lab(fine);
  Things all;
  const auto add = [&](const LikelyTop& likely, double to_fine) {
    Top top{likely};
    top.quad = turned_to_edges(lab, enlarged(top.quad, to_fine));
    // What the network says of a size is right to about a tenth.
    top.quad = fitted_to_edges(lab, top.quad, std::max(4.0, 0.09 * edge_of(top.quad)));
    top.quad = fitted_to_edges(lab, top.quad, 4);
    top.corners = corners_filled(lab, top.quad);
    top.quad = enlarged(top.quad, scale);
    all.tops.push_back(top);
  };
  const bool both = coarse.width < fine.width;
  const Likely in_fine = likely_things(fine, kUnsure);
  for (const LikelyTop& top : in_fine.tops) {
    if (!both || edge_of(top.quad) < kBorder) add(top, 1);
  }
  all.others = in_fine.others;
  for (LikelyOther& other : all.others) other.middle = scale * other.middle;
  const Likely in_coarse = both ? likely_things(coarse, kUnsure) : Likely{};
  for (const LikelyTop& top : in_coarse.tops) {
    if (from_coarse * edge_of(top.quad) > kCommon * kBorder) add(top, from_coarse);
  }
  std::ranges::stable_sort(all.tops, std::ranges::greater{}, &LikelyTop::sureness);
  std::vector<Top> kept;
  for (const Top& top : all.tops) {
    const bool seen =
        std::ranges::any_of(kept, [&](const Top& one) { return is_same(one.quad, top.quad); });
    if (!seen) kept.push_back(top);
  }
  all.tops = std::move(kept);
  return all;
}

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
  Detection detection;
  for (const Top& top : things.tops) {
    const auto refuse = [&](std::string_view why) {
      detection.refused.push_back({top.quad, std::string(why)});
    };
    const auto other = std::ranges::find_if(things.others, [&](const LikelyOther& one) {
      return one.sureness > top.sureness && is_inside(top.quad, one.middle);
    });
    constexpr int kCornersLeast = 2;
    const double ratio = edge_of(top.quad) / common;
    if (other != things.others.end()) {
      refuse(other->why);
    } else if (top.corners < kCornersLeast) {
      refuse("it has not four corners");
    } else if (ratio > kOtherSize) {
      refuse("it is larger than the other cubes");
    } else if (ratio < 1 / kOtherSize) {
      refuse("it is smaller than the other cubes");
    } else if (top.sureness < kSure) {
      refuse("its top is hardly that of a cube, or mostly hidden");
    } else if (!top.color) {
      refuse("it is white or grey");
    } else if (!settings.colors.empty() &&
               std::ranges::find(settings.colors, *top.color) == settings.colors.end()) {
      refuse("it is " + std::string(name(*top.color)) + ", which was not asked for");
    } else {
      detection.cubes.push_back({*top.color,
                                 top.quad,
                                 middle_of(top.quad),
                                 edge_of(top.quad),
                                 yaw(top.quad),
                                 top.sureness,
                                 {}});
    }
  }
  for (const LikelyOther& other : things.others) {
    const bool top = std::ranges::any_of(
        things.tops, [&](const Top& one) { return is_inside(one.quad, other.middle); });
    if (other.sureness < kOtherSure || top) continue;
    const double edge = common > 0 ? common : 0.04 * std::max(picture.width, picture.height);
    detection.refused.push_back({square_around(other.middle, edge), std::string(other.why)});
  }
  return detection;
}

}  // namespace sinew::vision
