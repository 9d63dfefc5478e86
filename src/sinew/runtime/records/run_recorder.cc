#include "sinew/runtime/records/run_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include "sinew/runtime/journal/position_record.h"

namespace sinew::runtime {
namespace {

/// The writer is called for so many samples at once, and for every event.
constexpr std::uint64_t kBatch = 16;
constexpr std::size_t kToldMax = 64;
constexpr const char* kFlightMark = "_fault-";
constexpr const char* kRunMark = "_run-";

template <class... Kinds>
Instant time_of(const std::variant<Kinds...>& entry) {
  return std::visit([](const auto& one) { return one.at; }, entry);
}

std::string safe(const std::string& text) {
  constexpr std::size_t kLongest = 32;  // both, the time and a number stay under Disk::kNameMax
  std::string result;
  for (const char c : text.substr(0, kLongest)) {
    const bool fine = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      c == '-' || c == '_';
    result += fine ? c : '-';
  }
  return result;
}

/// So that the folder never has more than `count` records with this in their names; others are left
/// alone.
DiskResult<void> keep_newest(Disk& disk, std::string_view mark, std::size_t count) {
  const auto names = disk.list();
  if (!names) return std::unexpected(names.error());
  std::vector<std::pair<std::int64_t, std::string>> records;
  for (const std::string& name : *names) {
    if (!name.ends_with(".mcap") || !name.contains(mark)) continue;
    if (const auto stamp = disk.stamp(name)) records.emplace_back(stamp->changed_ns, name);
  }
  std::ranges::sort(records);
  for (std::size_t k = 0; k + count < records.size(); ++k) {
    if (auto removed = disk.remove(records[k].second); !removed) return removed;
  }
  return {};
}

/// A second file of the same millisecond gets another name.
std::string free_name(Disk& disk, const std::string& name) {
  const std::string stem = name.substr(0, name.size() - std::string_view(".mcap").size());
  std::string result = name;
  for (int k = 2; disk.stamp(result).has_value(); ++k) result = fmt::format("{}-{}.mcap", stem, k);
  return result;
}

}  // namespace

std::string record_name(const std::string& robot, const std::string& what, std::int64_t wall_ns) {
  using namespace std::chrono;
  const sys_time<nanoseconds> wall{nanoseconds(wall_ns)};
  const auto day = floor<days>(wall);
  const year_month_day date{day};
  const hh_mm_ss time{floor<milliseconds>(wall - day)};
  return fmt::format("{}_{}_{:04}{:02}{:02}T{:02}{:02}{:02}.{:03}Z.mcap", safe(robot), safe(what),
                     static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()), time.hours().count(),
                     time.minutes().count(), time.seconds().count(), time.subseconds().count());
}

/// One file on its disk.
class RunRecorder::File {
 public:
  static io::IoResult<std::unique_ptr<File>> create(const RobotModel& robot,
                                                    const RecordPlace& place,
                                                    const RecordTitle& title) {
    auto disk = io::DiskFolder::open_folder(place.folder);
    if (!disk) return std::unexpected(disk.error());
    auto made = disk->create(place.name);
    if (!made) {
      return std::unexpected(
          io::IoError{fmt::format("{}/{}: {}", place.folder, place.name, sentence(made.error()))});
    }
    return std::unique_ptr<File>(new File(std::move(*disk), *made, place, robot, title));
  }
  ~File() { disk_.close(file_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  template <class... Kinds>
  void add(const std::variant<Kinds...>& entry) {
    if (trouble_.empty()) {
      std::visit([&](const auto& one) { encoder_.add(one); }, entry);
    } else {
      ++lost_;
    }
    if (!first_) first_ = time_of(entry);
    last_ = time_of(entry);
  }
  /// Nothing more gets into it.
  bool over() const { return !trouble_.empty() || full(); }
  bool full() const { return size_ >= size_max_; }
  RecordUnderWay under_way() const {
    return {name_, first_ ? to_seconds(last_ - *first_) : 0, size_};
  }
  void add_lost(std::uint64_t count, Instant at) { encoder_.add_lost(count, at); }
  RecordTold finish() {
    encoder_.finish();
    if (trouble_.empty()) note(disk_.sync(file_));
    return {disk_.path() + "/" + name_, std::nullopt, trouble_, lost_ + encoder_.lost(), full()};
  }
  Disk& disk() { return disk_; }

 private:
  File(io::DiskFolder disk, DiskFile file, const RecordPlace& place, const RobotModel& robot,
       const RecordTitle& title)
      : disk_(std::move(disk)),
        file_(file),
        name_(place.name),
        size_max_(place.size_max),
        encoder_(robot, title, [this](std::span<const std::uint8_t> bytes) {
          if (!trouble_.empty()) return;
          note(disk_.append(file_, bytes));
          size_ += bytes.size();
        }) {}
  void note(const DiskResult<void>& done) {
    if (!done) trouble_ = sentence(done.error());
  }

  io::DiskFolder disk_;
  DiskFile file_;
  std::string name_;
  std::uint64_t size_max_;
  std::uint64_t size_ = 0;
  std::optional<Instant> first_;
  Instant last_{};
  std::string trouble_;
  std::uint64_t lost_ = 0;
  RecordEncoder encoder_;
};

RunRecorder::RunRecorder(const RobotModel& robot, RecorderOptions options, Instant now,
                         std::int64_t wall_ns)
    : robot_(robot),
      options_(std::move(options)),
      start_(now),
      wall_ns_(wall_ns),
      next_(now),
      ring_(kRing),
      last_(now),
      thread_([this] { run(); }) {}

RunRecorder::~RunRecorder() {
  stop_ = true;
  calls_.fetch_add(1, std::memory_order_release);
  calls_.notify_one();
  thread_.join();
  if (fault_) write_flight();
  end(RecordSlot::kJob);
  end(RecordSlot::kWanted);
}

void RunRecorder::offer(const RunSample& sample) {
  next_ = std::max(next_ + kPeriod, sample.at);
  push(sample);
}

void RunRecorder::offer(const control::ControlEvent& event, Instant now) {
  push(RunEvent{now, event});
}

bool RunRecorder::push(const Entry& entry) {
  const std::uint64_t offered = offered_.load(std::memory_order_relaxed);
  if (offered - taken_.load(std::memory_order_acquire) >= kRing) {
    lost_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  ring_[offered % kRing] = entry;
  offered_.store(offered + 1, std::memory_order_release);
  if (offered % kBatch == 0 || std::holds_alternative<RunEvent>(entry)) {
    calls_.fetch_add(1, std::memory_order_release);
    calls_.notify_one();
  }
  return true;
}

void RunRecorder::run() {
  while (true) {
    // Both are read first: what was offered before a call is found by the work behind it.
    const bool stop = stop_;
    const std::uint32_t calls = calls_.load(std::memory_order_acquire);
    bool worked = false;
    {
      const std::scoped_lock lock(work_);
      worked = work();
    }
    if (worked) continue;
    if (stop) return;
    calls_.wait(calls, std::memory_order_acquire);
  }
}

bool RunRecorder::work() {
  const std::uint64_t offered = offered_.load(std::memory_order_acquire);
  std::uint64_t taken = taken_.load(std::memory_order_relaxed);
  if (taken == offered) return false;
  while (taken != offered) {
    take(ring_[taken % kRing]);
    taken_.store(++taken, std::memory_order_release);
  }
  const std::uint64_t lost = lost_.load(std::memory_order_relaxed);
  for (const auto& file : files_) {
    if (file && lost != lost_told_) file->add_lost(lost - lost_told_, last_);
  }
  lost_told_ = lost;
  auto& wanted = files_[static_cast<std::size_t>(RecordSlot::kWanted)];
  if (wanted && wanted->over()) {
    tell(wanted->finish());
    wanted.reset();
  }
  show_wanted();
  return true;
}

void RunRecorder::take(const Entry& entry) {
  last_ = time_of(entry);
  for (const auto& file : files_) {
    if (file) file->add(entry);
  }
  if (options_.flight_folder.empty()) return;
  if (fault_ && last_ - fault_->at > kBehindFault) write_flight();
  keep(entry);
  const auto* event = std::get_if<RunEvent>(&entry);
  const bool fault = event != nullptr && event->event.kind == control::ControlEvent::Kind::kLatched;
  if (fault && !fault_) fault_ = *event;
}

void RunRecorder::show_wanted() {
  const auto& wanted = files_[static_cast<std::size_t>(RecordSlot::kWanted)];
  const std::scoped_lock lock(told_mutex_);
  under_way_ = wanted ? std::optional(wanted->under_way()) : std::nullopt;
}

void RunRecorder::keep(const Entry& entry) {
  if (flight_.size() < kFlightMax) {
    flight_.push_back(entry);
    return;
  }
  flight_[flight_next_] = entry;
  flight_next_ = (flight_next_ + 1) % kFlightMax;
}

void RunRecorder::write_flight() {
  const RunEvent fault = *std::exchange(fault_, std::nullopt);
  const std::string cause(control::stop_rule(fault.event.cause).name);
  const std::string what = "fault-" + cause;
  const std::string& folder = options_.flight_folder;
  const auto cannot = [&](const std::string& sentence) {
    tell({folder, fault.event.cause, sentence, flight_.size(), false});
  };
  auto disk = io::DiskFolder::open_folder(folder);
  if (!disk) return cannot(disk.error().sentence);
  const std::string name =
      free_name(*disk, record_name(options_.robot, what, wall_ns_ + (fault.at - start_).count()));
  const RecordPlace place{folder, name, "the last 10 s before a fault: " + cause};
  auto file = File::create(robot_, place, title(place.program));
  if (!file) return cannot(file.error().sentence);
  auto look = looks_.begin();
  for (std::size_t k = 0; k < flight_.size(); ++k) {
    const Entry& entry = flight_[(flight_next_ + k) % flight_.size()];
    // What was seen last was seen long ago, where the arm has far to go.
    for (; look != looks_.end() && time_of(*look) <= time_of(entry); ++look) (*file)->add(*look);
    if (time_of(entry) >= fault.at - kBeforeFault) (*file)->add(entry);
  }
  RecordTold told = (*file)->finish();
  told.fault = fault.event.cause;
  if (const auto kept = keep_newest((*file)->disk(), kFlightMark, kFlightFilesMax);
      !kept && told.trouble.empty()) {
    told.trouble = "older ones could not be removed: " + sentence(kept.error());
  }
  tell(std::move(told));
}

RecordPlace run_place(const std::string& folder, const std::string& robot,
                      const std::string& program, std::int64_t wall_ns) {
  // Of a program's path its name says enough.
  const std::string name = std::filesystem::path(program).stem().string();
  return {folder, record_name(robot, kRunMark + 1 + name, wall_ns), program,
          RunRecorder::kRunSizeMax, true};
}

RecordTitle RunRecorder::title(const std::string& program) const {
  return {options_.robot, program, options_.library, wall_ns_, start_};
}

io::IoResult<void> RunRecorder::begin(const RecordPlace& place, RecordSlot slot) {
  end(slot);
  auto file = File::create(robot_, place, title(place.program));
  if (!file) return std::unexpected(file.error());
  if (place.of_every_run) {
    if (const auto kept = keep_newest((*file)->disk(), kRunMark, kRunFilesMax); !kept) {
      return std::unexpected(
          io::IoError{"older records could not be removed: " + sentence(kept.error())});
    }
  }
  const std::scoped_lock lock(work_);
  work();
  files_[static_cast<std::size_t>(slot)] = std::move(*file);
  show_wanted();
  return {};
}

std::optional<RecordTold> RunRecorder::end(RecordSlot slot) {
  std::optional<RecordTold> told;
  {
    const std::scoped_lock lock(work_);
    work();
    auto& file = files_[static_cast<std::size_t>(slot)];
    if (!file) return std::nullopt;
    told = file->finish();
    file.reset();
    show_wanted();
  }
  tell(*told);
  return told;
}

std::optional<RecordUnderWay> RunRecorder::under_way() const {
  const std::scoped_lock lock(told_mutex_);
  return under_way_;
}

void RunRecorder::end_flight() {
  const std::scoped_lock lock(work_);
  work();
  if (fault_) write_flight();
}

void RunRecorder::add(const RunLook& look) {
  const std::scoped_lock lock(work_);
  work();  // what was before it
  for (const auto& file : files_) {
    if (file) file->add(look);
  }
  if (options_.flight_folder.empty()) return;
  if (looks_.size() == kLooksMax) looks_.pop_front();
  looks_.push_back(look);
}

void RunRecorder::settle() {
  const std::scoped_lock lock(work_);
  work();
}

void RunRecorder::tell(RecordTold told) {
  const std::scoped_lock lock(told_mutex_);
  // Somebody who never asks has no use for the oldest.
  if (told_.size() >= kToldMax) told_.pop_front();
  told_.push_back(std::move(told));
}

std::optional<RecordTold> RunRecorder::take_told() {
  const std::scoped_lock lock(told_mutex_);
  if (told_.empty()) return std::nullopt;
  RecordTold told = std::move(told_.front());
  told_.pop_front();
  return told;
}

}  // namespace sinew::runtime
