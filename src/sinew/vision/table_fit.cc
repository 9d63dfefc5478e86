#include "sinew/vision/table_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/vision/view_watch.h"

namespace sinew::vision {
namespace {

constexpr int kPerSide = 9;
constexpr double kAside = 0.9;  // px, of what is compared, to either side
// Of 8-bit RGB: what draws a side to it, and what is enough for one.
constexpr double kDraws = 80;
constexpr double kEnough = 22;

using Color = std::array<double, 3>;

/// Between pixels; nothing outside of the picture.
std::optional<Color> color_at(const Picture& picture, Pixel p) {
  const double x = p.x - 0.5, y = p.y - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= picture.width || y0 + 1 >= picture.height) return std::nullopt;
  const double u = x - x0, v = y - y0;
  Color color;
  for (std::size_t c = 0; c < 3; ++c) {
    const double above = (1 - u) * picture.at(x0, y0)[c] + u * picture.at(x0 + 1, y0)[c];
    const double below = (1 - u) * picture.at(x0, y0 + 1)[c] + u * picture.at(x0 + 1, y0 + 1)[c];
    color[c] = (1 - v) * above + v * below;
  }
  return color;
}

/// A top on its plane.
struct Top {
  double x = 0;    ///< m
  double y = 0;    ///< m
  double yaw = 0;  ///< rad
};

class Fit {
 public:
  Fit(const Picture& picture, const TableCamera& camera, double height, double edge, double pixel,
      const std::vector<bool>& hidden)
      : picture_(picture),
        camera_(camera),
        hidden_(hidden),
        grid_(grid_of(picture.width, picture.height)),
        X_CW_(camera.X_WC.inverse()),
        height_(height),
        half_(edge / 2),
        aside_(kAside * pixel) {}

  /// What is hidden counts as none: a top that hides more of itself has less.
  double draw(const Top& top) const {
    double sum = 0;
    for (int side = 0; side < 4; ++side) sum += across(top, side, height_, kDraws).sum;
    return sum / (4 * kPerSide);
  }
  /// Of what is not hidden.
  double contrast(const Top& top) const {
    Across all;
    for (int side = 0; side < 4; ++side) {
      const Across here = across(top, side, height_, kEnough);
      all.sum += here.sum;
      all.open += here.open;
    }
    return all.mean();
  }
  bool is_sure(const Top& top) const {
    const auto is_open = [&](int side) {
      return 2 * across(top, side, height_, kEnough).open >= kPerSide;
    };
    return (is_open(0) || is_open(2)) && (is_open(1) || is_open(3));
  }

  /// Where the side faces below meet the table.
  std::optional<double> foot(const Top& top) const {
    constexpr double kSeen = 5;  // px, of a side face's height in the picture
    std::optional<double> least;
    for (int side = 0; side < 4; ++side) {
      const auto above = pixel(at(top, side, 0, half_, height_));
      const auto below = pixel(at(top, side, 0, half_, 0));
      const Vec3 middle = at(top, side, 0, half_, height_ / 2);
      const Vec3 out = at(top, side, 0, 2 * half_, height_ / 2) - middle;
      const bool faces = dot(camera_.X_WC.p - middle, out) > 0;
      if (!faces || !above || !below || length(*above - *below) < kSeen) continue;
      const Across here = across(top, side, 0, kEnough);
      if (2 * here.open < kPerSide) continue;
      least = std::min(least.value_or(here.mean()), here.mean());
    }
    return least;
  }

  /// The best of some places around, up to a quarter of an edge aside: a top and a side face that
  /// were taken for one top have their middle between those of both.
  Top best_around(const Top& top) const {
    constexpr int kSteps = 3;
    const double step = half_ / 2 / kSteps;
    const double cos = std::cos(top.yaw), sin = std::sin(top.yaw);
    Top best = top;
    double most = draw(top);
    for (int i = -kSteps; i <= kSteps; ++i) {
      for (int k = -kSteps; k <= kSteps; ++k) {
        if (i * i + k * k > kSteps * kSteps) continue;
        const Top other{top.x + step * (i * cos - k * sin), top.y + step * (i * sin + k * cos),
                        top.yaw};
        const double there = draw(other);
        if (there <= most) continue;
        most = there;
        best = other;
      }
    }
    return best;
  }

  /// Steps along each of its three numbers, halved where none helps.
  Top best_near(Top top, double step, double turn) const {
    constexpr int kHalvings = 6, kRounds = 8;
    double most = draw(top);
    for (int halving = 0; halving < kHalvings; ++halving, step /= 2, turn /= 2) {
      bool better = true;
      for (int round = 0; better && round < kRounds; ++round) {
        better = false;
        for (const Top& way : {Top{step, 0, 0}, {0, step, 0}, {0, 0, turn}}) {
          for (const double sign : {1.0, -1.0}) {
            const Top other{top.x + sign * way.x, top.y + sign * way.y, top.yaw + sign * way.yaw};
            const double there = draw(other);
            if (there <= most) continue;
            most = there;
            top = other;
            better = true;
          }
        }
      }
    }
    return top;
  }

 private:
  /// A point of the top's plane, or below it. Side 0 lies at +x of the top, the others a quarter
  /// turn on. m
  static Vec3 at(const Top& top, int side, double along, double out, double height) {
    constexpr std::array<double, 4> kCos{1, 0, -1, 0}, kSin{0, 1, 0, -1};
    const auto i = static_cast<std::size_t>(side);
    const double u = out * kCos[i] - along * kSin[i], v = out * kSin[i] + along * kCos[i];
    const double cos = std::cos(top.yaw), sin = std::sin(top.yaw);
    return {top.x + cos * u - sin * v, top.y + sin * u + cos * v, height};
  }
  std::optional<Pixel> pixel(const Vec3& p_W) const { return camera_.model.project(X_CW_ * p_W); }
  bool is_hidden(const Vec3& p_W) const {
    if (hidden_.empty()) return false;
    const auto p = pixel(p_W);
    const auto cell = p ? cell_of(grid_, picture_.width, picture_.height, *p) : std::nullopt;
    return cell && hidden_[*cell];
  }
  std::optional<Color> color(const Vec3& p_W) const {
    const auto p = pixel(p_W);
    return p ? color_at(picture_, *p) : std::nullopt;
  }
  struct Across {
    double sum = 0;
    int open = 0;  // places that are not hidden

    double mean() const { return open > 0 ? sum / open : 0; }
  };
  /// Contrast across one side's line at a height.
  Across across(const Top& top, int side, double height, double most) const {
    Across all;
    for (int i = 0; i < kPerSide; ++i) {
      const double along = 0.85 * half_ * (2.0 * i / (kPerSide - 1) - 1);
      const Vec3 in = at(top, side, along, half_ - aside_, height);
      const Vec3 out = at(top, side, along, half_ + aside_, height);
      if (is_hidden(in) || is_hidden(out)) continue;
      ++all.open;
      const auto inside = color(in);
      const auto outside = color(out);
      if (!inside || !outside) continue;
      double square = 0;
      for (std::size_t c = 0; c < 3; ++c) square += std::pow((*inside)[c] - (*outside)[c], 2);
      all.sum += std::min(most, std::sqrt(square));
    }
    return all;
  }

  const Picture& picture_;
  const TableCamera& camera_;
  const std::vector<bool>& hidden_;
  CellGrid grid_;
  Pose<frame::Camera, frame::World> X_CW_;
  double height_;  ///< m
  double half_;    ///< m
  double aside_;   ///< m
};

}  // namespace

TableFit fitted_on_table(const Picture& picture, const TableCamera& camera,
                         const CubePosition& start, double edge, double pixel,
                         const std::vector<bool>& hidden) {
  const Top begin{start.top_W.x, start.top_W.y, start.yaw};
  // From afar first: with sides that are compared over a wider strip it does not stop early.
  const Fit coarse(picture, camera, start.top_W.z, edge, 2.5 * pixel, hidden);
  const Fit fine(picture, camera, start.top_W.z, edge, pixel, hidden);
  const auto fit_at = [&](const Top& top) {
    TableFit fit{start, fine.contrast(top), fine.foot(top), fine.is_sure(top)};
    fit.position.top_W.x = top.x;
    fit.position.top_W.y = top.y;
    fit.position.yaw = std::remainder(top.yaw, kPi / 2);
    if (fit.position.yaw < 0) fit.position.yaw += kPi / 2;
    return fit;
  };
  TableFit best = fit_at(begin);
  double most = 0;
  // Edges of a side face or the grain of wood can attract the fit. The right fit also has edges
  // where the side faces meet the table.
  for (const Top& from : {coarse.best_around(begin), begin}) {
    const Top near = coarse.best_near(from, 2 * pixel, from_deg(4));
    const Top top = fine.best_near(near, pixel, from_deg(2));
    if (std::hypot(top.x - begin.x, top.y - begin.y) > edge / 3) continue;
    const TableFit fit = fit_at(top);
    const double fits = fit.contrast + fit.foot.value_or(0);
    if (fits <= most) continue;
    most = fits;
    best = fit;
  }
  return best;
}

}  // namespace sinew::vision
