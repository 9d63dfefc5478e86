#include "sinew/render/view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/render/tracer.h"

namespace sinew::render {
namespace {

float brightest(Rgb light) {
  return std::max({light.r, light.g, light.b});
}

/// Whether two neighbours have so different colours that more rays are worth it.
bool differ(Rgb a, Rgb b) {
  const float apart = std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
  return apart > 0.12F * (brightest(a) + brightest(b)) + 0.01F;
}

class Eye {
 public:
  Eye(const Scene& scene, const vision::CameraModel& camera,
      const Pose<frame::World, frame::Camera>& X_WC)
      : tracer_(scene), camera_(camera), X_WC_(X_WC) {}

  struct Seen {
    Shade shade;
    std::uint16_t solid = kNoSolid;
    std::uint16_t face = 0;
    bool up = false;

    bool is_same_face(const Seen& other) const {
      return solid == other.solid && face == other.face;
    }
  };
  Seen look(vision::Pixel p, SplitMix64& random) const {
    const Ray ray{X_WC_.p, X_WC_.R * camera_.direction(p)};
    const auto hit = tracer_.nearest(ray);
    if (!hit) return {{{}, {}, tracer_.light_of_room(ray.toward)}};
    constexpr double kUp = 0.7;
    return {tracer_.shade(ray, *hit, random), static_cast<std::uint16_t>(hit->solid),
            static_cast<std::uint16_t>(hit->face), hit->normal_W.z > kUp};
  }

 private:
  Tracer tracer_;
  const vision::CameraModel& camera_;
  const Pose<frame::World, frame::Camera>& X_WC_;
};

double bell(SplitMix64& random) {
  double sum = -2;
  for (int i = 0; i < 4; ++i) sum += random.uniform(0, 1);
  return sum * std::sqrt(3.0);
}

/// Each value is the mean around it, with weights of a bell.
void blur(std::vector<Rgb>& light, int width, int height, double sigma) {
  const int reach = static_cast<int>(std::ceil(2.5 * sigma));
  if (reach < 1) return;
  std::vector<float> weights;
  float sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    weights.push_back(static_cast<float>(std::exp(-k * k / (2 * sigma * sigma))));
    sum += weights.back();
  }
  const auto pass = [&](int dx, int dy) {
    const std::vector<Rgb> from = light;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        Rgb mean;
        for (int k = -reach; k <= reach; ++k) {
          const int u = std::clamp(x + k * dx, 0, width - 1);
          const int v = std::clamp(y + k * dy, 0, height - 1);
          mean = mean + weights[static_cast<std::size_t>(k + reach)] / sum *
                            from[static_cast<std::size_t>(v * width + u)];
        }
        light[static_cast<std::size_t>(y * width + x)] = mean;
      }
    }
  };
  pass(1, 0);
  pass(0, 1);
}

std::uint8_t byte_of(double linear, double contrast) {
  const double v = std::clamp(linear, 0.0, 1.0);
  double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
  s += contrast * (s * s * (3 - 2 * s) - s);
  return static_cast<std::uint8_t>(std::lround(255 * s));
}

}  // namespace

View view_of(const Scene& scene, const vision::CameraModel& camera,
             const Pose<frame::World, frame::Camera>& X_WC, std::uint64_t seed) {
  const int width = camera.width;
  const int height = camera.height;
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  View view{width, height, std::vector<Rgb>(count), std::vector<std::uint16_t>(count),
            std::vector<bool>(count)};
  const Eye eye(scene, camera, X_WC);
  SplitMix64 random(seed);
  std::vector<Eye::Seen> seen(count);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(y * width + x);
      seen[i] = eye.look({x + 0.5, y + 0.5}, random);
      view.solids[i] = seen[i].solid;
      view.upward[i] = seen[i].up;
    }
  }
  const auto around = [&](int x, int y, int reach, const auto& visit) {
    for (int v = std::max(0, y - reach); v <= std::min(height - 1, y + reach); ++v) {
      for (int u = std::max(0, x - reach); u <= std::min(width - 1, x + reach); ++u) {
        visit(seen[static_cast<std::size_t>(v * width + u)]);
      }
    }
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(y * width + x);
      const Eye::Seen& here = seen[i];
      bool edge = false;
      around(x, y, 1, [&](const Eye::Seen& other) {
        edge = edge || !here.is_same_face(other) || differ(here.shade.color, other.shade.color);
      });
      Rgb sum;
      float weight = 0;
      if (edge) {
        constexpr int kFine = 3;
        for (int k = 0; k < kFine * kFine; ++k, ++weight) {
          const vision::Pixel p{x + (k % kFine + random.uniform(0, 1)) / kFine,
                                y + (k / kFine + random.uniform(0, 1)) / kFine};
          sum = sum + eye.look(p, random).shade.light();
        }
        view.light[i] = 1 / weight * sum;
        continue;
      }
      // Light on a face changes slowly: the mean of a few rays nearby has less noise than one.
      around(x, y, 3, [&](const Eye::Seen& other) {
        if (!here.is_same_face(other)) return;
        sum = sum + other.shade.arrives;
        ++weight;
      });
      view.light[i] = 1 / weight * sum * here.shade.color + here.shade.mirrored;
    }
  }
  return view;
}

Pose<frame::World, frame::Camera> looking_at(const Vec3& eye, const Vec3& target) {
  const Vec3 z = normalized(target - eye);
  const Vec3 up = std::abs(z.z) > 0.999 ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  const Vec3 x = normalized(cross(z, up));
  return {{x, cross(z, x), z}, eye};
}

vision::Picture taken(const View& view, const Sensor& sensor, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<Rgb> light = view.light;
  blur(light, view.width, view.height, sensor.blur);
  vision::Picture picture = vision::black_picture(view.width, view.height);
  const double corner = std::hypot(view.width, view.height) / 2;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const double out = std::hypot(x - view.width / 2.0, y - view.height / 2.0) / corner;
      const double share = sensor.exposure * (1 - sensor.vignette * out * out);
      const Rgb here = light[static_cast<std::size_t>(y * view.width + x)];
      std::array<double, 3> v{here.r * share, here.g * share, here.b * share};
      const std::array<double, 3> gains{sensor.balance.r, sensor.balance.g, sensor.balance.b};
      for (std::size_t c = 0; c < 3; ++c) {
        const double sigma = sensor.noise + sensor.grain * std::sqrt(std::max(0.0, v[c]));
        v[c] = std::min(1.0, v[c] + sigma * bell(random)) * gains[c];
      }
      const double grey = 0.3 * v[0] + 0.59 * v[1] + 0.11 * v[2];
      for (std::size_t c = 0; c < 3; ++c) {
        picture.at(x, y)[c] = byte_of(grey + sensor.saturation * (v[c] - grey), sensor.contrast);
      }
    }
  }
  return picture;
}

View rolling_shutter(std::span<const View> views, double exposure) {
  View mixed = views[views.size() / 2];
  const auto last = static_cast<double>(views.size());
  for (int y = 0; y < mixed.height; ++y) {
    const double begin = (1 - exposure) * y / mixed.height * last;
    const auto from = static_cast<std::size_t>(begin);
    const auto to = std::clamp(static_cast<std::size_t>(std::ceil(begin + exposure * last)),
                               from + 1, views.size());
    for (int x = 0; x < mixed.width; ++x) {
      const auto i = static_cast<std::size_t>(y * mixed.width + x);
      Rgb sum;
      for (std::size_t k = from; k < to; ++k) sum = sum + views[k].light[i];
      mixed.light[i] = 1 / static_cast<float>(to - from) * sum;
    }
  }
  return mixed;
}

}  // namespace sinew::render
