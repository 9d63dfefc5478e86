#pragma once

#include <atomic>
#include <cstdint>
#include <expected>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/runtime/cell_settings.h"
#include "sinew/runtime/journal/text_shelf.h"
#include "sinew/runtime/records/kept_records.h"
#include "sinew/runtime/running_cell.h"
#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// What a cell keeps for its people: records, and for each kind of robot programs and points, in
/// the very files that `sinew run` reads. Waits for disks; for one thread, but for what says
/// otherwise.
class Keeper {
 public:
  using Result = std::expected<Json, RpcError>;
  /// Bytes of one answer of read_record() and read_csv().
  static constexpr std::size_t kPart = std::size_t{256} << 10;

  /// @param cell, settings  outlive this; null: nothing can be set
  Keeper(const runtime::RunningCell& cell, runtime::CellSettings* settings);

  /// Goes up with each change of what is kept, so that whoever shows it asks again. Any thread.
  std::uint64_t changes() const { return changes_; }

  // keeper_records.cc
  Result list_records();
  /// Of a record's bytes, or of its samples as CSV.
  Result read_record(const std::string& record, std::uint64_t offset);
  Result read_csv(const std::string& record, std::uint64_t offset);
  Result remove_record(const std::string& record);
  Result start_record(std::size_t robot, const std::string& title);
  Result stop_record(std::size_t robot);

  // keeper_texts.cc; programs and points of the kind of robot that this one is
  Result list_programs(std::size_t robot);
  Result load_program(std::size_t robot, const std::string& name);
  Result save_program(std::size_t robot, const std::string& name, const std::string& text,
                      std::uint64_t revision);
  Result remove_program(std::size_t robot, const std::string& name, std::uint64_t revision);
  Result list_points(std::size_t robot);
  /// @param toml  of a file of points: those that are put into the kept one
  Result save_points(std::size_t robot, const std::string& toml, std::uint64_t revision);
  Result remove_point(std::size_t robot, const std::string& name, std::uint64_t revision);
  Result rename_point(std::size_t robot, const std::string& name, const std::string& to,
                      std::uint64_t revision);

  // keeper_settings.cc
  Result get_settings(std::size_t robot);
  Result check_settings(std::size_t robot, const runtime::RobotSettings& settings) const;
  /// @param settings  none: its own files count again
  Result set_settings(std::size_t robot, const runtime::RobotSettings& settings,
                      std::uint64_t revision);

  /// Whatever is kept of a kind of robot, for a check. Any thread.
  /// @error  a sentence
  std::expected<std::string, std::string> kept_program(std::size_t robot,
                                                       std::string_view name) const;
  /// Empty where there are none.
  std::expected<std::string, std::string> kept_points(std::size_t robot) const;

 private:
  using Changed = std::expected<std::string, std::vector<Complaint>>;

  std::string record_being_written(const std::string& name) const;
  std::string shelf_folder(std::size_t robot) const;
  Result at_shelf(std::size_t robot, const std::function<Result(runtime::TextShelf&)>& work) const;
  Result change_points(std::size_t robot, std::uint64_t revision,
                       const std::function<Changed(const std::string& toml)>& change);
  Json points_json(std::size_t robot, const std::string& toml, std::uint64_t revision,
                   const TaughtPoints& points) const;

  const runtime::RunningCell& cell_;
  runtime::KeptRecords records_;
  runtime::CellSettings* settings_;
  std::vector<runtime::RobotSettings> running_;  ///< what was set when the cell began
  std::atomic<std::uint64_t> changes_ = 0;
  /// The last one that was asked for: it is asked for part by part.
  struct Csv {
    std::string record;
    std::uint64_t size = 0;  ///< of the record that it was made of
    std::string text;
  } csv_;
};

}  // namespace sinew::server
