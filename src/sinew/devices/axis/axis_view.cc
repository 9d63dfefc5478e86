#include "sinew/devices/axis/axis_view.h"

namespace sinew {

void judge_axis(const FactsView& view, FactsJson& json, const FactsJson& axis, bool answers,
                std::size_t i) {
  if (!answers) return FactsView::warn(json, "no_answer", view.joint(i));
  if (axis.contains("fault")) FactsView::warn(json, "axis_fault", view.joint(i));
  if (!axis.contains("flags")) return;
  const FactsJson& flags = axis["flags"];
  if (flags["emergency_stop"]) FactsView::warn(json, "emergency_stop", view.joint(i));
  if (!flags["motor_ok"]) FactsView::warn(json, "motor", view.joint(i));
  if (!flags["sensor_ok"]) FactsView::warn(json, "encoder", view.joint(i));
  if (flags["end_stop"]) FactsView::warn(json, "end_stop", view.joint(i));
  if (!flags["homed"]) FactsView::warn(json, "not_homed", view.joint(i));
}

}  // namespace sinew
