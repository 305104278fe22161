#!/usr/bin/env bash
# Plays the trainer by its scripted hand, takes pictures and makes a film of it: ./picture.sh [DIR], by default the directory of this script.
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
command -v convert >/dev/null 2>&1 || missing "convert" "your system's package imagemagick"
run=()
if [ -z "${DISPLAY:-}" ]; then
    command -v xvfb-run >/dev/null 2>&1 || missing "xvfb-run" "your system's packages xvfb and mesa-vulkan-drivers"
    run=(xvfb-run --auto-servernum --server-args "-screen 0 1280x800x24")
fi
cargo build --release --locked --features trainer --example trainer
mkdir -p "$pictures"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# The recording is left where the trainer runs.
(cd "$work" && "${run[@]}" "$CARGO_TARGET_DIR/release/examples/trainer" --script "$work")
for picture in "$work"/*.png; do
    # As few colours as do not show: half the size.
    convert "$picture" -dither None -colors 255 "png8:$pictures/$(basename "$picture")"
done
# One palette for all of the film, from small copies: what stands still has the same colours in each picture, and is written once.
film=("$work"/film/*.png)
convert "${film[@]}" -resize 140x -append -dither None -colors 255 -unique-colors "$work/palette.png"
convert -delay 10 "${film[@]::${#film[@]}-1}" -delay 200 "${film[-1]}" \
    -resize 560x -dither None -remap "$work/palette.png" -layers optimize "$pictures/trainer-moving.gif"
ls -l "$pictures"/*.png "$pictures"/*.gif
