#include "sinew/render/tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>

#include "sinew/core/units.h"

namespace sinew::render {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();
/// m, that rays start off a surface.
constexpr double kOff = 1e-6;
/// m, how far the room's light is looked for.
constexpr double kRoom = 1.5;

struct Crossing {
  double distance = kEndless;
  int face = 0;
};

Crossing enter(const Polyhedron& form, const Vec3& from, const Vec3& toward) {
  Crossing in{-kEndless, 0};
  double out = kEndless;
  for (std::size_t i = 0; i < form.faces.size(); ++i) {
    const Polyhedron::Face& face = form.faces[i];
    const double speed = dot(face.normal, toward);
    const double gap = face.distance - dot(face.normal, from);
    if (speed == 0) {
      if (gap < 0) return {};
      continue;
    }
    const double t = gap / speed;
    if (speed > 0) {
      out = std::min(out, t);
    } else if (t > in.distance) {
      in = {t, static_cast<int>(i)};
    }
    if (in.distance > out) return {};
  }
  return in.distance > kOff ? in : Crossing{};
}

/// Near an edge the normal leans to the next face.
Vec3 normal_of(const Polyhedron& form, const Vec3& p, int at) {
  Vec3 normal = form.faces[static_cast<std::size_t>(at)].normal;
  if (form.bevel <= 0) return normal;
  for (std::size_t i = 0; i < form.faces.size(); ++i) {
    if (static_cast<int>(i) == at) continue;
    const double gap = form.faces[i].distance - dot(form.faces[i].normal, p);
    if (gap < form.bevel) normal = normal + (1 - gap / form.bevel) * form.faces[i].normal;
  }
  return normalized(normal);
}

Crossing enter(const Cylinder& form, const Vec3& from, const Vec3& toward) {
  Crossing best;
  const double a = toward.x * toward.x + toward.y * toward.y;
  const double b = from.x * toward.x + from.y * toward.y;
  const double c = from.x * from.x + from.y * from.y - form.radius * form.radius;
  const double root = b * b - a * c;
  if (root < 0) return best;
  if (a > 0) {
    const double t = (-b - std::sqrt(root)) / a;
    const double z = from.z + t * toward.z;
    if (t > kOff && std::abs(z) <= form.half) best = {t, 0};
  }
  if (toward.z != 0) {
    const double end = toward.z > 0 ? -form.half : form.half;
    const double t = (end - from.z) / toward.z;
    const double x = from.x + t * toward.x;
    const double y = from.y + t * toward.y;
    if (t > kOff && t < best.distance && x * x + y * y <= form.radius * form.radius) {
      best = {t, end > 0 ? 1 : 2};
    }
  }
  return best;
}

Vec3 normal_of(const Cylinder& form, const Vec3& p, int at) {
  if (at > 0) return {0, 0, at == 1 ? 1.0 : -1.0};
  return {p.x / form.radius, p.y / form.radius, 0};
}

Crossing enter(const Ball& form, const Vec3& from, const Vec3& toward) {
  const double b = dot(from, toward);
  const double root = b * b - dot(from, from) + form.radius * form.radius;
  if (root < 0) return {};
  const double t = -b - std::sqrt(root);
  if (t <= kOff) return {};
  return {t, 0};
}

Vec3 normal_of(const Ball& form, const Vec3& p, int /*at*/) {
  return (1 / form.radius) * p;
}

Crossing enter(const Ground& /*form*/, const Vec3& from, const Vec3& toward) {
  if (toward.z >= 0 || from.z <= 0) return {};
  return {-from.z / toward.z, 0};
}

Vec3 normal_of(const Ground& /*form*/, const Vec3& /*p*/, int /*at*/) {
  return {0, 0, 1};
}

/// A ray in the frame of a solid.
struct Inside {
  Inside(const Solid& solid, const Ray& ray)
      : from(transposed_times(solid.X_WS.R, ray.from - solid.X_WS.p)),
        toward(transposed_times(solid.X_WS.R, ray.toward)) {}

  Crossing enter_into(const Solid& solid) const {
    return std::visit([&](const auto& form) { return enter(form, from, toward); }, solid.form);
  }
  Vec3 at(double distance) const { return from + distance * toward; }

  Vec3 from;    // m
  Vec3 toward;  // of length 1
};

/// Half of the box around a solid, along the axes of W.
Vec3 half_around(const Solid& solid) {
  return std::visit(
      [&](const auto& form) -> Vec3 {
        using Form = std::decay_t<decltype(form)>;
        if constexpr (std::is_same_v<Form, Cylinder>) {
          const auto along = [&](double c) {
            return std::abs(c) * form.half + std::sqrt(std::max(0.0, 1 - c * c)) * form.radius;
          };
          const Vec3 axis = solid.X_WS.R.z;
          return {along(axis.x), along(axis.y), along(axis.z)};
        } else if constexpr (std::is_same_v<Form, Ground>) {
          return {kEndless, kEndless, kEndless};
        } else {
          return {form.radius, form.radius, form.radius};
        }
      },
      solid.form);
}

Vec3 least(const Vec3& a, const Vec3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vec3 most(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
double Vec3::* longest_axis(const Vec3& size) {
  if (size.x >= size.y && size.x >= size.z) return &Vec3::x;
  return size.y >= size.z ? &Vec3::y : &Vec3::z;
}

double fifth_power(double x) {
  return x * x * x * x * x;
}

/// Two directions across a normal.
std::pair<Vec3, Vec3> across(const Vec3& normal) {
  const Vec3 other = std::abs(normal.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 u = normalized(cross(other, normal));
  return {u, cross(normal, u)};
}

Vec3 in_ball(SplitMix64& random) {
  while (true) {
    const Vec3 p{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (dot(p, p) <= 1) return p;
  }
}

/// More of it the more the direction is that of the normal.
Vec3 around(const Vec3& normal, SplitMix64& random) {
  const double turn = random.uniform(0, 2 * kPi);
  const double r2 = random.uniform(0, 1);
  const double r = std::sqrt(r2);
  const auto [u, v] = across(normal);
  return r * std::cos(turn) * u + r * std::sin(turn) * v + std::sqrt(1 - r2) * normal;
}

}  // namespace

Rgb color_at(const Solid& solid, const Vec3& p_S) {
  const Material& material = solid.material;
  if (!material.print.picture) return material.color;
  // Seen along the axis that the surface faces most; on a table from above.
  double u = p_S.x;
  double v = p_S.y;
  if (const auto* form = std::get_if<Polyhedron>(&solid.form)) {
    const auto nearest = std::ranges::min_element(
        form->faces, {}, [&](const auto& face) { return face.distance - dot(face.normal, p_S); });
    if (std::abs(nearest->normal.z) < 0.7) {
      u = std::abs(nearest->normal.x) > 0.7 ? p_S.y : p_S.x;
      v = p_S.z;
    }
  } else if (std::holds_alternative<Cylinder>(solid.form)) {
    const double radius = std::get<Cylinder>(solid.form).radius;
    if (p_S.x * p_S.x + p_S.y * p_S.y > 0.998 * radius * radius) {
      u = radius * std::atan2(p_S.y, p_S.x);
      v = p_S.z;
    }
  }
  const vision::Picture& picture = *material.print.picture;
  double x = u / material.print.width + 0.5;
  double y = 0.5 - v / material.print.height;
  if (material.print.single && (x < 0 || x >= 1 || y < 0 || y >= 1)) return material.color;
  x = (x - std::floor(x)) * picture.width;
  y = (y - std::floor(y)) * picture.height;
  static const std::array<float, 256> linear = [] {
    std::array<float, 256> all{};
    for (unsigned i = 0; i < all.size(); ++i) all[i] = from_srgb(i).b;
    return all;
  }();
  const std::uint8_t* rgb = picture.at(std::min(static_cast<int>(x), picture.width - 1),
                                       std::min(static_cast<int>(y), picture.height - 1));
  const Rgb ink{linear[rgb[0]], linear[rgb[1]], linear[rgb[2]]};
  return material.print.single ? ink : ink * material.color;
}

Tracer::Tracer(const Scene& scene) : scene_(scene) {
  for (std::uint32_t i = 0; i < scene.solids.size(); ++i) {
    (std::holds_alternative<Ground>(scene.solids[i].form) ? endless_ : order_).push_back(i);
  }
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
}

void Tracer::build(std::uint32_t begin, std::uint32_t end) {
  const auto middle_of = [&](std::uint32_t i) { return scene_.solids[i].X_WS.p; };
  Vec3 low{kEndless, kEndless, kEndless};
  Vec3 high = -low;
  for (std::uint32_t i = begin; i < end; ++i) {
    const Vec3 half = half_around(scene_.solids[order_[i]]);
    low = least(low, middle_of(order_[i]) - half);
    high = most(high, middle_of(order_[i]) + half);
  }
  const std::size_t node = nodes_.size();
  nodes_.push_back({low, high, begin, end});
  constexpr std::uint32_t kFew = 1;
  if (end - begin <= kFew) return;
  double Vec3::* const axis = longest_axis(high - low);
  const std::uint32_t half = begin + (end - begin) / 2;
  std::nth_element(
      order_.begin() + begin, order_.begin() + half, order_.begin() + end,
      [&](std::uint32_t a, std::uint32_t b) { return middle_of(a).*axis < middle_of(b).*axis; });
  build(begin, half);
  nodes_[node].begin = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].end = 0;
  build(half, end);
}

/// Calls `visit(solid)` for all whose box the ray meets within `reach`, which visits may shorten.
template <class Visit>
void Tracer::visit(const Ray& ray, double& reach, const Visit& visit) const {
  for (const std::uint32_t solid : endless_) visit(solid);
  if (nodes_.empty()) return;
  const Vec3 inverse{1 / ray.toward.x, 1 / ray.toward.y, 1 / ray.toward.z};
  std::array<std::uint32_t, 48> open{};
  std::size_t count = 1;
  while (count > 0 && reach > 0) {
    const std::uint32_t at = open[--count];
    const Node& node = nodes_[at];
    const double x0 = (node.low.x - ray.from.x) * inverse.x;
    const double x1 = (node.high.x - ray.from.x) * inverse.x;
    const double y0 = (node.low.y - ray.from.y) * inverse.y;
    const double y1 = (node.high.y - ray.from.y) * inverse.y;
    const double z0 = (node.low.z - ray.from.z) * inverse.z;
    const double z1 = (node.high.z - ray.from.z) * inverse.z;
    const double in = std::max({std::min(x0, x1), std::min(y0, y1), std::min(z0, z1), 0.0});
    const double out = std::min({std::max(x0, x1), std::max(y0, y1), std::max(z0, z1), reach});
    if (!(in <= out)) continue;
    if (node.end == 0) {
      open[count++] = node.begin;
      open[count++] = at + 1;
      continue;
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i) visit(order_[i]);
  }
}

std::optional<Hit> Tracer::nearest(const Ray& ray, double reach) const {
  Hit best;
  bool found = false;
  visit(ray, reach, [&](std::size_t i) {
    const Crossing at = Inside(scene_.solids[i], ray).enter_into(scene_.solids[i]);
    if (at.distance >= reach) return;
    best.solid = i;
    best.face = at.face;
    reach = at.distance;
    found = true;
  });
  if (!found) return std::nullopt;
  best.distance = reach;
  const Solid& solid = scene_.solids[best.solid];
  best.p_S = Inside(solid, ray).at(reach);
  best.normal_W = solid.X_WS.R *
                  std::visit([&](const auto& form) { return normal_of(form, best.p_S, best.face); },
                             solid.form);
  return best;
}

std::optional<Vec3> Tracer::crossing_of(std::size_t solid, const Ray& ray) const {
  const Solid& body = scene_.solids[solid];
  const Inside inside(body, ray);
  const Crossing at = inside.enter_into(body);
  if (at.distance == kEndless) return std::nullopt;
  return inside.at(at.distance);
}

bool Tracer::is_blocked(const Ray& ray, double reach) const {
  const double all = reach;
  visit(ray, reach, [&](std::size_t i) {
    if (Inside(scene_.solids[i], ray).enter_into(scene_.solids[i]).distance < all) reach = 0;
  });
  return reach == 0;
}

Rgb Tracer::light_of_room(const Vec3& toward) const {
  const auto up = static_cast<float>(std::clamp(0.5 + 2 * toward.z, 0.0, 1.0));
  return up * scene_.above + (1 - up) * scene_.below;
}

Shade Tracer::shade(const Ray& ray, const Hit& hit, SplitMix64& random) const {
  const Solid& solid = scene_.solids[hit.solid];
  const Material& material = solid.material;
  const Vec3 normal = hit.normal_W;
  const Vec3 p = ray.from + hit.distance * ray.toward + kOff * normal;
  const double facing = std::max(0.02, -dot(ray.toward, normal));
  // Mirrors all the more the flatter one looks at it (Schlick, 1994).
  const auto mirror =
      static_cast<float>(material.gloss + (1 - material.gloss) * fifth_power(1 - facing) * 0.5);
  Shade shade{{}, color_at(solid, hit.p_S), {}};
  for (const Lamp& lamp : scene_.lamps) {
    const Vec3 to = lamp.p_W + lamp.radius * in_ball(random) - p;
    const double distance = norm(to);
    const Vec3 toward = (1 / distance) * to;
    const double cosine = dot(toward, normal);
    if (cosine <= 0 || is_blocked({p, toward}, distance)) continue;
    const Rgb arrives = static_cast<float>(cosine / (distance * distance)) * lamp.power;
    shade.arrives = shade.arrives + arrives;
    const double along = dot(normalized(toward - ray.toward), normal);
    const double power = 2 / (material.roughness * material.roughness);
    // Far off the reflection there is nothing left of it: x^n < e^(-n (1 - x)).
    constexpr double kNothing = 14;
    if (power * (1 - along) > kNothing) continue;
    const double lobe = (power + 8) / 8 * std::pow(std::max(0.0, along), power);
    shade.mirrored = shade.mirrored + static_cast<float>(mirror * lobe) * arrives;
  }
  const Ray out{p, around(normal, random)};
  Rgb room = light_of_room(out.toward);
  if (const auto blocker = nearest(out, kRoom)) {
    constexpr float kLit = 0.45F;  // of what the room and the lamps give, on average
    Rgb lit = scene_.above;
    for (const Lamp& lamp : scene_.lamps) {
      const Vec3 to = lamp.p_W - p;
      lit = lit + static_cast<float>(0.5 / dot(to, to)) * lamp.power;
    }
    room = kLit * (color_at(scene_.solids[blocker->solid], blocker->p_S) * lit);
  }
  const Vec3 reflected = ray.toward - 2 * dot(ray.toward, normal) * normal;
  shade.arrives = shade.arrives + room;
  shade.mirrored = shade.mirrored + mirror * light_of_room(reflected);
  return shade;
}

}  // namespace sinew::render
