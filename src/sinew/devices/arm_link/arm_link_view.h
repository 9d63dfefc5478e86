#pragma once

#include "sinew/devices/facts_view.h"

namespace sinew {

/// DeviceKind::view; docs/api.md has its fields.
FactsJson arm_link_view(const FactsView& view, const DeviceFacts& facts);

}  // namespace sinew
