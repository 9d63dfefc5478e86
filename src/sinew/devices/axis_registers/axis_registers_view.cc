#include "sinew/devices/axis_registers/axis_registers_view.h"

#include "sinew/devices/axis/axis_view.h"
#include "sinew/devices/axis/axis_wire_words.h"
#include "sinew/devices/axis_registers/axis_registers_driver_facts.h"
#include "sinew/devices/axis_registers/axis_registers_driver_units.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"

namespace sinew {

FactsJson axis_registers_view(const FactsView& view, const DeviceFacts& all) {
  const auto& facts = all.get<AxisRegistersFacts>();
  using namespace axis_registers;
  const auto& device = view.model().device.settings.get<AxisRegistersDevice>();
  FactsJson json = view.base();
  json["reports_status"] = device.reports_status;
  json["axes"] = FactsJson::array();
  for (std::size_t i = 0; i < facts.axes.size(); ++i) {
    const AxisRegistersFacts::Axis& axis = facts.axes[i];
    FactsJson one{{"joint", view.joint(i)}, {"answers", axis.answers}};
    if (axis.fault) one["fault"] = view.error(*axis.fault);
    one["registers"] = FactsJson::array();
    for (std::size_t k = 0; k < axis.registers.size(); ++k) {
      if (!axis.registers[k]) continue;
      const auto& [value, at] = *axis.registers[k];
      const Register which = kDocumentRegisters[k].name;
      FactsJson row{{"register", name(which)}, {"written", value.written}};
      row.update(view.heard(at, value.data));
      if (which == Register::kMoveAngle) {
        const auto told = read_angle(device.encoding, device.boards[i].zero, value.data);
        if (told) row["position_rad"] = told->q;
      } else if (which == Register::kDiagStatus) {
        if (const auto status = decode_status(value.data)) {
          for (const auto& word : kStatusWords)
            one["flags"][std::string(word.name)] = (*status).*word.flag;
          row["fault_number"] = status->fault;
        }
      } else if (value.data.size() == 1) {
        row["value"] = value.data[0];
      }
      one["registers"].push_back(std::move(row));
    }
    if (!device.reports_status) one.erase("flags");
    judge_axis(view, json, one, axis.answers, i);
    json["axes"].push_back(std::move(one));
  }
  return json;
}

}  // namespace sinew
