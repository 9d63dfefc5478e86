#include "sinew/render/view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/render/tracer.h"
#include "sinew/vision/picture_file.h"
#include "sinew/vision/srgb.h"

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

struct Seen {
  Shade shade;
  std::uint16_t solid = kNoSolid;
  std::uint16_t face = 0;
  bool up = false;

  bool is_same_face(const Seen& other) const { return solid == other.solid && face == other.face; }
};

/// One picture in the making: a ray with its light through the middle of each pixel, then finer
/// rays where neighbours differ. Light on a face changes slowly, so that the mean of a few rays
/// nearby has less noise than one, and finer rays need not follow it again.
class Eye {
 public:
  Eye(const Scene& scene, const vision::CameraModel& camera,
      const Pose<frame::World, frame::Camera>& X_WC, std::uint64_t seed)
      : tracer_(scene), scene_(scene), camera_(camera), from_W_(X_WC.p), random_(seed) {
    for (int y = 0; y <= camera.height; ++y) {
      for (int x = 0; x <= camera.width; ++x) {
        corners_.push_back(X_WC.R * camera.direction({1.0 * x, 1.0 * y}));
      }
    }
    seen_.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) seen_.push_back(look(ray_of(x, y, 0.5, 0.5)));
    }
  }

  const Seen& at(int x, int y) const {
    return seen_[static_cast<std::size_t>(y * camera_.width + x)];
  }

  Rgb light_of(int x, int y) {
    const Seen& here = at(x, y);
    bool edge = false;
    bool mixed = false;
    around(x, y, 1, [&](const Seen& other) {
      edge = edge || !here.is_same_face(other);
      mixed = mixed || differ(here.shade.color, other.shade.color);
    });
    const Rgb arrives = mean_light(here, x, y);
    if (!edge && !mixed) return arrives * here.shade.color + here.shade.mirrored;
    constexpr int kFine = 3;
    Rgb sum;
    for (int k = 0; k < kFine * kFine; ++k) {
      const Ray ray = ray_of(x, y, (k % kFine + random_.uniform(0, 1)) / kFine,
                             (k / kFine + random_.uniform(0, 1)) / kFine);
      sum = sum + (edge ? fine_light(ray, x, y, arrives) : face_light(ray, here, arrives));
    }
    return 1.0F / (kFine * kFine) * sum;
  }

 private:
  /// Through a point of the pixel (x, y), right and down from its corner, 0 to 1. Between the
  /// corners directions are as good as straight.
  Ray ray_of(int x, int y, double right, double down) const {
    const Vec3* above = &corners_[static_cast<std::size_t>(y * (camera_.width + 1) + x)];
    const Vec3* below = above + camera_.width + 1;
    return {from_W_, normalized((1 - down) * ((1 - right) * above[0] + right * above[1]) +
                                down * ((1 - right) * below[0] + right * below[1]))};
  }

  Seen look(const Ray& ray) {
    const auto hit = tracer_.nearest(ray);
    if (!hit) return {{{}, {}, tracer_.light_of_room(ray.toward)}};
    constexpr double kUp = 0.7;
    return {tracer_.shade(ray, *hit, random_), static_cast<std::uint16_t>(hit->solid),
            static_cast<std::uint16_t>(hit->face), hit->normal_W.z > kUp};
  }

  /// Of a ray between pixels that all show the same face, in several colors: one of a solid.
  Rgb face_light(const Ray& ray, const Seen& here, Rgb arrives) const {
    const auto p_S = tracer_.crossing_of(here.solid, ray);
    const Rgb color = p_S ? color_at(scene_.solids[here.solid], *p_S) : here.shade.color;
    return arrives * color + here.shade.mirrored;
  }

  /// Of a ray inside the pixel (x, y). @param here  mean light on what the pixel's middle shows
  Rgb fine_light(const Ray& ray, int x, int y, Rgb here) {
    const auto hit = tracer_.nearest(ray);
    if (!hit) return tracer_.light_of_room(ray.toward);
    const Seen* same = nullptr;
    around(x, y, 1, [&](const Seen& other) {
      if (other.solid == hit->solid && other.face == hit->face && same != &at(x, y)) same = &other;
    });
    // What no pixel's middle shows is followed whole.
    if (same == nullptr) return tracer_.shade(ray, *hit, random_).light();
    const Rgb arrives = same->is_same_face(at(x, y)) ? here : mean_light(*same, x, y);
    return arrives * color_at(scene_.solids[hit->solid], hit->p_S) + same->shade.mirrored;
  }

  Rgb mean_light(const Seen& of, int x, int y) const {
    Rgb sum;
    float count = 0;
    around(x, y, 3, [&](const Seen& other) {
      if (!of.is_same_face(other)) return;
      sum = sum + other.shade.arrives;
      ++count;
    });
    return 1 / count * sum;
  }

  template <class Visit>
  void around(int x, int y, int reach, const Visit& visit) const {
    for (int v = std::max(0, y - reach); v <= std::min(camera_.height - 1, y + reach); ++v) {
      for (int u = std::max(0, x - reach); u <= std::min(camera_.width - 1, x + reach); ++u) {
        visit(at(u, v));
      }
    }
  }

  Tracer tracer_;
  const Scene& scene_;
  const vision::CameraModel& camera_;
  Vec3 from_W_;
  SplitMix64 random_;
  std::vector<Vec3> corners_;  ///< directions through the pixels' corners, row by row, in W
  std::vector<Seen> seen_;     ///< row by row
};

double bell(SplitMix64& random) {
  double sum = -2;
  for (int i = 0; i < 4; ++i) sum += random.uniform(0, 1);
  return sum * std::numbers::sqrt3;
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

/// Bytes of light from 0 to 1 in even steps, finer than a byte's own steps where it is dark.
class Tones {
 public:
  explicit Tones(double contrast) {
    for (std::size_t i = 0; i < bytes_.size(); ++i) {
      const double v = static_cast<double>(i) / kLast;
      double s = vision::srgb_of_light(v);
      s += contrast * (s * s * (3 - 2 * s) - s);
      bytes_[i] = static_cast<std::uint8_t>(std::lround(255 * s));
    }
  }
  std::uint8_t operator()(double linear) const {
    return bytes_[static_cast<std::size_t>(kLast * std::clamp(linear, 0.0, 1.0) + 0.5)];
  }

 private:
  static constexpr std::size_t kLast = 16384;
  std::array<std::uint8_t, kLast + 1> bytes_{};
};

}  // namespace

View view_of(const Scene& scene, const vision::CameraModel& camera,
             const Pose<frame::World, frame::Camera>& X_WC, std::uint64_t seed) {
  const int width = camera.width;
  const int height = camera.height;
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  View view{width, height, std::vector<Rgb>(count), std::vector<std::uint16_t>(count),
            std::vector<bool>(count)};
  Eye eye(scene, camera, X_WC, seed);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(y * width + x);
      view.solids[i] = eye.at(x, y).solid;
      view.upward[i] = eye.at(x, y).up;
      view.light[i] = eye.light_of(x, y);
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
  const Tones tones(sensor.contrast);
  const double middle_x = view.width / 2.0;
  const double middle_y = view.height / 2.0;
  const double corner2 = middle_x * middle_x + middle_y * middle_y;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const double out2 =
          ((x - middle_x) * (x - middle_x) + (y - middle_y) * (y - middle_y)) / corner2;
      const double share = sensor.exposure * (1 - sensor.vignette * out2);
      const Rgb here = light[static_cast<std::size_t>(y * view.width + x)];
      std::array<double, 3> v{here.r * share, here.g * share, here.b * share};
      const std::array<double, 3> gains{sensor.balance.r, sensor.balance.g, sensor.balance.b};
      for (std::size_t c = 0; c < 3; ++c) {
        const double sigma = sensor.noise + sensor.grain * std::sqrt(std::max(0.0, v[c]));
        v[c] = std::min(1.0, v[c] + sigma * bell(random)) * gains[c];
      }
      const double grey = 0.3 * v[0] + 0.59 * v[1] + 0.11 * v[2];
      for (std::size_t c = 0; c < 3; ++c) {
        picture.at(x, y)[c] = tones(grey + sensor.saturation * (v[c] - grey));
      }
    }
  }
  if (sensor.jpeg == 0) return picture;
  auto compressed = vision::decode_picture(vision::encode_jpeg(picture, sensor.jpeg));
  SINEW_ASSERT(compressed);
  return *std::move(compressed);
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
