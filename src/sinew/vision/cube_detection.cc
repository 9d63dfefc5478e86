#include "sinew/vision/cube_detection.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "sinew/core/units.h"
#include "sinew/vision/edge_fit.h"
#include "sinew/vision/lab.h"
#include "sinew/vision/regions.h"
#include "sinew/vision/shapes.h"

namespace sinew::vision {
namespace {

/// px, the longer side of the picture that is searched; more shows no more of a cube.
constexpr int kSearched = 720;
/// Of that side: the smallest and the largest edge of a cube.
constexpr double kSmallest = 0.016;
constexpr double kLargest = 0.3;
/// Thresholds between a plane's darkest and brightest percent.
constexpr int kThresholds = 16;
constexpr double kElongationMax = 2.2;  ///< of the box around a square, seen aslant
constexpr double kSolidityMin = 0.86;   ///< of a region in its convex hull
constexpr double kFitMin = 0.85;        ///< of the four corners' area in that hull
constexpr double kRatioMax = 1.6;       ///< of its sides

/// Four corners around a region, and how well they do.
struct Candidate {
  Quad quad{};
  double shape = 0;  ///< solidity times fit, up to 1
};

/// What is inside and around four corners.
struct Look {
  Lab color;           ///< in the middle of what is inside
  double spread = 0;   ///< half of the inside is nearer to that than this
  double pattern = 0;  ///< four fifths are
  double apart = 0;    ///< nearly all around is farther from it than this
  double edges = 0;    ///< change of colour a px across the weakest side
};

double quantile(std::vector<double>& values, double share) {
  const auto at = values.begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::ranges::nth_element(values, at);
  return *at;
}

Plane chroma_of(const LabPicture& lab) {
  Plane plane = lab.a;
  for (std::size_t i = 0; i < plane.values.size(); ++i) {
    plane.values[i] = std::hypot(lab.a.values[i], lab.b.values[i]);
  }
  return plane;
}

/// Between what all but one percent of the picture is above, and below.
std::vector<float> thresholds_of(const Plane& plane) {
  std::vector<double> some;
  for (std::size_t i = 0; i < plane.values.size(); i += 7) some.push_back(plane.values[i]);
  const double low = quantile(some, 0.01);
  const double high = quantile(some, 0.99);
  std::vector<float> thresholds;
  for (int k = 1; k <= kThresholds; ++k) {
    thresholds.push_back(static_cast<float>(low + (high - low) * k / (kThresholds + 1)));
  }
  return thresholds;
}

std::optional<Candidate> candidate_of(const Region& region) {
  std::vector<Pixel> hull = convex_hull(region.edges);
  const double around = area_of(hull);
  const double solidity = region.area / around;
  if (solidity < kSolidityMin) return std::nullopt;
  const auto quad = four_corners(std::move(hull));
  if (!quad) return std::nullopt;
  const double fit = area_of(*quad) / around;
  if (fit < kFitMin || side_ratio(*quad) > kRatioMax) return std::nullopt;
  return Candidate{*quad, solidity * fit};
}

std::vector<Candidate> candidates_in(const LabPicture& lab) {
  const double side = std::max(lab.width(), lab.height());
  const RegionLimits limits{.area_min = (kSmallest * side) * (kSmallest * side),
                            .area_max = (kLargest * side) * (kLargest * side),
                            .elongation_max = kElongationMax};
  std::vector<Candidate> all;
  const auto take = [&](const Region& region) {
    if (const auto candidate = candidate_of(region)) all.push_back(*candidate);
  };
  const auto search = [&](const Plane& plane, bool below) {
    for (const float threshold : thresholds_of(plane)) {
      for_each_region(plane, threshold, Side::kAbove, limits, take);
      if (below) for_each_region(plane, threshold, Side::kBelow, limits, take);
    }
  };
  for (const Plane* plane : {&lab.L, &lab.a, &lab.b}) search(*plane, true);
  search(chroma_of(lab), false);
  return all;
}

class Inspector {
 public:
  explicit Inspector(const LabPicture& lab) : lab_(lab) {}

  std::optional<Look> look(const Quad& quad) const {
    Look look;
    std::vector<Lab> inside;
    constexpr int kGrid = 11;
    for (int i = 0; i < kGrid; ++i) {
      for (int k = 0; k < kGrid; ++k) {
        const auto place = [](int step) { return 0.15 + 0.7 * step / (kGrid - 1); };
        inside.push_back(at(across(quad, place(i), place(k))));
      }
    }
    look.color = median(inside);
    std::vector<double> off;
    for (const Lab& one : inside) off.push_back(distance(one, look.color));
    look.spread = quantile(off, 0.5);
    look.pattern = quantile(off, 0.8);
    std::vector<double> around;
    for (const double factor : {1.2, 1.3}) {
      const Quad ring = scaled(quad, factor);
      along(ring, 0, 1, [&](Pixel p, Pixel /*normal*/) {
        if (is_in_picture(p)) around.push_back(distance(at(p), look.color));
      });
    }
    if (around.size() < 40) return std::nullopt;  // half of it is outside
    look.apart = quantile(around, 0.15);
    look.edges = edges(quad);
    return look;
  }

 private:
  static constexpr int kAlong = 12;  ///< places on each side

  bool is_in_picture(Pixel p) const {
    return p.x >= 0 && p.y >= 0 && p.x < lab_.width() && p.y < lab_.height();
  }
  Lab at(Pixel p) const {
    const int x = std::clamp(static_cast<int>(p.x), 0, lab_.width() - 1);
    const int y = std::clamp(static_cast<int>(p.y), 0, lab_.height() - 1);
    return lab_.at(x, y);
  }
  static Pixel across(const Quad& quad, double u, double v) {
    const Pixel top = quad[0] + u * (quad[1] - quad[0]);
    const Pixel bottom = quad[3] + u * (quad[2] - quad[3]);
    return top + v * (bottom - top);
  }
  static Lab median(const std::vector<Lab>& colors) {
    const auto of = [&](float Lab::* part) {
      std::vector<double> values;
      for (const Lab& color : colors) values.push_back(color.*part);
      return static_cast<float>(quantile(values, 0.5));
    };
    return {of(&Lab::L), of(&Lab::a), of(&Lab::b)};
  }
  /// Places on each side, with what points out of it.
  template <class Visit>
  static void along(const Quad& quad, double from, double to, const Visit& visit) {
    for (std::size_t i = 0; i < 4; ++i) along_side(quad, i, from, to, visit);
  }
  template <class Visit>
  static void along_side(const Quad& quad, std::size_t i, double from, double to,
                         const Visit& visit) {
    const Pixel side = quad[(i + 1) % 4] - quad[i];
    const Pixel normal = (1 / std::max(length(side), 1e-9)) * Pixel{side.y, -side.x};
    for (int k = 0; k < kAlong; ++k) {
      visit(quad[i] + (from + (to - from) * k / (kAlong - 1)) * side, normal);
    }
  }
  /// The weakest side: what three quarters of its places have at least, near it.
  double edges(const Quad& quad) const {
    double weakest = kInfinity;
    for (std::size_t i = 0; i < 4; ++i) {
      std::vector<double> steps;
      along_side(quad, i, 0.15, 0.85, [&](Pixel p, Pixel normal) {
        double most = 0;
        for (int offset = -2; offset <= 2; ++offset) {
          const Pixel there = p + offset * normal;
          most = std::max<double>(most, distance(at(there + normal), at(there - normal)) / 2);
        }
        steps.push_back(most);
      });
      weakest = std::min(weakest, quantile(steps, 0.25));
    }
    return weakest;
  }

  const LabPicture& lab_;
};

struct Judged {
  Quad quad{};
  Look look;
  double score = 0;
};

/// 0 where it is no square of one colour; what speaks for it is multiplied.
double score_of(const Candidate& candidate, const Look& look) {
  constexpr double kEdge = 4;     // a px: as sharp as any
  constexpr double kApart = 12;   // of colours that are clearly different
  constexpr double kSpread = 16;  // of a side that shines
  const double skewed = skew(candidate.quad) / from_deg(60);
  const double square = (kRatioMax - side_ratio(candidate.quad)) / (kRatioMax - 1);
  return std::pow(candidate.shape, 3) * std::min(1.0, look.edges / kEdge) *
         std::min(1.0, look.apart / kApart) * std::max(0.0, 1 - look.spread / kSpread) *
         std::max(0.0, 1 - skewed) * square;
}

/// Of those that lie on each other the best.
std::vector<Judged> best_of(std::vector<Judged> all) {
  std::ranges::stable_sort(all, [](const Judged& a, const Judged& b) { return a.score > b.score; });
  std::vector<Judged> kept;
  constexpr double kShared = 0.25;
  for (Judged& one : all) {
    const bool taken = std::ranges::any_of(kept, [&](const Judged& other) {
      const double smaller = std::min(area_of(one.quad), area_of(other.quad));
      return common_area(one.quad, other.quad) > kShared * smaller;
    });
    if (!taken) kept.push_back(std::move(one));
  }
  return kept;
}

/// The edge that most agree on, px, by how sure they are.
double common_size(const std::vector<Judged>& all) {
  constexpr double kSame = 1.3;
  double best = 0;
  double most = 0;
  for (const Judged& one : all) {
    const double size = std::sqrt(area_of(one.quad));
    double votes = 0;
    for (const Judged& other : all) {
      const double ratio = std::sqrt(area_of(other.quad)) / size;
      if (ratio < kSame && ratio > 1 / kSame) votes += other.score;
    }
    if (votes <= most) continue;
    most = votes;
    best = size;
  }
  return best;
}

/// From the picture that is searched to the one that was given.
Quad enlarged(Quad quad, double scale) {
  for (Pixel& corner : quad) corner = scale * corner;
  return quad;
}

SeenCube cube_of(const Judged& one, ColorName color, double scale) {
  const Quad top = enlarged(one.quad, scale);
  return {color,          top,
          middle_of(top), std::sqrt(area_of(top)),
          yaw(top),       std::clamp(one.score / 0.6, 0.0, 1.0)};
}

}  // namespace

Detection detect_cubes(const Picture& picture, const DetectionSettings& settings) {
  constexpr double kScoreMin = 0.08;
  constexpr double kPatternMax = 26;  // of one colour, in light and shade
  constexpr double kOtherSize = 1.75;
  const Picture small = shrunk(picture, kSearched);
  const double scale = static_cast<double>(picture.width) / small.width;
  const LabPicture raw = to_lab(small, white_balance(small));
  const LabPicture lab{smoothed(raw.L), smoothed(raw.a), smoothed(raw.b)};
  const Inspector inspector(lab);
  std::vector<Judged> judged;
  for (const Candidate& candidate : candidates_in(lab)) {
    const auto look = inspector.look(candidate.quad);
    if (!look) continue;
    const double score = score_of(candidate, *look);
    if (score >= kScoreMin) judged.push_back({candidate.quad, *look, score});
  }
  judged = best_of(std::move(judged));

  Detection detection;
  const auto refuse = [&](const Judged& one, std::string why) {
    detection.refused.push_back({enlarged(one.quad, scale), std::move(why)});
  };
  std::vector<Judged> squares;
  for (Judged& one : judged) {
    if (one.look.pattern > kPatternMax) {
      refuse(one, "it has a pattern: a tag, a label or something printed");
    } else if (!color_name(one.look.color)) {
      refuse(one, "it is white or grey");
    } else {
      one.quad = fitted_to_edges(raw, fitted_to_edges(raw, one.quad));
      squares.push_back(std::move(one));
    }
  }
  const double size = common_size(squares);
  for (const Judged& one : squares) {
    const ColorName color = *color_name(one.look.color);
    const double ratio = std::sqrt(area_of(one.quad)) / size;
    const bool wanted = settings.colors.empty() ||
                        std::ranges::find(settings.colors, color) != settings.colors.end();
    if (ratio > kOtherSize) {
      refuse(one, "it is larger than the other cubes");
    } else if (ratio < 1 / kOtherSize) {
      refuse(one, "it is smaller than the other cubes");
    } else if (!wanted) {
      refuse(one, "it is " + std::string(name(color)) + ", which was not asked for");
    } else {
      detection.cubes.push_back(cube_of(one, color, scale));
    }
  }
  return detection;
}

}  // namespace sinew::vision
