#!/usr/bin/env python3
"""Makes data/sculpture/: a white matte head of the generator's, its test split's object "moai".

usage: make_sculpture.py FFPROCAMS OUT      (needs Pillow)

Generates the scene with a plain white material and keeps what a sample needs: pictures and patterns called all_black,
all_white, lollipop_0 and, held back, lollipop_3; depth of the input views; the six new poses. PNG files are packed again
without loss.
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

SCENE = 97  # of all meshes under the first material
ROLES = {'all_black': 'black', 'all_white': 'white', 'lollipop_0': 'active', 'lollipop_3': 'novel'}
RESOLUTION = 256
EXPOSURE = -0.4  # stops: white light on white is not to clip


def generate(program, folder):
    material = folder / 'white'
    material.mkdir()
    Image.new('RGB', (8, 8), (235, 235, 235)).save(material / 'basecolor.png')
    Image.new('L', (8, 8), 217).save(material / 'roughness.png')
    subprocess.run([program, 'generate', folder / 'scenes', '--first', str(SCENE), '--count', '1', '--material', material,
                    '--resolution', str(RESOLUTION), '--sensor', f'exposure={EXPOSURE}'], check=True)
    return folder / 'scenes' / f'all_{SCENE:05d}'


def copy(source, target):
    """A PNG in the fewest bytes that Pillow finds, if that is a gain; any other file as it is."""
    data = source.read_bytes()
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(data)
    if source.suffix != '.png':
        return
    with Image.open(source) as image:
        image.save(target, optimize=True)
    with Image.open(source) as a, Image.open(target) as b:
        assert a.mode == b.mode and a.tobytes() == b.tobytes(), source
    if target.stat().st_size >= len(data):
        target.write_bytes(data)


def keep(capture, out, patterns, truth):
    scene = json.loads((capture / 'scene.json').read_text())
    scene['name'] = 'sculpture'
    scene['patterns'] = [dict(p, role=ROLES[p['name']]) for p in scene['patterns'] if p['name'] in patterns]
    for pattern in scene['patterns']:
        copy(capture / pattern['file'], out / pattern['file'])
    for view in scene['views']:
        view['images'] = {name: file for name, file in view['images'].items() if name in patterns}
        for key in {'depth', 'normal', 'albedo', 'roughness', 'direct_white'} - set(truth):
            view.pop(key, None)
        for file in [*view['images'].values(), *(view[key] for key in truth)]:
            copy(capture / file, out / file)
    (out / 'scene.json').write_text(json.dumps(scene, indent=1) + '\n')


def main():
    program, out = sys.argv[1], Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as folder:
        capture = generate(program, Path(folder))
        keep(capture, out, list(ROLES), ['depth'])
        keep(capture / 'targets', out / 'targets', ['all_black', 'all_white', 'lollipop_0'], [])


main()
