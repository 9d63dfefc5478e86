#pragma once

#include "sinew/devices/facts_view.h"

namespace sinew {

/// DeviceKind::view; docs/api.md has its fields.
FactsJson bigrobotarm_view(const FactsView& view, const DeviceFacts& facts);

}  // namespace sinew
