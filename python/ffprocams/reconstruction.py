"""From photographs to Gaussians."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Union

from ._arguments import Seed, checked, expects
from ._call import Call, Keep, PathLike, ProgressOption, holding, some
from ._library import ffi, lib
from .capture import Capture, capture_of, record
from .gaussians import Gaussians, Model, drawing_of, gaussians_of

#: Weights: a Model, a path, None for the shipped ones, or "none" for the classical initialisation alone.
ModelOption = Union[Model, PathLike, None]


@dataclass
class ReconstructionStats:
    """Statistics of a reconstruction; times are wall-clock seconds."""

    pattern: str  #: the first pattern used
    patterns: int  #: number of patterns used
    gaussians: int
    initialisation_s: float  #: projector matching and the classical estimates
    network_s: float
    polish_s: float
    noise: float  #: standard deviation of the noise that was filtered
    denoise_s: float
    network_dropped: bool  #: the prediction reproduced the photographs worse than the classical initialisation
    polish_dropped: bool  #: the polish made the match with the photographs worse and was discarded
    psnr: float  #: dB on the photographs it was made from, mean over a view's photographs and over the views
    least_psnr: float  #: that of the view with the least
    least_view: str
    score_s: float  #: comparing with the photographs
    unseen: int  #: patterns that the capture holds out, by which it is judged; at most 2
    unseen_psnr: float  #: dB on their photographs, which no fit has looked at; NaN: there are none
    lit_psnr: float  #: of `psnr`, over the pixels of the object that white lights
    unseen_lit_psnr: float  #: of `unseen_psnr`, the same


@dataclass
class RefinementStats:
    """Statistics of a fit."""

    psnr_before: float  #: dB over the fitted pictures
    psnr_after: float
    steps: int
    gaussians: int
    elapsed_s: float
    stopped: bool  #: by the progress function; the best state so far was kept
    dropped: bool  #: the fit made the pictures worse and was discarded


class Reconstructed(Gaussians):
    """Gaussians with the statistics of their reconstruction."""

    stats: ReconstructionStats


class Refined(Gaussians):
    """Gaussians with the statistics of their fit."""

    stats: RefinementStats


def model_of(model: ModelOption) -> Model | None:
    if isinstance(model, Model):
        return model
    return None if isinstance(model, str) and model == "none" else Model.open(model)


def _automatic(value: float | None, least: float, what: str) -> float:
    if value is None:
        return -1
    expects(value >= least, what, f"at least {least:g}", value)
    return value


@checked
def reconstruct(
    capture: Capture | PathLike,
    model: ModelOption = None,
    *,
    pattern: str | Sequence[str] | None = None,
    polish: int | None = None,
    noise: float | None = None,
    layers: float | None = None,
    form: str = "ours",
    samples: int = 0,
    force: bool = False,
    width: int = 0,
    progress: ProgressOption = None,
    threads: int = 0,
    device: str = "cpu",
) -> Reconstructed:
    """Reconstructs Gaussians by one forward pass of the network and a short fit. The result has the same bits as that
    of the program's `reconstruct`.

    Args:
        capture: a Capture, or a folder that holds one.
        model: see ffprocams.ModelOption.
        pattern: name or names of the structured-light patterns to use. Every view must have the first, which the
            network sees; matching and the polish use all that a view has photographs under. None: the first that every
            view has.
        polish: gradient steps, one view each; 0: the forward pass alone; None: 72, or 9 per view with more than 8
            views; for scenes 2.5 times that.
        noise: standard deviation of the noise to be filtered from the photographs first, in linear values from 0 to 1;
            0: no filtering; None: estimated.
        layers: how many splats may cover the same place of the surface; 0: a splat for every pixel of every view;
            None: depends on their number.
        form: how Gaussians are drawn while fitting, "ours", "paper" or "gs-procams".
        samples: per side of a pixel while fitting, 1 to 4; 0: the model's setting.
        force: continue although a view's photographs contradict the others or its devices (turned, mirrored, exchanged,
            black for white); otherwise that is an error, which names the view.
        width: a draft: pixels to which wider pictures are reduced first; the scores are those on the capture's own. 0: none
            are.
        progress: see ffprocams.ProgressOption.
        threads: number of threads; 0: all processors.
        device: "cpu" or "cuda".

    Returns:
        Gaussians in the capture's world units, with ``stats``.

    Raises:
        ArgumentError: an argument is wrong, or names a pattern that the capture lacks.
        FaultError: the capture has a fault, and ``force`` is not given.
        UnsupportedError: the library was built without that device.
        Error: a file cannot be read; its subclass says why.
    """
    capture, keep, weights = capture_of(capture), Keep(), model_of(model)
    options, stats = (
        ffi.new("FfpReconstruction *", lib.ffp_reconstruction_defaults()),
        ffi.new("FfpReconstructionStats *"),
    )
    options.model = ffi.NULL if weights is None else weights._pointer
    names = [keep.text(p) for p in some(pattern or ())]
    options.patterns, options.n_patterns = keep.texts(names), len(names)
    options.polish = int(_automatic(polish, 0, "polish"))
    options.noise, options.layers = _automatic(noise, 0, "noise"), _automatic(layers, 0, "layers")
    options.drawing, options.force, options.width = drawing_of(form, samples), force, width
    with holding(capture, weights), Call(progress, threads, device) as call:
        made = lib.ffp_reconstruct(call.context, capture._pointer, options, stats, call.error)
        out = Reconstructed(call.take(made, lib.ffp_gaussians_close))
    out.stats = record(ReconstructionStats, stats)
    return out


def _refinement(
    patterns: str | Sequence[str], steps: int, seconds: float, noise: float | None, seed: Seed,
    metrics: PathLike | None, drawing: dict[str, int], keep: Keep,
) -> Any:  # fmt: skip
    options = ffi.new("FfpRefinement *", lib.ffp_refinement_defaults())
    names = [keep.text(p) for p in some(patterns)]
    options.patterns, options.n_patterns = keep.texts(names), len(names)
    options.steps, options.limit_s, options.seed = steps, seconds, seed
    options.noise = _automatic(noise, 0, "noise")
    options.metrics, options.drawing = keep.path(metrics), drawing
    return options


@checked
def refine(
    gaussians: Gaussians | PathLike,
    capture: Capture | PathLike,
    *,
    patterns: str | Sequence[str] = (),
    steps: int = 0,
    seconds: float = 0,
    noise: float | None = None,
    seed: Seed = 1,
    metrics: PathLike | None = None,
    form: str = "ours",
    samples: int = 0,
    force: bool = False,
    progress: ProgressOption = None,
    threads: int = 0,
    device: str = "cpu",
) -> Refined:
    """Fits a copy of the Gaussians to a capture's pictures. The given Gaussians and their arrays are unchanged.

    Args:
        gaussians, capture: or the paths of their files.
        patterns: structured-light patterns to use in addition to black and white; none: the one that reconstruct uses.
        steps: number of steps, one view each; 0: no limit.
        seconds: of wall clock; 0: no limit. With neither limit: 30 s.
        noise: as in reconstruct.
        seed: for the order of views. If only the number of steps is limited, the same seed and number of threads give
            identical bits.
        metrics: file for one line of JSON per round, or None.
        form, samples, force, threads, device: as in reconstruct.
        progress: see ffprocams.ProgressOption. A function that returns False ends the fit, which then returns the best
            state so far; an exception, including Ctrl-C, is raised, and nothing is returned.

    Raises:
        ArgumentError: an argument is wrong, or names a pattern that the capture lacks.
        FaultError: the capture has a fault, and ``force`` is not given.
        Error: a file cannot be read or written; its subclass says why.
    """
    capture, keep, stats = capture_of(capture), Keep(), ffi.new("FfpRefinementStats *")
    options = _refinement(patterns, steps, seconds, noise, seed, metrics, drawing_of(form, samples), keep)
    options.force = force
    out = Refined(gaussians_of(gaussians).copy()._pointer)
    with holding(capture), Call(progress, threads, device) as call:
        call.check(
            lib.ffp_refine_gaussians(call.context, out._pointer, capture._pointer, options, stats, call.error)
        )
    out.stats = record(RefinementStats, stats)
    return out


@checked
def fit_from_scratch(
    capture: Capture | PathLike,
    *,
    points: Gaussians | PathLike | None = None,
    patterns: str | Sequence[str] = (),
    steps: int = 0,
    seconds: float = 0,
    noise: float | None = None,
    seed: Seed = 1,
    metrics: PathLike | None = None,
    form: str = "ours",
    samples: int = 0,
    progress: ProgressOption = None,
    threads: int = 0,
    device: str = "cpu",
) -> Refined:
    """Fits Gaussians without a prediction, as GS-ProCams does; for comparison, since it takes far longer. It begins
    with the centres of `points`, or with points in the visual hull. Other arguments as for refine; with neither limit:
    20000 steps. Raises what refine raises."""
    capture, keep, stats = capture_of(capture), Keep(), ffi.new("FfpRefinementStats *")
    options = _refinement(patterns, steps, seconds, noise, seed, metrics, drawing_of(form, samples), keep)
    begin = None if points is None else gaussians_of(points)
    with holding(capture, begin), Call(progress, threads, device) as call:
        at = ffi.NULL if begin is None else begin._pointer
        made = lib.ffp_fit_from_scratch(call.context, capture._pointer, at, options, stats, call.error)
        out = Refined(call.take(made, lib.ffp_gaussians_close))
    out.stats = record(RefinementStats, stats)
    return out
