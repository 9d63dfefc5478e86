#include "sinew/runtime/records/look_encoder.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "sinew/core/base64.h"
#include "sinew/model/error_sentence.h"
#include "sinew/runtime/records/record_json.h"
#include "sinew/vision/color_names.h"
#include "sinew/vision/picture_file.h"

namespace sinew::runtime {
namespace {

using namespace record;

/// As Foxglove's schemas of these names have it, so that its image view shows them.
/// Source: https://docs.foxglove.dev/docs/visualization/message-schemas
Json image_schema() {
  Json data = text();
  data["contentEncoding"] = "base64";
  return object({{"timestamp", time_schema()},
                 {"frame_id", text()},
                 {"data", std::move(data)},
                 {"format", text()}});
}

Json annotations_schema() {
  const Json point = object({{"x", number()}, {"y", number()}});
  const Json color = object({{"r", number()}, {"g", number()}, {"b", number()}, {"a", number()}});
  const Json points = object({{"timestamp", time_schema()},
                              {"type", whole()},
                              {"points", list(point)},
                              {"outline_color", color},
                              {"thickness", number()}});
  const Json one = object({{"timestamp", time_schema()},
                           {"position", point},
                           {"text", text()},
                           {"font_size", number()},
                           {"text_color", color},
                           {"background_color", color}});
  return object(
      {{"circles", list(object(Json::object()))}, {"points", list(points)}, {"texts", list(one)}});
}

Json decision_schema() {
  return object({{"kind", text()},
                 {"line", whole()},
                 {"grasp", whole()},
                 {"cube", object({{"color", text()},
                                  {"x_m", number()},
                                  {"y_m", number()},
                                  {"z_m", number()},
                                  {"yaw_rad", number()},
                                  {"edge_m", number()}})},
                 {"error", object({{"code", text()}, {"sentence", text()}})}});
}

/// An outline and a text beside it.
void annotate(Json& annotations, std::uint64_t time, const vision::Quad& outline,
              const std::string& words, const Json& color) {
  constexpr int kLineLoop = 2;
  Json points = Json::array();
  vision::Pixel right = outline[0];
  for (const vision::Pixel& p : outline) {
    points.push_back({{"x", p.x}, {"y", p.y}});
    if (p.x > right.x) right = p;
  }
  annotations["points"].push_back({{"timestamp", time_json(time)},
                                   {"type", kLineLoop},
                                   {"points", std::move(points)},
                                   {"outline_color", color},
                                   {"thickness", 2}});
  annotations["texts"].push_back(
      {{"timestamp", time_json(time)},
       {"position", {{"x", right.x}, {"y", right.y}}},
       {"text", words},
       {"font_size", 12},
       {"text_color", color},
       {"background_color", {{"r", 0}, {"g", 0}, {"b", 0}, {"a", 0.6}}}});
}

Json annotations_of(const Camera::Shot& shot, std::uint64_t time) {
  const Json green{{"r", 0.2}, {"g", 1}, {"b", 0.3}, {"a", 1}};
  const Json magenta{{"r", 1}, {"g", 0.2}, {"b", 1}, {"a", 1}};
  Json annotations{{"circles", Json::array()}, {"points", Json::array()}, {"texts", Json::array()}};
  for (const vision::SeenCube& cube : shot.seen.cubes) {
    annotate(annotations, time, cube.top,
             fmt::format("{} {:.2f}", name(cube.color), cube.confidence), green);
  }
  for (const vision::RefusedShape& shape : shot.seen.refused) {
    annotate(annotations, time, shape.outline, shape.why, magenta);
  }
  return annotations;
}

}  // namespace

LookEncoder::Channels LookEncoder::channels_of(McapWriter& writer, const std::string& camera) {
  if (!schemas_) {
    schemas_ = Channels{
        writer.add_schema("foxglove.CompressedImage", "jsonschema", text_of(image_schema())),
        writer.add_schema("foxglove.ImageAnnotations", "jsonschema",
                          text_of(annotations_schema()))};
  }
  const auto [at, is_new] = cameras_.try_emplace(camera);
  if (is_new) {
    const std::string topic = "/camera/" + camera;
    at->second = {writer.add_channel(schemas_->image, topic, "json"),
                  writer.add_channel(schemas_->annotations, topic + "/annotations", "json")};
  }
  return at->second;
}

std::uint64_t LookEncoder::put(McapWriter& writer, std::uint64_t time, const RunPicture& picture) {
  const Camera::Shot& shot = *picture.shot;
  if (shot.picture.width == 0) return 0;
  const Channels channels = channels_of(writer, picture.camera);
  const auto jpeg = vision::encode_jpeg(shot.picture);
  const Json image{{"timestamp", time_json(time)},
                   {"frame_id", "camera/" + picture.camera},
                   {"data", base64({reinterpret_cast<const char*>(jpeg.data()), jpeg.size()})},
                   {"format", "jpeg"}};
  std::uint64_t lost = writer.add_message(channels.image, time, text_of(image)) ? 0 : 1;
  const Json annotations = annotations_of(shot, time);
  lost += writer.add_message(channels.annotations, time, text_of(annotations)) ? 0 : 1;
  return lost;
}

std::uint64_t LookEncoder::put(McapWriter& writer, std::uint64_t time,
                               const RunDecision& decision) {
  if (!decisions_) {
    const auto schema =
        writer.add_schema("sinew.Decision", "jsonschema", text_of(decision_schema()));
    decisions_ = writer.add_channel(schema, "/" + name_ + "/decisions", "json");
  }
  const program::Decision& what = decision.decision;
  Json json{{"kind", name(what.kind)}, {"line", what.line}};
  if (what.grasp > 0) json["grasp"] = what.grasp;
  if (what.cube) {
    const grasping::Cube& cube = *what.cube;
    json["cube"] = {{"color", name(static_cast<vision::ColorName>(cube.color))},
                    {"x_m", cube.p_BO.x},
                    {"y_m", cube.p_BO.y},
                    {"z_m", cube.p_BO.z},
                    {"yaw_rad", cube.yaw},
                    {"edge_m", cube.edge}};
  }
  if (what.why) {
    json["error"] = {{"code", info(what.why->code).name},
                     {"sentence", sentence_of(*what.why, robot_)}};
  }
  return writer.add_message(*decisions_, time, text_of(json)) ? 0 : 1;
}

}  // namespace sinew::runtime
