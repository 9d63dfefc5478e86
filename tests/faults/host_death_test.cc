#include <gtest/gtest.h>

#include <chrono>
#include <memory>

#include "sinew/devices/axis_registers/axis_registers_driver.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "sinew/devices/kinds.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/property.h"
#include "support/robots.h"

// A host that dies in the middle of a register transaction leaves a board that waits for ever. The
// next host must get it back without anybody cutting its power.

namespace sinew::test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t kSyn = 0x97;
constexpr int kTransfers = 7;  // of one transaction
constexpr std::uint8_t kRead = 1;
constexpr std::uint8_t kWrite = 2;
constexpr std::size_t kOperationAt = 4;
constexpr Duration kCall = 20us;

/// One host after the other on the same six boards.
class RegisterHosts {
 public:
  explicit RegisterHosts(const std::string& profile)
      : robot_(*runtime::variant_of(robot("robot-arm-2"), profile, "registers")),
        machine_(std::move(
            make_machine(robot_, {.profile = profile, .seed = seed()}, Instant{}).value().spi)) {
    new_host();
  }

  void new_host() {
    driver = std::make_unique<AxisRegistersDriver>(
        robot_.device.settings.get<AxisRegistersDevice>(), robot_.joints);
    place_ = 0;
    events_ = {};
  }

  /// Until that event came; false after `limit`.
  bool run_to(DriverEvent::Kind kind, Duration limit) {
    for (const Instant end = now + limit; now < end;) {
      step(end);
      while (const auto event = driver->take_event())
        ++events_[static_cast<std::size_t>(event->kind)];
      if (events_[static_cast<std::size_t>(kind)] > 0) return true;
    }
    return false;
  }

  /// Until a transaction of that kind was begun, and is over: more of its kind follow.
  bool run_to_operation(std::uint8_t operation, Duration limit) {
    operation_ = 0;
    for (const Instant end = now + limit; now < end && operation_ != operation;) step(end);
    return operation_ == operation;
  }

  /// Until the host dies: in the `place`-th transfer of a transaction, before its last byte where
  /// `half` is set. False where there was none within `limit`.
  bool run_to_death(int place, bool half, Duration limit) {
    while (place_ != 0) step(now + 1s);  // not in the middle of one
    for (const Instant end = now + limit; now < end;) {
      if (const auto transfer = next_transfer(end)) {
        count(*transfer);
        if (place_ == place) {
          if (half) die_within(*transfer);
          if (!half) exchange(*transfer);
          return true;
        }
        exchange(*transfer);
      }
    }
    return false;
  }

  bool all_boards_answer() const {
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
      if (driver->axis_fault(i)) return false;
    }
    return true;
  }
  /// Operation of the last header that was sent.
  std::uint8_t operation() const { return operation_; }

  std::unique_ptr<AxisRegistersDriver> driver;
  Instant now{1s};

 private:
  std::optional<spi::Transfer> next_transfer(Instant end) {
    driver->poll(now);
    if (auto transfer = driver->take_transfer(now)) return transfer;
    const Instant due = driver->next_deadline().value_or(end);
    now = std::min(end, std::max(now + 1us, due));
    machine_->advance(now);
    return {};
  }
  void step(Instant end) {
    if (const auto transfer = next_transfer(end)) {
      count(*transfer);
      exchange(*transfer);
    }
  }
  void count(const spi::Transfer& transfer) {
    const bool begins = transfer.mosi.size() == 1 && transfer.mosi[0] == kSyn;
    place_ = begins ? 1 : place_ > 0 ? (place_ + 1) % (kTransfers + 1) : 0;
    if (transfer.mosi.size() == axis_registers::kHeaderSize) {
      operation_ = transfer.mosi[kOperationAt];
    }
  }
  void exchange(const spi::Transfer& transfer) {
    const spi::Bytes miso = machine_->exchange(transfer, now);
    now += transfer.setup + spi::wire_time(transfer) + kCall;
    machine_->advance(now);
    driver->exchanged({miso.data(), miso.size()}, now);
    if (place_ == kTransfers) place_ = 0;
  }
  void die_within(spi::Transfer transfer) {
    transfer.mosi.resize(transfer.mosi.size() - 1);
    static_cast<void>(machine_->exchange(transfer, now));
  }

  RobotModel robot_;
  std::unique_ptr<sim::SpiMachine> machine_;
  int place_ = 0;  ///< of the transfer under way in its transaction, 1..7
  std::uint8_t operation_ = 0;
  std::array<int, 8> events_{};
};

class HostDeath : public ::testing::TestWithParam<const char*> {};

TEST_P(HostDeath, in_any_transfer_of_a_transaction_leaves_boards_that_the_next_host_gets_back) {
  int deaths = 0;
  for (const bool write : {false, true}) {
    for (int place = 1; place <= kTransfers; ++place) {
      for (const bool half : {false, true}) {
        SCOPED_TRACE(testing::Message() << (write ? "WRITE" : "READ") << ", transfer " << place
                                        << (half ? ", cut" : ""));
        RegisterHosts hosts(GetParam());
        hosts.driver->open(hosts.now);
        ASSERT_TRUE(hosts.run_to(DriverEvent::Kind::kReady, 20s));
        if (write) {
          ASSERT_TRUE(hosts.driver->clear_fault(hosts.now));
        }
        ASSERT_TRUE(hosts.run_to_operation(write ? kWrite : kRead, 5s));
        ASSERT_TRUE(hosts.run_to_death(place, half, 5s));
        if (place >= 5) {
          EXPECT_EQ(hosts.operation(), write ? kWrite : kRead)
              << "the death was meant for the other one";
        }
        ++deaths;
        hosts.now += 3s;
        hosts.new_host();
        const Instant opened = hosts.now;
        hosts.driver->open(hosts.now);
        ASSERT_TRUE(hosts.run_to(DriverEvent::Kind::kReady, 10s));
        EXPECT_LT(hosts.now - opened, 4s);
        EXPECT_TRUE(hosts.all_boards_answer());
        ASSERT_TRUE(hosts.driver->clear_fault(hosts.now));
        EXPECT_TRUE(hosts.run_to(DriverEvent::Kind::kDone, 10s)) << "boards take no more WRITE";
      }
    }
  }
  EXPECT_EQ(deaths, 28);
}

INSTANTIATE_TEST_SUITE_P(Profiles, HostDeath, ::testing::Values("document", "as-built"),
                         [](const auto& each) {
                           return each.index == 0 ? std::string("document")
                                                  : std::string("as_built");
                         });

}  // namespace
}  // namespace sinew::test
