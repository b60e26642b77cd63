#!/bin/bash
# tests/product/cli/readme.sh PROGRAM LIBRARY: the examples of README.md, the guide and the reference, as printed. Blocks marked `sh` are run
# one after the other, in a folder that looks like a repository with a finished build. Blocks marked `text` need what only the reader has
# (photographs, root, hours): their commands and options must exist. The C program is compiled and run.
set -euo pipefail
program=$(realpath "$1")
library=$(realpath "$2")
source=$(realpath "$(dirname "$0")/../../..")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export OMP_WAIT_POLICY=passive

# The chain from bare devices needs OpenCV's module.
without=none
if "$program" calibrate nowhere -o nowhere.xml --board 9x6 --square 1 2>&1 | grep -q "install OpenCV"; then
    without=own-rig.md
    echo "skipped: $without, since there is no OpenCV"
fi
documents=()
for document in "$source"/README.md "$source"/docs/guide/*.md "$source"/docs/reference/{commands,library}.md; do
    [[ $document == *"/$without" ]] || documents+=("$document")
done
fail() { echo "the documents: $*" >&2; exit 1; }

mkdir "$work/blocks" "$work/build"
ln -s "$source"/data "$source"/docs "$source"/models "$work/"
ln -s "$program" "$work/build/ffprocams"
cd "$work"

# blocks/NUMBER.LANGUAGE, in the order of the text
awk '/^```/ { if (file) file = ""; else { language = substr($0, 4); file = sprintf("blocks/%03d.%s", ++n, language) } next }
     file { print > file }
     !file && /^    +(build\/|ffprocams|script\/)/ { print FILENAME ": outside of a marked block: " $0; bad = 1 }
     END { if (file) print "a block without end"; exit bad || file != "" }' "${documents[@]}" >bad || fail "$(cat bad)"

# Every option of a command that is not run must be one that its help names.
check() { # command line
    local words word command help
    read -ra words <<<"$1"
    command=${words[1]}
    help=$(build/ffprocams "$command" --help) || fail "no such command: $1"
    for word in "${words[@]:2}"; do
        [[ $word == -?* && ! $word =~ ^-[0-9] ]] || continue
        grep -qE -- "(^| )${word%%=*}[ ,=[]" <<<"$help " || fail "$command has no option $word: $1"
    done
}

ran=0
for block in blocks/*; do
    case $block in
    *.sh)
        begin=$SECONDS
        bash -eu "$block" >log 2>&1 </dev/null || { cat "$block" log >&2; fail "this example fails"; }
        echo "$((SECONDS - begin)) s: $(head -1 "$block")"
        ran=$((ran + 1))
        ;;
    *.c)
        cc -std=c11 "$block" -o example -I "$source/include" -I "$(dirname "$library")/include" "$library" -Wl,-rpath,"$(dirname "$library")"
        ./example || fail "its C program fails"
        echo "the C program"
        ;;
    *.text)
        sed -e ':join; /\\$/ { N; s/\\\n//; b join }' "$block" | { grep '^build/ffprocams ' || true; } |
            while read -r line; do check "$line"; done
        ;;
    *.python) ;; # python/tests/test_documents.py runs these
    *.cmake) ;;  # script/test-install does what these say
    *) fail "a block is marked neither sh, text, c, cmake nor python: $(head -1 "$block")" ;;
    esac
done
# How well own-rig's chain does in its room: turns that were not photographed, against pictures without noise, by true masks.
[ "$without" = own-rig.md ] || {
    shots=out/shots
    build/ffprocams import -c out/calibration.xml -t out/axis.json --angles 22,157 --name object -w 128 -o truth/capture \
        -i "black,white=$shots/truth/view-{view}/00[12].png" -i "photograph,map=$shots/truth/held-out/view-{view}/{pattern}.png" \
        -m "$shots/masks/view-{view}.png" -p "photograph=$shots/held-out/photograph.png" --held-out "map=$shots/held-out/map.png" \
        >log 2>&1 || { cat log >&2; fail "no truth"; }
    build/ffprocams evaluate out/object --gaussians out/object.ply --targets truth/capture/scene.json --json scores.json >log 2>&1 ||
        { cat log >&2; fail "the chain's result cannot be evaluated"; }
    python3 - <<'END' || fail "own-rig's chain: the object is too unlike the truth at new turns"
import json
row = next(row for row in json.load(open("scores.json"))["rows"] if row["protocol"] == "novel_pose")
print(f"own-rig's chain, new turns: {row['psnr_foreground']:.2f} dB of the object's pixels, {row['psnr']:.2f} of the full frame")
raise SystemExit(row["psnr_foreground"] < 28.5 or row["psnr"] < 37)
END
}
[ "$ran" -gt 9 ] || fail "only $ran blocks to run"
