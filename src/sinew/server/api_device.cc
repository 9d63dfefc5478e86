#include "sinew/server/api.h"
#include "sinew/server/device_json.h"

namespace sinew::server {
namespace {

constexpr std::uint64_t kFramesUsual = 500;
constexpr std::uint64_t kFramesMax = 2000;

}  // namespace

/// What the device has told last; asks it nothing.
Json Api::device_status(std::size_t robot) const {
  const runtime::Station& station = cell_.station(robot);
  const runtime::StationView view = station.view();
  Json json{{"robot", station.name()}, {"port", station.port_name()}};
  json.update(device_json(view.facts, station.robot(), view.at));
  return json;
}

Api::Answer Api::read_wire(const Call& call) {
  const std::uint64_t limit = call.request.whole("limit", kFramesUsual);
  if (limit < 1 || limit > kFramesMax) return invalid("limit has to be 1 to 2000");
  auto& monitor = monitors_[*call.robot];
  const runtime::Station& station = cell_.station(*call.robot);
  if (!monitor) {
    monitor = std::make_unique<runtime::WireMonitor>(station.wire(), station.robot().device);
  }
  const runtime::StationView view = station.view();
  const auto read = monitor->read(view.facts, call.request.whole("since", 0), limit);
  Json frames = Json::array();
  for (const auto* frame : read.frames) frames.push_back(frame_json(*frame));
  return Json{{"frames", std::move(frames)},
              {"last", read.last},
              {"lost", read.lost},
              {"at_s", to_seconds(view.at.time_since_epoch())}};
}

}  // namespace sinew::server
