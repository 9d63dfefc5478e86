#pragma once

#include "sinew/devices/facts_view.h"
#include "sinew/driver/device_facts.h"

namespace sinew {

/// `device.status` of a board that speaks GRBL; docs/api.md.
FactsJson grbl_view(const FactsView& view, const DeviceFacts& facts);

}  // namespace sinew
