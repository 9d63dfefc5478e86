#!/usr/bin/env bash
# Every test: all of them in the release build, and what reads bytes of devices or files once more
# under the address and undefined-behaviour sanitizers. Closes with "N passed, N failed",
# and behind it what has passed on its second try only.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

# Rooms that read what others have written: their tests are repeated under the sanitizers, with the
# fuzz corpora that need no server. Every other test under them: make campaign PARTS=asan.
byte_rooms=(core mcu wire toml config driver program io vision)
# And every kind of device.
kind_tests() {
  local folder
  for folder in src/sinew/devices/*/; do echo "$(basename "$folder")_test"; done
}
# What these rooms test for long without reading anything from outside: plans and rendered tables.
no_bytes=(CubeRun. Foresight. CubeRows. TableTop. OpenAttitude. CubeDetection.recall_ TableThing.
  AxisLinkArm. AxisController. StepperArm. RobotArm2/ BigRobotArm/)

passed=0
failed=0
second_try=()  # tests that failed, and passed with the machine to themselves
# read_end LOG: `of` and `bad` of its caller, as ctest says them at the end; empty where it never got
# there.
read_end() {
  of=$(sed -n 's/.* tests failed out of \([0-9]*\)$/\1/p' "$logs/$1.log")
  bad=$(sed -n 's/.* \([0-9]*\) tests failed out of [0-9]*$/\1/p' "$logs/$1.log")
}

# Counts what a log says; a run that never got to its end counts as one failure.
count() {
  local of bad
  read_end "$1"
  if [[ -z $of || $of == 0 ]]; then
    failed=$((failed + 1))
    return
  fi
  passed=$((passed + of - bad))
  failed=$((failed + bad))
}

# failures_of LOG: names of the tests that ctest lists at the end.
failures_of() {
  sed -n 's/^[\t ]*[0-9]* - \(.*\) (\(Failed\|Timeout\|SEGFAULT\|Subprocess aborted\)).*/\1/p' "$1"
}

# try_alone PRESET: what failed, once more with the machine to itself, and said. Some tests run real
# processes against the clock, and a busy host may be too late for a device that waits 50 ms; what
# is broken fails again.
try_alone() {
  local log=$logs/tests-$1.log again=tests-$1-again of bad name
  failures_of "$log" | sed 's/^/    failed at first: /'
  # More than a few were not late: something is broken, and each would use up its time again.
  if (($(failures_of "$log" | wc -l) > 5)); then return 1; fi
  step "tests $1, those again" "$again" ctest --test-dir "build/$1" --rerun-failed \
    --output-on-failure --no-tests=error --timeout 900 -j 1 || true
  read_end "$again"
  if [[ -z $of ]]; then return 1; fi
  passed=$((passed + of - bad))
  failed=$((failed - of + bad))
  while read -r name; do
    second_try+=("$name ($1)")
  done < <(failures_of "$log" | grep -vxF -f <(failures_of "$logs/$again.log"; echo))
  ((bad == 0))
}

# run_tests PRESET OPTIONS...: the times of the tests stand in the log.
run_tests() {
  local preset=$1 code=0
  shift
  step "tests $preset" "tests-$preset" ctest --test-dir "build/$preset" --output-on-failure \
    --no-tests=error --timeout 900 -j "$(jobs_count)" "$@" || code=$?
  grep -E '^[0-9]+% tests passed' "$logs/tests-$preset.log" | sed 's/^/    /' || true
  grep -hE '^[0-9]+ tests and [0-9]+ random cases' build/"$preset"/Testing/Temporary/LastTest.log |
    sed 's/^/    /' || true
  count "tests-$preset"
  if ((code != 0)) && try_alone "$preset"; then code=0; fi
  return "$code"
}

# The corpora that are replayed under the sanitizers, by their programs' names.
corpora() {
  ctest --test-dir build/asan/fuzz -N 2>/dev/null | sed -n 's/^ *Test *#[0-9]*: //p' |
    grep -v '_request_'
}

# Names of the tests for the sanitizers, joined for ctest -R.
byte_tests() {
  { printf '%s_test\n' "${byte_rooms[@]}" devices; kind_tests; corpora; } | sed 's/[.+]/\\&/g' |
    paste -s -d '|' | sed 's/.*/^(&)$/'
}

# Ninja's names for what these tests need.
byte_targets() {
  printf 'src/sinew/%s/all\n' "${byte_rooms[@]}" devices
  corpora
}

# The panel's types and unit tests; where there is no node it says so and is no test.
panel_part() {
  local code=0
  scripts/panel.sh test || code=$?
  if ((code != 0)); then failed=$((failed + 1)); fi
  return "$code"
}

# Where all can be had nothing may be left out: SINEW_STRICT, set in a bare system and in the continuous integration.
nothing_left_out() {
  if [[ -z ${SINEW_STRICT-} ]]; then return 0; fi
  local missing=""
  command -v chromium >/dev/null || missing+=" chromium"
  [[ -d panel/node_modules/playwright-core ]] || missing+=" the panel"
  command -v arm-none-eabi-g++ >/dev/null || missing+=" arm-none-eabi-g++"
  [[ -e /usr/include/unicorn/unicorn.h ]] || missing+=" libunicorn"
  command -v avr-g++ >/dev/null || missing+=" avr-g++"
  [[ -e /usr/include/simavr/sim_avr.h ]] || missing+=" libsimavr"
  command -v sdcc >/dev/null || missing+=" sdcc"
  command -v sstm8 >/dev/null || command -v ucsim_stm8 >/dev/null || missing+=" sstm8"
  if [[ -z $missing ]]; then return 0; fi
  echo "  SINEW_STRICT: missing:$missing"
  failed=$((failed + 1))
  return 1
}

release_part() {
  if ! configure_release_tests || ! build release; then
    failed=$((failed + 1))
    return 1
  fi
  # Old results would speak for programs that no longer run.
  rm -rf build/release/test_results
  SINEW_FULL_RUN=1 run_tests release
}

asan_part() {
  local targets
  configure asan -DSINEW_TESTS=ON || { failed=$((failed + 1)); return 1; }
  mapfile -t targets < <(byte_targets)
  build asan "${targets[@]}" || { failed=$((failed + 1)); return 1; }
  GTEST_FILTER="-$(printf '%s*:' "${no_bytes[@]}")" run_tests asan -R "$(byte_tests)"
}

start=$(milliseconds_now)
code=0
echo "sinew: test"
scripts/packages.sh build test firmware || { echo "0 passed, 1 failed"; exit 1; }
# Without a browser the panel's tests in one are left out; CMake says so.
scripts/packages.sh browser || echo "  no browser: the panel is tested without one"
# Before the build, which puts the panel into the binary where there is one.
panel_part || code=1
nothing_left_out || code=1
release_part || code=1
asan_part || code=1
printf '  %-34s %10s\n' "in all" "$(pretty_ms $(($(milliseconds_now) - start)))"
if ((failed > 0)); then code=1; fi
echo "$passed passed, $failed failed"
if ((${#second_try[@]} > 0)); then
  echo "passed on the second try only: $(printf '%s, ' "${second_try[@]}" | sed 's/, $//')"
fi
exit "$code"
