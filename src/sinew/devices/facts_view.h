#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "sinew/core/error.h"
#include "sinew/driver/wire_reader.h"
#include "sinew/model/robot_model.h"

namespace sinew {

using FactsJson = nlohmann::ordered_json;

/// What each kind needs to say what its device has reported last; ages are as of one instant.
class FactsView {
 public:
  using ErrorJson = FactsJson (*)(const Error& error, const RobotModel& model);

  FactsView(const RobotModel& model, Instant now, ErrorJson error_json)
      : model_(model), now_(now), error_json_(error_json) {}

  const RobotModel& model() const { return model_; }
  const std::string& joint(std::size_t j) const { return model_.joints[j].name; }
  FactsJson error(const Error& error) const { return error_json_(error, model_); }
  /// What each view begins with: {"wire", "at_s", "warnings"}.
  FactsJson base() const {
    return {{"wire", model_.device.protocol},
            {"at_s", to_seconds(now_.time_since_epoch())},
            {"warnings", FactsJson::array()}};
  }
  double age(Instant at) const { return std::max(0.0, to_seconds(now_ - at)); }
  /// With its age and its bytes.
  template <class Bytes>
  FactsJson heard(Instant at, const Bytes& bytes) const {
    return {{"age_s", age(at)}, {"bytes", hex(bytes)}};
  }
  template <class Bytes>
  static std::string hex(const Bytes& bytes) {
    return hex_of({bytes.begin(), bytes.end()});
  }

  /// Something that needs attention. @param name  one of docs/api.md
  static void warn(FactsJson& json, std::string_view name, const std::string& joint = {},
                   std::optional<double> age = {}) {
    FactsJson one{{"name", name}};
    if (!joint.empty()) one["joint"] = joint;
    if (age) one["age_s"] = *age;
    json["warnings"].push_back(std::move(one));
  }

 private:
  const RobotModel& model_;
  Instant now_;
  ErrorJson error_json_;
};

}  // namespace sinew
