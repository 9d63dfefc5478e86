#include "sinew/config/read_device.h"

#include <optional>
#include <vector>

#include "sinew/devices/kinds.h"
#include "sinew/devices/table_file.h"

namespace sinew {

void read_device(TableReader& root, RobotModel& model) {
  std::optional<TableReader> reader = root.table("device", Presence::kOptional);
  if (!reader) return;
  model.device = {};
  std::vector<Named<const DeviceKind*>> kinds;
  for (const DeviceKind* kind : device_kinds()) kinds.push_back({kind->table.protocol, kind});
  const DeviceKind* kind = nullptr;
  if (reader->choice("protocol", kinds, kind)) {
    model.device.protocol = kind->table.protocol;
    const bool goes_on =
        !kind->table.capability_in_file || read_capability(*reader, kind->table, model);
    if (goes_on) kind->read(*reader, model);
  } else {
    reader->ignore_rest();
  }
  reader->finish();
}

void check_device(TableReader& root, const RobotModel& model) {
  if (!root.clean()) return;
  const DeviceKind& kind = kind_of(model.device);
  if (kind.check != nullptr) kind.check(root, model);
}

}  // namespace sinew
