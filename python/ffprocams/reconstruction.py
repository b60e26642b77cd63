"""From photographs to Gaussians."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Union

from ._call import Call, Keep, PathLike, ProgressOption, holding, some
from ._library import ffi, lib
from .capture import Capture, record
from .errors import argument_error
from .gaussians import Gaussians, Model, drawing_of

#: Weights: a Model, a path, None for the shipped ones, or "none" for the classical initialisation alone, which needs none.
ModelOption = Union[Model, PathLike, None]


@dataclass
class ReconstructionStats:
    """How a reconstruction went; seconds of wall clock."""

    pattern: str  #: that was used, of several the first
    patterns: int  #: how many were
    gaussians: int
    initialisation_s: float  #: projector matching and the classical estimates
    network_s: float
    polish_s: float
    noise: float  #: deviation of the noise that was taken away
    denoise_s: float
    network_dropped: bool  #: the prediction showed the photographs worse than the classical initialisation
    polish_dropped: bool  #: the fit showed them worse than what it began with


@dataclass
class RefinementStats:
    """How a fit went."""

    psnr_before: float  #: dB over the pictures fitted
    psnr_after: float
    steps: int
    gaussians: int
    seconds: float
    stopped: bool  #: the progress function ended it: the best state so far was kept
    dropped: bool  #: the fit made the pictures worse: the Gaussians are what they were


class Reconstructed(Gaussians):
    """Gaussians that know how they were made."""

    stats: ReconstructionStats


class Refined(Gaussians):
    """Gaussians that know how they were fitted."""

    stats: RefinementStats


def model_of(model: ModelOption) -> Model | None:
    if isinstance(model, Model):
        return model
    return None if isinstance(model, str) and model == "none" else Model.open(model)


def _automatic(value: float | None, least: float, what: str) -> float:
    if value is None:
        return -1
    if not value >= least:
        raise argument_error(f"{value} is below {least:g}", what)
    return value


def reconstruct(
    capture: Capture,
    model: ModelOption = None,
    *,
    pattern: str | Sequence[str] | None = None,
    polish: int | None = None,
    noise: float | None = None,
    layers: float | None = None,
    form: str = "ours",
    samples: int = 0,
    force: bool = False,
    progress: ProgressOption = None,
    threads: int = 0,
    device: str = "cpu",
) -> Reconstructed:
    """One forward pass of the network and a short fit. The same bits as the program's `reconstruct`.

    Args:
        model: see ffprocams.ModelOption.
        pattern: name of the structured-light pattern to use, or of several: every view has the first, which the
            network sees, and matching and fit look at all; None: the first that every view has.
        polish: gradient steps, of one view each; 0: the forward pass alone; None: 88, and of many views more.
        noise: deviation of the photographs' noise (linear, of values up to 1) to be taken away; 0: none; None:
            estimated.
        layers: how many times splats may describe a place of the surface; 0: a splat for every pixel of every view;
            None: by their number.
        form: how Gaussians are drawn while fitting, "ours" or "paper".
        samples: a side of the grid of samples in each pixel while fitting, 1 to 4; 0: as the model has it.
        force: go on although a view's photographs contradict the others or its devices (turned, mirrored, exchanged,
            black for white), which is otherwise an error that names the view.
        progress: see ffprocams.ProgressOption.
        threads: that may work at a time; 0: all processors.
        device: "cpu" or "cuda".

    Returns:
        Gaussians in the capture's world units, with ``stats``.
    """
    keep, weights = Keep(), model_of(model)
    options, stats = (
        ffi.new("FfpReconstruction *", lib.ffp_reconstruction_defaults()),
        ffi.new("FfpReconstructionStats *"),
    )
    options.model = ffi.NULL if weights is None else weights._pointer
    names = [keep.text(p) for p in some(pattern or ())]
    options.patterns, options.n_patterns = keep.texts(names), len(names)
    options.polish = int(_automatic(polish, 0, "polish"))
    options.noise, options.layers = _automatic(noise, 0, "noise"), _automatic(layers, 0, "layers")
    options.drawing, options.force = drawing_of(form, samples), force
    with holding(capture, weights), Call(progress, threads, device) as call:
        made = lib.ffp_reconstruct(call.context, capture._pointer, options, stats, call.error)
        out = Reconstructed(call.take(made, lib.ffp_gaussians_close))
    out.stats = record(ReconstructionStats, stats)
    return out


def _refinement(
    patterns: str | Sequence[str], steps: int, seconds: float, noise: float | None, seed: int,
    metrics: PathLike | None, drawing: dict[str, int], keep: Keep,
) -> Any:  # fmt: skip
    options = ffi.new("FfpRefinement *", lib.ffp_refinement_defaults())
    names = [keep.text(p) for p in some(patterns)]
    options.patterns, options.n_patterns = keep.texts(names), len(names)
    options.steps, options.seconds, options.seed = steps, seconds, seed
    options.noise = _automatic(noise, 0, "noise")
    options.metrics, options.drawing = keep.path(metrics), drawing
    return options


def refine(
    gaussians: Gaussians,
    capture: Capture,
    *,
    patterns: str | Sequence[str] = (),
    steps: int = 0,
    seconds: float = 0,
    noise: float | None = None,
    seed: int = 1,
    metrics: PathLike | None = None,
    form: str = "ours",
    samples: int = 0,
    force: bool = False,
    progress: ProgressOption = None,
    threads: int = 0,
    device: str = "cpu",
) -> Refined:
    """Fits Gaussians to a capture's pictures. Those given stay as they are, and so do their arrays.

    Args:
        patterns: structured-light patterns to use beside black and white; none: the one a reconstruction would take.
        steps: of one view each; 0: no limit.
        seconds: of wall clock; 0: no limit. With neither limit 30 s.
        noise: as in reconstruct.
        seed: of the order of views. With a limit in steps alone the same seed and threads give the same bits.
        metrics: file for a line of JSON a round, or None.
        form, samples, force, threads, device: as in reconstruct.
        progress: see ffprocams.ProgressOption. A function that returns False ends the fit, which then gives the best
            state so far; an exception, Ctrl-C among them, is raised, and nothing is given.
    """
    keep, stats = Keep(), ffi.new("FfpRefinementStats *")
    options = _refinement(patterns, steps, seconds, noise, seed, metrics, drawing_of(form, samples), keep)
    options.force = force
    out = Refined(gaussians.copy()._pointer)
    with holding(capture), Call(progress, threads, device) as call:
        call.check(
            lib.ffp_refine_gaussians(call.context, out._pointer, capture._pointer, options, stats, call.error)
        )
    out.stats = record(RefinementStats, stats)
    return out


def fit_from_scratch(
    capture: Capture,
    *,
    patterns: str | Sequence[str] = (),
    steps: int = 0,
    seconds: float = 0,
    noise: float | None = None,
    seed: int = 1,
    metrics: PathLike | None = None,
    form: str = "ours",
    samples: int = 0,
    progress: ProgressOption = None,
    threads: int = 0,
    device: str = "cpu",
) -> Refined:
    """As refine without a prediction, the way GS-ProCams does it: for comparison, since it takes far longer. With
    neither limit 20000 steps."""
    keep, stats = Keep(), ffi.new("FfpRefinementStats *")
    options = _refinement(patterns, steps, seconds, noise, seed, metrics, drawing_of(form, samples), keep)
    with holding(capture), Call(progress, threads, device) as call:
        made = lib.ffp_fit_from_scratch(call.context, capture._pointer, options, stats, call.error)
        out = Refined(call.take(made, lib.ffp_gaussians_close))
    out.stats = record(RefinementStats, stats)
    return out
