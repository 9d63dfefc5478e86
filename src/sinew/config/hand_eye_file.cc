#include "sinew/config/hand_eye_file.h"

#include <array>
#include <cstdio>

#include "sinew/core/units.h"
#include "sinew/toml/table_reader.h"
#include "sinew/toml/toml_pose.h"

namespace sinew {
namespace {

constexpr int kFormat = 1;
constexpr std::size_t kNameMax = 60;  // bytes

HandEyeFile read_root(TableReader& root) {
  constexpr Named<bool> kMounts[] = {{"arm", true}, {"table", false}};
  HandEyeFile file;
  root.needs_no_source();
  int format = 0;
  if (root.integer("format", 1, 1'000'000, format) && format != kFormat) {
    root.complain("format", "is " + std::to_string(format) +
                                ": written by another version; measure again: sinew camera "
                                "hand-eye");
  }
  root.choice("mount", kMounts, file.on_arm);
  root.text("robot", kNameMax, file.robot);
  root.text("lens", kNameMax, file.lens);
  root.text("target", kNameMax, file.target);
  if (auto camera = root.table("camera")) {
    camera->needs_no_source();
    read_toml_pose(*camera, file.X_MC);
    camera->finish();
  }
  if (auto target = root.table("target_pose")) {
    target->needs_no_source();
    read_toml_pose(*target, file.X_NB);
    target->finish();
  }
  for (TableReader& zero : root.tables("joint_zero", Presence::kOptional)) {
    zero.needs_no_source();
    auto& [joint, offset] = file.joint_zeros.emplace_back();
    zero.text("joint", kNameMax, joint);
    zero.quantity("add_*", kAngle, between(-kPi, kPi), offset);
    zero.finish();
  }
  if (auto accuracy = root.table("accuracy")) {
    accuracy->needs_no_source();
    accuracy->integer("views", 0, 100'000, file.views);
    accuracy->number("reprojection_px", between(0, 1e4), file.reprojection);
    accuracy->quantity("held_back_*", kLength, between(0, 10), file.held_back);
    accuracy->quantity("table_*", kLength, between(0, 10), file.table);
    accuracy->finish();
  }
  root.finish();
  return file;
}

}  // namespace

std::expected<HandEyeFile, std::vector<Complaint>> read_hand_eye(std::string_view toml,
                                                                 std::string_view file_name) {
  return read_toml_file(toml, file_name, read_root);
}

std::string hand_eye_text(const HandEyeFile& file) {
  std::string text = "format = " + std::to_string(kFormat) + "\nmount = \"" +
                     (file.on_arm ? "arm" : "table") + "\"\nrobot = \"" + file.robot +
                     "\"\nlens = \"" + file.lens + "\"\ntarget = \"" + file.target + "\"\n";
  text += std::string("\n[camera]  # in the ") + (file.on_arm ? "flange" : "base") + "\n" +
          toml_pose(file.X_MC.p, file.X_MC.R);
  text += std::string("\n[target_pose]  # in the ") + (file.on_arm ? "base" : "flange") + "\n" +
          toml_pose(file.X_NB.p, file.X_NB.R);
  const auto add = [&](const char* form, auto... values) {
    std::array<char, 300> line{};
    std::snprintf(line.data(), line.size(), form, values...);
    text += line.data();
  };
  for (const auto& [joint, offset] : file.joint_zeros) {
    text += "\n[[joint_zero]]\njoint = \"" + joint + "\"\n";
    add("add_deg = %.9f\n", to_deg(offset));
  }
  add("\n[accuracy]\nviews = %d\nreprojection_px = %.3f\nheld_back_mm = %.2f  # at the target, "
      "95 %%, of views held back\ntable_mm = %.2f  # of the target or the camera's table in the "
      "base, 95 %%\n",
      file.views, file.reprojection, 1e3 * file.held_back, 1e3 * file.table);
  return text;
}

}  // namespace sinew
