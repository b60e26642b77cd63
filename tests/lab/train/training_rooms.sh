#!/bin/bash
# tests/lab/train/training_rooms.sh BUILD FOLDER: script/training-rooms makes a room that training takes, and keeps it when it is run again.
set -euo pipefail
build=$(realpath "$1")
source=$(realpath "$(dirname "$0")/../../..")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export OMP_WAIT_POLICY=passive COUNT=1 FIRST=3 HEIGHT=64 PANEL=64x64 WIDTH=32
fail() { echo "training rooms: $*" >&2; cat "$work/said" >&2; exit 1; }

make() { "$source/script/training-rooms" "$work/rooms" "$build" >"$work/said" 2>&1; }
make || fail "the script fails"
grep -q ": 1 rooms made" "$work/said" || fail "no room is made"
room=$work/rooms/train_00003
for kept in scene.json targets/scene.json; do [ -f "$room/$kept" ] || fail "no $kept"; done
grep -q '"022"' "$room/targets/scene.json" || fail "no turn between the stops has clean pictures"
made=$(stat -c %i "$room/scene.json")
make && grep -q ": 0 rooms made" "$work/said" && [ "$(stat -c %i "$room/scene.json")" = "$made" ] || fail "the room is not kept"

cat >"$work/config.json" <<END
{"model": "tiny", "rooms": "$work/rooms", "room_share": 1, "resolution": 32, "pool": 1, "reuse": 1, "views": 8, "targets": 1,
 "lollipops": 3, "pattern_side": 64, "supervised_inputs": 1, "supervised_targets": 1, "validate_every": 0, "log_every": 1, "warmup_steps": 1}
END
"$build/ffprocams" train --out "$work/run" --config "$work/config.json" --steps 1 >"$work/said" 2>&1 || fail "training does not take it"
grep -q '"loss":[^n]*"terms"' "$work/run/metrics.jsonl" || { cp "$work/run/metrics.jsonl" "$work/said"; fail "no loss"; }
