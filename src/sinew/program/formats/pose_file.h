#pragma once

#include <array>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/driver/driver.h"
#include "sinew/kinematics/hexapod.h"
#include "sinew/model/robot_model.h"

namespace sinew::program {

/// What a platform's `.pos` file says: where the heads of its actuators are, and how far it was
/// moved and turned in all since its home. The totals do not determine the pose (turns do not
/// commute), the heads do.
struct PoseFile {
  std::array<Vec3, kLegs> heads;  ///< m, in base B
  Vec3 translation_total;         ///< m
  Vec3 rotation_total;            ///< rad
};

/// How a file writes the mark before its decimals: the old program follows the country of its PC.
enum class DecimalMark : std::uint8_t { kPoint, kComma };

/// 24 numbers, one a row, mm and deg: x, y, z of the heads of leg 1 to 6, the totals. Rows end with
/// LF or CR LF, empty ones may stand at the end; UTF-8 or UTF-16 with a byte order mark is read. A
/// decimal mark is a point or a comma, the same one in the whole file.
/// @error  all complaints with line and column
std::expected<PoseFile, std::vector<Complaint>> read_pose_file(std::string_view text,
                                                               std::string_view file_name);

/// With nine decimals; read_pose_file() gives the same back, to 1e-9 mm or deg.
std::string pose_text(const PoseFile& file, DecimalMark mark);

/// The old program's config.cfg, 50 rows: its port, its folder, 24 numbers of the platform and 24
/// of the one that it only showed.
struct PlatformConfig {
  std::string port;
  std::string folder;
  PoseFile real, preview;
};
std::expected<PlatformConfig, std::vector<Complaint>> read_platform_config(
    std::string_view text, std::string_view file_name);

/// A rigid platform at those heads: its pose, and the largest distance of a head from where that
/// pose has it.
struct PlatformFit {
  kinematics::PoseBP X_BP;
  double residual = 0;  ///< m
};
/// The largest residual that a file of this platform has, m; more is another platform's file.
inline constexpr double kPlatformResidualMax = 0.1e-3;

/// Least squares over all heads, after Horn, "Closed-form solution of absolute orientation using
/// unit quaternions" (1987).
PlatformFit fit_platform(const std::array<Vec3, kLegs>& heads, const HexapodGeometry& geometry);

/// The file of a platform at a pose; totals count from its home.
PoseFile pose_file(const kinematics::PoseBP& X_BP, const HexapodGeometry& geometry);

/// Where an old config.cfg says that the legs are. It was written without sync or checksum, and
/// only when the program ended: each leg is kUncertain over its whole way, the file's word is the
/// guess.
FixedVector<JointPosition, kMaxJoints> uncertain_legs(const PlatformFit& fit,
                                                      const RobotModel& robot);

}  // namespace sinew::program
