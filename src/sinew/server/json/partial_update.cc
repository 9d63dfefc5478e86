#include "sinew/server/json/partial_update.h"

namespace sinew::server {

Json partial_update(const Json& before, const Json& now) {
  Json update = Json::object();
  for (const auto& [key, value] : now.items()) {
    const auto known = before.find(key);
    if (known == before.end() || *known != value) update[key] = value;
  }
  for (const auto& [key, value] : before.items()) {
    if (!now.contains(key)) update[key] = nullptr;
  }
  return update;
}

void apply_update(Json& known, const Json& update) {
  for (const auto& [key, value] : update.items()) {
    if (value.is_null()) {
      known.erase(key);
    } else {
      known[key] = value;
    }
  }
}

}  // namespace sinew::server
