#!/bin/sh
# side_by_side.sh PROGRAM SHARDS RESULTS: the tests of one GoogleTest program as so many processes at
# once, for tests that mostly wait. Leaves RESULTS.1.json, RESULTS.2.json, ...
program=$1 shards=$2 results=$3
shift 3
running=
shard=0
while [ "$shard" -lt "$shards" ]; do
  GTEST_TOTAL_SHARDS=$shards GTEST_SHARD_INDEX=$shard \
    "$program" --gtest_output="json:$results.$((shard + 1)).json" "$@" &
  running="$running $!"
  shard=$((shard + 1))
done
code=0
for process in $running; do
  wait "$process" || code=1
done
exit $code
