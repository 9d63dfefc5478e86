#include <algorithm>

#include "sinew/server/api.h"
#include "sinew/server/camera_json.h"

namespace sinew::server {
namespace {

constexpr std::uint64_t kLongestMin = 16;  // px
constexpr std::uint64_t kLongestMax = 4096;
constexpr std::uint64_t kLongestUsual = 640;

}  // namespace

std::expected<std::size_t, RpcError> Api::asked_camera(const Call& call) const {
  const auto& cameras = cell_.cell().cameras;
  const std::string wanted = call.request.text("camera");
  const auto found = std::ranges::find_if(
      cameras, [&](const CellCamera& one) { return wanted.empty() || one.name == wanted; });
  if (found == cameras.end()) {
    std::string names;
    for (const CellCamera& one : cameras) names += (names.empty() ? "" : ", ") + one.name;
    return std::unexpected(
        invalid(names.empty() ? "this cell has no camera; [[camera]] in its file names one"
                              : "no camera of this cell has that name; there are " + names));
  }
  const auto i = static_cast<std::size_t>(found - cameras.begin());
  if (cell_.camera(i) == nullptr) return std::unexpected(invalid(found->name + " was not opened"));
  return i;
}

/// The answer is the newest picture, at once, and the next one taken meanwhile: who wants to see
/// more asks again.
Api::Answer Api::look_through(const Call& call) {
  const auto found = asked_camera(call);
  if (!found) return found.error();
  const std::size_t i = *found;
  const std::uint64_t longest = call.request.whole("longest_px", kLongestUsual);
  if (longest < kLongestMin || longest > kLongestMax) {
    return invalid("longest_px has to be 16 to 4096");
  }
  runtime::Camera* camera = cell_.camera(i);
  camera->refresh();
  const std::uint64_t known = call.request.whole("known", 0);
  return Errand{pictures_, as_task([this, i, camera, known, longest]() -> Keeper::Result {
                  const auto shot = camera->newest();
                  if (!shot) return Json{{"camera", camera->settings().name}, {"number", 0}};
                  return shot_json(cell_, i, *shot, known, static_cast<int>(longest));
                })};
}

}  // namespace sinew::server
