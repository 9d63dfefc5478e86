#include "sinew/cli/cameras/detect_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "sinew/cli/output/pixel_json.h"
#include "sinew/cli/output/table.h"
#include "sinew/config/camera_file.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/runtime/cameras/read_picture.h"
#include "sinew/vision/cube_detection.h"
#include "sinew/vision/detection_picture.h"
#include "sinew/vision/picture_file.h"
#include "sinew/vision/table_camera.h"

namespace sinew::cli {
namespace {

using vision::Detection;
using vision::Picture;
using vision::Pixel;

/// "red, orange, .."
std::expected<vision::DetectionSettings, Outcome> settings_of(const DetectRequest& request) {
  vision::DetectionSettings settings;
  for (const std::string& text : request.colors) {
    const auto color = vision::color_named(text);
    if (!color) {
      return std::unexpected(
          bad_input("--colors: '" + printable(text) + "' is none of " + vision::color_list()));
    }
    settings.colors.push_back(*color);
  }
  return settings;
}

double rounded(double value, double parts) {
  return std::round(parts * value) / parts;
}

/// A calibrated camera where one is named; with the size of the cubes.
std::expected<std::optional<vision::TableCamera>, Outcome> camera_of(const DetectRequest& request) {
  constexpr double kSmallest = 1;
  constexpr double kLargest = 500;  // mm
  if (request.camera && !request.cube_mm) {
    return std::unexpected(
        bad_input("--camera: the size of the cubes is missing, as in --cube-mm 25"));
  }
  if (const auto& mm = request.cube_mm; mm && !(*mm >= kSmallest && *mm <= kLargest)) {
    return std::unexpected(bad_input(
        fmt::format("--cube-mm: {:g} mm is not {:g} to {:g} mm", *mm, kSmallest, kLargest)));
  }
  if (!request.camera) return std::nullopt;
  const auto text = io::read_file(*request.camera, std::size_t{1} << 20U);
  if (!text) return std::unexpected(could_not("--camera: " + text.error().sentence));
  auto camera = read_camera(*text, *request.camera);
  if (!camera) return std::unexpected(complaints_outcome(camera.error()));
  return std::optional(std::move(*camera));
}

Json mm_json(const Vec3& p) {
  return {rounded(to_mm(p.x), 100), rounded(to_mm(p.y), 100), rounded(to_mm(p.z), 100)};
}

/// @param camera  null: none
Json detection_json(const std::string& path, const Picture& picture, const Detection& detection,
                    const vision::TableCamera* camera) {
  Json json{{"image", path},
            {"width", picture.width},
            {"height", picture.height},
            {"cubes", Json::array()},
            {"refused", Json::array()}};
  for (const vision::SeenCube& cube : detection.cubes) {
    Json corners = Json::array();
    for (const Pixel& corner : cube.top) corners.push_back(pixel_json(corner));
    Json one{{"color", name(cube.color)},
             {"center_px", pixel_json(cube.center)},
             {"yaw_deg", rounded(to_deg(cube.yaw), 10)},
             {"size_px", rounded(cube.size, 10)},
             {"confidence", rounded(cube.confidence, 100)},
             {"top_px", corners}};
    if (const auto& at = cube.position) {
      one["center_mm"] = mm_json(at->top_W);
      if (const auto& table = camera->touched) {
        one["center_base_mm"] = mm_json(table->X_BW * at->top_W);
        json["robot"] = table->robot;
      }
      one["yaw_table_deg"] = rounded(to_deg(at->yaw), 10);
      one["edge_mm"] = rounded(to_mm(at->edge), 100);
      one["level"] = at->level;
    }
    json["cubes"].push_back(std::move(one));
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
    std::vector<std::string> head{"#", "color", "middle, px", "edge, px", "yaw, deg", "confidence"};
    const bool placed = detection.cubes.front().position.has_value();
    if (placed) head.insert(head.end(), {"top, mm", "on the table, deg", "level"});
    Table table(head);
    table.left(1);
    for (const vision::SeenCube& cube : detection.cubes) {
      std::vector<std::string> row{fmt::format("{}", ++number),
                                   std::string(name(cube.color)),
                                   place_text(cube.center),
                                   fmt::format("{:.0f}", cube.size),
                                   fmt::format("{:.0f}", to_deg(cube.yaw)),
                                   fmt::format("{:.2f}", cube.confidence)};
      if (const auto& at = cube.position) {
        row.push_back(fmt::format("{:.1f}, {:.1f}, {:.1f}", to_mm(at->top_W.x), to_mm(at->top_W.y),
                                  to_mm(at->top_W.z)));
        row.push_back(fmt::format("{:.0f}", to_deg(at->yaw)));
        row.push_back(fmt::format("{}", at->level));
      }
      table.add(row);
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

void add_detect(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<DetectRequest>();
  DetectRequest& request = *own;
  CLI::App& verb = *add_verb(app, call, "detect", "the coloured cubes in pictures of a table",
                             "sinew detect table.jpg --debug seen.png");
  verb.add_option("IMAGE", request.images, "JPEG or PNG files: a table from above")->required();
  verb.add_option("--colors", request.colors, "these only, comma between: " + vision::color_list())
      ->delimiter(',');
  verb.add_option("--debug", request.debug,
                  "PNG file: what was seen in green, what was refused in magenta, and why");
  verb.add_option("--camera", request.camera,
                  "file of a calibrated camera: positions on the table, mm")
      ->option_text("FILE");
  verb.add_option("--cube-mm", request.cube_mm, "edge of the cubes, with --camera")
      ->option_text("MM");
  verb.callback([&call, own] { call.verb = [own] { return detect(*own); }; });
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
  const auto camera = camera_of(request);
  if (!camera) return camera.error();
  Outcome outcome;
  Json images = Json::array();
  const auto fail = [&](const std::string& path, const std::string& sentence) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + sentence;
    images.push_back({{"image", path}, {"error", {{"sentence", sentence}}}});
  };
  for (const std::string& path : request.images) {
    const auto picture = runtime::read_picture(path);
    if (!picture) {
      fail(path, picture.error());
      continue;
    }
    if (const auto& at = *camera;
        at && (at->model.width != picture->width || at->model.height != picture->height)) {
      fail(path,
           fmt::format("{}: is {} x {} px; {} was calibrated with {} x {} px", path, picture->width,
                       picture->height, *request.camera, at->model.width, at->model.height));
      continue;
    }
    Detection detection = vision::detect_cubes(*picture, *settings);
    if (*camera) vision::place_on_table(detection, *picture, **camera, from_mm(*request.cube_mm));
    images.push_back(detection_json(path, *picture, detection, *camera ? &**camera : nullptr));
    outcome.text += detection_text(path, *picture, detection);
    if (!request.debug) continue;
    const auto png = vision::encode_png(vision::detection_picture(*picture, detection));
    const auto written = io::replace_file(
        *request.debug, std::string(reinterpret_cast<const char*>(png.data()), png.size()));
    if (!written) return could_not("--debug: " + written.error().sentence);
    outcome.text += "  " + *request.debug + "\n";
  }
  if (request.cube_mm && !request.camera) {
    outcome.text += "  positions in mm need a calibrated camera, too: --camera FILE\n";
  }
  outcome.json = images.size() == 1 ? std::move(images[0]) : Json{{"images", std::move(images)}};
  return outcome;
}

}  // namespace sinew::cli
