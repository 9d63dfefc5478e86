#include "firmware/emulation_stm8/chip_model.h"

#include <string_view>
#include <utility>
#include <vector>

namespace sinew::emulation {
namespace {

using Statements = std::vector<std::string>;

/// Registers as the rules below name them: as the chip has them, without breakpoints.
constexpr std::pair<std::string_view, std::string_view> kRegisters[] = {
    {"CR2", "io_chip[0x211]"},   {"DR", "io_chip[0x216]"},    {"SR1", "io_chip[0x217]"},
    {"SR2", "io_chip[0x218]"},   {"UART", "io_chip[0x231]"},  {"PORTA", "io_chip[0x000]"},
    {"PORTB", "io_chip[0x005]"}, {"PORTD", "io_chip[0x00f]"}, {"KEY", "io_chip[0x0e0]"},
    {"TIMER", "io_chip[0x344]"},
};

constexpr std::string_view kVariables[] = {
    "m_at",     // clock at which the flags come
    "m_sr1",    // flags that SR1 gets then
    "m_sr2",    // flags that SR2 gets then
    "m_stop",   // clock at which a stop condition is over
    "m_begin",  // a start condition, or its byte
    "m_read",   // the address byte asked for reading
    "m_pointer", "m_byte", "m_now", "m_reading",
    // What the test sets: chip and bus, STATUS, and the shaft in ticks and 2^-20 ticks a clock.
    "m_present", "m_held", "m_status", "m_base", "m_ahead", "m_back", "m_since",
    "m_fault",  // steps of a reading that are forbidden
    "m_fed",    // clock at which the watchdog was fed
};

std::string expanded(std::string text) {
  for (const auto& [name, cell] : kRegisters) {
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos; at += cell.size()) {
      text.replace(at, name.size(), cell);
    }
  }
  return text;
}

/// Before an access. The condition is 0, so nothing stops.
std::string before(std::string_view access, const std::string& assignment) {
  return "break rom " + std::string(access) + " if \"" + expanded("(" + assignment + ")*0") +
         "\"\n";
}

/// Behind the instruction of an access; the chip runs on.
std::string behind(const std::string& access, const Statements& statements) {
  std::string text = "break rom " + access + "\ncommands ";
  for (const std::string& statement : statements) text += expanded(statement) + ";";
  return text + "run\n";
}

/// An event with the value of a register; first bit 28, which no other number here has.
std::string note(const std::string& access, char act, const std::string& value) {
  return behind(access, {std::string("(0x1") + act + "000000+" + value + ")", "sim_ticks"});
}

// The console's language: both branches of ?: are evaluated, so an assignment cannot be in one. A
// bit takes 42 clocks (381 kHz), a byte with its acknowledge 378.

/// RM0016 21.4.2, as master.
std::string bus() {
  std::string text;
  text += before("r 0x5217", "SR1=SR1|((sim_ticks>=m_at)*m_sr1)");
  text += before("r 0x5218", "SR2=SR2|((sim_ticks>=m_at)*m_sr2)");
  text += before("r 0x5211", "CR2=CR2&(255-2*(sim_ticks>=m_stop))");
  // CR1: off or on.
  text += behind("w 0x5210", {"SR1=0", "SR2=0", "CR2=0", "m_sr1=0", "m_sr2=0"});
  // CR2: a start, unless the bus is held; a stop.
  text +=
      behind("w 0x5211", {"m_begin=CR2&1", "m_at=m_begin?sim_ticks+40:m_at",
                          "m_sr1=m_begin?(1-m_held):m_sr1", "SR1=m_begin?0:SR1",
                          "m_stop=(CR2&2)?sim_ticks+100:m_stop", "0x12000000+CR2", "sim_ticks"});
  // DR is written: behind a start an address, which is acknowledged or not; else a pointer.
  text += behind("w 0x5216",
                 {"m_begin=SR1&1", "m_now=m_present*((DR>>1)==0x36)", "m_at=sim_ticks+378",
                  "m_sr1=m_begin?(2*m_now):0x84", "m_sr2=m_begin?(4-4*m_now):0",
                  "m_read=m_begin?(DR&1):m_read", "m_pointer=m_begin?m_pointer:DR", "SR1=0"});
  return text;
}

std::string reading() {
  std::string text;
  // SR3: the bus goes on. The chip takes STATUS and angle of this moment; two bytes later the clock
  // is held.
  text += behind(
      "r 0x5219",
      {"m_at=sim_ticks+756", "m_sr1=m_read*0x44", "SR1=0x80-0x80*m_read", "m_now=sim_ticks-m_since",
       "m_reading=(m_base+((m_now*m_ahead)>>20)-((m_now*m_back)>>20))&4095", "m_byte=0",
       "m_fault=m_fault+m_read*(m_pointer!=0x0b)", "DR=m_read?m_status:DR",
       "m_read*(0x11000000+m_status*4096+m_reading)", "sim_ticks"});
  // DR is read; a write of it reads it too, which is none. Wrong are: a byte that is taken before
  // the clock is held; an acknowledge of the last one; the second one without a stop, or more than
  // a bit behind it.
  text += behind(
      "r 0x5216",
      {"m_now=m_read*(1-(SR1&1))", "m_byte=m_byte+m_now",
       "m_fault=m_fault+m_now*((m_byte<3)*((SR1&4)==0)+(m_byte==1)*((CR2&4)>>2))",
       "m_fault=m_fault+m_now*(m_byte==2)*((1-((CR2&2)>>1))+(sim_ticks>m_stop-100+42))",
       "DR=m_now?((m_byte==1)?(m_reading>>8):(m_reading&255)):DR", "m_at=m_now?sim_ticks+378:m_at",
       "m_sr1=m_now?((m_byte==1)*0x44+(m_byte==2)*0x40):m_sr1", "SR1=m_now?((m_byte<3)*0x40):SR1"});
  return text;
}

/// The image's 64 ms, looked at each millisecond.
std::string watchdog() {
  const std::string late = "sim_ticks>m_fed+1024000";
  return behind("w 0x50e0", {"m_fed=sim_ticks", "0x17000000+KEY", "sim_ticks"}) +
         behind("w 0x5344 if \"" + late + "\"", {"m_fed=200000000", "(0x1a000000)", "sim_ticks"});
}

}  // namespace

std::string model_commands() {
  std::string text;
  for (const std::string_view name : kVariables) text += "var " + std::string(name) + "\n";
  text += "m_present=1\nm_status=32\n" + bus() + reading() + watchdog();
  text += note("w 0x5231", '3', "UART") + note("r 0x5231", '4', "UART");
  text += note("w 0x500f", '5', "PORTD") + note("w 0x5005", '6', "PORTB");
  text += note("w 0x5000", '8', "PORTA") + note("w 0x5344", '9', "TIMER");
  return text;
}

std::string model_start_commands() {
  // The stack begins where the chip has it, and may take a quarter of the RAM.
  return "SP=0x3ff\nsp_limit=0x300\nuart1_check_often=1\nfill io_chip 0x210 0x21d 0\n"
         "m_at=0\nm_sr1=0\nm_sr2=0\nm_stop=0\nm_fed=sim_ticks\n";
}

}  // namespace sinew::emulation
