#!/usr/bin/env bash
# Builds the package and the page into bindings/web/dist: `build.sh` both modules, `build.sh simd` only that for browsers with SIMD, which are
# all of today's. Needs cargo with the target wasm32-unknown-unknown, node and npm.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)

need() {
    command -v "$1" >/dev/null 2>&1 || { echo "$1 is not on the PATH: $2" >&2; exit 1; }
}
need cargo "install Rust by https://rustup.rs"
need node "install Node.js 20 or newer by https://nodejs.org or your system's package nodejs"
node -e 'process.exit(Number.parseInt(process.versions.node) < 20 ? 1 : 0)' || { echo "node is $(node --version): 20 or newer is needed, see https://nodejs.org" >&2; exit 1; }
need npm "install it with Node.js, or your system's package npm"
if ! ls "$(rustc --print sysroot)"/lib/rustlib/wasm32-unknown-unknown/lib/libcore-*.rlib >/dev/null 2>&1; then
    need rustup "the target wasm32-unknown-unknown is missing, which your system's package of Rust may have"
    rustup target add wasm32-unknown-unknown
fi

# Several in one machine may be made to wait for each other by RHEXIS_CARGO="flock FILE cargo".
read -ra cargo <<<"${RHEXIS_CARGO:-cargo}"
export CARGO_PROFILE_RELEASE_DEBUG=false

# Two modules of the same engine: WebAssembly cannot ask which instructions there are while it runs.
module() {
    RUSTFLAGS=$2 "${cargo[@]}" build --release --locked --package rhexis-web --lib --target wasm32-unknown-unknown \
        --target-dir "$root/target/web/$1" --manifest-path "$root/Cargo.toml"
    # It runs for seconds: without optimisation it is built in half the time, and writes the same bytes.
    CARGO_PROFILE_RELEASE_OPT_LEVEL=0 "${cargo[@]}" run --release --locked --quiet --package rhexis-web-pack --manifest-path "$root/Cargo.toml" -- \
        "$root/target/web/$1/wasm32-unknown-unknown/release/rhexis_web.wasm" "dist/$1"
}

[ -d node_modules/three ] || npm ci --no-audit --no-fund
mkdir -p dist/page/vendor
case "${1:-all}" in
    simd) module simd "-C target-feature=+simd128" ;;
    plain) module plain "" ;;
    all)
        module simd "-C target-feature=+simd128"
        module plain ""
        ;;
    *) echo "build.sh: $1 is not known; give simd, plain or nothing for both" >&2 && exit 2 ;;
esac
cp js/index.js js/index.d.ts "$root"/LICENSE-* dist/
cp page/* dist/page/
three=node_modules/three
cp $three/build/three.module.js $three/build/three.core.js $three/examples/jsm/controls/OrbitControls.js $three/LICENSE dist/page/vendor/
echo "built: $(du -sh dist | cut -f1) in bindings/web/dist; serve it by \`rhexis view\`"
