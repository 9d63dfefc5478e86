#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "sinew/core/error_code.h"
#include "sinew/io/disk_folder.h"
#include "sinew/io/port.h"
#include "sinew/io/port_identity.h"
#include "sinew/runtime/journal/port_claims.h"
#include "sinew/runtime/station.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

/// A running station whose robot is plugged in later, and pulled out and plugged in again.
namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

class PluggedInLater : public ::testing::Test {
 protected:
  static const RobotModel& arm() { return test::robot("learm"); }

  static io::Port adapter() {
    auto port = io::Port::open_pseudo_terminal();
    EXPECT_TRUE(port);
    return std::move(*port);
  }
  void plug(const io::Port& adapter) const { fs::create_symlink(adapter.path(), path_); }
  void unplug() const { fs::remove(path_); }

  std::unique_ptr<Station> start(const std::optional<std::string>& journal) {
    StationOptions options;
    options.name = "learm";
    options.port = path_;
    options.journal = journal;
    options.journal_folder = positions_;
    auto station = Station::start(arm(), std::move(options), clock_);
    EXPECT_TRUE(station) << station.error().sentence;
    return station ? std::move(*station) : nullptr;
  }
  std::vector<std::string> owners(const io::Port& adapter) const {
    auto disk = io::DiskFolder::open_folder(positions_);
    return PortClaims(*disk, io::port_identities(adapter.path()), arm().id).owners();
  }
  /// Real time: a port is tried each second.
  template <class Condition>
  static bool soon(Condition condition) {
    const io::Clock clock;
    while (!condition() && clock.now() < Instant{} + 20s) clock.pause(5ms);
    return condition();
  }

  test::ScratchFolder folder_;
  std::string path_ = folder_.at("arm");
  std::string positions_ = folder_.at("positions");
  io::Clock clock_;
};

TEST_F(PluggedInLater, its_journal_follows_it_unless_another_one_did) {
  const io::Port theirs = adapter();
  const io::Port ours = adapter();
  ASSERT_TRUE(PositionRecord::open(positions_, "b", arm(), theirs.path()));
  const auto station = start("a");
  ASSERT_TRUE(station);
  EXPECT_NE(station->trouble(), "");
  plug(theirs);
  ASSERT_TRUE(soon([&] { return station->trouble().find("'b' followed") != std::string::npos; }))
      << station->trouble();
  EXPECT_FALSE(station->view().port_open);
  EXPECT_EQ(owners(theirs), std::vector<std::string>{"b"});
  EXPECT_TRUE(io::Port::open_serial(theirs.path(), 9600)) << "others may have it";
  unplug();
  plug(ours);
  ASSERT_TRUE(soon([&] { return station->view().port_open; })) << station->trouble();
  EXPECT_EQ(owners(ours), std::vector<std::string>{"a"});
}

TEST_F(PluggedInLater, what_moves_without_a_journal_is_forgotten_under_its_own_names) {
  const io::Port theirs = adapter();
  ASSERT_TRUE(PositionRecord::open(positions_, "b", arm(), theirs.path()));
  const auto station = start(std::nullopt);
  ASSERT_TRUE(station);
  const auto slot = station->take_slot();
  const auto give = [&] {
    return station->post({station->next_id(*slot), {}, control::Resume{}}, 0);
  };
  EXPECT_TRUE(give()) << "there is nothing yet";
  EXPECT_EQ(owners(theirs), std::vector<std::string>{"b"});
  plug(theirs);
  ASSERT_TRUE(soon([&] { return station->view().port_open; })) << station->trouble();
  EXPECT_EQ(owners(theirs), std::vector<std::string>{"b"}) << "nothing has moved it";
  EXPECT_TRUE(give());
  EXPECT_EQ(owners(theirs), std::vector<std::string>{""});
}

TEST_F(PluggedInLater, where_that_cannot_be_written_nothing_moves_and_the_reason_is_told) {
  const io::Port theirs = adapter();
  ASSERT_TRUE(PositionRecord::open(positions_, "b", arm(), theirs.path()));
  plug(theirs);
  const auto station = start(std::nullopt);
  ASSERT_TRUE(station);
  fs::rename(positions_, folder_.at("elsewhere"));
  {
    std::ofstream(positions_) << "a file where the folder was";
  }
  const auto slot = station->take_slot();
  const auto given = station->post({station->next_id(*slot), {}, control::Resume{}}, 0);
  ASSERT_FALSE(given);
  EXPECT_EQ(given.error().code, ErrorCode::kNotRecorded);
}

}  // namespace
}  // namespace sinew::runtime
