#include "sinew/cli/record_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "sinew/cli/table.h"
#include "sinew/io/file.h"
#include "sinew/runtime/mcap_reader.h"

namespace sinew::cli {
namespace {

constexpr std::size_t kFileMax = std::size_t{1} << 30;

using runtime::McapContent;
using runtime::McapMessage;

double seconds(std::uint64_t from, std::uint64_t to) {
  return to >= from ? static_cast<double>(to - from) * 1e-9
                    : -static_cast<double>(from - to) * 1e-9;
}

/// The last part of a topic: "/learm/joint_states" is about joint_states.
std::string_view kind_of(const McapContent& content, const McapMessage& message) {
  const std::string_view topic = content.channels.at(message.channel).topic;
  return topic.substr(topic.rfind('/') + 1);
}

std::string complaint_of(const std::string& file, const runtime::McapTrouble& trouble) {
  return fmt::format("{}: at byte {}: {}", file, trouble.offset, trouble.sentence);
}

/// A value as a cell of the table: texts of a stranger's file must not break its rows.
std::string cell_text(const Json& value) {
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
      const Json json = Json::parse(message.data, nullptr, false);
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
      rows += fmt::format("{:.6f}{},{},{},{}\n", seconds(*begin_, message.time), *row,
                          of(state_, "state"), of(wire_, "to_device_bytes_s"),
                          of(wire_, "to_host_bytes_s"));
    }
    if (!begin_) return std::unexpected("there are no joint_states in it");
    std::string head = "t_s";
    for (const auto& [joint, key] : columns_) head += "," + cell_text(joint + "_" + key);
    return head + ",state,to_device_bytes_s,to_host_bytes_s\n" + rows;
  }

 private:
  static std::string of(const Json& json, const char* key) {
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

  std::expected<std::string, std::string> joints(const Json& json) {
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
  Json state_ = Json::object();
  Json wire_ = Json::object();
};

Outcome content_outcome(const std::string& file, const McapContent& content) {
  Outcome outcome;
  Table table({"channel", "schema", "messages"});
  table.left(0).left(1);
  Json channels = Json::array();
  std::map<std::uint16_t, std::size_t> counts;
  for (const McapMessage& message : content.messages) ++counts[message.channel];
  for (const auto& [id, channel] : content.channels) {
    const auto schema = content.schemas.find(channel.schema);
    const std::string name = schema != content.schemas.end() ? schema->second.name : "";
    table.add({channel.topic, name, fmt::format("{}", counts[id])});
    channels.push_back({{"topic", channel.topic}, {"schema", name}, {"messages", counts[id]}});
  }
  const auto by_time = [](const McapMessage& message) { return message.time; };
  double duration = 0;
  if (!content.messages.empty()) {
    const auto [first, last] = std::ranges::minmax_element(content.messages, {}, by_time);
    duration = seconds(first->time, last->time);
  }
  outcome.json = {{"file", file},
                  {"library", content.library},
                  {"duration_s", duration},
                  {"channels", channels},
                  {"metadata", content.metadata},
                  {"whole", !content.trouble.has_value()}};
  outcome.text = fmt::format("{}\n  {:.2f} s, written by {}\n", table.text(), duration,
                             content.library.empty() ? "nobody it names" : content.library);
  return outcome;
}

}  // namespace

Outcome show_record(const RecordRequest& request) {
  if (request.csv) {
    if (const auto fine = io::check_place(*request.csv); !fine) {
      return bad_input("--csv: " + fine.error().sentence);
    }
    if (io::same_file(*request.csv, request.file)) {
      return bad_input("--csv: " + *request.csv + " is the record; choose another name");
    }
  }
  const auto text = io::read_file(request.file, kFileMax);
  if (!text) return bad_input(text.error().sentence);
  const McapContent content =
      runtime::read_mcap({reinterpret_cast<const std::uint8_t*>(text->data()), text->size()});
  if (content.trouble && (!content.trouble->cut || content.channels.empty())) {
    return bad_input(complaint_of(request.file, *content.trouble));
  }
  Outcome outcome = content_outcome(request.file, content);
  if (content.trouble) {
    outcome.text += "  note: it was cut off, this is what there is: " +
                    complaint_of(request.file, *content.trouble) + "\n";
    outcome.json["trouble"] = complaint_of(request.file, *content.trouble);
  }
  if (!request.csv) return outcome;
  const auto csv = CsvTable().make(content);
  if (!csv) return bad_input(request.file + ": " + csv.error());
  if (const auto written = io::replace_file(*request.csv, *csv); !written) {
    return could_not("--csv: " + written.error().sentence);
  }
  outcome.text += "  " + *request.csv + "\n";
  outcome.json["csv"] = *request.csv;
  return outcome;
}

}  // namespace sinew::cli
