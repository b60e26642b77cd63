"""compare_methods.py TARGETS CAPTURE..: the paper's protocols for methods that are functions from photographs to predictors."""
import sys

import ffprocams
import numpy as np
from ffprocams import Array, Floats, Pinhole
from ffprocams.protocols import Inputs, Predictor, run, table


def ours(inputs: Inputs) -> Predictor:
    gaussians, renderer = ffprocams.reconstruct(inputs.capture()), ffprocams.Renderer()
    return lambda camera, projector, pattern: renderer.aim(gaussians, camera, projector).shade(pattern, inputs.intensity)


def nearest_white(inputs: Inputs) -> Predictor:
    """The photograph under white from the nearest camera, dimmed as the pattern is: what every method must beat."""
    places = np.array([camera.position for camera in inputs.cameras])

    def predict(camera: Pinhole, projector: Pinhole, pattern: Floats) -> Array:
        i = ((places - camera.position) ** 2).sum(axis=1).argmin()
        light = inputs.white[i] - inputs.black[i]
        return ffprocams.encode(inputs.black[i] + light * pattern.mean(axis=(0, 1)))

    return predict


methods = {"ours": ours, "nearest white": nearest_white}  # put your own beside these
print(table(run(sys.argv[2:], methods, targets=sys.argv[1])))
