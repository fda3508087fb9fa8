#!/usr/bin/env bash
# Sees that commands are there, if need be from Debian's packages.
# Usage: tests/apt.sh COMMAND … -- PACKAGE …. Fails where they are not, and cannot be installed. With --newest for the
# commands, packages are installed as new as Debian has them.
set -uo pipefail

commands=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  commands+=("$1")
  shift
done
shift
# `command -v` is content with one of many.
all() { for one in "${commands[@]}"; do command -v "$one" >/dev/null || return 1; done; }

is_newest=false
[ "${commands[*]}" = --newest ] && commands=() && is_newest=true
$is_newest || ! all || exit 0
[ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || exit 1
export DEBIAN_FRONTEND=noninteractive
{ apt-get update && apt-get install -y --no-install-recommends "$@"; } >/dev/null 2>&1
all
