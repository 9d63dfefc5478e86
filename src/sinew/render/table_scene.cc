#include "sinew/render/table_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <span>

#include "sinew/core/units.h"
#include "sinew/render/paint.h"
#include "sinew/render/prints.h"
#include "sinew/render/solids.h"
#include "sinew/vision/shapes.h"

namespace sinew::render {
namespace {

using vision::ColorName;
using vision::Pixel;

/// m, the edge of a common cube.
constexpr double kEdge = 0.03;

/// sRGB of a hue (deg), a saturation and a value, each 0 to 1.
std::array<double, 3> from_hsv(double hue, double saturation, double value) {
  std::array<double, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double k = std::fmod((hue + 360) / 60 + 5 - 2 * static_cast<double>(c), 6.0);
    rgb[c] = value * (1 - saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  }
  return rgb;
}

/// What people call by one name, in the light of day.
struct HsvRange {
  double hue_low;  ///< deg
  double hue_high;
  double saturation_low;
  double saturation_high;
  double value_low;
  double value_high;
};
constexpr std::array<HsvRange, vision::kColorNames> kNamed{{{350, 366, 0.7, 1, 0.45, 1},
                                                            {17, 33, 0.7, 1, 0.75, 1},
                                                            {45, 61, 0.5, 1, 0.7, 1},
                                                            {80, 165, 0.3, 1, 0.22, 1},
                                                            {197, 240, 0.5, 1, 0.25, 1},
                                                            {260, 295, 0.35, 0.9, 0.3, 0.85},
                                                            {318, 345, 0.25, 0.75, 0.8, 1},
                                                            {0, 360, 0, 0.3, 0.03, 0.2},
                                                            {26, 40, 0.2, 0.5, 0.55, 0.95}}};

Rgb linear_of(const std::array<double, 3>& srgb) {
  unsigned hex = 0;
  for (const double v : srgb) {
    hex = hex << 8U | static_cast<unsigned>(std::lround(255 * std::clamp(v, 0.0, 1.0)));
  }
  return from_srgb(hex);
}

class Maker {
 public:
  Maker(std::uint64_t seed, const TableSettings& settings) : random_(seed), settings_(settings) {}

  TableScene make() {
    place_camera();
    place_lamps();
    lay_table();
    const double clutter = random_.uniform(0, 1);
    if (chance(0.35)) lay_board();
    if (chance(0.25)) furnish_room();
    if (chance(0.2)) lay_zones();
    for (int n = whole(0, static_cast<int>(1 + 5 * clutter)); n > 0; --n) lay_flat();
    place_cubes();
    if (chance(0.15)) place_tray();
    for (int n = whole(0, static_cast<int>(7 * clutter)); n > 0; --n) place_other();
    if (chance(0.3)) reach_in(true);
    if (chance(0.12)) reach_in(false);
    if (chance(0.12)) lay_cable();
    set_sensor();
    return std::move(out_);
  }

 private:
  using X = Pose<frame::World, frame::Solid>;

  double uniform(double low, double high) { return random_.uniform(low, high); }
  int whole(int low, int high) { return static_cast<int>(random_.uniform(low, high + 1)); }
  bool chance(double share) { return random_.uniform(0, 1) < share; }
  Rgb one_of(std::span<const unsigned> swatches) { return near_one_of(random_, swatches); }
  Rgb any_color() { return render::any_color(random_); }
  /// One of the swatches, or any color at all.
  Rgb any_color_at_all() {
    if (chance(0.5)) return any_color();
    return linear_of(from_hsv(uniform(0, 360), uniform(0, 1) * uniform(0, 1), uniform(0.03, 1)));
  }
  Material plastic(Rgb color) { return render::plastic(random_, color); }
  std::array<double, 3> srgb_named(ColorName name) {
    const HsvRange& range = kNamed[static_cast<std::size_t>(name)];
    return from_hsv(uniform(range.hue_low, range.hue_high),
                    uniform(range.saturation_low, range.saturation_high),
                    uniform(range.value_low, range.value_high));
  }
  std::size_t add(std::variant<Polyhedron, Cylinder, Ball, Ground> form, const X& X_WS,
                  Material material) {
    out_.scene.solids.push_back({std::move(form), X_WS, std::move(material)});
    return out_.scene.solids.size() - 1;
  }
  void add_other(OtherKind kind, std::variant<Polyhedron, Cylinder, Ball, Ground> form,
                 const X& X_WS, Material material) {
    out_.others.push_back({kind, add(std::move(form), X_WS, std::move(material)), {}, 0});
  }
  /// A place on the table that the camera shows.
  Vec3 somewhere(double height, double margin = 0.04) {
    for (int tries = 0; tries < 50; ++tries) {
      const Pixel p{uniform(margin, 1 - margin) * settings_.width,
                    uniform(margin, 1 - margin) * settings_.height};
      const Vec3 ray = out_.X_WC.R * out_.camera.direction(p);
      if (ray.z > -0.1) continue;
      return out_.X_WC.p + (height - out_.X_WC.p.z) / ray.z * ray;
    }
    return {0, 0, height};
  }

  void place_camera() {
    const double view = from_deg(uniform(35, 75));
    vision::CameraModel camera = vision::pinhole(settings_.width, settings_.height, view);
    if (chance(0.5)) camera.lens = {uniform(-0.2, 0.12), uniform(-0.03, 0.03), 0, 0, 0};
    camera.center = camera.center + Pixel{uniform(-10, 10), uniform(-10, 10)};
    edge_px_ = std::exp(uniform(std::log(settings_.edge_least), std::log(settings_.edge_most)));
    const double distance = kEdge * camera.fx / edge_px_;
    const double tilt = chance(0.45)  ? from_deg(uniform(0, 15))
                        : chance(0.5) ? from_deg(uniform(10, 50))
                                      : from_deg(uniform(40, 68));
    const double aside = uniform(0, 2 * kPi);
    const Vec3 eye{distance * std::sin(tilt) * std::cos(aside),
                   distance * std::sin(tilt) * std::sin(aside), distance * std::cos(tilt)};
    out_.camera = camera;
    out_.X_WC = looking_at(eye, {0, 0, 0});
    const double roll = tilt > from_deg(25) ? uniform(-0.15, 0.15) : uniform(0, 2 * kPi);
    out_.X_WC.R = out_.X_WC.R * rotation_z(roll);
    // m, half of what the middle of the picture shows.
    reach_ = 0.5 * distance * settings_.width / camera.fx;
  }

  Rgb warm() {
    const double t = uniform(-1, 1);  // from a bulb to a cloudy sky
    return {static_cast<float>(1 - 0.25 * t), 1, static_cast<float>(1 + 0.35 * t)};
  }

  void place_lamps() {
    const int count = whole(1, 3);
    const bool is_sun = chance(0.12);  // one that throws hard shadows
    for (int i = 0; i < count; ++i) {
      const double high = uniform(0.5, 2.5) * std::max(0.4, 2 * reach_);
      const double aside = uniform(0, 2 * kPi);
      const double out = uniform(0, 1.5) * high;
      const double far = std::hypot(high, out);
      const double power = uniform(0.15, 1) / count * far * far;
      out_.scene.lamps.push_back({{out * std::cos(aside), out * std::sin(aside), high},
                                  (is_sun ? 0.005 : uniform(0.01, 0.25)) * far,
                                  static_cast<float>((is_sun ? 2 : 1) * power) * warm()});
    }
    out_.scene.above = static_cast<float>(uniform(0.08, 0.7)) * warm();
    out_.scene.below = static_cast<float>(uniform(0.02, 0.3)) * any_color();
  }

  void lay_table() {
    Material table = plastic(chance(0.7) ? one_of(table_swatches()) : any_color_at_all());
    table.gloss = static_cast<float>(chance(0.8) ? uniform(0, 0.08) : uniform(0.08, 0.3));
    const double size = uniform(0.5, 3) * reach_;
    switch (whole(0, 12)) {
      case 0:
      case 1:
        print_on(table, grain(random_, uniform(0.2, 0.7)), size);
        break;
      case 2:
      case 3:
        print_on(table, clouds(random_, uniform(0.05, 0.6)), size);
        break;
      case 4:
        print_on(table, grid(random_, whole(4, 20), uniform(-0.3, 0.8)), size);
        break;
      case 5:
        print_on(table, fields(random_), 4 * reach_);
        break;
      case 6:
        print_on(table, chance(0.5) ? blots(random_) : checkers(whole(4, 16)), size);
        break;
      case 7:
      case 8:
        print_on(table, mottled(random_, uniform(0.1, 0.9), uniform(0, 1)), size);
        break;
      case 9:
        print_on(table, collage(random_), uniform(1, 4) * reach_);
        break;
      default:
        break;
    }
    if (chance(0.6)) {
      add(Ground{}, {}, table);
      return;
    }
    // Its edge is in view: the floor lies below.
    Material floor = plastic(one_of(table_swatches()));
    print_on(floor, chance(0.5) ? clouds(random_, 0.5) : mottled(random_, 0.6, uniform(0, 0.6)), 1);
    add(Ground{}, {Rotation{}, {0, 0, -uniform(0.1, 0.9)}}, floor);
    const Vec3 half{uniform(0.5, 1.5) * reach_, uniform(0.5, 1.5) * reach_, 0.01};
    add(box(half),
        upright(uniform(-0.4, 0.4) * reach_, uniform(-0.4, 0.4) * reach_, -0.01, uniform(0, kPi)),
        table);
  }

  void lay_board() {
    Material board = plastic(one_of(table_swatches()));
    const double half = uniform(0.3, 0.9) * reach_;
    const double high = uniform(0.0003, 0.004);
    switch (whole(0, 8)) {
      case 0:
        print_on(board, blots(random_), 2 * half, true);
        break;
      case 1:
        print_on(board, fields(random_), 2 * half, true);
        break;
      case 2:
        print_on(board, writing(random_), half);
        break;
      case 3:
        print_on(board, stripes(whole(8, 40)), half);
        break;
      case 4:
        print_on(board, grid(random_, whole(4, 16), 0.7), half);
        break;
      case 5:
        print_on(board, framed(uniform(0.01, 0.08)), 2 * half, true);
        break;
      case 6:
      case 7:
        print_on(board, collage(random_), 2 * half, true);
        break;
      default:
        break;
    }
    add(box({half, half * uniform(0.6, 1), high}),
        upright(uniform(-0.3, 0.3) * reach_, uniform(-0.3, 0.3) * reach_, high, uniform(0, kPi)),
        board);
  }

  /// Paper, tape, a tag, a ring mark: no height that one would see.
  void lay_flat() {
    const Vec3 at = somewhere(0, -0.1);
    const double half = kEdge * uniform(0.3, 2.5);
    const double high = uniform(0.0001, 0.0006);
    Material flat = plastic(chance(0.4) ? Rgb{0.9F, 0.9F, 0.9F} : any_color_at_all());
    flat.gloss *= 0.3F;
    double narrow = chance(0.3) ? 1 : uniform(0.1, 1);
    const int kind = whole(0, 7);
    if (kind == 0) print_on(flat, writing(random_), 2 * half);
    if (kind == 1 || kind == 2) print_on(flat, tag(random_), 2 * half, true);
    if (kind == 3) print_on(flat, rings(), 2 * half, true);
    if (kind == 4) print_on(flat, chance(0.5) ? checkers(8) : stripes(12), 2 * half, true);
    if (kind == 5) print_on(flat, collage(random_), 2 * half, true);
    if (kind == 1 || kind == 2 || kind == 3) {
      flat.color = {0.9F, 0.9F, 0.9F};
      narrow = 1;
    }
    const double turn = uniform(0, kPi);
    if (chance(0.1)) {
      add_other(OtherKind::kFlat, Cylinder{half, high}, upright(at.x, at.y, high, turn), flat);
    } else {
      add_other(OtherKind::kFlat, box({half, half * narrow, high}),
                upright(at.x, at.y, high + 0.0002, turn), flat);
    }
    taken_.push_back({{at.x, at.y, 0}, 1.1 * half});
  }

  struct Taken {
    Vec3 at;
    double radius;
  };
  bool is_free(const Vec3& at, double radius) const {
    return std::ranges::none_of(taken_, [&](const Taken& other) {
      return std::hypot(at.x - other.at.x, at.y - other.at.y) < radius + other.radius;
    });
  }

  std::pair<Material, PlacedCube> block() {
    PlacedCube cube;
    cube.is_pale = chance(0.05);
    if (!cube.is_pale) {
      cube.color = static_cast<ColorName>(whole(0, static_cast<int>(vision::kColorNames) - 1));
    }
    if (!cube.is_pale && few_ > 0)
      cube.color = picked_[static_cast<std::size_t>(whole(1, few_)) - 1];
    const auto color = cube.is_pale ? std::nullopt : std::optional(cube.color);
    Material material = painted_block(random_, color, static_cast<BlockStyle>(style_), edge_);
    if (!cube.is_pale && (is_printed_ || chance(0.4))) {
      const std::array<double, 3> srgb = srgb_named(cube.color);
      material.color = linear_of(srgb);
      if (is_printed_ && chance(0.8)) {
        const double rgb[3] = {srgb[0], srgb[1], srgb[2]};
        print_on(material, printed_face(random_, rgb, face_print_), edge_, true);
      }
    }
    if (surface_ == 0) material.gloss = 0;  // foam, chalk, raw wood
    if (surface_ == 1) {
      material.gloss = static_cast<float>(uniform(0.06, 0.18));
      material.roughness = static_cast<float>(uniform(0.06, 0.3));
    }
    return {std::move(material), cube};
  }

  /// A block whose bottom is at `at`. How high it is, m.
  double put_block(const Vec3& at, double turn) {
    const double common = edge_;
    if (is_mixed_) edge_ *= uniform(0.65, 1.35);
    auto [material, cube] = block();
    const double high = edge_ * proportion_ * uniform(0.97, 1.03);
    const double slim = uniform(0.97, 1.03);
    const Vec3 half{edge_ / 2 * slim, edge_ / 2 / slim, high / 2};
    cube.edge = edge_;
    cube.top_W = at + Vec3{0, 0, high};
    Polyhedron form = box(half, bevel_ * edge_);
    if (chamfer_ > 0) {
      for (const auto& [x, y] : {std::pair(1, 1), {1, -1}, {-1, 1}, {-1, -1}}) {
        const double root = std::sqrt(0.5);
        form.faces.push_back(
            {{x * root, y * root, 0}, (half.x + half.y - chamfer_ * edge_) * root});
      }
    }
    if (is_capped_) {
      add(form, upright(at.x, at.y, at.z + high / 2 - 0.001, turn), body_);
      const double share = uniform(0.8, 1);
      form = box({share * half.x, share * half.y, 0.0015}, 0.0005);
      cube.edge *= share;
      cube.solid = add(form, upright(at.x, at.y, at.z + high - 0.0015, turn), material);
    } else {
      cube.solid = add(form, upright(at.x, at.y, at.z + high / 2, turn), material);
    }
    for (int i = 0; i < studs_ * studs_; ++i) {
      const double step = edge_ / studs_;
      const Vec3 stud =
          rotation_z(turn) * Vec3{(i % studs_ - 0.5 * (studs_ - 1)) * step,
                                  (static_cast<double>(i / studs_) - 0.5 * (studs_ - 1)) * step, 0};
      add(Cylinder{0.3 * step, 0.05 * step},
          {Rotation{}, cube.top_W + stud + Vec3{0, 0, 0.05 * step}}, material);
    }
    out_.cubes.push_back(cube);
    edge_ = common;
    return high;
  }

  void place_cubes() {
    edge_ = kEdge * uniform(0.95, 1.05);
    style_ = whole(0, 9);
    bevel_ = chance(0.7) ? uniform(0.01, 0.08) : 0;
    chamfer_ = chance(0.2) ? uniform(0.03, 0.16) : 0;
    studs_ = chance(0.05) ? whole(1, 3) : 0;
    proportion_ = chance(0.8) ? 1 : uniform(0.25, 2);
    is_mixed_ = chance(0.25);
    is_printed_ = chance(0.25);
    face_print_ = static_cast<FacePrint>(whole(0, 5));
    surface_ = whole(0, 4);
    is_capped_ = chance(0.06);
    body_ = plastic(chance(0.6) ? Rgb{0.02F, 0.02F, 0.02F} : any_color_at_all());
    if (chance(0.35)) {
      few_ = whole(1, 3);
      for (ColorName& name : picked_) {
        name = static_cast<ColorName>(whole(0, static_cast<int>(vision::kColorNames) - 1));
      }
    }
    if (chance(0.04)) return;
    const double room =
        static_cast<double>(settings_.width) * settings_.height / (4 * edge_px_ * edge_px_);
    const int most = std::clamp(static_cast<int>(room), 1, settings_.cubes_most);
    const int count = chance(0.5) ? whole(1, std::min(8, most)) : whole(1, most);
    if (chance(0.1)) return in_rows(count);
    for (int i = 0; i < count; ++i) {
      Vec3 at;
      bool free = false;
      for (int tries = 0; tries < 12 && !free; ++tries) {
        at = somewhere(0);
        free = is_free(at, 0.75 * edge_);
      }
      if (!free) continue;
      const double turn = uniform(0, kPi / 2);
      taken_.push_back({at, 0.72 * edge_});
      if (chance(0.03)) {  // one that an arm lifts
        at.z = uniform(0.3, 4) * edge_;
        put_block(at, turn);
        continue;
      }
      double high = put_block(at, turn);
      if (chance(0.15)) {  // a tower
        for (int n = whole(1, 3); n > 0; --n) {
          high += put_block(at + Vec3{uniform(-0.1, 0.1) * edge_, uniform(-0.1, 0.1) * edge_, high},
                            turn + uniform(-0.3, 0.3));
        }
      } else if (chance(0.25)) {  // neighbours that touch it, or nearly
        const Rotation R = rotation_z(turn);
        for (int n = whole(1, 3); n > 0; --n) {
          const double gap = chance(0.5) ? 0.001 : uniform(0.001, 0.01);
          const Vec3 next = at + R * Vec3{edge_ * 1.03 + gap, uniform(-0.2, 0.2) * edge_, 0};
          if (!is_free(next + 0.3 * (next - at), 0.3 * edge_)) break;
          put_block(next, turn);
          taken_.push_back({next, 0.72 * edge_});
          at = next;
        }
      }
    }
  }

  void in_rows(int count) {
    const double step = edge_ * uniform(1.05, 2.5);
    const double turn = uniform(0, kPi);
    const int across = std::max(1, static_cast<int>(std::sqrt(count)));
    for (int i = 0; i < count; ++i) {
      const Vec3 at =
          rotation_z(turn) * Vec3{(i % across - 0.5 * (across - 1)) * step,
                                  (static_cast<double>(i / across) - 0.5 * (across - 1)) * step, 0};
      put_block(at, turn + uniform(-0.1, 0.1));
      taken_.push_back({at, 0.72 * edge_});
    }
  }

  /// Something on the table that is no block with a square top.
  void place_other() {
    const double size = kEdge * uniform(0.5, 2);
    const Vec3 at = somewhere(0);
    if (!is_free(at, size)) return;
    const double turn = uniform(0, kPi);
    Material material = plastic(any_color_at_all());
    if (chance(0.2)) print_on(material, writing(random_), 2 * size);
    if (chance(0.1)) print_on(material, collage(random_), 2 * size);
    if (chance(0.1)) print_on(material, screw(random_, uniform(0.1, 0.35)), 1.2 * size);
    double reach = size;
    switch (whole(0, 7)) {
      case 0:
      case 1: {  // a brick
        const double high = size * uniform(0.15, 0.5);
        const double narrow = uniform(0.15, 0.62);
        add_other(OtherKind::kLong, box({size, size * narrow, high}, 0.03 * size),
                  upright(at.x, at.y, high, turn), material);
        break;
      }
      case 2: {  // a disc or a can
        const double half = size * uniform(0.1, 0.8);
        add_other(OtherKind::kRound, Cylinder{0.6 * size, half}, upright(at.x, at.y, half, 0),
                  material);
        break;
      }
      case 3: {  // a roll, lying
        const double radius = size * uniform(0.2, 0.6);
        const Rotation R = rotation_z(turn) * rotation_y(kPi / 2);
        add_other(OtherKind::kRound, Cylinder{radius, size}, {R, {at.x, at.y, radius}}, material);
        break;
      }
      case 4: {
        const double radius = size * uniform(0.3, 0.7);
        add_other(OtherKind::kRound, Ball{radius}, {Rotation{}, {at.x, at.y, radius}}, material);
        break;
      }
      case 5: {  // three, five, six or eight sides
        const std::array<int, 4> sides{3, 5, 6, 8};
        const double half = size * uniform(0.1, 0.5);
        add_other(
            OtherKind::kManySided,
            prism(sides[static_cast<std::size_t>(whole(0, 3))], 0.7 * size, half, 0.03 * size),
            upright(at.x, at.y, half, turn), material);
        break;
      }
      case 6: {  // a bar or a strip across the table
        const double half = size * uniform(2, 8);
        const double high = size * uniform(0.02, 0.3);
        add_other(OtherKind::kLong, box({half, size * uniform(0.1, 0.5), high}),
                  upright(at.x, at.y, high, turn), material);
        break;
      }
      default: {  // a box, much larger
        reach = kEdge * uniform(1.6, 4);
        const double high = reach * uniform(0.1, 0.5);
        add_other(OtherKind::kLarge, box({reach, reach * uniform(0.4, 0.9), high}, 0.002),
                  upright(at.x, at.y, high, turn), material);
      }
    }
    taken_.push_back({at, reach});
  }

  /// Flat fields and outlines of tape, where a program sorts cubes to. Cubes may stand on them.
  void lay_zones() {
    const double half = kEdge * uniform(0.6, 3);
    const double turn = chance(0.5) ? 0 : uniform(0, kPi);
    const double thick = half * uniform(0.03, 0.15);
    const bool outlined = chance(0.5);
    for (int n = whole(1, 5); n > 0; --n) {
      const Vec3 at = somewhere(0);
      Material material = plastic(any_color_at_all());
      material.gloss *= 0.3F;
      const double high = uniform(0.00005, 0.0002);
      if (!outlined) {
        add_other(OtherKind::kFlat, box({half, half, high}), upright(at.x, at.y, high, turn),
                  material);
        continue;
      }
      for (const auto& [x, y] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const Vec3 p = at + half * (rotation_z(turn) * Vec3{x * 1.0, y * 1.0, 0});
        add(box({x == 0 ? half : thick, y == 0 ? half : thick, high}),
            upright(p.x, p.y, high, turn), material);
      }
    }
  }

  /// A tray or a bin with walls.
  void place_tray() {
    const double half = kEdge * uniform(1.2, 4);
    const Vec3 at = somewhere(0, 0);
    if (!is_free(at, half)) return;
    const double turn = uniform(0, kPi);
    const Material material = plastic(any_color_at_all());
    const double wall = kEdge * uniform(0.03, 0.15);
    const double high = kEdge * uniform(0.2, 2);
    add_other(OtherKind::kLarge, box({half, half, 0.001}), upright(at.x, at.y, 0.001, turn),
              material);
    for (const auto& [x, y] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const Vec3 p = at + half * (rotation_z(turn) * Vec3{x * 1.0, y * 1.0, 0});
      add(box({x == 0 ? half : wall, y == 0 ? half : wall, high / 2}),
          upright(p.x, p.y, high / 2, turn), material);
    }
    taken_.push_back({at, 1.5 * half});
  }

  /// A wall behind the table, and things of any size and color around it.
  void furnish_room() {
    const double aside = std::atan2(out_.X_WC.p.y, out_.X_WC.p.x) + kPi + uniform(-0.5, 0.5);
    const double far = reach_ * uniform(1.2, 4);
    Material wall = plastic(any_color_at_all());
    if (chance(0.7)) print_on(wall, collage(random_), uniform(1, 4) * reach_);
    add(box({0.01, 6 * reach_, 6 * reach_}),
        upright((far + reach_) * std::cos(aside), (far + reach_) * std::sin(aside), 0, aside),
        wall);
    for (int n = whole(2, 14); n > 0; --n) {
      const double direction = aside + uniform(-1.4, 1.4);
      const double out = reach_ * uniform(0.8, 2.5);
      const Vec3 half{reach_ * uniform(0.03, 0.4), reach_ * uniform(0.03, 0.4),
                      reach_ * uniform(0.03, 0.6)};
      const Vec3 at{out * std::cos(direction), out * std::sin(direction), half.z};
      Material material = plastic(any_color_at_all());
      if (chance(0.4)) print_on(material, collage(random_), uniform(0.3, 2) * reach_);
      if (chance(0.6)) {
        add_other(OtherKind::kLarge, box(half, 0.002), upright(at.x, at.y, at.z, uniform(0, kPi)),
                  material);
      } else if (chance(0.6)) {
        add_other(OtherKind::kRound, Cylinder{half.x, half.z}, upright(at.x, at.y, at.z, 0),
                  material);
      } else {
        add_other(OtherKind::kRound, Ball{half.x}, upright(at.x, at.y, half.x, 0), material);
      }
      taken_.push_back({at, std::max(half.x, half.y)});
    }
  }

  void rod(const Vec3& from, const Vec3& to, double radius, const Material& material) {
    if (material.print.picture && radius > 0.4 * kEdge) {
      add(box({radius, radius, norm(to - from) / 2}, 0.1 * radius), along(from, to), material);
      return;
    }
    add_rod(out_.scene, from, to, radius, material);
  }

  /// An arm of a robot, or one of a person, from outside of the picture to above the table.
  void reach_in(bool robot) {
    const double aside = uniform(0, 2 * kPi);
    Material skin = plastic(robot ? any_color() : one_of(skin_swatches()));
    const Material other = plastic(any_color());
    if (robot && chance(0.6))
      print_on(skin, chance(0.5) ? writing(random_) : clouds(random_, 0.2), 0.06);
    const double thick = (robot ? uniform(0.3, 1) : 0.7) * kEdge;
    Vec3 at{1.6 * reach_ * std::cos(aside), 1.6 * reach_ * std::sin(aside), uniform(0, 4) * kEdge};
    const Vec3 target = somewhere(kEdge * uniform(0.3, 3), 0.1);
    const int joints = robot ? whole(2, 4) : 2;
    for (int i = 1; i <= joints; ++i) {
      const double share = static_cast<double>(i) / joints;
      Vec3 next = at + 1.0 / (joints - i + 1) * (target - at);
      next.z += (1 - share) * uniform(0, 5) * kEdge;
      rod(at, next, thick * uniform(0.6, 1), chance(0.6) ? skin : other);
      if (robot && chance(0.7)) {
        const double half = thick * uniform(0.7, 1.4);
        add(box({half, half * uniform(0.4, 1), half * uniform(0.4, 1)}, 0.001),
            {rotation_z(uniform(0, kPi)) * rotation_x(uniform(-0.4, 0.4)), next}, other);
        if (chance(0.5)) {
          add(Cylinder{half * 0.5, half * 1.3}, {Rotation{}, next}, plastic(any_color()));
        }
      }
      at = next;
    }
    const int fingers = robot ? 2 : 4;
    const Vec3 along = normalized(target - Vec3{std::cos(aside), std::sin(aside), 0.2});
    const Vec3 across = normalized(cross(Vec3{0, 0, 1}, along));
    for (int i = 0; i < fingers; ++i) {
      const Vec3 root = at + (i - 0.5 * (fingers - 1)) * (robot ? 0.9 : 0.5) * kEdge * across;
      rod(root, root + kEdge * uniform(0.6, 1.6) * (along + Vec3{0, 0, uniform(-0.8, 0)}),
          (robot ? 0.15 : 0.24) * kEdge, robot ? other : skin);
    }
  }

  void lay_cable() {
    const Material material = plastic(any_color());
    const double radius = uniform(0.001, 0.003);
    Vec3 at = somewhere(radius, -0.1);
    double turn = uniform(0, 2 * kPi);
    for (int i = whole(4, 14); i > 0; --i) {
      turn += uniform(-0.6, 0.6);
      const Vec3 next = at + 0.04 * Vec3{std::cos(turn), std::sin(turn), 0};
      rod(at, next, radius, material);
      at = next;
    }
  }

  void set_sensor() {
    Sensor& sensor = out_.sensor;
    // Auto exposure and balance come from the view; these are their errors.
    sensor.exposure = std::exp(uniform(-0.75, 0.4));
    sensor.blur = chance(0.85) ? uniform(0.35, 1.3) : uniform(1.3, 2.2);
    sensor.noise = uniform(0.001, 0.012);
    sensor.grain = uniform(0.002, 0.03);
    sensor.vignette = uniform(0, 0.45);
    Rgb light = out_.scene.above;
    for (const Lamp& lamp : out_.scene.lamps) {
      light = light + static_cast<float>(1 / dot(lamp.p_W, lamp.p_W)) * lamp.power;
    }
    const double drift = uniform(0.45, 1);  // of the lamps' tint, that the camera takes away
    const auto gain = [&](float v) {
      return static_cast<float>(std::pow(light.g / v, drift) * uniform(0.93, 1.07));
    };
    sensor.balance = {gain(light.r), 1, gain(light.b)};
    sensor.saturation = uniform(0.6, 1.6);
    sensor.contrast = uniform(-0.3, 1);
  }

  SplitMix64 random_;
  const TableSettings& settings_;
  TableScene out_;
  double edge_px_ = 40;
  double reach_ = 0.3;
  double edge_ = kEdge;
  int style_ = 0;
  double bevel_ = 0;
  double chamfer_ = 0;  ///< of an edge, off the upright edges
  int studs_ = 0;       ///< a side, of bricks that hold together
  double proportion_ = 1;
  bool is_mixed_ = false;    ///< blocks of several sizes
  bool is_printed_ = false;  ///< with letters, tags, pips or scratches on all faces
  FacePrint face_print_ = FacePrint::kLetter;
  int surface_ = 4;         ///< 0: dull, 1: shiny, else: any plastic
  bool is_capped_ = false;  ///< a plate in the block's color on a body in another one
  Material body_;
  int few_ = 0;  ///< colors of the blocks; 0: all
  std::array<ColorName, 3> picked_{};
  std::vector<Taken> taken_;
};

}  // namespace

TableScene random_table(std::uint64_t seed, const TableSettings& settings) {
  return Maker(seed, settings).make();
}

void measure_tops(TableScene& table, const View& view) {
  std::vector<PlacedCube> shown;
  const auto X_CW = table.X_WC.inverse();
  for (PlacedCube& cube : table.cubes) {
    const Solid& solid = table.scene.solids[cube.solid];
    const auto& half = std::get<Polyhedron>(solid.form).faces;
    bool all = true;
    constexpr std::array<std::array<double, 2>, 4> kCorners{{{1, 1}, {1, -1}, {-1, -1}, {-1, 1}}};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 p_S{kCorners[i][0] * half[0].distance, kCorners[i][1] * half[2].distance,
                     half[4].distance};
      const auto p = table.camera.project(X_CW * (solid.X_WS * p_S));
      all = all && p.has_value();
      if (p) cube.top[i] = *p;
    }
    if (!all) continue;
    const double area = vision::area_of(cube.top);
    const auto bounds = [&](double Pixel::* axis) {
      return std::ranges::minmax(cube.top, {}, [axis](Pixel p) { return p.*axis; });
    };
    const auto [left, right] = bounds(&Pixel::x);
    const auto [top, bottom] = bounds(&Pixel::y);
    double seen = 0;
    for (int y = std::max(0, static_cast<int>(top.y)); y < std::min<double>(view.height, bottom.y);
         ++y) {
      for (int x = std::max(0, static_cast<int>(left.x)); x < std::min<double>(view.width, right.x);
           ++x) {
        const auto i = static_cast<std::size_t>(y * view.width + x);
        if (view.solids[i] == cube.solid && view.upward[i] &&
            vision::is_inside(cube.top, {x + 0.5, y + 0.5})) {
          seen += 1;
        }
      }
    }
    cube.seen = area > 0 ? seen / area : 0;
    if (cube.seen > 0) shown.push_back(cube);
  }
  table.cubes = std::move(shown);

  struct Sum {
    Pixel places;
    double count = 0;
  };
  std::vector<Sum> sums(table.scene.solids.size());
  for (std::size_t i = 0; i < view.solids.size(); ++i) {
    if (view.solids[i] == kNoSolid || !view.upward[i]) continue;
    const auto width = static_cast<std::size_t>(view.width);
    Sum& sum = sums[view.solids[i]];
    sum.places = sum.places +
                 Pixel{static_cast<double>(i % width) + 0.5, static_cast<double>(i / width) + 0.5};
    ++sum.count;
  }
  for (PlacedOther& other : table.others) {
    const Sum& sum = sums[other.solid];
    if (sum.count > 0) other.middle = 1 / sum.count * sum.places;
    other.size = std::sqrt(sum.count);
  }
  std::erase_if(table.others, [](const PlacedOther& other) { return other.size < 6; });
}

double exposure_for(const View& view, double mean) {
  double sum = 0;
  for (const Rgb& light : view.light) {
    sum += std::min(2.0F, 0.3F * light.r + 0.59F * light.g + 0.11F * light.b);
  }
  return mean * static_cast<double>(view.light.size()) / std::max(1e-6, sum);
}

}  // namespace sinew::render
