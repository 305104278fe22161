#!/usr/bin/env bash
# Plays the trainer by its scripted hand and takes pictures: ./picture.sh [DIR], by default the directory of this script.
# Where there is no display a virtual one is used, with Vulkan in software.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}
pictures=$(realpath "${1:-.}")

missing() {
    echo "picture.sh: $1 is missing: install $2" >&2
    exit 1
}
run=()
if [ -z "${DISPLAY:-}" ]; then
    command -v xvfb-run >/dev/null 2>&1 || missing "xvfb-run" "your system's packages xvfb and mesa-vulkan-drivers"
    run=(xvfb-run --auto-servernum --server-args "-screen 0 1280x800x24")
fi
cargo build --locked --features trainer --example trainer
mkdir -p "$pictures"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# The recording is left where the trainer runs.
(cd "$work" && "${run[@]}" "$CARGO_TARGET_DIR/debug/examples/trainer" --script "$work")
for picture in "$work"/*.png; do
    # As few colours as do not show: half the size.
    if command -v convert >/dev/null 2>&1; then
        convert "$picture" -dither None -colors 255 "png8:$pictures/$(basename "$picture")"
    else
        cp "$picture" "$pictures/"
    fi
done
ls -l "$pictures"/*.png
