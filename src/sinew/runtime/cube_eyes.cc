#include "sinew/runtime/cube_eyes.h"

#include <cmath>
#include <utility>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"

namespace sinew::runtime {

namespace {

std::optional<Error> size_change(const vision::Picture& picture, const vision::CameraModel& was) {
  const auto changed = [](int now, int before) {
    return Error{ErrorCode::kCameraChanged, -1, 1.0 * now, 1.0 * before};
  };
  if (picture.width != was.width) return changed(picture.width, was.width);
  if (picture.height != was.height) return changed(picture.height, was.height);
  return std::nullopt;
}

}  // namespace

program::Sighting sighting_of(const vision::Detection& seen, const CubeEyes::Place& place) {
  program::Sighting sighting;
  sighting.table_z = place.X_BW.p.z;
  const double turn = fixed_xyz(place.X_BW.R).z;
  for (const vision::SeenCube& cube : seen.cubes) {
    if (!cube.position) continue;
    grasping::Cube one;
    one.p_BO = place.X_BW * (cube.position->top_W - Vec3{0, 0, place.edge / 2});
    one.yaw = std::remainder(cube.position->yaw + turn, kPi / 2);
    one.edge = place.edge;
    one.color = static_cast<int>(cube.color);
    sighting.cubes.push_back(one);
  }
  return sighting;
}

CubeEyes::CubeEyes(const Place& place, Source source)
    : place_(place),
      source_(std::move(source)),
      thread_([this](const std::stop_token& ending) { work(ending); }) {}

CubeEyes::~CubeEyes() = default;

void CubeEyes::look() {
  {
    const std::scoped_lock lock(mutex_);
    ++asked_;
    answer_.reset();
  }
  wanted_.notify_one();
}

std::optional<Expected<program::Sighting>> CubeEyes::seen() {
  const std::scoped_lock lock(mutex_);
  if (answered_ != asked_) return std::nullopt;
  return std::exchange(answer_, std::nullopt);
}

void CubeEyes::work(const std::stop_token& ending) {
  std::unique_lock lock(mutex_);
  while (wanted_.wait(lock, ending, [&] { return answered_ != asked_; })) {
    const std::uint64_t number = asked_;
    lock.unlock();
    auto picture = source_(ending);
    std::optional<Expected<program::Sighting>> answer;
    if (!picture) {
      answer = std::unexpected(picture.error());
    } else if (const auto changed = size_change(*picture, place_.camera.model)) {
      answer = std::unexpected(*changed);
    } else {
      auto seen = vision::detect_cubes(*picture);
      vision::place_on_table(seen, place_.camera, place_.edge);
      answer = sighting_of(seen, place_);
    }
    lock.lock();
    // Where another look was asked for meanwhile this one is forgotten.
    answered_ = number;
    answer_ = std::move(answer);
  }
}

}  // namespace sinew::runtime
