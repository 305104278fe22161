#!/usr/bin/env bash
# Builds and tests the browser part: `check.sh [--bits | --page | --bundlers] [SCREENSHOTS]`. The bits in Node and natively, the types, the page in
# headless Chromium; --bits leaves out the page, --page all but the page. By the module with SIMD, which is built soon; RHEXIS_BITS=all takes the
# plain one too. --bundlers builds both modules, and runs the npm package in bundlers alone.
# RHEXIS_PROGRAM is the program that serves the page, which is built where it is not given.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
read -ra cargo <<<"${RHEXIS_CARGO:-cargo}"
# Built soon rather than for speed; the bits are the same.
export CARGO_PROFILE_RELEASE_DEBUG=false CARGO_PROFILE_RELEASE_LTO=off CARGO_INCREMENTAL=0

bits=true page=true bundlers=false
case "${1:-}" in
    --bits) page=false ;;
    --page) bits=false ;;
    --bundlers) bits=false page=false bundlers=true ;;
esac
if ! $bits || ! $page; then shift; fi

# The target for WebAssembly and the npm packages are fetched by build.sh; the browser is where whoever runs this may install it.
if ($page || $bundlers) && [ -z "${RHEXIS_CHROMIUM:-}" ] && ! command -v chromium chromium-browser google-chrome >/dev/null 2>&1; then
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium
    else
        echo "Chromium is missing: install your system's package chromium, or give its path as RHEXIS_CHROMIUM" >&2
        exit 1
    fi
fi

started=$SECONDS
took() {
    echo "check.sh: $1 in $((SECONDS - started)) s"
    started=$SECONDS
}

if $bundlers || [ "${RHEXIS_BITS:-}" = all ]; then ./build.sh all; else ./build.sh simd; fi
took "module and page"
# Not with the whole workspace, in which other packages ask for the engine's feature `direct`, whose factors give other bits; with the two packages
# of the gate's tests without it, so that the engine is built for both once.
native=(--release --locked --manifest-path "$root/Cargo.toml" --package rhexis --package rhexis-scene --package rhexis-web)
if $bits; then
    "${cargo[@]}" test "${native[@]}" --test bits
    took "the native side"
    npx --no-install tsc --noEmit --strict --target es2022 --module nodenext --moduleResolution nodenext --lib es2022,dom,esnext.disposable test/types.ts
    # Half of the scenes on each of two cores.
    RHEXIS_SHARE=0/2 node --test --test-reporter=spec test/bits.test.mjs &
    other=$!
    RHEXIS_SHARE=1/2 node --test --test-reporter=spec test/bits.test.mjs test/node.test.mjs
    wait "$other"
    took "types, bits and the package"
fi
if $page; then
    "${cargo[@]}" build "${native[@]}" --example replay_recording
    built=${CARGO_TARGET_DIR:-$root/target}/release
    if [ -z "${RHEXIS_PROGRAM:-}" ]; then
        # By itself, for its feature `direct` gives other bits.
        "${cargo[@]}" build --release --locked --manifest-path "$root/Cargo.toml" --package rhexis-cli
    fi
    export RHEXIS_REPLAY=$built/examples/replay_recording RHEXIS_PROGRAM=${RHEXIS_PROGRAM:-$built/rhexis}
    node test/browser.mjs "$@"
    took "the page"
fi
if $bundlers; then
    node test/bundlers/run.mjs
    took "bundlers"
fi
