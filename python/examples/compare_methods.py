"""compare_methods.py CAPTURE..: the paper's protocols for methods that are functions; two of them are here.

A method gets photographs as numpy arrays (ffprocams.protocols.Inputs) and returns a function that predicts pictures. Put
your own beside these.
"""

from __future__ import annotations

import sys

import ffprocams
from ffprocams import Array, Floats, Pinhole
from ffprocams.protocols import Inputs, Predictor, run, table


def ours(inputs: Inputs, polish: int | None = None) -> Predictor:
    gaussians = ffprocams.reconstruct(inputs.capture(), polish=polish)
    renderer = ffprocams.Renderer()

    def predict(camera: Pinhole, projector: Pinhole, pattern: Floats) -> Array:
        return renderer.aim(gaussians, camera, projector).shade(pattern, inputs.intensity)

    return predict


def nearest_white(inputs: Inputs) -> Predictor:
    """The photograph under white from the nearest camera, dimmed as the pattern is: what every method must beat."""

    def predict(camera: Pinhole, projector: Pinhole, pattern: Floats) -> Array:
        i = min(
            range(len(inputs.cameras)),
            key=lambda i: ((inputs.cameras[i].position - camera.position) ** 2).sum(),
        )
        light = inputs.white[i] - inputs.black[i]
        return ffprocams.encode(inputs.black[i] + light * pattern.mean(axis=(0, 1)))

    return predict


if __name__ == "__main__":
    rows = run(sys.argv[1:], {"ours": ours, "nearest white": nearest_white}, targets="targets.json")
    print(table(rows))
