#!/usr/bin/env python3
"""bench/own_frame.py TRUTH CORRECTED OUT: a capture's true poses, moved as one into the frame of corrected ones.

Photographs cannot tell where the object and all devices are as a whole, so poses that `ffprocams align` corrected may differ from the
true ones by a rigid motion that is not an error of the reconstruction. TRUTH and CORRECTED are scene.json files with the same views. The rigid motion
that brings what TRUTH's cameras see nearest to what CORRECTED's see (least squares, in pixels, of points in the object's sphere) is
applied to every pose of TRUTH, and to those of the targets/scene.json beside it; OUT gets both, with links to the pictures. Prints the
cameras' error before and after, in pixels. Give OUT's scene.json or targets/scene.json to `ffprocams evaluate --targets`."""
import json
import sys
from pathlib import Path

import numpy as np


def load(path):
    scene = json.loads(Path(path).read_text())
    return scene, {v["id"]: np.array(v["c2w"]) for v in scene["views"]}


def rotation(turn):
    """Rodrigues' formula."""
    angle = np.linalg.norm(turn)
    x, y, z = turn / angle if angle > 0 else (0, 0, 0)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def motion(numbers):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation(numbers[:3]), numbers[3:]
    return pose


def seen(pose, focal, points):
    local = (points - pose[:3, 3]) @ pose[:3, :3]
    return focal * local[:, :2] / local[:, 2:]


def errors(numbers, truth, corrected, focal, points):
    """Of every point in every camera, pixels."""
    move = motion(numbers)
    return np.concatenate([(seen(move @ truth[v], focal, points @ move[:3, :3].T + move[:3, 3]) -
                            seen(corrected[v], focal, points @ move[:3, :3].T + move[:3, 3])).ravel() for v in truth])


def fit(truth, corrected, focal, points):
    """Gauss and Newton's method with differences for slopes."""
    numbers = np.zeros(6)
    for _ in range(10):
        here = errors(numbers, truth, corrected, focal, points)
        slopes = np.stack([(errors(numbers + step, truth, corrected, focal, points) - here) / 1e-6 for step in 1e-6 * np.eye(6)], 1)
        numbers -= np.linalg.lstsq(slopes, here, rcond=None)[0]
    return numbers


def write(source, out, move):
    out.mkdir(parents=True, exist_ok=True)
    for file in source.iterdir():
        if file.is_dir() and file.name == "targets":
            write(file, out / "targets", move)
        elif file.name != "scene.json" and not (out / file.name).exists():
            (out / file.name).symlink_to(file.resolve())
    scene, _ = load(source / "scene.json")
    for view in scene["views"]:
        for device in ("c2w", "p2w"):
            view[device] = (move @ np.array(view[device])).tolist()
    (out / "scene.json").write_text(json.dumps(scene))


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    source = Path(sys.argv[1])
    source = source if source.is_dir() else source.parent
    corrected_path = Path(sys.argv[2])
    scene, truth = load(source / "scene.json")
    _, corrected = load(corrected_path / "scene.json" if corrected_path.is_dir() else corrected_path)
    centre, radius = np.array(scene["object"]["centre"]), scene["object"]["radius"]
    grid = np.stack(np.meshgrid(*[[-0.5, 0, 0.5]] * 3), -1).reshape(-1, 3)
    points = centre + radius * grid
    numbers = fit(truth, corrected, scene["camera"]["fx"], points)
    rms = [np.sqrt(2 * np.mean(errors(x, truth, corrected, scene["camera"]["fx"], points) ** 2)) for x in (np.zeros(6), numbers)]
    print(f"{source.name}: {rms[0]:.3f} pixels, in its own frame {rms[1]:.3f}; moved by {np.round(numbers[3:], 4)}")
    write(source, Path(sys.argv[3]), motion(numbers))


main()
