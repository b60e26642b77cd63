#!/bin/bash
# tests/examples/roles.sh RECONSTRUCT SAMPLE: a capture whose black and white have the names that an import gives them, and whose first
# pattern is held out: the example goes by what the patterns are for.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export OMP_WAIT_POLICY=passive

cp -r "$2" "$work/capture"
sed -i 's/"all_black"/"black"/; s/"all_white"/"white"/; s/"lollipop_0"/"earth"/' "$work/capture/render_poses.json"
mv "$work/capture/patterns/lollipop_0.png" "$work/capture/patterns/earth.png"
said=$("$1" "$work/capture" "$work/out.ply")
[[ $said == *"from pattern lollipop_1" ]] || { echo "not reconstructed from lollipop_1: $said" >&2; exit 1; }
