# shellcheck shell=bash
# What the scripts of the house share: steps with times and logs. Sourced, not run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

logs=build/logs
mkdir -p "$logs"
export LC_ALL=C
# Colours and cursor games are for people; a log or a pipe gets plain lines.
if [[ -t 1 ]]; then live=yes; else live=no; fi

die() {
  printf 'sinew: %s\n' "$*" >&2
  exit 1
}

milliseconds_now() {
  local now=${EPOCHREALTIME/[.,]/}
  printf '%s' "$((now / 1000))"
}

# 61234 -> "61.2 s"
pretty_ms() {
  printf '%d.%d s' "$(($1 / 1000))" "$(($1 % 1000 / 100))"
}

# One job a core, but no more than the memory carries: the heaviest files take about 1 GB each.
jobs_count() {
  local cores memory_gb
  cores=$(nproc)
  memory_gb=$(($(sed -n 's/^MemAvailable: *\([0-9]*\).*/\1/p' /proc/meminfo) / 1000000))
  if ((memory_gb < 1)); then memory_gb=1; fi
  echo "$((cores < memory_gb ? cores : memory_gb))"
}

# The last "[12/345]" of a build or "12/45 Test" of a ctest run.
progress_of() {
  tail -c 2000 "$1" 2>/dev/null | tr '\r' '\n' |
    sed -n -e 's/^\[\([0-9]*\/[0-9]*\)\].*/\1/p' -e 's/^ *\([0-9]*\/[0-9]*\) Test .*/\1/p' | tail -n 1
}

# While process $1 runs, shows how far log $3 has come: all the time to people, each half minute
# to a log.
watch_progress() {
  local process=$1 title=$2 log=$3 ticks=0 state
  while kill -0 "$process" 2>/dev/null; do
    sleep 0.2
    ticks=$((ticks + 1))
    if [[ $live == yes && $((ticks % 5)) == 0 ]]; then
      printf '\r  %-34s %10s ' "$title" "$(progress_of "$log")"
    elif [[ $live == no && $((ticks % 150)) == 0 ]]; then
      state=$(progress_of "$log")
      printf '  %-34s %10s\n' "$title" "${state:-still at it}"
    fi
  done
}

# step TITLE LOG COMMAND...: runs the command with its output in build/logs/LOG.log and prints one
# line with the time. On failure prints the last lines, names the log and returns the exit code.
step() {
  local title=$1 log=$logs/$2.log start code=0 process took
  shift 2
  start=$(milliseconds_now)
  # A process group of its own, so that Ctrl-C ends the compilers too and not only this script.
  set -m
  "$@" >"$log" 2>&1 </dev/null &
  process=$!
  set +m
  trap 'kill -TERM -- "-$process" 2>/dev/null; printf "\n"; die "interrupted"' INT TERM
  watch_progress "$process" "$title" "$log"
  wait "$process" || code=$?
  trap - INT TERM
  took=$(($(milliseconds_now) - start))
  if [[ $live == yes ]]; then printf '\r'; fi
  if ((code == 0)); then
    printf '  %-34s %10s\n' "$title" "$(pretty_ms "$took")"
    return 0
  fi
  printf '  %-34s %10s  FAILED (exit %d)\n' "$title" "$(pretty_ms "$took")" "$code"
  explain_failure "$log"
  return "$code"
}

# The lines of a log that say what went wrong: the compiler's errors where there are any, else the
# end.
explain_failure() {
  local found
  # What a GoogleTest or a test in the browser says stands below its name.
  found=$(
    grep -nE '(error:|FAILED|\*\*\*Failed|CMake Error)' "$1" | head -n 12 || true
    grep -nE -A 12 '(^ *not ok|Failure$|AssertionError)' "$1" | head -n 40 || true
  )
  if [[ -n $found ]]; then
    printf '%s\n' "$found" | cut -c 1-300 | sed 's/^/    /'
    printf '    ...\n'
  fi
  # Compiler command lines say nothing that the error does not.
  tail -n 15 "$1" | grep -v '^/usr/bin/' | cut -c 1-300 | sed 's/^/    /' || true
  printf '  full log: %s\n' "$1"
}

installed() {
  dpkg-query -W -f '${db:Status-Status}\n' "$@" 2>/dev/null
}

# True where every one of the Debian packages is installed.
have_packages() {
  local package
  command -v dpkg-query >/dev/null || return 1
  for package in "$@"; do
    [[ $(installed "$package") == *installed* ]] || return 1
  done
}

cached() {
  sed -n "s/^$2:[A-Z]*=//p" "build/$1/CMakeCache.txt" 2>/dev/null || true
}

# keep_toggle PRESET OPTION PACKAGES...: prints -DOPTION=ON where the tree was configured so before
# and can still be. Turning a toggle off would make ninja delete what it had built.
keep_toggle() {
  local preset=$1 option=$2
  shift 2
  if [[ $(cached "$preset" "$option") == ON ]] && have_packages "$@"; then
    echo "-D$option=ON"
  else
    echo "-D$option=OFF"
  fi
}

# configure PRESET OPTIONS...
configure() {
  local preset=$1
  shift
  step "configure $preset" "configure-$preset" cmake --preset "$preset" "$@"
}

# The release build with its tests; benchmarks stay where they were configured.
configure_release_tests() {
  configure release -DSINEW_TESTS=ON "$(keep_toggle release SINEW_BENCH libbenchmark-dev)"
}

# build PRESET TARGETS...: all targets where none is named.
build() {
  local preset=$1
  shift
  local targets=()
  if (($# > 0)); then targets=(--target "$@"); fi
  step "build $preset" "build-$preset" \
    cmake --build "build/$preset" -j "$(jobs_count)" "${targets[@]}"
}
