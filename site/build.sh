#!/usr/bin/env bash
# Builds the site into target/site/book: `site/build.sh [PROGRAM]`, with the pages of `cargo doc` from RHEXIS_DOC, by default target/doc, and the page
# with the engine from RHEXIS_PAGE, by default bindings/web/dist. Needs Python 3; npm, which has the font of formulas; cargo, by which it installs mdBook
# into target/site unless it is on the PATH. Fails on a link that leads nowhere.
set -euo pipefail
cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-$PWD/target}
program=${1:-$target/release/rhexis}
api=${RHEXIS_DOC:-$target/doc}
page=${RHEXIS_PAGE:-bindings/web/dist}
out=$target/site
mdbook=0.5.4
font=@fontsource/noto-sans-math@5.3.0

need() {
    command -v "$1" >/dev/null 2>&1 || [ -e "$1" ] || { echo "$1 is missing: $2" >&2; exit 1; }
}
need python3 "install Python 3.9 or newer"
need npm "install Node.js 20 or newer"
need "$program" "cargo build --release --package rhexis-cli"
need "$api/rhexis/index.html" "cargo doc --workspace --no-deps"
need "$page/page/index.html" "bindings/web/build.sh simd"

mkdir -p "$out"
PATH=$PATH:$out/bin
if ! command -v mdbook >/dev/null 2>&1; then
    cargo install --quiet --locked --version "$mdbook" --no-default-features --features search --root "$out" mdbook
fi
if [ ! -e "$out/font/package" ]; then
    mkdir -p "$out/font"
    (cd "$out/font" && npm pack --silent "$font" >/dev/null && tar xzf ./*.tgz)
fi
cp site/book.toml site/site.css "$out/"
python3 -B site/pages.py "$program" "$api" "$page" "$out"
rm -rf "$out/book"
mkdir -p "$out/src/math"
cp "$out"/font/package/LICENSE "$out"/font/package/files/noto-sans-math-latin-400-normal.woff2 "$out/src/math/"
mdbook build "$out"
cp -r "$api" "$out/book/api"
rm -f "$out/book/api/.lock"
python3 -B site/links.py "$out/book"
echo "built: $out/book/index.html"
