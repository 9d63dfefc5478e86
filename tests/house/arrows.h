#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "house/source_tree.h"

namespace sinew::house {

/// One folder below src/sinew and the folders it points at, space-separated.
struct FolderArrows {
  std::string_view folder;
  std::string_view points_at;
};

/// The arrows of the house. A folder may include what it reaches by following them, everything
/// reaches core. New arrows are a design decision, not a fix for a test.
inline constexpr std::array kArrows = std::to_array<FolderArrows>({
    {"core", ""},
    {"mcu", ""},
    {"model", ""},
    {"io", ""},
    {"toml", ""},
    {"kinematics", "model"},
    {"vision", "model"},
    {"render", "vision kinematics"},
    {"calibration", "vision kinematics"},
    {"wire", "mcu"},
    {"motion", "mcu"},
    {"device", "wire motion kinematics"},
    {"driver", "wire model"},
    {"planning/paths", "motion kinematics model"},
    {"planning/timing", "planning/paths"},
    {"planning/collision", "planning/paths"},
    {"planning/jog", "planning/collision"},
    {"planning/studies", "kinematics model"},
    {"planning", "planning/timing planning/collision"},
    {"grasping", "planning/collision"},
    {"sim", "device kinematics model"},
    {"file", "toml model"},
    {"devices", "file driver sim"},
    {"config", "devices vision"},
    {"control", "driver planning planning/jog"},
    {"program/language", "driver vision grasping"},
    {"program/plans", "program/language control devices planning/studies"},
    {"program/formats", "program/plans"},
    {"program/runs", "program/plans"},
    {"program/procedures", "program/plans"},
    {"runtime/cameras", "io sim config render program/language"},
    {"runtime/links", "runtime/cameras"},
    {"runtime/journal", "io sim control"},
    {"runtime/records", "runtime/links runtime/journal program/runs"},
    {"runtime", "runtime/records program/procedures calibration"},
    {"server/json", "runtime program/formats"},
    {"server/files", "server/json"},
    {"server/api", "server/files"},
    {"server/web", "server/api"},
    {"cli/output", "server/web"},
    {"cli/plans", "cli/output"},
    {"cli/images", "cli/output"},
    {"cli/cells", "cli/plans cli/images"},
    {"cli/cameras", "cli/output"},
    {"cli/boards", "cli/cells"},
    {"cli", "cli/boards cli/cells cli/cameras"},
});

/// What stands in devices/ goes by the first of these words in its file's name: icp_driver_leg.h
/// has the arrows of driver. Without one it has those of devices: all of its kind.
struct FileRole {
  std::string_view word;
  std::string_view folder;
};
inline constexpr std::array kFileRoles = std::to_array<FileRole>({
    {"settings", "model"},
    {"wire", "wire"},
    {"device", "device"},
    {"driver", "driver"},
    {"listener", "driver"},
    {"file", "file"},
    {"machine", "sim"},
    {"procedure", "program/procedures"},
    {"format", "program/formats"},
    {"verb", "cli/cells"},
});

/// Headers by which bytes, files or time leave the process, and the folders that may include them.
/// A name that ends in '/' means everything below it.
struct GuardedHeaders {
  std::string_view headers;
  std::string_view folders;
};

inline constexpr std::array kGuardedHeaders = std::to_array<GuardedHeaders>({
    {"unistd.h fcntl.h termios.h poll.h pty.h netdb.h dirent.h sys/ linux/ netinet/ arpa/", "io"},
    {"boost/asio/ boost/asio.hpp", "io server/web"},
    {"boost/beast/ boost/beast.hpp", "server/web"},
});

/// Folders that move the machine or speak its bytes: they never see a clock, file, socket or
/// thread, so that one seed replays one whole run.
inline constexpr std::string_view kPureFolders =
    "mcu control driver device devices file sim wire motion planning kinematics vision render "
    "calibration grasping";

inline constexpr std::string_view kNotInPureFolders =
    "thread mutex shared_mutex condition_variable future semaphore latch barrier stop_token "
    "pthread.h fstream iostream filesystem cstdio stdio.h ctime time.h";

/// Complaints of the form `path:line: what is wrong`; an empty list is a clean house. Unit tests
/// (*_test.cc, *_test*.h) may include anything, and may not sleep.
std::vector<std::string> check_arrows(std::span<const SourceFile> files);
std::vector<std::string> check_guarded_headers(std::span<const SourceFile> files);
std::vector<std::string> check_clocks_and_sleeps(std::span<const SourceFile> files);

/// What `folder` may include besides itself, sorted; empty for a folder that has no row.
std::vector<std::string> reachable_from(std::string_view folder);

}  // namespace sinew::house
