#pragma once

#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// What has to be said of an object to somebody who knows how it was: its fields that differ,
/// whole; null for those that are gone. Empty where nothing differs.
Json partial_update(const Json& before, const Json& now);

/// `known` with an update of it.
void apply_update(Json& known, const Json& update);

}  // namespace sinew::server
