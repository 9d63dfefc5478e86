#!/usr/bin/env bash
# The long checks. Each part runs even where one before it failed; the end says which did.
#   FUZZ_SECONDS  for each fuzz target (60)
#   SEEDS         runs of all tests with a fresh seed (5)
#   SINEW_FAULTS  injected into each wire (1000000)
#   SINEW_SEQUENCES  of plan, jog, override, pause and stop, on all robots together (1000000)
#   SINEW_KILLS   -9 of real processes, of each of two robots (1000)
#   SINEW_OUTAGES of hosts and machines that are killed, cut off, suspended or run full, of each of
#                 seven robots and wires (1430)
#   SINEW_POWER_LOSSES  of the position journal (100000)
#   SINEW_SEEDS   of the whole system in virtual time (100000)
#   SINEW_TRACE_SEEDS  compared between g++ and clang (200)
#   SINEW_CELLS   with a camera and cubes, from the picture to the basket (500), from the seed
#                 SINEW_FIRST on (1)
#   SOAK_MINUTES  of the demonstration, whose memory must not grow (30)
#   PARTS         which of: format tidy asan tsan fuzz seeds faults motion losses kills outages system trace latency flood soak cubes browser (all)
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

fuzz_seconds=${FUZZ_SECONDS:-60}
seeds=${SEEDS:-5}
faults=${SINEW_FAULTS:-1000000}
sequences=${SINEW_SEQUENCES:-1000000}
losses=${SINEW_POWER_LOSSES:-100000}
kills=${SINEW_KILLS:-1000}
outages=${SINEW_OUTAGES:-1430}
system_seeds=${SINEW_SEEDS:-100000}
trace_seeds=${SINEW_TRACE_SEEDS:-200}
cells=${SINEW_CELLS:-500}
soak_minutes=${SOAK_MINUTES:-30}
parts=${PARTS:-format tidy asan tsan fuzz seeds faults motion losses kills outages system trace latency flood soak cubes browser}
# Only their own parts ask for so many.
unset SINEW_FAULTS SINEW_SEQUENCES SINEW_POWER_LOSSES SINEW_KILLS SINEW_OUTAGES SINEW_SEEDS SINEW_CELLS

run_ctest() {
  local preset=$1 title=$2 log=$3
  shift 3
  step "$title" "$log" ctest --test-dir "build/$preset" --output-on-failure --no-tests=error \
    -j "$(jobs_count)" "$@"
}

format_part() { scripts/format.sh --check; }

# Warnings are errors in every preset, so building is the check. Of the tests those are run that
# ask something of the compiler itself.
tidy_part() {
  configure tidy -DSINEW_TESTS=ON && build tidy &&
    run_ctest tidy "tests tidy" tests-tidy -R '^must_not_compile'
}

asan_part() {
  configure asan -DSINEW_TESTS=ON && build asan && run_ctest asan "tests asan" tests-asan
}

tsan_part() {
  configure tsan -DSINEW_TESTS=ON && build tsan && run_ctest tsan "tests tsan" tests-tsan
}

# New finds go to build/corpus/, so that a campaign changes nothing in the tree; an input that
# breaks something is left in build/findings/.
fuzz_one() {
  local program=$1 name found=build/corpus findings=build/findings
  name=$(basename "$program")
  local own=fuzz/corpus/${name%_fuzz}
  mkdir -p "$found/$name" "$findings"
  local corpora=("$found/$name")
  if [[ -d $own ]]; then corpora+=("$own"); fi
  step "fuzz $name" "fuzz-$name" "$program" "-max_total_time=$fuzz_seconds" -print_final_stats=1 \
    "-artifact_prefix=$findings/$name-" "${corpora[@]}"
}

fuzz_part() {
  local programs program code=0
  configure fuzz && build fuzz || return 1
  mapfile -t programs < <(find build/fuzz -name '*_fuzz' -type f -executable | sort)
  if ((${#programs[@]} == 0)); then
    echo "  no program called *_fuzz was built"
    return 1
  fi
  for program in "${programs[@]}"; do fuzz_one "$program" || code=1; done
  return "$code"
}

seeds_part() {
  local i code=0
  configure_release_tests && build release || return 1
  for ((i = 1; i <= seeds; ++i)); do
    SINEW_SEED=$((RANDOM << 30 | RANDOM << 15 | RANDOM))
    export SINEW_SEED
    run_ctest release "tests with SINEW_SEED=$SINEW_SEED" "seed-$SINEW_SEED" || code=1
  done
  unset SINEW_SEED
  return "$code"
}

# side_by_side TITLE PROGRAM SUITE VARIABLE=NUMBER: every test of the suite by itself.
side_by_side() {
  local title=$1 program=build/release/tests/$2 suite=$3 many=$4
  configure_release_tests && build release || return 1
  local names name code=0 running=0
  mapfile -t names < <("$program" --gtest_list_tests "--gtest_filter=$suite.*" |
    awk '/^  / { print $1 }')
  if ((${#names[@]} == 0)); then
    echo "  $2 has no test called $suite.*"
    return 1
  fi
  for name in "${names[@]}"; do
    if ((running >= $(jobs_count))); then
      wait -n || code=1
      running=$((running - 1))
    fi
    (live=no && step "$title ${name##*/}" "$title-${name//\//-}" env "$many" \
      "$program" "--gtest_filter=$suite.$name") &
    running=$((running + 1))
  done
  while ((running > 0)); do
    wait -n || code=1
    running=$((running - 1))
  done
  return "$code"
}

faults_part() { side_by_side faults faults_test Faults "SINEW_FAULTS=$faults"; }
motion_part() { side_by_side motion sequences_test '*Sequences' "SINEW_SEQUENCES=$sequences"; }
losses_part() { side_by_side losses runtime_test JournalLosses "SINEW_POWER_LOSSES=$losses"; }
kills_part() { side_by_side kills crash_test '*Kills' "SINEW_KILLS=$kills"; }
outages_part() { side_by_side outages crash_test '*Outages' "SINEW_OUTAGES=$outages"; }

# The processor's other work is the matter here, so nothing runs beside it.
latency_part() {
  configure_release_tests && build release sinew &&
    step "stops in real time" stop-latency /usr/bin/env python3 tests/latency/stop_latency.py \
      build/release/sinew 100 && cat "$logs/stop-latency.log"
}

flood_part() {
  build release sinew &&
    step "a flood of clients" flood /usr/bin/python3 tests/web/flood.py build/release/sinew 15 &&
    cat "$logs/flood.log" &&
    step "stops in a flood of viewers" stop-flood /usr/bin/python3 tests/latency/stop_flood.py \
      build/release/sinew && cat "$logs/stop-flood.log"
}

soak_part() {
  build release sinew &&
    step "soak, $soak_minutes min" soak /usr/bin/python3 tests/web/load_test.py --soak \
      build/release/sinew "$soak_minutes" && cat "$logs/soak.log"
}

cubes_part() {
  configure_release_tests && build release &&
    step "$cells cells with cubes" cubes env "SINEW_CELLS=$cells" build/release/tests/cubes_test \
      --gtest_filter='CubeCampaign.*' && grep '^  ' "$logs/cubes.log"
}

# Every test of the panel in a browser, those of make test too.
browser_part() {
  local file code=0
  scripts/packages.sh browser && scripts/panel.sh && configure_release_tests &&
    build release sinew || return 1
  for file in tests/panel/*_test.mjs; do
    step "browser $(basename "$file" _test.mjs)" "browser-$(basename "$file" .mjs)" \
      node --test "$file" || code=1
  done
  return "$code"
}

# A stretch of the seeds for each core, in the last one supplies sink as well; a seed that fails is
# told with as little as still fails.
system_part() {
  configure_release_tests && build release || return 1
  local jobs share k code=0 pids=() supplies
  jobs=$(jobs_count)
  share=$(((system_seeds + jobs - 1) / jobs))
  for ((k = 0; k < jobs; ++k)); do
    supplies=()
    if ((k == jobs - 1)); then supplies=(--supplies); fi
    (live=no && step "system, stretch $((k + 1))" "system-$((k + 1))" build/release/tests/sinew-sim \
      "${supplies[@]}" --seeds "$((k * share + 1))..$(((k + 1) * share))") &
    pids+=($!)
  done
  for k in "${pids[@]}"; do wait "$k" || code=1; done
  return "$code"
}

# The same seeds are the same runs, to the last byte and event, whoever compiled them.
trace_part() {
  local preset
  configure_release_tests && configure clang -DSINEW_TESTS=ON || return 1
  for preset in release clang; do
    build "$preset" sinew-sim || return 1
    step "trace $preset" "trace-$preset" sh -c \
      "build/$preset/tests/sinew-sim --seeds 1..$trace_seeds --hashes > build/trace-$preset.txt" ||
      return 1
  done
  if ! cmp build/trace-release.txt build/trace-clang.txt; then
    echo "  g++ and clang do not agree; build/trace-*.txt"
    return 1
  fi
}

echo "sinew: campaign ($parts)"
scripts/packages.sh build test campaign
start=$(milliseconds_now)
failed=()
for part in $parts; do
  declare -F "${part}_part" >/dev/null || die "no part of the campaign is called $part"
  "${part}_part" || failed+=("$part")
done
printf '  %-34s %10s\n' "in all" "$(pretty_ms $(($(milliseconds_now) - start)))"
if ((${#failed[@]} > 0)); then
  echo "campaign failed in: ${failed[*]}"
  exit 1
fi
echo "campaign clean"
