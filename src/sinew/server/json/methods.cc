#include "sinew/server/json/methods.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sinew/core/spelling.h"

namespace sinew::server {
namespace {

constexpr Param kRobotParam{"robot", ParamType::kRobot, true, "its name in the cell"};
constexpr Param kRobotOnly[] = {kRobotParam};
constexpr Param kRobotOrAll[] = {
    {"robot", ParamType::kRobot, false, "its name in the cell; all of them where left out"}};
constexpr Param kWatchParams[] = {
    {"rate_hz", ParamType::kNumber, false, "status messages a second, up to 100; 0 for none; 10"},
    {"robot", ParamType::kRobot, false, "of this one only"},
    {"after", ParamType::kWhole, false,
     "events behind this number too; from now on where left out"}};
constexpr Param kEventsParams[] = {
    {"after", ParamType::kWhole, false, "number of the last event that is known already"}};
constexpr Param kQueryParams[] = {
    {"objects", ParamType::kNames, false, "of objects.list; all of them where left out"}};
constexpr Param kSubscribeParams[] = {
    {"objects", ParamType::kNames, true, "of objects.list; none ends it"},
    {"rate_hz", ParamType::kNumber, false, "messages a second, up to 100; 0 for none; 10"}};
constexpr Param kTakeParams[] = {
    kRobotParam,
    {"take_over", ParamType::kFlag, false, "from whoever has it, which stops the machine first"}};
constexpr Param kFeedParams[] = {
    kRobotParam,
    {"share", ParamType::kNumber, true, "0 to 2 of the planned pace; up to 1 on whole moves"}};
constexpr Param kJogParams[] = {
    kRobotParam,
    {"frame", ParamType::kText, true, "joint, base, tool or platform"},
    {"velocity", ParamType::kNumbers, true,
     "rad/s and m/s: a number a joint, or x, y, z (m/s) "
     "and the turns (rad/s) that this tool has"},
    {"expiry_s", ParamType::kNumber, false,
     "for how long it counts, up to 1 s; 0.15. Real time, also where the cell runs faster"}};
constexpr Param kDeclareParams[] = {
    kRobotParam,
    {"positions", ParamType::kNumbers, false, "rad or m, one a joint; its home where left out"},
    {"shown", ParamType::kFlag, false,
     "instead: the middle of its intervals, which stay; refused where they are wider than a person "
     "sees"},
    {"moved", ParamType::kText, false,
     "why what was known of its place does not count any more, in words: who moved it"},
    {"zero_counters", ParamType::kFlag, false,
     "the device's counters read zero there from now on, where it has such a command"}};
constexpr Param kFreeDriveParams[] = {
    kRobotParam, {"on", ParamType::kFlag, true, "false: the motors hold each joint where it is"}};
constexpr Param kNudgeParams[] = {
    kRobotParam,
    {"joint", ParamType::kText, true, "its name"},
    {"way", ParamType::kNumber, true, "rad or m, at most the robot's nudge_max"},
    {"until_probe", ParamType::kFlag, false,
     "ends where the device's probe input closes; `touched` of device.status says where"}};
constexpr Param kFormParam = {
    "form", ParamType::kText, false,
    "of the text: sequence (BigRobotArm), pos (platform) or gcode; where left out its first word "
    "tells"};
constexpr Param kRunParams[] = {
    kRobotParam,
    {"text", ParamType::kText, true, "rows as in docs/programs.md, or another form as it is"},
    kFormParam,
    {"name", ParamType::kText, false, "as complaints and events call it"},
    {"points", ParamType::kText, false, "taught points, a points.toml"},
    {"called", ParamType::kTexts, false, "the programs that it calls, by name"},
    {"take_over", ParamType::kFlag, false, "the lease, from whoever has it"},
    {"standing_at", ParamType::kNumbers, false,
     "where it stands, from somebody who has looked; "
     "rad or m, one a joint"},
    {"shown", ParamType::kFlag, false, "instead: where its intervals show it, as robot.declare"},
    {"moved", ParamType::kText, false, "who moved it, as robot.declare"},
    {"from_line", ParamType::kWhole, false, "of its own text, where it goes on"},
    {"speed", ParamType::kNumber, false, "share of all rows' speed, 0.01 to 1"},
    {"single_step", ParamType::kFlag, false, "a pause behind each order, as program.step makes"}};

constexpr Param kHoldParams[] = {
    kRobotParam,
    {"guarded", ParamType::kFlag, false, "only this client, or an explicit take_over, resumes it"}};
constexpr Param kTakeHoldParam = {"take_over", ParamType::kFlag, false,
                                  "also where another client guards the hold"};
constexpr Param kResumeParams[] = {kRobotParam, kTakeHoldParam};
constexpr Param kStepParams[] = {
    kRobotParam,
    kTakeHoldParam,
    {"back", ParamType::kFlag, false, "where it is paused between two orders: the last one anew"}};

constexpr Param kRideParams[] = {
    kRobotParam,
    {"duration_s", ParamType::kNumber, true, "1 to 3600"},
    {"seed", ParamType::kWhole, false, "one seed, one ride; 1"},
    {"amplitude", ParamType::kNumber, false,
     "share of the joints' ranges, up to 1; as the wire allows where left out"},
    {"take_over", ParamType::kFlag, false, "the lease, from whoever has it"}};

constexpr Param kProcedureParams[] = {
    kRobotParam,
    {"kind", ParamType::kText, true, "home, recover or commission"},
    {"take_over", ParamType::kFlag, false, "the lease, from whoever has it"},
    {"anew", ParamType::kFlag, false,
     "commission: asks again what was answered of a list that was broken off"}};

constexpr Param kAnswerParams[] = {
    kRobotParam,
    {"answer", ParamType::kText, true,
     "as a person writes it: yes, go, a word of its choices, a number with its unit"}};

constexpr Param kCameraParam{"camera", ParamType::kText, false,
                             "its name in the cell; the first one where left out"};
constexpr Param kCameraOnly[] = {kCameraParam};
constexpr Param kLookParams[] = {
    kCameraParam,
    {"known", ParamType::kWhole, false, "number of the last picture: it is not sent again"},
    {"longest_px", ParamType::kWhole, false, "of the picture's longer side, 16 to 4096; 640"},
    {"tags", ParamType::kFlag, false, "the printed tags in it, too"},
    {"take", ParamType::kFlag, false, "takes the next picture; true"}};
constexpr Param kPaperParam{"paper", ParamType::kText, false, "a4, a3 or letter; a4"};
constexpr Param kPrintParams[] = {
    {"what", ParamType::kText, true, "board (to hold) or sheet (for the table)"},
    kPaperParam,
    {"form", ParamType::kText, false, "svg or pdf; svg"}};
constexpr Param kTroubleParams[] = {
    {"trouble", ParamType::kText, true, "none, hand, covered, unplugged or frozen"}, kCameraParam};
constexpr Param kSessionParam{
    "session", ParamType::kWhole, false,
    "of the calibration that is meant; refused where another client has begun a new one"};
constexpr Param kBeginParams[] = {
    kCameraParam,
    kPaperParam,
    {"anew", ParamType::kFlag, false, "without the views of the calibration under way"}};
constexpr Param kExpectParams[] = {
    {"step", ParamType::kText, true, "board, sheet or touch"}, kCameraParam, kSessionParam};
constexpr Param kSessionOnly[] = {kCameraParam, kSessionParam};
constexpr Param kTouchParams[] = {
    kRobotParam,
    {"mark", ParamType::kText, true, "of the sheet: cross1 to cross5, tag580 to tag583"},
    {"pin_m", ParamType::kNumber, false,
     "how far a pin in the tool stands out of it: tools keep 5 mm clear of tables; 0"},
    kCameraParam,
    kSessionParam};
constexpr Param kDropParams[] = {{"view", ParamType::kWhole, false, "its number"},
                                 {"mark", ParamType::kText, false, "that was touched"},
                                 kCameraParam,
                                 kSessionParam};
constexpr Param kCalibrationSaveParams[] = {
    kCameraParam,
    kSessionParam,
    {"sheet_stays", ParamType::kFlag, false,
     "on the table, so that a camera that was moved is noticed; true"}};

constexpr Param kCubesParams[] = {
    kRobotParam,
    {"camera", ParamType::kText, false, "its name in the cell; the first one where left out"}};
constexpr Param kCubeReachParams[] = {
    kRobotParam,
    {"edge_m", ParamType::kNumber, false, "of the cube, 0.005 to 0.2; the first camera's"},
    {"z_m", ParamType::kNumber, false,
     "what it stands on, in the cell; the first camera's table, or the robot's foot"}};
constexpr Param kBasketParams[] = {
    {"basket", ParamType::kText, true, "its name in the cell"},
    {"x_m", ParamType::kNumber, true, "middle of its floor in the cell"},
    {"y_m", ParamType::kNumber, true, "likewise"},
    {"turn_rad", ParamType::kNumber, false, "about z; as it is turned where left out"}};

constexpr Param kPreviewParams[] = {
    kRobotParam,
    {"joints", ParamType::kNumbers, false, "where the joints shall be; rad or m, one a joint"},
    {"tool", ParamType::kNumbers, false,
     "where the tool shall be in the base frame: x, y, z (m), which keeps its attitude, or with "
     "its quaternion behind it (w, x, y, z)"},
    {"text", ParamType::kText, false, "rows, as program.run takes them"},
    kFormParam,
    {"line", ParamType::kFlag, false, "the tool goes there along a straight line"},
    {"speed", ParamType::kNumber, false, "share of the joints' limits, 0.01 to 1"},
    {"samples", ParamType::kWhole, false, "of the profile at most, 2 to 1000; 121"}};

constexpr Param kWireParams[] = {
    kRobotParam,
    {"since", ParamType::kWhole, false, "`last` of the answer before; as far back as there is"},
    {"limit", ParamType::kWhole, false, "frames at most, 1 to 2000; 500"}};
constexpr Param kCheckParams[] = {
    kRobotParam,
    {"text", ParamType::kText, true, "rows as in docs/programs.md, or another form as it is"},
    kFormParam,
    {"points", ParamType::kText, false, "a points.toml; the kept one where left out"},
    {"called", ParamType::kTexts, false,
     "the programs that it calls, by name; the kept ones where left out"}};
constexpr Param kFormatParams[] = {{"text", ParamType::kText, true, "rows, of any robot"}};
constexpr Param kImportParams[] = {
    kRobotParam,
    {"text", ParamType::kText, true, "the file's bytes, in UTF-8"},
    {"form", ParamType::kText, true, "sequence (BigRobotArm), pos (platform) or gcode"}};
constexpr Param kExportParams[] = {
    kRobotParam,
    {"text", ParamType::kText, true, "rows as in docs/programs.md"},
    {"form", ParamType::kText, true, "sequence (BigRobotArm) or pos (platform)"},
    {"points", ParamType::kText, false, "a points.toml; the kept one where left out"},
    {"called", ParamType::kTexts, false,
     "the programs that it calls, by name; the kept ones where left out"},
    {"decimal_comma", ParamType::kFlag, false, "pos: as German PCs read it"}};
constexpr Param kProgramName{"name", ParamType::kText, true,
                             "a letter, then letters, digits, - and _, 40 at most"};
constexpr Param kRevision{"revision", ParamType::kWhole, true,
                          "of what it was made from, as it was told; 0: nothing is there yet"};
constexpr Param kProgramParams[] = {kRobotParam, kProgramName};
constexpr Param kSaveParams[] = {
    kRobotParam,
    kProgramName,
    {"text", ParamType::kText, true, "256 KiB at most; it may have mistakes still"},
    kRevision};
constexpr Param kRemoveParams[] = {kRobotParam, kProgramName, kRevision};
constexpr Param kPointsSaveParams[] = {
    kRobotParam,
    {"points", ParamType::kText, true, "as in a points.toml, of this kind of robot"},
    kRevision};
constexpr Param kRenameParams[] = {
    kRobotParam, kProgramName, {"to", ParamType::kText, true, "its new name"}, kRevision};
constexpr Param kRecordParams[] = {
    kRobotParam,
    {"title", ParamType::kText, false, "32 letters of it stand in the file's name; recording"}};
constexpr Param kRecordName{"record", ParamType::kText, true, "its name in records.list"};
constexpr Param kRecordOnly[] = {kRecordName};
constexpr Param kRecordParts[] = {
    kRecordName, {"offset", ParamType::kWhole, false, "bytes that the client has already; 0"}};

constexpr Param kSettings{"settings", ParamType::kTexts, true,
                          "by name, as settings.get has them; of the device these alone count"};
constexpr Param kSettingsParams[] = {kRobotParam, kSettings};
constexpr Param kSettingsSetParams[] = {
    kRobotParam,
    {"settings", ParamType::kTexts, true,
     "as settings.check takes them; none: its own files count again"},
    kRevision};

constexpr auto kMethods = std::to_array<Method>({
    {MethodId::kRpcDiscover,
     "rpc.discover",
     false,
     "this table, for programs",
     {},
     "an OpenRPC document",
     "Document"},
    {MethodId::kCellDescribe,
     "cell.describe",
     false,
     "the cell and its robots; only its baskets ever move",
     {},
     "title, version, time_scale, robots, objects, cameras, baskets",
     "CellDescription"},
    {MethodId::kCellStatus,
     "cell.status",
     false,
     "how all robots are",
     {},
     "robots: a status each",
     "CellStatus"},
    {MethodId::kRobotStatus, "robot.status", false, "how one robot is", kRobotOnly, "its status",
     "Status"},
    {MethodId::kWatch, "watch", false,
     "from now on `status`, `job`, `procedure` and `event` messages; latest wins for whoever reads "
     "slowly",
     kWatchParams, "an empty object"},
    {MethodId::kEventsList, "events.list", false,
     "what happened, the last 1000 events at most, also of the cell's lives before", kEventsParams,
     "events", "Events"},
    {MethodId::kObjectsList,
     "objects.list",
     false,
     "what can be queried and subscribed to",
     {},
     "objects: their names",
     "ObjectNames"},
    {MethodId::kObjectsQuery, "objects.query", false, "how objects are", kQueryParams,
     "objects: a state each, by name", "Objects"},
    {MethodId::kObjectsSubscribe, "objects.subscribe", false,
     "how objects are, and from now on `objects` messages with the fields that have changed since "
     "the one before, null for those that are gone; instead of what was subscribed to before",
     kSubscribeParams, "objects: a state each, by name", "Objects"},
    {MethodId::kLeaseTake, "lease.take", true,
     "the right to move; ends a second behind its holder's last message", kTakeParams, "epoch",
     "Lease"},
    {MethodId::kLeaseRenew,
     "lease.renew",
     true,
     "nothing but a message, by which all leases of this client live on",
     {},
     "an empty object"},
    {MethodId::kLeaseRelease, "lease.release", true, "gives it back", kRobotOnly,
     "an empty object"},
    {MethodId::kRobotEnable, "robot.enable", true, "finds the device; needs the lease", kRobotOnly,
     "an empty object, when it is ready"},
    {MethodId::kRobotDisable, "robot.disable", true, "lets go of the device; needs the lease",
     kRobotOnly, "an empty object"},
    {MethodId::kRobotAcknowledge, "robot.acknowledge", true,
     "a fault whose cause is gone; needs the lease", kRobotOnly, "an empty object"},
    {MethodId::kRobotSelfTest, "robot.self_test", true,
     "each board tests itself, where it has such a command; a homed one turns its motor a full "
     "step "
     "and back; needs the lease",
     kRobotOnly, "an empty object, when all have passed"},
    {MethodId::kRobotFreeDrive, "robot.free_drive", true,
     "the joints' motors off, to guide the arm by hand, where they can be; the arm falls where no "
     "hand holds it. Needs the lease",
     kFreeDriveParams, "an empty object, when it is so"},
    {MethodId::kRobotStop, "robot.stop", false, "to rest; anybody may", kRobotOrAll,
     "an empty object, when it is told"},
    {MethodId::kRobotHold, "robot.hold", false,
     "to rest on its path, or behind what cannot be interrupted, to go on later; any client may",
     kHoldParams, "an empty object", "Steered"},
    {MethodId::kRobotResume, "robot.resume", true,
     "on from there; needs the lease, but for a program, which goes on under that of the client "
     "that runs it, and under the caller's where that client is gone",
     kResumeParams, "an empty object", "Steered"},
    {MethodId::kRobotFeed, "robot.feed", true, "the pace from now on; needs the lease", kFeedParams,
     "an empty object"},
    {MethodId::kRobotJog, "robot.jog", true,
     "a velocity from now on, until it expires; needs the lease", kJogParams, "an empty object"},
    {MethodId::kRobotNudge, "robot.nudge", true,
     "one joint a little and slowly, also while nobody knows where it is; needs the lease",
     kNudgeParams, "an empty object, when it has begun"},
    {MethodId::kRobotDeclare, "robot.declare", true,
     "where it stands, from somebody who has looked; needs the lease", kDeclareParams,
     "an empty object"},
    {MethodId::kProgramRun, "program.run", true,
     "plans and runs a program; `job` messages tell how it goes", kRunParams, "job: its number",
     "JobNumber"},
    {MethodId::kRobotRide, "robot.bullride", true,
     "random poses, all within reach and limits, and back; a job as a program is", kRideParams,
     "job: its number", "JobNumber"},
    {MethodId::kProgramStep, "program.step", true,
     "the program's next order, then a pause; or back to where the last one began", kStepParams,
     "job: its number; wishes: how many it had heard before this one", "JobNumber"},
    {MethodId::kJobStatus, "job.status", false, "the job under way, or the last one", kRobotOnly,
     "a job", "Job"},
    {MethodId::kProcedureStart, "procedure.start", true,
     "goes step by step through homing, recovery or commissioning with whoever answers, under the "
     "lease that it takes for this client; `procedure` messages tell how it goes",
     kProcedureParams, "a procedure", "Procedure"},
    {MethodId::kProcedureAnswer, "procedure.answer", true,
     "of its question; where it is refused, nothing moves and the question stands; for whoever "
     "started it",
     kAnswerParams, "a procedure", "Procedure"},
    {MethodId::kProcedureBack, "procedure.back", true,
     "one step back, while something is asked; for whoever started it", kRobotOnly, "a procedure",
     "Procedure"},
    {MethodId::kProcedureCancel, "procedure.cancel", true,
     "its end: what moves comes to rest, what was answered is kept; for whoever started it",
     kRobotOnly, "a procedure", "Procedure"},
    {MethodId::kProcedureStatus, "procedure.status", false,
     "the procedure under way, or the last one", kRobotOnly, "a procedure", "Procedure"},
    {MethodId::kSimulationTruth, "simulation.truth", false,
     "where a simulated machine really stands, whatever it believes", kRobotOnly, "truth", "Truth"},
    {MethodId::kSimulationCamera, "simulation.camera", true,
     "what happens to the simulated cameras of this cell from now on, to try what robots make of "
     "it; a hand reaches into the picture of the one that is named",
     kTroubleParams, "camera, trouble", "SimulatedCamera"},
    {MethodId::kRobotModel, "robot.model", false,
     "what it is drawn and steered from: its chain, linkage or legs, its bodies, its joints",
     kRobotOnly, "kind, joints, links, shapes, geometry, jog", "Model"},
    {MethodId::kRobotPreview, "robot.preview", false,
     "one of joints, tool and text, as it would go from where the robot stands; nothing moves. Of "
     "previews that wait only a client's latest of each robot is made",
     kPreviewParams, "text, duration_s, limited, from, to, samples", "Preview"},
    {MethodId::kDeviceStatus, "device.status", false,
     "what its device has told of itself last, with the bytes and their age; asks it nothing",
     kRobotOnly, "wire, warnings, and what this wire tells", "Device"},
    {MethodId::kWireRead, "wire.read", false,
     "what has passed over its wire, both ways, message by message: of those behind `since` the "
     "latest `limit`",
     kWireParams, "frames, last, lost: how many behind `since` are not among them", "WireFrames"},
    {MethodId::kCameraLook, "camera.look", false,
     "the newest picture of a camera and the cubes in it; the next one is taken meanwhile, "
     "unless `take` is false: then pictures are those that programs take",
     kLookParams,
     "number, width_px, height_px, cubes, refused, tags, fault, trouble of a simulated one, "
     "picture: a JPEG as base64",
     "CameraShot"},
    {MethodId::kRobotCubes, "robot.cubes", false,
     "whether this robot can pick the cubes in a camera's newest picture, each as they lie now, "
     "and "
     "what would help; nothing moves",
     kCubesParams, "number of the picture, cubes in the order in which they are picked",
     "CubeVerdicts"},
    {MethodId::kRobotCubeReach, "robot.cube_reach", false,
     "where on a level surface this robot can take a cube that lies alone; computed while a client "
     "asks for it: `done` is the share so far",
     kCubeReachParams,
     "x_m, y_m: middle of the first cell of the grid; rows along y, a letter a cell along x: s "
     "straight "
     "down, t tilted, - not, . not known yet",
     "CubeReach"},
    {MethodId::kBasketMove, "basket.move", true,
     "says where a basket stands from now on, and keeps it; refused while a program handles cubes",
     kBasketParams, "basket; warnings: robots that do not reach it", "MovedBasket"},
    {MethodId::kCameraPrint, "camera.print", false,
     "a sheet to print at 100 % for the calibration of a camera, as sinew camera makes it",
     kPrintParams, "text", "Text"},
    {MethodId::kCalibrationStatus, "camera.calibration.status", false,
     "how the calibration of a camera stands", kCameraOnly,
     "camera, under_way, session, step, views, coverage, better, trouble, result, touch",
     "Calibration"},
    {MethodId::kCalibrationBegin, "camera.calibration.begin", true,
     "calibrates a camera, or goes on with the calibration under way, of all clients alike; a "
     "simulated camera is shown the board from now on",
     kBeginParams, "as camera.calibration.status", "Calibration"},
    {MethodId::kCalibrationExpect, "camera.calibration.expect", true, "what the next view shows",
     kExpectParams, "as camera.calibration.status", "Calibration"},
    {MethodId::kCalibrationTake, "camera.calibration.take", true,
     "a picture, as a view of the board or of the sheet; refused where it adds nothing, is blurred "
     "or shows neither",
     kSessionOnly, "as camera.calibration.status, and taken: its number", "Calibration"},
    {MethodId::kCalibrationTouch, "camera.calibration.touch", true,
     "the tip of this robot's tool is on a mark of the sheet: three and more say where the sheet "
     "lies. The robot has to be at rest, its jaws closed",
     kTouchParams, "as camera.calibration.status", "Calibration"},
    {MethodId::kCalibrationDrop, "camera.calibration.drop", true,
     "removes a view, or a mark that was touched", kDropParams, "as camera.calibration.status",
     "Calibration"},
    {MethodId::kCalibrationSave, "camera.calibration.save", true,
     "writes the camera's file beside the cell's, and ends; the camera sees by it from its next "
     "picture on. Refused while a program runs",
     kCalibrationSaveParams, "as camera.calibration.status, and saved", "Calibration"},
    {MethodId::kCalibrationEnd, "camera.calibration.end", true,
     "without a file: its views are lost", kSessionOnly, "as camera.calibration.status",
     "Calibration"},
    {MethodId::kProgramCheck, "program.check", false,
     "a verdict for each row, from where the robot stands; nothing moves, and what is refused is "
     "no error",
     kCheckParams, "fine, duration_min_s, duration_max_s, homing_at_most_s, rows", "Check"},
    {MethodId::kProgramFormat, "program.format", false, "a program in its one layout",
     kFormatParams, "text", "Text"},
    {MethodId::kProgramImport, "program.import", false,
     "a file of another program as rows; what has no row is refused with its line", kImportParams,
     "text", "Text"},
    {MethodId::kProgramExport, "program.export", false,
     "a program as a file of another one, planned from home; what that cannot say is refused with "
     "its line",
     kExportParams, "text", "Text"},
    {MethodId::kProgramsList, "programs.list", false,
     "the programs that are kept of this kind of robot", kRobotOnly, "folder, programs",
     "Programs"},
    {MethodId::kProgramsLoad, "programs.load", false, "one of them", kProgramParams,
     "name, text, revision", "Program"},
    {MethodId::kProgramsSave, "programs.save", true,
     "keeps it, unless somebody else has changed it meanwhile", kSaveParams, "name, revision",
     "Saved"},
    {MethodId::kProgramsRemove, "programs.remove", true,
     "for good, unless somebody else has changed it meanwhile", kRemoveParams, "an empty object"},
    {MethodId::kPointsList, "points.list", false, "the points that are kept of this kind of robot",
     kRobotOnly, "file, revision, points", "Points"},
    {MethodId::kPointsSave, "points.save", true,
     "each in the place of the one of its name, or behind the others; the rest of the file stays "
     "as it is",
     kPointsSaveParams, "as points.list", "Points"},
    {MethodId::kPointsRemove, "points.remove", true, "one of them", kRemoveParams, "as points.list",
     "Points"},
    {MethodId::kPointsRename, "points.rename", true,
     "one of them; programs that go there are not changed", kRenameParams, "as points.list",
     "Points"},
    {MethodId::kRecordStart, "record.start", true,
     "what this robot does goes into a file from now on, up to 128 MiB", kRecordParams,
     "record, path", "RecordBegun"},
    {MethodId::kRecordStop, "record.stop", true, "the file is whole", kRobotOnly,
     "record, path, size_bytes, lost", "RecordEnded"},
    {MethodId::kRecordsList,
     "records.list",
     false,
     "the records of this cell, those of faults too, the newest first",
     {},
     "folder, records",
     "Records"},
    {MethodId::kRecordsRead, "records.read", false, "256 KiB of one of them, as base64",
     kRecordParts, "record, offset, data, size_bytes, end", "RecordPart"},
    {MethodId::kRecordsCsv, "records.csv", false,
     "the same of its samples as a table, as sinew record --csv makes it", kRecordParts,
     "record, offset, data, size_bytes, end", "RecordPart"},
    {MethodId::kRecordsRemove, "records.remove", true, "one of them, for good", kRecordOnly,
     "an empty object"},
    {MethodId::kSettingsGet, "settings.get", false,
     "what this robot is set to, and what can be set: beside its cell's file, which nobody writes",
     kRobotOnly,
     "file, revision, is_set, own, now, running, restart, settable, wires, profiles, found",
     "Settings"},
    {MethodId::kSettingsCheck, "settings.check", false,
     "whether a cell with these would start, as its file is checked; nothing is kept",
     kSettingsParams, "fine, complaints, profiles", "SettingsCheck"},
    {MethodId::kSettingsSet, "settings.set", true,
     "keeps them for the next start, unless they do not fit or somebody else has changed them "
     "meanwhile",
     kSettingsSetParams, "as settings.get", "Settings"},
});

bool fits(ParamType type, const Json& value) {
  const auto finite = [](const Json& number) {
    return number.is_number() && std::isfinite(number.get<double>());
  };
  switch (type) {
    case ParamType::kRobot:
    case ParamType::kText:
      return value.is_string();
    case ParamType::kNumber:
      return finite(value);
    case ParamType::kWhole:
      return value.is_number_unsigned();
    case ParamType::kFlag:
      return value.is_boolean();
    case ParamType::kNumbers:
      return value.is_array() && value.size() <= kNumbersMax && std::ranges::all_of(value, finite);
    case ParamType::kTexts:
      return value.is_object() && value.size() <= kTextsMax &&
             std::ranges::all_of(value, [](const Json& one) { return one.is_string(); });
    case ParamType::kNames:
      return value.is_array() && value.size() <= kTextsMax &&
             std::ranges::all_of(value, [](const Json& one) { return one.is_string(); });
  }
  return false;
}

std::string meant_text(std::string_view word, const std::vector<std::string_view>& known) {
  const std::string_view meant = nearest_spelling(word, known);
  return meant.empty() ? std::string() : "; did you mean '" + std::string(meant) + "'?";
}

std::unexpected<RpcError> unfit(std::string message) {
  return std::unexpected(invalid(std::move(message)));
}

}  // namespace

std::span<const Method> methods() {
  return kMethods;
}

std::string_view type_name(ParamType type) {
  constexpr std::string_view kNames[] = {
      "a robot's name",       "a string",         "a number",
      "a whole number >= 0",  "true or false",    "a list of numbers",
      "an object of strings", "a list of strings"};
  return kNames[static_cast<std::size_t>(type)];
}

std::expected<const Method*, RpcError> check(const RpcRequest& request) {
  const auto found = std::ranges::find(kMethods, std::string_view(request.method), &Method::name);
  if (found == kMethods.end()) {
    std::vector<std::string_view> names;
    for (const Method& method : kMethods) names.push_back(method.name);
    return std::unexpected(
        RpcError{RpcCode::kMethodNotFound,
                 "there is no method of this name" + meant_text(request.method, names), nullptr});
  }
  for (const auto& [key, value] : request.params.items()) {
    const auto param = std::ranges::find(found->params, std::string_view(key), &Param::name);
    if (param == found->params.end()) {
      std::vector<std::string_view> names;
      for (const Param& one : found->params) names.push_back(one.name);
      return unfit(std::string(found->name) + " takes no '" + key.substr(0, 64) + "'" +
                   meant_text(key, names));
    }
    if (!fits(param->type, value)) {
      return unfit(std::string(param->name) + " has to be " + std::string(type_name(param->type)));
    }
  }
  for (const Param& param : found->params) {
    if (param.required && !request.params.contains(param.name)) {
      return unfit(std::string(found->name) + " needs '" + std::string(param.name) +
                   "': " + std::string(param.meaning));
    }
  }
  return &*found;
}

}  // namespace sinew::server
