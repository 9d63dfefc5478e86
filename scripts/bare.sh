#!/usr/bin/env bash
# bare.sh [COMMAND...]: what a newcomer's machine makes of the README. Clones HEAD into a bare Debian (debootstrap
# minbase with git and make: no compiler, no node) and runs `make run` and `make test` there, or each COMMAND.
# SUITE=trixie takes Debian 13 instead of 12. The system is made anew each time and removed at the end.
# Exit: that of the first command that fails; 77 where no bare system can be had here (not root, no debootstrap).
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

suite=${SUITE:-bookworm}
cannot() {
  echo "  no bare $suite: $*"
  exit 77
}

# Mounts and processes end with these name spaces, however this script ends.
if [[ -z ${SINEW_BARE_PLACE-} ]]; then
  ((EUID == 0)) || cannot "needs root"
  unshare --mount --pid --fork true 2>/dev/null || cannot "name spaces are not allowed here"
  if ! command -v debootstrap >/dev/null; then
    { apt-get update && apt-get install -y --no-install-recommends debootstrap; } \
      >"$logs/bare-debootstrap.log" 2>&1 || cannot "debootstrap cannot be installed"
  fi
  SINEW_BARE_PLACE=$(mktemp -d "${TMPDIR:-/var/tmp}/sinew-bare-XXXXXX")
  # As any system's root: a user of the tests who is not root must be able to go through it.
  chmod 755 "$SINEW_BARE_PLACE"
  export SINEW_BARE_PLACE
  trap 'rm -rf --one-file-system "$SINEW_BARE_PLACE"' EXIT
  unshare --mount --propagation private --pid --fork --kill-child --mount-proc \
    bash scripts/bare.sh "$@" || exit
  exit 0
fi

place=$SINEW_BARE_PLACE
# The mirror that this machine uses itself; debootstrap's own choice where none is named.
mirror=$(sed -n 's/^URIs: *\([^ ]*\).*/\1/p' /etc/apt/sources.list.d/*.sources 2>/dev/null | head -n 1)
[[ -n $mirror ]] ||
  mirror=$(sed -n 's/^deb \(\[[^]]*\] \)\?\([^ ]*\).*/\2/p' /etc/apt/sources.list 2>/dev/null | head -n 1)
step "bare $suite: system" bare-debootstrap debootstrap --variant=minbase \
  --include=ca-certificates,git,make "$suite" "$place" ${mirror:+"$mirror"} ||
  cannot "debootstrap failed"

# How packages are reached from here (resolver, certificates, proxies), and nothing else of this machine.
cp /etc/resolv.conf /etc/hosts "$place/etc/"
cp -r /etc/ssl/certs/. "$place/etc/ssl/certs/"
for file in $(grep -lsiE 'proxy|Acquire::https?' /etc/apt/apt.conf /etc/apt/apt.conf.d/* || true); do
  cp "$file" "$place/etc/apt/apt.conf.d/"
done
for file in /etc/npmrc /usr/etc/npmrc "$HOME/.npmrc"; do
  [[ -f $file ]] || continue
  mkdir -p "$place${file%/*}"
  # Where this machine's node has its headers is not where the bare one has them.
  sed '/^nodedir/d' "$file" >"$place$file"
done
mount --rbind /dev "$place/dev"
mount --rbind /sys "$place/sys"
mount -t proc proc "$place/proc"
git clone -q . "$place/root/sinew"

if (($#)); then commands=("$@"); else commands=("make run" "make test"); fi
for command in "${commands[@]}"; do
  echo "bare $suite: $command"
  start=$(milliseconds_now)
  code=0
  env -i HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin ${CI:+CI="$CI"} SINEW_STRICT=1 \
    chroot "$place" /bin/bash -c "cd /root/sinew && $command" </dev/null 2>&1 |
    tee "$logs/bare-$suite-${command//[^a-z]/-}.log" || code=$?
  took=$(pretty_ms $(($(milliseconds_now) - start)))
  if ((code != 0)); then
    cp -r "$place/root/sinew/build/logs" "$logs/bare-$suite" 2>/dev/null || true
    echo "bare $suite: $command: FAILED (exit $code) after $took; its logs: $logs/bare-$suite"
    exit "$code"
  fi
  echo "bare $suite: $command: ok, $took"
done
