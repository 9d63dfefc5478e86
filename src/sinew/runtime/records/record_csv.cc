#include "sinew/runtime/records/record_csv.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace sinew::runtime {
namespace {

/// The last part of a topic: "/learm/joint_states" is about joint_states.
std::string_view kind_of(const McapContent& content, const McapMessage& message) {
  const std::string_view topic = content.channels.at(message.channel).topic;
  return topic.substr(topic.rfind('/') + 1);
}

/// A value as a cell of the table: texts of a stranger's file must not break its rows.
std::string cell_text(const nlohmann::json& value) {
  if (value.is_number_float()) {
    const double number = value.get<double>();
    return std::isfinite(number) ? fmt::format("{:.9g}", number) : std::string();
  }
  if (!value.is_string()) return value.is_primitive() && !value.is_null() ? value.dump() : "";
  const auto& text = value.get_ref<const std::string&>();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// One row for each message of joint_states, with what was last said of state and wire.
class CsvTable {
 public:
  /// @error  a sentence: a message that no record of Sinew has
  std::expected<std::string, std::string> make(const McapContent& content) {
    std::string rows;
    for (const McapMessage& message : content.messages) {
      const std::string_view kind = kind_of(content, message);
      const bool shown = kind == "joint_states" || kind == "state" || kind == "wire";
      if (!shown) continue;
      const nlohmann::json json = nlohmann::json::parse(message.data, nullptr, false);
      if (!json.is_object()) {
        return std::unexpected(fmt::format("message {} of {} is no JSON object", message.sequence,
                                           content.channels.at(message.channel).topic));
      }
      if (kind != "joint_states") {
        (kind == "state" ? state_ : wire_) = json;
        continue;
      }
      if (!begin_) {
        begin_ = message.time;
        learn(content, message.channel);
      }
      const auto row = joints(json);
      if (!row) return std::unexpected(row.error());
      rows += fmt::format("{:.6f}{},{},{},{}\n", seconds_between(*begin_, message.time), *row,
                          of(state_, "state"), of(wire_, "to_device_bytes_s"),
                          of(wire_, "to_host_bytes_s"));
    }
    if (!begin_) return std::unexpected("there are no joint_states in it");
    std::string head = "t_s";
    for (const auto& [joint, key] : columns_) head += "," + cell_text(joint + "_" + key);
    return head + ",state,to_device_bytes_s,to_host_bytes_s\n" + rows;
  }

 private:
  static std::string of(const nlohmann::json& json, const char* key) {
    const auto found = json.find(key);
    return found != json.end() ? cell_text(*found) : std::string();
  }

  /// The channel's schema says which columns there are, in the robot's order.
  void learn(const McapContent& content, std::uint16_t channel) {
    const auto schema = content.schemas.find(content.channels.at(channel).schema);
    if (schema == content.schemas.end()) return;
    using Ordered = nlohmann::ordered_json;
    const Ordered json = Ordered::parse(schema->second.data, nullptr, false);
    const Ordered joints =
        json.is_object()
            ? json.value(Ordered::json_pointer("/properties/joints/properties"), Ordered::object())
            : Ordered::object();
    if (!joints.is_object()) return;
    for (const auto& [name, joint] : joints.items()) {
      if (!joint.is_object() || !joint.contains("properties")) continue;
      for (const auto& [key, type] : joint["properties"].items()) {
        columns_.emplace_back(name, key);
      }
    }
  }

  std::expected<std::string, std::string> joints(const nlohmann::json& json) {
    const auto found = json.find("joints");
    if (found == json.end() || !found->is_object()) {
      return std::unexpected("a message of joint_states has no joints");
    }
    std::string row;
    for (const auto& [name, key] : columns_) {
      const auto joint = found->find(name);
      const bool has = joint != found->end() && joint->is_object() && joint->contains(key);
      row += "," + (has ? cell_text((*joint)[key]) : std::string());
    }
    return row;
  }

  std::optional<std::uint64_t> begin_;
  std::vector<std::pair<std::string, std::string>> columns_;
  nlohmann::json state_ = nlohmann::json::object();
  nlohmann::json wire_ = nlohmann::json::object();
};

}  // namespace

std::expected<std::string, std::string> record_csv(const McapContent& content) {
  return CsvTable().make(content);
}

}  // namespace sinew::runtime
