#!/usr/bin/env bash
# Builds and tests the browser part: types, hashes in Node against native ones, the page in headless Chromium.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
read -ra cargo <<<"${RHEXIS_CARGO:-cargo}"
export CARGO_PROFILE_RELEASE_DEBUG=false

./build.sh
reference=$(mktemp)
trap 'rm -f "$reference"' EXIT
# Alone: in the workspace another crate would ask for `direct`, whose factors give other bits.
"${cargo[@]}" build --release --locked --package rhexis-web --examples --manifest-path "$root/Cargo.toml"
export RHEXIS_REFERENCE=$reference RHEXIS_REPLAY=$root/target/release/examples/replay_recording
"$root/target/release/examples/reference" test/plan.json >"$reference"

[ -d node_modules/playwright-core ] || npm ci --no-audit --no-fund
npx --no-install tsc --noEmit --strict --target es2022 --module nodenext --moduleResolution nodenext --lib es2022,dom test/types.ts
node --test --test-reporter=spec test/node.test.mjs
node test/browser.mjs "$@"
