#!/usr/bin/env bash
# Builds and tests the browser part: types, hashes in Node against native ones, the page in headless Chromium.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
read -ra cargo <<<"${RHEXIS_CARGO:-cargo}"
export CARGO_PROFILE_RELEASE_DEBUG=false

# The target for WebAssembly and the npm packages are fetched by build.sh; the browser is where whoever runs this may install it.
if [ -z "${RHEXIS_CHROMIUM:-}" ] && ! command -v chromium chromium-browser google-chrome >/dev/null 2>&1; then
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium
    else
        echo "Chromium is missing: install your system's package chromium, or give its path as RHEXIS_CHROMIUM" >&2
        exit 1
    fi
fi

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
