#include <algorithm>

#include "sinew/server/api/api.h"
#include "sinew/server/json/partial_update.h"
#include "sinew/server/json/robot_json.h"

namespace sinew::server {
namespace {

constexpr std::string_view kRobotPrefix = "robot/";
constexpr std::string_view kJobPrefix = "job/";

}  // namespace

/// "cell", and of each robot "robot/NAME" and "job/NAME".
std::vector<std::string> Api::object_names() const {
  std::vector<std::string> names{"cell"};
  for (const CellRobot& robot : cell_.cell().robots) {
    names.push_back(std::string(kRobotPrefix) + robot.name);
    names.push_back(std::string(kJobPrefix) + robot.name);
  }
  return names;
}

std::optional<Json> Api::object(std::string_view name) {
  if (name == "cell") return std::get<Json>(describe());
  const bool job = name.starts_with(kJobPrefix);
  if (!job && !name.starts_with(kRobotPrefix)) return std::nullopt;
  const auto robot = cell_.find(name.substr(job ? kJobPrefix.size() : kRobotPrefix.size()));
  if (!robot) return std::nullopt;
  if (job) return job_status(*robot);
  Json state = status(*robot);
  state.erase("job");
  return state;
}

std::expected<Json, RpcError> Api::objects(const Json& names) {
  Json all = Json::object();
  for (const Json& one : names) {
    const std::string& name = one.get_ref<const std::string&>();
    auto state = object(name);
    if (!state) {
      std::string known;
      for (const std::string& other : object_names()) known += (known.empty() ? "" : ", ") + other;
      return std::unexpected(invalid("no object of this cell has that name; there are " + known));
    }
    all[name] = std::move(*state);
  }
  return all;
}

Api::Answer Api::query(const Call& call) {
  const auto named = call.request.params.find("objects");
  auto all = objects(named != call.request.params.end() ? *named : Json(object_names()));
  if (!all) return all.error();
  return Json{{"objects", std::move(*all)}};
}

Api::Answer Api::subscribe(const Call& call) {
  const auto interval = message_interval(call);
  if (!interval) return interval.error();
  auto all = objects(call.request.params["objects"]);
  if (!all) return all.error();
  call.session.subscription = {.interval = *interval,
                               .next = call.now + *interval,
                               .known = *all,
                               .baskets = cell_.baskets().revision()};
  return Json{{"objects", std::move(*all)}};
}

/// What has changed since it was last told; whoever reads slowly is told less often, and misses
/// nothing.
void Api::tell_objects(Session& session, Instant now) {
  Subscription& subscription = session.subscription;
  if (subscription.known.empty() || subscription.interval == Duration{}) return;
  if (now < subscription.next) return;
  subscription.next = next_due(subscription.next, subscription.interval, now);
  Json updates = Json::object();
  for (auto& [name, known] : subscription.known.items()) {
    if (name == "cell" && subscription.baskets == cell_.baskets().revision()) continue;
    const auto state = object(name);
    if (!state) continue;
    Json update = partial_update(known, *state);
    // That time passes is no news by itself.
    const bool news = !update.empty() && !(update.size() == 1 && update.contains("at_s"));
    if (!news) continue;
    known = *state;
    updates[name] = std::move(update);
  }
  subscription.baskets = cell_.baskets().revision();
  if (!updates.empty()) put(session, notification_text("objects", {{"objects", updates}}));
}

}  // namespace sinew::server
