#include "sinew/cli/detect_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "sinew/cli/table.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/vision/cube_detection.h"
#include "sinew/vision/detection_picture.h"
#include "sinew/vision/picture_file.h"

namespace sinew::cli {
namespace {

using vision::Detection;
using vision::Picture;
using vision::Pixel;

constexpr std::size_t kFileMax = std::size_t{256} << 20U;  // a PNG of all pixels that are read

/// "red, orange, .."
std::string all_colors() {
  std::string all;
  for (std::size_t i = 0; i < vision::kColorNames; ++i) {
    all += (i == 0 ? "" : ", ") + std::string(name(static_cast<vision::ColorName>(i)));
  }
  return all;
}

std::expected<vision::DetectionSettings, Outcome> settings_of(const DetectRequest& request) {
  vision::DetectionSettings settings;
  for (const std::string& text : request.colors) {
    const auto color = vision::color_named(text);
    if (!color) {
      return std::unexpected(
          bad_input("--colors: '" + printable(text) + "' is none of " + all_colors()));
    }
    settings.colors.push_back(*color);
  }
  return settings;
}

std::expected<Picture, std::string> read_picture(const std::string& path) {
  const auto file = io::read_file(path, kFileMax);
  if (!file) return std::unexpected(file.error().sentence);
  auto picture =
      vision::decode_picture({reinterpret_cast<const std::uint8_t*>(file->data()), file->size()});
  if (!picture) return std::unexpected(path + ": " + picture.error());
  return picture;
}

/// px, to a tenth.
Json pixel_json(Pixel p) {
  return {std::round(10 * p.x) / 10, std::round(10 * p.y) / 10};
}

Json detection_json(const std::string& path, const Picture& picture, const Detection& detection) {
  Json json{{"image", path},
            {"width", picture.width},
            {"height", picture.height},
            {"cubes", Json::array()},
            {"refused", Json::array()}};
  for (const vision::SeenCube& cube : detection.cubes) {
    Json corners = Json::array();
    for (const Pixel& corner : cube.top) corners.push_back(pixel_json(corner));
    json["cubes"].push_back({{"color", name(cube.color)},
                             {"center_px", pixel_json(cube.center)},
                             {"yaw_deg", std::round(10 * to_deg(cube.yaw)) / 10},
                             {"size_px", std::round(10 * cube.size) / 10},
                             {"confidence", std::round(100 * cube.confidence) / 100},
                             {"top_px", corners}});
  }
  for (const vision::RefusedShape& shape : detection.refused) {
    json["refused"].push_back(
        {{"why", shape.why}, {"center_px", pixel_json(middle_of(shape.outline))}});
  }
  return json;
}

std::string place_text(Pixel p) {
  return fmt::format("{:.0f}, {:.0f}", p.x, p.y);
}

std::string detection_text(const std::string& path, const Picture& picture,
                           const Detection& detection) {
  std::string text =
      fmt::format("  {}: {} x {} px, {} {}\n", path, picture.width, picture.height,
                  detection.cubes.size(), detection.cubes.size() == 1 ? "cube" : "cubes");
  std::size_t number = 0;
  if (!detection.cubes.empty()) {
    Table table({"#", "color", "middle, px", "edge, px", "yaw, deg", "confidence"});
    table.left(1);
    for (const vision::SeenCube& cube : detection.cubes) {
      table.add({fmt::format("{}", ++number), std::string(name(cube.color)),
                 place_text(cube.center), fmt::format("{:.0f}", cube.size),
                 fmt::format("{:.0f}", to_deg(cube.yaw)), fmt::format("{:.2f}", cube.confidence)});
    }
    text += table.text();
  }
  for (const vision::RefusedShape& shape : detection.refused) {
    text += fmt::format("  {}: no cube at {}: {}\n", ++number, place_text(middle_of(shape.outline)),
                        shape.why);
  }
  return text;
}

}  // namespace

void declare_options(CLI::App& verb, DetectRequest& request) {
  verb.add_option("IMAGE", request.images, "JPEG or PNG files: a table from above")->required();
  verb.add_option("--colors", request.colors, "these only, comma between: " + all_colors())
      ->delimiter(',');
  verb.add_option("--debug", request.debug,
                  "PNG file: what was seen in green, what was refused in magenta, with numbers");
}

Outcome detect(const DetectRequest& request) {
  const auto settings = settings_of(request);
  if (!settings) return settings.error();
  if (request.debug && request.images.size() > 1) {
    return bad_input("--debug: shows one image; name one");
  }
  if (request.debug && io::same_file(*request.debug, request.images[0])) {
    return bad_input("--debug: " + *request.debug + " is the image itself; choose another name");
  }
  Outcome outcome;
  Json images = Json::array();
  for (const std::string& path : request.images) {
    const auto picture = read_picture(path);
    if (!picture) {
      outcome.exit = ExitCode::kCouldNot;
      outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + picture.error();
      images.push_back({{"image", path}, {"error", {{"sentence", picture.error()}}}});
      continue;
    }
    const Detection detection = vision::detect_cubes(*picture, *settings);
    images.push_back(detection_json(path, *picture, detection));
    outcome.text += detection_text(path, *picture, detection);
    if (!request.debug) continue;
    const auto png = vision::encode_png(vision::detection_picture(*picture, detection));
    const auto written = io::replace_file(
        *request.debug, std::string(reinterpret_cast<const char*>(png.data()), png.size()));
    if (!written) return could_not("--debug: " + written.error().sentence);
    outcome.text += "  " + *request.debug + "\n";
  }
  outcome.json = images.size() == 1 ? std::move(images[0]) : Json{{"images", std::move(images)}};
  return outcome;
}

}  // namespace sinew::cli
