#!/usr/bin/env bash
# check.sh SINEW FOLDER: a record of the real program, opened with the public MCAP reader
# (@mcap/core, by npm, into FOLDER). Exit code 77: npm or its registry is not here.
set -euo pipefail
sinew=$1
folder=$2
here=$(cd "$(dirname "$0")" && pwd)

if ! command -v npm >/dev/null; then
  echo "npm is not installed: nothing checked"
  exit 77
fi
mkdir -p "$folder"
cp "$here"/{package.json,package-lock.json,.npmrc,check_record.mjs} "$folder"
cd "$folder"
# Once: what is there already is what the lock file says.
if ! cmp -s package-lock.json node_modules/.of; then
  if ! npm ci --ignore-scripts --no-audit --no-fund >npm.log 2>&1; then
    cat npm.log
    grep -qE 'ENOTFOUND|EAI_AGAIN|ETIMEDOUT|ECONNREFUSED|ENETUNREACH' npm.log && exit 77
    exit 1
  fi
  cp package-lock.json node_modules/.of
fi

rm -f ./*.mcap
cat >turn.sinew <<'END'
joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg
joint base=30deg
jaws 20mm
END
"$sinew" run turn.sinew --robot learm --profile bus --time-scale 10 --record arm.mcap --json >arm.json
printf 'joint base=20deg\njoint base=0deg\n' >big.sinew
"$sinew" run big.sinew --robot bigrobotarm --time-scale 10 --record big.mcap --json >big.json
node check_record.mjs arm.mcap big.mcap
# The check itself sees a file that is not whole.
head -c 20000 arm.mcap >cut.mcap
if node check_record.mjs cut.mcap; then
  echo "a file that was cut passed"
  exit 1
fi
