#!/usr/bin/env python3
"""Makes data/sample/ from a capture folder in the layout of render_poses.json.

usage: make_sample.py CAPTURE PATTERNS OUT      (needs Pillow)

Copies poses, targets, depth, and the pictures and patterns called all_black, all_white and lollipop_*; whatever else the
capture was shown is dropped from the JSON files too. PNG files are packed again without loss.
"""
import json
import shutil
import sys
from pathlib import Path

from PIL import Image


def kept(name):
    return name in ('all_black', 'all_white') or name.startswith('lollipop_')


def pack(source, target):
    """Writes the same pixels in the fewest bytes that Pillow finds; keeps the source if that gains nothing."""
    with Image.open(source) as image:
        image.save(target, optimize=True)
    with Image.open(source) as a, Image.open(target) as b:
        assert a.mode == b.mode and a.tobytes() == b.tobytes(), source
    if target.stat().st_size >= source.stat().st_size:
        shutil.copyfile(source, target)


def main():
    capture, patterns, out = map(Path, sys.argv[1:4])
    (out / 'patterns').mkdir(parents=True, exist_ok=True)
    for name in ('render_poses.json', 'targets.json'):
        scene = json.loads((capture / name).read_text())
        for view in scene['views']:
            view['patterns'] = [p for p in view['patterns'] if kept(p['projector_image'])]
            for file in [Path(p['file_path']).name for p in view['patterns']] + [f"{view['view_id']}_depth.png"]:
                pack(capture / file, out / file)
        (out / name).write_text(json.dumps(scene, indent=1) + '\n')
    for pattern in sorted(patterns.glob('*.png')):
        if kept(pattern.stem):
            pack(pattern, out / 'patterns' / pattern.name)


main()
