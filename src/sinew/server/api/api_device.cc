#include "sinew/server/api/api.h"
#include "sinew/server/json/device_json.h"

namespace sinew::server {
namespace {

constexpr std::uint64_t kFramesUsual = 500;
constexpr std::uint64_t kFramesMax = 2000;
constexpr Duration kForgotten = std::chrono::seconds(10);

}  // namespace

/// What the device has told last; asks it nothing.
Json Api::device_status(std::size_t robot) const {
  const runtime::Station& station = cell_.station(robot);
  const runtime::StationView view = station.view();
  Json json{{"robot", station.name()}, {"port", station.port_name()}};
  json.update(device_json(view.facts, station.robot(), view.at));
  return json;
}

/// In a thread of its own: thousands of messages take some milliseconds.
Api::Answer Api::read_wire(const Call& call) {
  const std::uint64_t limit = call.request.whole("limit", kFramesUsual);
  if (limit < 1 || limit > kFramesMax) return invalid("limit has to be 1 to 2000");
  wires_read_ = call.now;
  return Errand{wires_, [this, robot = *call.robot, since = call.request.whole("since", 0), limit] {
                  return wire_text(robot, since, limit);
                }};
}

/// Each message is decoded and written once, whoever asks for it.
std::string Api::wire_text(std::size_t robot, std::uint64_t since, std::uint64_t limit) {
  auto& monitor = monitors_[robot];
  const runtime::Station& station = cell_.station(robot);
  if (!monitor) {
    monitor = std::make_unique<runtime::WireMonitor>(station.wire(), station.robot().device);
  }
  const runtime::StationView view = station.view();
  const auto read = monitor->read(view.facts, since, limit);
  std::string text = R"({"frames":[)";
  for (runtime::WireMonitor::Frame* frame : read.frames) {
    if (frame->text.empty()) {
      frame->text = text_of(frame_json(*frame));
      frame->message = {};
    }
    if (frame != read.frames.front()) text += ',';
    text += frame->text;
  }
  const Json rest{
      {"last", read.last}, {"lost", read.lost}, {"at_s", to_seconds(view.at.time_since_epoch())}};
  text += "]," + text_of(rest).substr(1);
  return text;
}

/// What nobody looks at any more keeps no memory.
void Api::forget_wires(Instant now) {
  if (!wires_read_ || now - *wires_read_ < kForgotten) return;
  const auto forget = [this] {
    for (auto& monitor : monitors_) monitor.reset();
    return std::string();
  };
  if (!wires_.ask({0, nullptr, false}, forget)) return;
  ++asked_;
  wires_read_.reset();
}

}  // namespace sinew::server
