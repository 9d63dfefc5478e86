#!/bin/sh
# side_by_side.sh PROGRAM SHARDS RESULTS: the tests of one GoogleTest program as so many processes at
# once, for tests that mostly wait. Leaves RESULTS.1.json, RESULTS.2.json, ... A few that fail are
# repeated alone, with RESULTS.again.json: devices wait 50 ms for programs that wait for a processor.
program=$1 shards=$2 results=$3
shift 3
alone_max=3
mkdir -p "$(dirname "$results")"
rm -f "$results.again.json"
running=
shard=0
while [ "$shard" -lt "$shards" ]; do
  shard=$((shard + 1))
  GTEST_TOTAL_SHARDS=$shards GTEST_SHARD_INDEX=$((shard - 1)) \
    "$program" --gtest_output="json:$results.$shard.json" "$@" >"$results.$shard.log" 2>&1 &
  running="$running $!"
done
code=0
failed=
shard=0
for process in $running; do
  shard=$((shard + 1))
  good=0
  wait "$process" || good=$?
  cat "$results.$shard.log"
  if [ "$good" -eq 0 ]; then continue; fi
  # Its last lines name them; where there are none it died.
  names=$(sed -n '/tests\{0,1\}, listed below:$/,$s/^\[  FAILED  \] \([^ ,]*\.[^ ,]*\).*$/\1/p' \
    "$results.$shard.log")
  if [ -z "$names" ]; then code=1; fi
  failed="$failed $names"
done
rm -f "$results".*.log
# shellcheck disable=SC2086
set -- $failed
if [ $# -eq 0 ]; then exit $code; fi
if [ "$code" -ne 0 ] || [ $# -gt $alone_max ]; then exit 1; fi
echo "failed side by side, once more alone: $*"
exec "$program" --gtest_output="json:$results.again.json" --gtest_filter="$(echo "$*" | tr ' ' ':')"
