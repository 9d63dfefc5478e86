#include "sinew/runtime/records/record_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "sinew/core/base64.h"
#include "sinew/core/units.h"

namespace sinew::runtime {
namespace {

using Json = nlohmann::ordered_json;

/// Visits all messages of a schema in the order of their times. @param visit  (channel's topic,
/// s since the first message of the record, message) to whether it is one
template <class Visit>
bool visit_all(const McapContent& content, std::string_view schema, const Visit& visit) {
  std::vector<const McapMessage*> found;
  std::uint64_t begin = ~std::uint64_t{0};
  for (const McapMessage& message : content.messages) {
    begin = std::min(begin, message.time);
    const auto channel = content.channels.find(message.channel);
    if (channel == content.channels.end()) continue;
    const auto named = content.schemas.find(channel->second.schema);
    if (named != content.schemas.end() && named->second.name == schema) found.push_back(&message);
  }
  std::ranges::stable_sort(found, {}, &McapMessage::time);
  return std::ranges::all_of(found, [&](const McapMessage* message) {
    const Json json = Json::parse(message->data, nullptr, false);
    return json.is_object() && visit(content.channels.at(message->channel).topic,
                                     seconds_between(begin, message->time), json);
  });
}

/// For a file's name. Topics of a file from elsewhere may hold anything.
std::string plain(std::string text) {
  for (char& c : text) {
    const bool fine = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!fine) c = '-';
  }
  return text.substr(0, 40);
}

std::string text_at(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::string number_at(const Json& json, const char* key, double factor) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number()) return {};
  return fmt::format("{:.6g}", factor * found->get<double>());
}

/// A field of a CSV file; sentences have commas.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + "\"";
}

}  // namespace

std::expected<std::vector<RecordedPicture>, std::string> record_pictures(
    const McapContent& content) {
  std::vector<RecordedPicture> pictures;
  const bool fine = visit_all(
      content, "foxglove.CompressedImage",
      [&](const std::string& topic, double time, const Json& json) {
        auto jpeg = from_base64(text_at(json, "data"));
        if (!jpeg || text_at(json, "format") != "jpeg") return false;
        const std::string camera = plain(topic.substr(topic.rfind('/') + 1));
        pictures.push_back({fmt::format("{:04}_{}_{:.2f}s.jpg", pictures.size() + 1, camera, time),
                            std::move(*jpeg)});
        return true;
      });
  if (!fine) return std::unexpected("a picture in it is none that Sinew writes");
  return pictures;
}

std::expected<std::string, std::string> decisions_csv(const McapContent& content) {
  std::string csv = "time_s,line,kind,grasp,color,x_mm,y_mm,z_mm,yaw_deg,why\n";
  const bool fine =
      visit_all(content, "sinew.Decision", [&](const std::string&, double time, const Json& json) {
        const Json cube = json.value("cube", Json::object());
        const Json error = json.value("error", Json::object());
        if (!cube.is_object() || !error.is_object()) return false;
        csv +=
            fmt::format("{:.3f},{},{},{},{},{},{},{},{},{}\n", time, number_at(json, "line", 1),
                        quoted(text_at(json, "kind")), number_at(json, "grasp", 1),
                        quoted(text_at(cube, "color")), number_at(cube, "x_m", to_mm(1)),
                        number_at(cube, "y_m", to_mm(1)), number_at(cube, "z_m", to_mm(1)),
                        number_at(cube, "yaw_rad", to_deg(1)), quoted(text_at(error, "sentence")));
        return true;
      });
  if (!fine) return std::unexpected("a decision in it is none that Sinew writes");
  return csv;
}

}  // namespace sinew::runtime
