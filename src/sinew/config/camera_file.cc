#include "sinew/config/camera_file.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "sinew/toml/table_reader.h"
#include "sinew/toml/toml_pose.h"
#include "sinew/vision/tag_board.h"

namespace sinew {
namespace {

constexpr int kFormat = 1;
constexpr std::size_t kIdentityMax = 200;  // bytes
constexpr int kSideMax = 65'536;           // px
constexpr Range kFocal = between(1, 1e6);  // px
constexpr Range kInPicture = between(-1e5, 1e5);
constexpr Range kLens = between(-10, 10);
constexpr std::array<std::string_view, 5> kLensKeys{"k1", "k2", "p1", "p2", "k3"};

/// As a TOML string; what is not plain ASCII as '?'.
std::string quoted(std::string_view words) {
  std::string text = "\"";
  for (const char c : words.substr(0, kIdentityMax / 2)) {
    if (c == '"' || c == '\\') text += '\\';
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  return text + '"';
}

vision::TouchedTable read_touched(TableReader& table) {
  vision::TouchedTable touched;
  table.needs_no_source();
  table.text("robot", 40, touched.robot);
  read_toml_pose(table, touched.X_BW);
  table.quantity("error_*", kLength, between(0, 10), touched.error);
  table.finish();
  return touched;
}

vision::TableCamera read_root(TableReader& root) {
  vision::TableCamera camera;
  root.needs_no_source();
  int format = 0;
  if (root.integer("format", 1, 1'000'000, format) && format != kFormat) {
    root.complain("format", "is " + std::to_string(format) +
                                ": written by another version; "
                                "calibrate again: sinew camera calibrate");
  }
  root.text("name", 40, camera.name);
  root.integer("width", 1, kSideMax, camera.model.width);
  root.integer("height", 1, kSideMax, camera.model.height);
  if (auto lens = root.table("lens")) {
    lens->needs_no_source();
    lens->number("fx", kFocal, camera.model.fx);
    lens->number("fy", kFocal, camera.model.fy);
    lens->number("cx", kInPicture, camera.model.center.x);
    lens->number("cy", kInPicture, camera.model.center.y);
    for (std::size_t i = 0; i < kLensKeys.size(); ++i) {
      lens->number(kLensKeys[i], kLens, camera.model.lens[i]);
    }
    lens->finish();
  }
  if (auto pose = root.table("pose")) {
    pose->needs_no_source();
    read_toml_pose(*pose, camera.X_WC);
    pose->finish();
  }
  if (auto accuracy = root.table("accuracy")) {
    accuracy->needs_no_source();
    accuracy->number("reprojection_px", between(0, 1e4), camera.reprojection);
    accuracy->quantity("table_*", kLength, between(0, 10), camera.accuracy);
    accuracy->finish();
  }
  if (auto table = root.optional().table("table")) camera.touched = read_touched(*table);
  if (root.optional().text("sheet", 10, camera.sheet) && !vision::table_sheet(camera.sheet)) {
    root.complain("sheet", "has to be a4, a3 or letter: the paper of the sheet on its table");
  }
  root.optional().text("identity", kIdentityMax, camera.identity);
  root.finish();
  return camera;
}

}  // namespace

std::expected<vision::TableCamera, std::vector<Complaint>> read_camera(std::string_view toml,
                                                                       std::string_view file_name) {
  return read_toml_file(toml, file_name, read_root);
}

std::string camera_text(const vision::TableCamera& camera) {
  std::string text;
  const auto add = [&](const char* form, auto... values) {
    std::array<char, 200> line{};
    std::snprintf(line.data(), line.size(), form, values...);
    text += line.data();
  };
  const vision::CameraModel& model = camera.model;
  text += "format = " + std::to_string(kFormat) + "\nname = \"" + camera.name + "\"\n";
  if (!camera.sheet.empty()) {
    text += "sheet = \"" + camera.sheet +
            "\"  # lies on the table as it lay; without this line a camera "
            "that was moved is not noticed\n";
  }
  if (!camera.identity.empty()) {
    text += "identity = " + quoted(camera.identity) + "  # of no other camera is this true\n";
  }
  add("width = %d\nheight = %d\n\n[lens]  # px, and Brown's coefficients\n", model.width,
      model.height);
  add("fx = %.9f\nfy = %.9f\ncx = %.9f\ncy = %.9f\n", model.fx, model.fy, model.center.x,
      model.center.y);
  for (std::size_t i = 0; i < kLensKeys.size(); ++i) {
    add("%s = %.12g\n", kLensKeys[i].data(), model.lens[i]);
  }
  text += "\n[pose]  # of the camera over the table\n" + toml_pose(camera.X_WC.p, camera.X_WC.R);
  add("\n[accuracy]\nreprojection_px = %.4g\ntable_mm = %.4g  # 95 %%\n", camera.reprojection,
      1e3 * camera.accuracy);
  if (camera.touched) {
    text += "\n[table]  # in the base of this robot, as its tool has touched it\nrobot = \"" +
            camera.touched->robot + "\"\n" +
            toml_pose(camera.touched->X_BW.p, camera.touched->X_BW.R);
    add("error_mm = %.4g  # 95 %%\n", 1e3 * camera.touched->error);
  }
  return text;
}

}  // namespace sinew
