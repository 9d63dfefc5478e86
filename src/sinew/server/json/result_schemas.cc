#include "sinew/server/json/result_schemas.h"

#include <string>

#include "sinew/server/json/device_schemas.h"
#include "sinew/server/json/schema_words.h"

namespace sinew::server {

using namespace schema;

namespace {

void put_basics(Json& all) {
  all["Empty"] = told("Nothing: it is done.", object({}));
  all["Document"] = object({{"openrpc", text()},
                            {"info", table(text())},
                            {"methods", list(table(true))},
                            {"components", table(true)},
                            {"x-messages", table(true)}});
  all["Pose"] = object(
      {{"x_m", number()}, {"y_m", number()}, {"z_m", number()}, {"quaternion_wxyz", numbers(4)}});
  all["LocalPose"] = object({{"xyz_m", numbers(3)}, {"quaternion_wxyz", numbers(4)}});
  all["Quality"] = one_of({"measured", "commanded", "uncertain", "lost"});
  all["State"] =
      one_of({"off", "enabling", "ready", "moving", "stopping", "held", "fault", "recovering"});
  all["StopCause"] =
      one_of({"client", "pause", "take_over", "lease_ended", "refused", "device", "not_recorded",
              "record_late", "cycle_overrun", "clock_gap", "shutdown"});
  all["Error"] =
      told("Why not. measured and limit have their unit in their names; null is no number.",
           object({{"code", text()}, {"sentence", text()}},
                  {{"joint", text()},
                   {"link", text()},
                   {"links", text()},
                   {"left_out", flag()},
                   {"line", whole()},
                   {"share", number()},
                   {"way_m", number()},
                   {"other", text()},
                   {"other_link", text()},
                   {"distance_m", number()},
                   {"margin_m", number()},
                   {"moving", flag()},
                   {"nearest_behind_m", number()},
                   {"would_work", ref("WouldWork")},
                   {"remedies", list(text())}},
                  {{"^(measured|limit)(_m|_rad|_s|_v|_rad_s|_rad_s2)?$", or_null("number")}}));
  all["Complaint"] =
      object({{"sentence", text()}},
             {{"file", text()}, {"line", whole()}, {"column", whole()}, {"name", text()}});
  Json refusal = told(
      "The data of an error, where it has any: an Error's fields, or some of these.", all["Error"]);
  refusal.erase("required");
  refusal["properties"].update({{"complaints", list(ref("Complaint"))},
                                {"cause", ref("StopCause")},
                                {"job", whole()},
                                {"record", text()},
                                {"revision", whole()}});
  all["Refusal"] = std::move(refusal);
  all["Note"] = object({{"line", whole()}, {"sentence", text()}});
  all["WouldWork"] = object({{"what", one_of({"back_inside", "joint_move", "nearest_orientation",
                                              "tilted", "short_of_it"})},
                             {"positions", list(number())}},
                            {{"left_m", number()}});
}

void put_cell(Json& all) {
  all["RobotDescription"] = object(
      {{"name", text()},
       {"robot", text()},
       {"title", text()},
       {"port", text()},
       {"simulated", flag()},
       {"time_scale", number()},
       {"pose", ref("Pose")},
       {"streams", flag()},
       {"free_drive", flag()},
       {"probes", flag()},
       {"joints", list(object({{"name", text()}}, {},
                              {{of_joint("lower|upper|home"), number()},
                               {of_joint("velocity_max", "_s"), number()},
                               {of_joint("acceleration_max", "_s2"), number()}}))},
       {"stop", object({{"ends_motion", flag()}, {"standstill", text()}, {"gravity", text()}})}},
      {{"position_journal", object({{"found", text()}, {"way_out", text()}})}},
      {{of_joint("nudge_max"), number()}});
  all["Box"] = object({{"name", text()},
                       {"x_m", number()},
                       {"y_m", number()},
                       {"z_m", number()},
                       {"quaternion_wxyz", numbers(4)},
                       {"length_m", number()},
                       {"width_m", number()},
                       {"height_m", number()}});
  all["CellDescription"] = object(
      {{"title", text()},
       {"version", text()},
       {"time_scale", number()},
       {"robots", list(ref("RobotDescription"))},
       {"objects", list(ref("Box"))},
       {"cameras",
        list(object(
            {{"name", text()}, {"device", text()}, {"cube_m", number()}, {"table", ref("Pose")}},
            {{"calibration", object({{"file", text()}}, {{"refused", text()}})},
             {"on_arm", flag()},
             {"lens", object({{"width_px", whole()},
                              {"height_px", whole()},
                              {"fx_px", number()},
                              {"fy_px", number()},
                              {"cx_px", number()},
                              {"cy_px", number()},
                              {"distortion", numbers(5)},
                              {"accuracy_m", number()}},
                             {{"pose", ref("Pose")}})}}))}},
      {{"baskets", list(ref("Box"))}});

  all["CellStatus"] = object({{"robots", list(ref("Status"))}}, {{"demonstration", flag()}});
  all["ObjectNames"] = object({{"objects", list(text())}});
  all["Objects"] = object(
      {{"objects",
        table({{"anyOf", Json::array({ref("CellDescription"), ref("Status"), ref("Job")})}})}});
  all["ObjectUpdates"] =
      told("By object the fields that have changed; null for those that are gone.",
           object({{"objects", table(table(true))}}));
  all["Lease"] = object({{"epoch", whole()}, {"client", whole()}});
}

void put_cameras(Json& all) {
  const Json corners = list(numbers(2));
  all["CameraShot"] = object(
      {{"camera", text()}, {"number", whole()}},
      {{"width_px", whole()},
       {"height_px", whole()},
       {"fault", ref("Error")},
       {"trouble", text()},
       {"pose", told("Of a camera on an arm, where the picture was taken.", ref("Pose"))},
       {"picture", text()},
       {"cubes", list(object({{"color", text()}, {"confidence", number()}, {"top_px", corners}},
                             {{"x_m", number()},
                              {"y_m", number()},
                              {"z_m", number()},
                              {"yaw_rad", number()},
                              {"edge_m", number()},
                              {"in_basket", text()}}))},
       {"baskets", list(ref("Box"))},
       {"tags", list(object({{"id", whole()}, {"corners_px", corners}}))},
       {"refused", list(object({{"why", text()}, {"outline_px", corners}}))}});
  all["SimulatedCamera"] = object({{"camera", text()}, {"trouble", text()}});
  all["MovedBasket"] =
      object({{"basket", ref("Box")},
              {"warnings", list(object({{"robot", text()}, {"error", ref("Error")}}))}});
  all["CubeVerdicts"] = object({{"camera", text()}, {"number", whole()}},
                               {{"cubes", list(object({{"color", text()},
                                                       {"x_m", number()},
                                                       {"y_m", number()},
                                                       {"z_m", number()},
                                                       {"fine", flag()}},
                                                      {{"tilt_rad", number()},
                                                       {"duration_s", number()},
                                                       {"error", ref("Error")},
                                                       {"help", text()}}))}});
  all["CubeReach"] = object({{"robot", text()},
                             {"edge_m", number()},
                             {"z_m", number()},
                             {"step_m", number()},
                             {"x_m", number()},
                             {"y_m", number()},
                             {"columns", whole()},
                             {"done", number()},
                             {"rows", list(text())}});
}

void put_calibrations(Json& all) {
  const Fields view{{"view", whole()}, {"tags", whole()}, {"corners_px", list(list(numbers(2)))}};
  all["Calibration"] = object(
      {{"camera", text()}, {"under_way", flag()}, {"simulated", flag()}},
      {{"file", text()},
       {"session", whole()},
       {"step", one_of({"board", "sheet", "touch"})},
       {"paper", text()},
       {"width_px", whole()},
       {"height_px", whole()},
       {"views_least", whole()},
       {"views_enough", whole()},
       {"views", list(object(view, {{"residual_px", number()}}))},
       {"sheet", object(view)},
       {"coverage", told("Rows of the picture from above: whether the views show that part of it.",
                         list(list(flag())))},
       {"better", text()},
       {"trouble", text()},
       {"result", object({{"table_error_m", number()},
                          {"reprojection_px", number()},
                          {"ambiguous", flag()},
                          {"left_out", whole()},
                          {"pose", ref("Pose")},
                          {"fx_px", number()},
                          {"fy_px", number()},
                          {"center_px", numbers(2)},
                          {"lens", numbers(5)}})},
       {"table_robot",
        told("Which has measured where the sheet lies, in what is saved now.", text())},
       {"paper_m", told("Width and height of the sheet.", numbers(2))},
       {"marks", told("Of the sheet, to touch; from its middle.",
                      list(object({{"mark", text()}, {"x_m", number()}, {"y_m", number()}})))},
       {"touch", object({{"robot", text()},
                         {"marks", list(object({{"mark", text()}}, {{"off_m", number()}}))}},
                        {{"trouble", text()},
                         {"too_few", flag()},
                         {"rms_m", number()},
                         {"error_m", number()},
                         {"pose", ref("Pose")},
                         {"moved_m", number()},
                         {"next", object({{"mark", text()}, {"error_m", number()}})}})},
       {"taken", whole()},
       {"saved",
        object({{"file", text()}, {"table_error_m", number()}, {"sheet_stays", flag()}})}});
}

void put_status(Json& all) {
  all["JointStatus"] = object({{"name", text()}, {"quality", ref("Quality")}}, {},
                              {{of_joint("position|lower|upper|commanded"), number()}});
  all["Latched"] = object({{"cause", ref("StopCause")}, {"error", ref("Error")}},
                          {{"category", category()}, {"later", list(ref("Latched"))}});
  all["Health"] =
      object({{"requests", whole()},
              {"retries", whole()},
              {"repeats", whole()},
              {"timeouts", whole()},
              {"unexpected", whole()},
              {"bytes_to_device", whole()},
              {"bytes_to_host", whole()}},
             {{"supply_v", number()}, {"temperature_c", number()}, {"jaws_width_m", number()}});
  all["Cycle"] = told("Of its control loop, s, over the last hundred cycles.",
                      object({{"mean_s", number()}, {"longest_s", number()}}));
  all["Status"] = object(
      {{"robot", text()},
       {"at_s", number()},
       {"state", ref("State")},
       {"position", ref("Quality")},
       {"connected", flag()},
       {"joints", list(ref("JointStatus"))},
       {"feed", number()},
       {"free_drive", flag()},
       {"progress", number()},
       {"health", ref("Health")}},
      {{"cycle", ref("Cycle")},
       {"kept", whole()},
       {"trouble", text()},
       {"tool", ref("Pose")},
       {"jaws_m", number()},
       {"held_m", number()},
       {"lease", object({{"client", whole()}, {"epoch", whole()}})},
       {"homing", text()},
       {"fault", ref("Latched")},
       {"jog", object({{"reason", text()}, {"share", number()}}, {{"joint", text()}})},
       {"last_stop", ref("StopCause")},
       {"goes_on_s", number()},
       {"recording", object({{"record", text()}, {"length_s", number()}, {"size_bytes", whole()}})},
       {"job", ref("Job")},
       {"procedure", object({{"number", whole()},
                             {"kind", text()},
                             {"phase", ref("ProcedurePhase")},
                             {"step", whole()},
                             {"of", whole()}},
                            {{"client_lost", flag()}})}});
  all["Truth"] = object({{"joints", list(object({{"name", text()},
                                                 {"stalled", flag()},
                                                 {"at_end_stop", flag()},
                                                 {"lost_steps", flag()}},
                                                {}, {{of_joint("position|believed"), number()}}))},
                         {"supply_v", number()},
                         {"moving", flag()},
                         {"tool", number()},
                         {"suction", flag()}});
}

void put_jobs(Json& all) {
  all["JobPhase"] =
      one_of({"opening", "planned", "running", "paused", "stopping", "done", "stopped", "failed"});
  all["Job"] = object({{"robot", text()},
                       {"job", whole()},
                       {"client", whole()},
                       {"title", text()},
                       {"phase", ref("JobPhase")},
                       {"over", flag()},
                       {"line", whole()},
                       {"orders_done", whole()},
                       {"orders", whole()},
                       {"predicted_s", number()},
                       {"homing_at_most_s", number()},
                       {"elapsed_s", number()},
                       {"progress", number()},
                       {"notices", whole()},
                       {"wishes", whole()}},
                      {{"limited", ref("Limited")},
                       {"error", ref("Error")},
                       {"wish_refused", ref("Error")},
                       {"waits_for", text()},
                       {"client_lost", flag()},
                       {"held_by", whole()},
                       {"stopped_by", ref("StopCause")},
                       {"paused_by", ref("Error")},
                       {"last_notice", ref("Error")},
                       {"notes", list(ref("Note"))}});
  all["JobNumber"] = object({{"job", whole()}}, {{"wishes", whole()}});
  all["Steered"] = told("Of a program its job; nothing where none runs.",
                        object({}, {{"job", whole()}, {"wishes", whole()}}));
  all["Event"] = told(
      "What there is beside the first four depends on its kind.",
      object(
          {{"number", whole()},
           {"at_ms", whole()},
           {"robot", text()},
           {"kind", one_of({"state", "lease", "stop", "fault", "notice", "record", "demonstration",
                            "job", "procedure", "declared", "declaration_refused", "begun"})}},
          {{"state", ref("State")},
           {"client", or_null("integer")},
           {"category", category()},
           {"cause", ref("StopCause")},
           {"error", ref("Error")},
           {"path", text()},
           {"lost", whole()},
           {"trouble", text()},
           {"full", flag()},
           {"runs", flag()},
           {"job", whole()},
           {"title", text()},
           {"phase", text()},
           {"over", flag()},
           {"predicted_s", number()},
           {"limited", ref("Limited")},
           {"procedure_number", whole()},
           {"procedure", text()},
           {"reason", text()},
           {"positions", list(number())},
           {"known", list(ref("JointStatus"))},
           {"zero_counters", flag()},
           {"version", text()}}));
  all["Events"] = object({{"events", list(ref("Event"))}});
}

void put_procedures(Json& all) {
  all["ProcedurePhase"] =
      one_of({"opening", "asking", "working", "cancelling", "done", "cancelled", "failed"});
  all["ProcedureStep"] = object({{"step", text()}, {"text", text()}, {"state", text()}},
                                {{"answer", text()}, {"words", text()}, {"number", number()}});
  all["Question"] = object({{"kind", one_of({"yes", "go", "words", "number", "amount", "place"})},
                            {"words", text()},
                            {"choices", list(text())},
                            {"ready", flag()}},
                           {}, {{"^(lower|upper)(_m|_rad)?$", number()}});
  all["Procedure"] = object(
      {{"robot", text()},
       {"number", whole()},
       {"client", whole()},
       {"kind", text()},
       {"title", text()},
       {"phase", ref("ProcedurePhase")},
       {"over", flag()},
       {"answers", whole()},
       {"place", whole()},
       {"steps", list(ref("ProcedureStep"))}},
      {{"step", object({{"id", text()}, {"number", whole()}, {"of", whole()}, {"text", text()}})},
       {"asks", ref("Question")},
       {"client_lost", flag()},
       {"joint", text()},
       {"progress", object({{"words", text()}, {"elapsed_s", number()}},
                           {{"at_most_s", number()}, {"share", number()}})},
       {"trouble", text()},
       {"file", text()},
       {"settings", table(text())},
       {"note", text()}});
}

void put_model(Json& all) {
  all["Geometry"] = told(
      "serial: dh, tool, gripper. palletizer: the lengths of its linkage. hexapod: its anchors.",
      object({}, {{"dh", list(object({{"d_m", number()},
                                      {"a_m", number()},
                                      {"alpha_rad", number()},
                                      {"theta_offset_rad", number()}},
                                     {{"slides", flag()}}))},
                  {"tool", ref("LocalPose")},
                  {"gripper", object({{"width_max_m", number()},
                                      {"reach_open_m", number()},
                                      {"reach_closed_m", number()}})},
                  {"base_height_m", number()},
                  {"upper_arm_m", number()},
                  {"shoulder_offset_m", number()},
                  {"forearm_m", number()},
                  {"tool_offset_m", number()},
                  {"base_front_rad", number()},
                  {"radius_min_m", number()},
                  {"base_anchors_m", list(numbers(3))},
                  {"platform_anchors_m", list(numbers(3))},
                  {"platform_radius_m", number()},
                  {"home", ref("LocalPose")}}));
  all["Shape"] =
      object({{"link", whole()}, {"form", one_of({"capsule", "box", "leg", "finger", "held"})}},
             {{"from_m", numbers(3)},
              {"to_m", numbers(3)},
              {"radius_m", number()},
              {"pose", ref("LocalPose")},
              {"half_m", numbers(3)}});
  all["Model"] = object(
      {{"robot", text()},
       {"title", text()},
       {"kind", one_of({"serial", "palletizer", "hexapod"})},
       {"task", one_of({"pose", "yaw", "pitch_roll", "approach", "point"})},
       {"joints", list(object({{"name", text()}, {"kind", one_of({"revolute", "prismatic"})}},
                              {{"left_out", flag()}},
                              {{of_joint("lower|upper|home"), number()},
                               {of_joint("velocity_max", "_s"), number()},
                               {of_joint("acceleration_max", "_s2"), number()},
                               {of_joint("jerk_max", "_s3"), number()}}))},
       {"links", list(object({{"name", text()}}, {{"home", ref("LocalPose")}}))},
       {"geometry", ref("Geometry")},
       {"shapes", list(ref("Shape"))},
       {"margin_m", number()},
       {"jog", told("The frames it can be jogged in, and how many numbers a velocity has there.",
                    table(whole()))},
       {"takes_speed", flag()}},
      {{"table_height_m", number()}});
}

void put_plans(Json& all) {
  const Json rows = list(list(number()));
  all["Limited"] = told("What holds motions back for longest.",
                        object({{"by", one_of({"joint_velocity", "joint_acceleration", "joint_jerk",
                                               "tool_speed", "tool_acceleration", "wire", "feed"})},
                                {"share_of_time", number()}},
                               {{"joint", text()}}));
  all["Preview"] =
      object({{"robot", text()},
              {"text", text()},
              {"duration_s", number()},
              {"homing_at_most_s", number()},
              {"first_move", flag()},
              {"to", told("null where nothing moves.",
                          object({{"positions", or_null("array")}, {"tool", or_null("array")}}))},
              {"samples", object({{"t_s", list(number())}, {"tool", rows}}, {},
                                 {{of_joint("position"), rows},
                                  {of_joint("velocity", "_s"), rows},
                                  {of_joint("acceleration", "_s2"), rows},
                                  {of_joint("jerk", "_s3"), rows}})}},
             {{"from", list(number())}, {"limited", ref("Limited")}});
  all["Verdict"] =
      object({{"line", whole()},
              {"column", whole()},
              {"verdict", one_of({"fine", "refused", "not_checked"})}},
             {{"file", text()},
              {"time_min_s", number()},
              {"time_max_s", number()},
              {"motion_of_line", whole()},
              {"sentence", text()},
              {"key", text()},
              {"refusal", ref("Error")},
              {"round", whole()},
              {"because", object({{"line", whole()}, {"column", whole()}}, {{"file", text()}})}});
  all["Check"] = told(
      "A program that cannot be read has no times.",
      object({{"fine", flag()}, {"rows", list(ref("Verdict"))}},
             {{"duration_min_s", number()},
              {"duration_max_s", number()},
              {"homing_at_most_s", number()},
              {"notes", list(ref("Note"))},
              {"broken_off",
               object({{"sentence", text()}, {"refusal", ref("Error")}}, {{"file", text()}})}}));
  all["Text"] = object({{"text", text()}});
}

void put_texts(Json& all) {
  all["Programs"] = object({{"folder", text()},
                            {"programs", list(object({{"name", text()},
                                                      {"revision", whole()},
                                                      {"size_bytes", whole()},
                                                      {"changed_ms", integer()}}))}});
  all["Program"] = object({{"name", text()}, {"text", text()}, {"revision", whole()}});
  all["Saved"] = object({{"name", text()}, {"revision", whole()}});
  all["Point"] = object(
      {{"name", text()}, {"robot", text()}},
      {{"pose", ref("Pose")},
       {"tool",
        object({{"x_m", number()}, {"y_m", number()}, {"z_m", number()}},
               {{"quaternion_wxyz", numbers(4)}, {"pitch_rad", number()}, {"roll_rad", number()}})},
       {"source", text()},
       {"taught_at", text()}},
      {{of_joint("position"), list(number())}});
  all["Points"] = object({{"file", text()},
                          {"revision", whole()},
                          {"size_bytes", whole()},
                          {"points", list(ref("Point"))}});
}

void put_kept(Json& all) {
  put_texts(all);
  all["RecordBegun"] = object({{"record", text()}, {"path", text()}});
  all["RecordEnded"] = object({{"record", text()}, {"path", text()}, {"lost", whole()}},
                              {{"size_bytes", whole()}, {"trouble", text()}});
  all["Records"] = object(
      {{"folder", text()},
       {"records", list(object({{"record", text()}, {"size_bytes", whole()}, {"fault", flag()}},
                               {{"robot", text()},
                                {"title", text()},
                                {"began_ms", integer()},
                                {"length_s", number()},
                                {"under_way", flag()}}))}},
      {{"size_max_bytes", whole()}, {"all_max_bytes", whole()}});
  all["RecordPart"] = object({{"record", text()},
                              {"offset", whole()},
                              {"data", told("base64", text())},
                              {"size_bytes", whole()},
                              {"end", flag()}});
  all["Settings"] = object({{"robot", text()},
                            {"file", text()},
                            {"revision", whole()},
                            {"is_set", flag()},
                            {"own", table(text())},
                            {"now", table(text())},
                            {"running", table(text())},
                            {"restart", flag()},
                            {"settable", list(text())},
                            {"wires", list(text())},
                            {"profiles", list(text())}},
                           {{"found", table(text())}});
  all["SettingsCheck"] =
      object({{"fine", flag()},
              {"complaints", list(object({{"name", text()}, {"sentence", text()}}))},
              {"profiles", list(text())}});
}

}  // namespace

Json result_schemas() {
  Json all = Json::object();
  put_basics(all);
  put_cell(all);
  put_cameras(all);
  put_calibrations(all);
  put_status(all);
  put_jobs(all);
  put_procedures(all);
  put_model(all);
  put_plans(all);
  put_device(all);
  put_kept(all);
  return all;
}

Json message_schemas() {
  return {{"status", ref("CellStatus")},
          {"job", ref("Job")},
          {"procedure", ref("Procedure")},
          {"event", ref("Event")},
          {"objects", ref("ObjectUpdates")}};
}

}  // namespace sinew::server
