#!/usr/bin/env bash
# Checks the plugin without a window: ./check.sh [--lint | --trainer]. Headless tests.
# --lint adds clippy, which compiles Bevy's part a second time. --trainer adds that of the examples with a window as well, for which a good
# part of Bevy is compiled, and which wants the headers of libudev, libasound2 and libxkbcommon on Linux.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
read -ra cargo <<<"${RHEXIS_CARGO:-cargo}"
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target} CARGO_INCREMENTAL=0

started=$SECONDS
took() {
    echo "check.sh: $1 in $((SECONDS - started)) s"
    started=$SECONDS
}

"${cargo[@]}" test --locked --features gizmos
took "headless tests"
if [ -n "${1:-}" ]; then
    "${cargo[@]}" clippy --locked --features gizmos --lib --tests -- -D warnings
    took "lints"
fi
if [ "${1:-}" = "--trainer" ]; then
    "${cargo[@]}" clippy --locked --features trainer --examples -- -D warnings
    took "lints of the examples"
fi
