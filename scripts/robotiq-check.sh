#!/usr/bin/env bash
# gripd on a virtual 2F-85 and a virtual TSF-85, written in Python, the gripper on a serial line and then behind a forwarder over TCP:
# a slip is held, and so is the object through time-outs, CRC errors, faults, unplugged lines and the end of gripd; one that was reset
# waits for a client.
#
#   scripts/robotiq-check.sh [PROFILE]      PROFILE is release, or dev for a quicker look
#
# Needs python3.
set -euo pipefail
cd "$(dirname "$0")/.."
profile=${1:-release}
target=${CARGO_TARGET_DIR:-target}

if [ "$profile" = release ]; then scripts/release-build.sh; else cargo build --locked -q --profile "$profile" -p gripd -p gripctl; fi
# Devices have processors of their own.
first=
! chrt -r 5 true 2>/dev/null || first="chrt -r 5"
$first python3 scripts/robotiq-devices.py "$target/${profile/#dev/debug}/gripd"
$first python3 scripts/robotiq-devices.py --forwarder "$target/${profile/#dev/debug}/gripd"
echo "robotiq-check: done"
