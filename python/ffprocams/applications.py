"""Applications: compensated projections and correspondence maps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from . import devices
from ._arguments import checked, one_of
from ._call import Call, Handle, Keep, PathLike, ProgressOption, holding, some
from ._library import ffi, lib
from ._pixels import Array, Floats, floats_at, picture_of
from .capture import Capture, capture_of, record
from .devices import Pinhole
from .errors import argument_error
from .gaussians import FRAMINGS, Gaussians, drawing_of, gaussians_of

_TRANSPARENT = {"black": False, "free": True}


@dataclass
class CompensationStats:
    """Statistics of a compensation."""

    gain: float  #: the gain used
    unlit: float  #: share of the object's pixels constrained by the targets that no projector lights
    too_dark: float  #: share whose target is too dark to be reached
    too_bright: float  #: share whose target is too bright
    psnr_dark: float  #: dB over the lit pixels, with dark projectors
    psnr_closed: float  #: after the closed form
    psnr: float  #: at the end
    patterns: int
    elapsed_s: float


@dataclass
class Compensation:
    """Patterns under which cameras see their targets. Linear pictures [height,width,3], by view."""

    patterns: dict[str, Floats]  #: of the projector's size, one for each projector
    seen: dict[str, Floats]  #: what the cameras will see
    targets: dict[str, Floats]  #: what they should see
    stats: CompensationStats


@dataclass
class MapStats:
    """Accuracy of a view's maps over a round trip from the camera to the projector and back."""

    lit_pixels: int  #: camera pixels whose round trip succeeded
    lost_pixels: int  #: lit pixels for which it failed
    within_half: float  #: share of the former that returned within half a pixel
    median: float  #: error in pixels
    most: float  #: the largest error, pixels
    lit_share: float  #: share of the projector's pixels that fall on the object


class _Images(Handle):
    def named(self) -> dict[str, Floats]:
        out: dict[str, Floats] = {}
        for i in range(lib.ffp_images_count(self._pointer)):
            image = lib.ffp_images_at(self._pointer, i)
            shape = (image.height, image.width) + ((image.channels,) if image.channels > 1 else ())
            out[ffi.string(image.name).decode()] = floats_at(image.data, shape, self)
        return out


@checked
def compensate(
    gaussians: Gaussians | PathLike,
    capture: Capture | PathLike,
    targets: Array | PathLike | Sequence[Array] | Sequence[PathLike],
    *,
    views: str | Sequence[str] = (),
    poses: PathLike | None = None,
    fit: str = "cover",
    transparent: str = "black",
    gain: float = 1.0,
    paint: bool = False,
    steps: int = 30,
    gaussians_only: bool = False,
    black_level: float = 0.0,
    sharpen: bool = False,
    form: str = "ours",
    samples: int = 0,
    progress: ProgressOption = None,
    threads: int = 0,
) -> Compensation:
    """Finds the patterns under which cameras see their targets as closely as light allows.

    Args:
        gaussians, capture: or the paths of their files.
        targets: one for all views or one for each, as arrays (see View) or image files.
        views: ids of the views whose cameras see a target, with all their projectors shining at once; none: all.
        poses: file of camera and projector poses; None: the capture's.
        fit: how targets go into the cameras' frames if their shapes differ: cover, contain, stretch or pixel.
        transparent: transparent parts of a target are black, or free (unconstrained).
        gain: factor on the linear targets; 0: the brightest that light allows.
        paint: targets are light on the object: 0 its look under black, 1 under white, shared where
            projectors overlap (no gain).
        steps: number of steps of gradient descent after the closed form; 0: none.
        gaussians_only: take ambient light and response from the Gaussians even if the view has photographs under black
            and white.
        black_level: share of its white that a dark projector still gives, in [0, 0.1]; where several overlap, the dark
            beside is lifted until it is as bright.
        sharpen: patterns are sharpened for the projector's blur, as found by import.
        form, samples: how Gaussians are drawn, as in Renderer.
        progress: see ffprocams.ProgressOption.
        threads: number of threads; 0: all processors.

    Raises:
        ArgumentError: an argument is wrong, or names a view that the capture lacks.
        Error: a file cannot be read; its subclass says why.
    """
    gaussians, capture = gaussians_of(gaussians), capture_of(capture)
    keep, options = Keep(), ffi.new("FfpCompensation *", lib.ffp_compensation_defaults())
    ids = [keep.text(v) for v in some(views)]
    options.poses, options.views, options.n_views = keep.path(poses), keep.texts(ids), len(ids)
    several = isinstance(targets, (list, tuple)) or getattr(targets, "ndim", 0) == 4
    given: Any = targets
    listed: list[Any] = list(given) if several else [given]
    _fill_targets(options, listed, keep)
    options.framing, options.transparent_free = one_of(FRAMINGS, fit, "fit"), one_of(_TRANSPARENT, transparent, "transparent")
    options.gain, options.paint, options.steps, options.gaussians_only = gain, paint, steps, gaussians_only
    options.black_level, options.sharpen = black_level, sharpen
    options.drawing, stats = drawing_of(form, samples), ffi.new("FfpCompensationStats *")
    with holding(gaussians, capture), Call(progress, threads) as call:
        made = lib.ffp_compensate_images(
            call.context, gaussians._pointer, capture._pointer, options, stats, call.error
        )
        images = _Images(call.take(made, lib.ffp_images_close)).named()
    patterns, seen, wanted = (
        {name[len(kind) :]: image for name, image in images.items() if name.startswith(kind)}
        for kind in ("pattern_", "seen_", "target_")
    )
    return Compensation(patterns, seen, wanted, record(CompensationStats, stats))


def _fill_targets(options: Any, targets: list[Any], keep: Keep) -> None:
    arrays = [hasattr(t, "__array__") for t in targets]
    if not targets or (any(arrays) and not all(arrays)):
        raise argument_error("expected arrays or files, at least one and not both", "targets")
    options.n_targets = len(targets)
    if any(arrays):
        pictures = keep(ffi.new("FfpPicture[]", len(targets)))
        for i, target in enumerate(targets):
            pictures[i] = picture_of(target, keep, f"targets[{i}]")[0]
        options.pictures = pictures
    else:
        options.targets = keep.texts([keep.path(t) for t in targets])


@checked
def maps(
    gaussians: Gaussians | PathLike,
    capture: Capture | PathLike,
    camera: Pinhole,
    projector: Pinhole,
    *,
    form: str = "ours",
    samples: int = 0,
    progress: ProgressOption = None,
    threads: int = 0,
) -> tuple[dict[str, Floats], MapStats]:
    """Correspondences and projected light for one camera and one projector.

    Args:
        gaussians, capture: or the paths of their files.
        form, samples: how Gaussians are drawn, as in Renderer.
        progress: see ffprocams.ProgressOption.
        threads: number of threads; 0: all processors.

    Returns:
        Arrays by name, the first of the camera's size, all others of the projector's: ``camera_to_projector`` and
        ``projector_to_camera`` [height,width,3] (position in pixels, centres at + 0.5; unshadowed share of the light,
        or 1; -1 -1 0 where there is no correspondence), ``projector_sees`` [height,width,3] linear, ``lit``,
        ``incidence`` (degrees, -1: no surface), ``density`` (camera pixels per projector pixel), ``resolution``
        (projector pixels per world unit), ``illuminance`` (cosine / distance^2, normalised to a maximum of 1)
        [height,width]. And the statistics of the round trip.

    Raises:
        ArgumentError: an argument is wrong.
        Error: a file cannot be read; its subclass says why.
    """
    gaussians, capture = gaussians_of(gaussians), capture_of(capture)
    stats, drawing = ffi.new("FfpWarpStats *"), drawing_of(form, samples)
    with holding(gaussians, capture), Call(progress, threads) as call:
        made = lib.ffp_warp_images(
            call.context, gaussians._pointer, capture._pointer, devices.to_c(camera), devices.to_c(projector), drawing,
            stats, call.error,
        )  # fmt: skip
        images = _Images(call.take(made, lib.ffp_images_close)).named()
    return images, record(MapStats, stats)
