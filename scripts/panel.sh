#!/usr/bin/env bash
# Builds the panel into build/panel, from where CMake puts it into the binary. Where there is no node or
# npm, or nothing can be fetched, it says so: the controller is built without a panel then.
# `panel.sh test` runs its unit tests too.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

wanted=18
scripts/packages.sh panel >/dev/null 2>&1 || true # said below, where it has not helped
if ! command -v node >/dev/null || ! command -v npm >/dev/null; then
  echo "  no panel: node $wanted or newer and npm are not here (apt-get install nodejs npm)"
  exit 0
fi
have=$(node -p 'process.versions.node.split(".")[0]')
if ((have < wanted)); then
  echo "  no panel: node $have is too old, $wanted or newer is needed"
  exit 0
fi

log=$PWD/$logs/panel.log
# Everything that the result depends on, so that what is built is not built again.
print=$(cd panel && find . ../robots -path ./node_modules -prune -o -type f -print0 | sort -z |
  xargs -0 sha256sum | sha256sum | cut -d' ' -f1)
if [[ -f build/panel/index.html && $(cat build/panel.print 2>/dev/null) == "$print" && ${1-} != test ]]; then
  printf '  %-34s %10s\n' "panel" "up to date"
  exit 0
fi

began=$(milliseconds_now)
cd panel
lock=$(sha256sum package-lock.json | cut -d' ' -f1)
if [[ $(cat node_modules/.print 2>/dev/null) != "$lock" ]]; then
  if ! npm ci --no-audit --no-fund >"$log" 2>&1; then
    echo "  no panel: npm ci failed, see $log"
    exit 0
  fi
  echo "$lock" >node_modules/.print
fi
npx --no-install tsc --noEmit >>"$log" 2>&1 || die "panel: the types do not fit, see $log"
npx --no-install vite build >>"$log" 2>&1 || die "panel: vite build failed, see $log"
echo "$print" >../build/panel.print
# Behind the build: the browser's tests say what they say of this panel, whatever its unit tests do.
if [[ ${1-} == test ]] && ! npx --no-install vitest run >>"$log" 2>&1; then
  explain_failure "$log"
  die "panel: a unit test failed"
fi
cd ..
printf '  %-34s %10s\n' "panel" "$(pretty_ms $(($(milliseconds_now) - began)))"
