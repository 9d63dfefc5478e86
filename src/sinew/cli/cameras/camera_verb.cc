#include "sinew/cli/cameras/camera_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "sinew/calibration/board_views.h"
#include "sinew/cli/cameras/camera_hand_eye.h"
#include "sinew/cli/cameras/camera_touch.h"
#include "sinew/cli/output/pixel_json.h"
#include "sinew/cli/output/table.h"
#include "sinew/config/camera_file.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/runtime/cameras/read_picture.h"
#include "sinew/vision/tag_board.h"
#include "sinew/vision/tags.h"

namespace sinew::cli {

Outcome wrong_paper(const CameraRequest& request) {
  return bad_input("--paper: '" + printable(request.paper) + "' is none of a4, a3, letter");
}

namespace {

Outcome print_board(const CameraRequest& request) {
  const auto board = request.action == "sheet" ? vision::table_sheet(request.paper)
                                               : vision::calibration_board(request.paper);
  if (!board) return wrong_paper(request);
  if (request.form != "svg" && request.form != "pdf") {
    return bad_input("--form: '" + printable(request.form) + "' is neither svg nor pdf");
  }
  if (!request.images.empty()) {
    return bad_input("camera " + request.action + " takes no images; " +
                     printable(request.images[0]) + " is one. Redirect its output: sinew camera " +
                     request.action + " > " + request.action + "." + request.form);
  }
  Outcome outcome;
  outcome.text = request.form == "svg" ? svg_of(*board) : pdf_of(*board);
  outcome.json = {{"paper", board->paper},
                  {"family", name(board->family)},
                  {"first", board->first},
                  {"columns", board->columns},
                  {"rows", board->rows},
                  {"tag_mm", 1e3 * board->tag},
                  {"pitch_mm", 1e3 * board->pitch},
                  {request.form, outcome.text}};
  return outcome;
}

Outcome find_tags(const CameraRequest& request) {
  if (request.images.empty()) {
    return bad_input("camera tags: an image is missing; sinew camera tags table.jpg");
  }
  vision::TagFinder finder({vision::TagFamily::k36h11, vision::TagFamily::kStandard41h12});
  Outcome outcome;
  Json images = Json::array();
  for (const std::string& path : request.images) {
    const auto picture = runtime::read_picture(path);
    if (!picture) {
      outcome.exit = ExitCode::kCouldNot;
      outcome.complaint += (outcome.complaint.empty() ? "" : "\n") + picture.error();
      images.push_back({{"image", path}, {"error", {{"sentence", picture.error()}}}});
      continue;
    }
    const auto tags = finder.find(*picture);
    outcome.text += fmt::format("  {}: {} x {} px, {} {}\n", path, picture->width, picture->height,
                                tags.size(), tags.size() == 1 ? "tag" : "tags");
    Table table({"family", "tag", "center, px", "side, px", "margin"});
    table.left(0);
    Json list = Json::array();
    for (const vision::SeenTag& tag : tags) {
      const vision::Pixel center = middle_of(tag.corners);
      table.add({std::string(name(tag.family)), fmt::format("{}", tag.id),
                 fmt::format("{:.1f}, {:.1f}", center.x, center.y),
                 fmt::format("{:.1f}", length(tag.corners[1] - tag.corners[0])),
                 fmt::format("{:.0f}", tag.margin)});
      Json corners = Json::array();
      for (const vision::Pixel& corner : tag.corners) corners.push_back(pixel_json(corner));
      list.push_back({{"family", name(tag.family)},
                      {"id", tag.id},
                      {"corners_px", corners},
                      {"margin", tag.margin}});
    }
    if (!tags.empty()) outcome.text += table.text();
    images.push_back(
        {{"image", path}, {"width", picture->width}, {"height", picture->height}, {"tags", list}});
  }
  outcome.json = images.size() == 1 ? std::move(images[0]) : Json{{"images", std::move(images)}};
  return outcome;
}

using calibration::BoardViews;

/// Images as views of the board and of the sheet; nearly the same and blurred ones are left out.
struct ReadViews {
  BoardViews views;
  std::vector<std::string> paths;  ///< by the view's number - 1
  std::string left_out;            ///< a line each

  std::expected<void, Outcome> read(const std::string& path, bool is_sheet) {
    const auto picture = runtime::read_picture(path);
    if (!picture) return std::unexpected(could_not(picture.error()));
    const auto view = is_sheet ? views.lay(*picture) : views.add(*picture);
    if (view) {
      paths.push_back(path);
      return {};
    }
    const std::string why = path + ": " + view.error().sentence;
    if (is_sheet || !view.error().is_spare()) return std::unexpected(could_not(why));
    left_out += "  left out: " + why + "\n";
    return {};
  }
};

std::string views_text(const ReadViews& read, const std::vector<double>& residuals) {
  Table table({"view", "tags", "residual, px", "image"});
  table.left(3);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const calibration::TakenView& view = read.views.views()[i];
    table.add({fmt::format("{}", view.number), fmt::format("{}", view.tags),
               fmt::format("{:.2f}", residuals[i]), read.paths[view.number - 1]});
  }
  return table.text();
}

std::string calibration_text(const calibration::TableCalibration& result) {
  const auto& [camera, intrinsics, coverage, table] = result;
  const vision::CameraModel& model = camera.model;
  const auto& sigma = intrinsics.sigma;
  std::string text =
      fmt::format("  {} x {} px, {} views, {} points left out\n", model.width, model.height,
                  intrinsics.X_CB.size(), intrinsics.wrong_points.size());
  text +=
      fmt::format("  focal length  {:.1f}, {:.1f} px (+- {:.1f})\n", model.fx, model.fy, sigma[0]);
  text += fmt::format("  center        {:.1f}, {:.1f} px (+- {:.1f})\n", model.center.x,
                      model.center.y, sigma[2]);
  text += fmt::format("  lens          k1 {:.4f}, k2 {:.4f}, p1 {:.5f}, p2 {:.5f}, k3 {:.4f}\n",
                      model.lens[0], model.lens[1], model.lens[2], model.lens[3], model.lens[4]);
  text += fmt::format("  reprojection  {:.2f} px rms, {:.2f} px at 95 %\n", intrinsics.rms,
                      intrinsics.error_95);
  const Vec3 p = camera.X_WC.p;
  text +=
      fmt::format("  over the table at {:.1f}, {:.1f}, {:.1f} mm from the middle of the sheet\n",
                  to_mm(p.x), to_mm(p.y), to_mm(p.z));
  text += fmt::format("  error at the table: {:.2f} mm (95 %, of views held back)\n",
                      to_mm(camera.accuracy));
  if (table.ambiguous()) {
    text +=
        "  warning: two poses explain the image of the table. Look at it more from above, or "
        "from nearer.\n";
  }
  if (const auto advice = what_to_add(coverage)) text += "  better: " + *advice + "\n";
  return text;
}

Outcome calibration_outcome(const CameraRequest& request, const ReadViews& read,
                            const calibration::ViewsResult& result) {
  const vision::TableCamera& camera = result.camera->camera;
  Outcome outcome;
  outcome.text = read.left_out + views_text(read, result.residuals) +
                 calibration_text(*result.camera) + "  " + *request.out + "\n";
  const vision::CameraModel& model = camera.model;
  Json views = Json::array();
  for (std::size_t i = 0; i < result.residuals.size(); ++i) {
    const calibration::TakenView& view = read.views.views()[i];
    views.push_back({{"image", read.paths[view.number - 1]},
                     {"tags", view.tags},
                     {"residual_px", result.residuals[i]}});
  }
  outcome.json = {{"camera", request.name},
                  {"file", *request.out},
                  {"width", model.width},
                  {"height", model.height},
                  {"fx_px", model.fx},
                  {"fy_px", model.fy},
                  {"center_px", {model.center.x, model.center.y}},
                  {"lens", model.lens},
                  {"views", views.size()},
                  {"view_list", views},
                  {"reprojection_px", result.rms},
                  {"table_error_mm", to_mm(camera.accuracy)}};
  if (result.better) outcome.json["advice"] = *result.better;
  return outcome;
}

Outcome calibrate(const CameraRequest& request) {
  auto views = BoardViews::of(request.paper);
  if (!views) return wrong_paper(request);
  if (!request.table || !request.out) {
    return bad_input(
        "camera calibrate needs images of the board, and --table IMAGE of the sheet that lies on "
        "the table, and --out FILE: sinew camera calibrate board*.jpg --table table.jpg --out "
        "camera.toml");
  }
  if (request.name.empty() || request.name.size() > 40 || request.name != printable(request.name) ||
      request.name.find_first_of("\"\\") != std::string::npos) {
    return bad_input("--name: must be 1 to 40 letters, digits, blanks or signs, without \" and \\");
  }
  ReadViews read{std::move(*views), {}, {}};
  for (const std::string& path : request.images) {
    if (auto took = read.read(path, false); !took) return took.error();
  }
  if (auto took = read.read(*request.table, true); !took) return took.error();
  if (const std::size_t count = read.views.views().size(); count < BoardViews::kViewsLeast) {
    return could_not(read.left_out + sentence(calibration::CalibrationError{
                                         .fault = calibration::CalibrationFault::kTooFewViews,
                                         .measured = static_cast<double>(count),
                                         .limit = BoardViews::kViewsLeast}));
  }
  calibration::ViewsResult result = read.views.result();
  if (!result.camera) {
    const std::string where =
        result.trouble_view != 0 ? read.paths[result.trouble_view - 1] + ": " : "";
    return could_not(where + sentence(*result.trouble));
  }
  result.camera->camera.name = request.name;
  const auto written = io::replace_file(*request.out, camera_text(result.camera->camera));
  if (!written) return could_not("--out: " + written.error().sentence);
  return calibration_outcome(request, read, result);
}

}  // namespace

void add_camera(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<CameraRequest>();
  CameraRequest& request = *own;
  CLI::App& verb = *add_verb(app, call, "camera",
                             "boards to print, tags in images, and where cameras and tables are",
                             "sinew camera board --paper a4 > board.svg");
  verb.add_option("ACTION", request.action,
                  "board: a calibration board to print; sheet: tags and crosses that mark the "
                  "table; tags: the tags in images; calibrate: lens and pose of a camera; touch: "
                  "pose of the sheet, from crosses that the tool touched; hand-eye: pose of a "
                  "camera on the arm or beside it")
      ->required();
  verb.add_option("IMAGE", request.images,
                  "tags: any; calibrate: the board at 5 or more angles; hand-eye: the target, each "
                  "image named as the taught point of its joints; JPEG or PNG files");
  verb.add_option("--paper", request.paper, "of board and sheet: a4 (default), a3 or letter");
  verb.add_option("--form", request.form, "board, sheet: svg (default) or pdf, on stdout");
  verb.add_option("--table", request.table, "calibrate: image of the sheet on the table");
  verb.add_option("--out", request.out, "calibrate, hand-eye: file to write (TOML)");
  verb.add_option("--name", request.name, "calibrate: of the camera (default \"camera\")");
  verb.add_option("--robot", request.robot,
                  "touch, hand-eye: id or .toml file; with --cell the robot's name there");
  verb.add_option("--cell", request.cell,
                  "touch, hand-eye: file of the cell that the [[camera]] lines are for");
  verb.add_option_function<std::string>(
      "--points",
      [&request](const std::string& file) {
        request.points = file;
        request.points_given = true;
      },
      "touch, hand-eye: file of sinew teach (default points.toml); points named cross1 to cross5 "
      "or tag580 to tag583 are touched marks");
  verb.add_option("--mark", request.marks,
                  "touch, hand-eye: POINT=MARK, for a point with another name; MARK may be X,Y in "
                  "mm from the middle of the sheet. May be repeated")
      ->allow_extra_args(false);
  verb.add_option("--touch", request.touches,
                  "touch, hand-eye: MARK=JOINTS in deg, without a taught point. May be repeated")
      ->allow_extra_args(false);
  verb.add_option("--gripper-mm", request.gripper_mm,
                  "touch, hand-eye: width between the jaws while they touch (default 0)");
  verb.add_option("--pin-mm", request.pin_mm,
                  "touch, hand-eye: how far a pin in the jaws stands out of them: tools keep 5 mm "
                  "clear of tables (default 0)");
  verb.add_option("--limit-mm", request.limit_mm,
                  "touch: largest rms of the residuals, mm (default 5)");
  verb.add_option(
      "--camera", request.camera,
      "hand-eye: file of sinew camera calibrate; touch: its file, which gets the place of "
      "the sheet (with --cell)");
  verb.add_option("--mount", request.mount,
                  "hand-eye: arm (camera on the arm, target fixed) or table (camera fixed, target "
                  "on the arm)");
  verb.add_option("--target", request.target,
                  "hand-eye: board (default), sheet, or a tag as FAMILY:ID:SIDE, for instance "
                  "36h11:7:30mm");
  verb.add_option("--zeros-deg", request.zeros_deg,
                  "hand-eye: standard deviation of the joints' zeros, which are estimated too, deg "
                  "(default 0: zeros are exact)");
  verb.callback([&call, own] { call.verb = [own] { return camera(*own); }; });
}

Outcome camera(const CameraRequest& request) {
  if (request.action == "board" || request.action == "sheet") return print_board(request);
  if (request.action == "tags") return find_tags(request);
  if (request.action == "calibrate") return calibrate(request);
  if (request.action == "touch") return camera_touch(request);
  if (request.action == "hand-eye") return camera_hand_eye(request);
  return bad_input("camera " + printable(request.action) +
                   ": the actions are board, sheet, tags, calibrate, touch and hand-eye");
}

}  // namespace sinew::cli
