"""Captures: the photographs of an object by a projector-camera rig."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import devices
from ._arguments import checked, expects
from ._call import Call, Handle, Keep, PathLike, ProgressOption, holding
from ._library import ffi, lib
from ._pixels import Array, Floats, array_of, picture_of
from .devices import Doubles, Pinhole
from .errors import argument_error
from .findings import Finding, finding_of

if TYPE_CHECKING:
    from .gaussians import Gaussians


@checked
@dataclass
class View:
    """One view of an object, for Capture.from_arrays.

    Pictures are arrays [height,width] or [height,width,1, 3 or 4]: uint8 or uint16 sRGB-encoded with straight alpha,
    or float32 linear light premultiplied by alpha.
    """

    id: str
    camera: Pinhole
    projector: Pinhole
    photographs: Mapping[
        str, Array
    ]  #: pattern name to photograph, of the camera's size; black and white are required
    mask: Array | None = None  #: the object's share of each pixel; None: alpha, or the pixels that white brightens
    masked: bool = False  #: the photographs already show the object over black
    depth: Array | None = (
        None  #: [height,width] float32 truth: camera z, world units, 0 where there is no surface
    )
    correspondence: Array | None = (
        None  #: [height,width,3] float32: projector pixel that each pixel's light comes from; confidence, 0 to 1
    )


def capture_of(given: Capture | PathLike) -> Capture:
    """A capture, or that of a folder."""
    return given if isinstance(given, Capture) else Capture.open(given)


@dataclass
class AlignStats:
    """Statistics of align."""

    turntable: bool = False  #: the views come from a fixed rig around a turning object, and share a common pose
    own: bool = False  #: each view received separate poses
    turned: float = 0.0  #: their rotation, root mean square about a device's axis, degrees
    evened: float = 0.0  #: rotation that sharing a common pose took, root mean square, degrees
    depth: float = 0.0  #: rotation of the camera in all views, degrees: towards the projector
    across: float = 0.0  #: across that direction
    side: float = 0.0  #: sideways
    off: tuple[float, ...] = ()  #: separate poses, before and after: distance of rays from their projector pixels
    apart: tuple[float, ...] = ()  #: before and after: distance between surfaces of different views, camera pixels
    focal: tuple[float, ...] = ()  #: factors on the focal lengths of camera and projector; 1: unchanged
    before: float = 0.0  #: disagreement of the pictures: mean difference of pattern values, 0 to 1
    after: float = 0.0
    elapsed_s: float = 0.0
    known: bool = False  #: found by Gaussians: before and after compare photographs with drawn pictures, sRGB-encoded
    camera_turned: float = 0.0  #: by Gaussians: rotation of the camera about its centre, degrees, mean over the views
    camera_moved: float = 0.0  #: its way, world units
    projector_turned: float = 0.0
    projector_moved: float = 0.0


@dataclass
class FoundProjector:
    """Deviations of find_projector."""

    distance: float = 0.0  #: from the object's centre, world units
    turned: float = 0.0  #: standard deviation of its direction, degrees
    moved: float = 0.0  #: of its place, world units
    focal: float = 0.0  #: of its focal length, as a share
    centre: tuple[float, ...] = ()  #: of its principal point, pixels
    rms: float = 0.0  #: of the points used, pixels of the projector
    points: int = 0  #: of the object's surface that have codes
    used: int = 0  #: of them no outliers


def plain(value: Any) -> Any:
    """A number, string or tuple from a member of a C struct."""
    if not isinstance(value, ffi.CData):
        return value
    kind = ffi.typeof(value)
    numbers = kind.kind == "array" and kind.item.cname == "double"
    return tuple(value) if numbers else ffi.string(value).decode()


def record(kind: type[Any], c: Any) -> Any:
    """A dataclass from the C struct with the same names."""
    return kind(**{name: plain(getattr(c, name)) for name in kind.__dataclass_fields__})


@checked
class Capture(Handle):
    """Views of one object, each photographed under a black, a white and further patterns.

    Views and patterns are given by name or by index. Arrays are read-only views of the library's memory and keep it
    alive.
    """

    def __init__(self, pointer: Any) -> None:
        """Not to be called directly: use open or from_arrays."""
        super().__init__(pointer)
        self.view_ids: tuple[str, ...] = tuple(
            ffi.string(lib.ffp_capture_view_id(pointer, i)).decode()
            for i in range(lib.ffp_capture_views(pointer))
        )
        n = lib.ffp_capture_patterns(pointer)
        self.pattern_names: tuple[str, ...] = tuple(
            ffi.string(lib.ffp_capture_pattern_name(pointer, i)).decode() for i in range(n)
        )
        self._roles = [lib.ffp_capture_pattern_role(pointer, i) for i in range(n)]

    @classmethod
    def open(cls, path: PathLike) -> Capture:
        """Reads and checks a folder with scene.json or render_poses.json, or such a file.
        Raises MissingFileError or FileFormatError for a file that is missing or damaged."""
        keep = Keep()
        with Call() as call:
            return cls(
                call.take(
                    lib.ffp_capture_open(call.context, keep.path(path), ffi.NULL, call.error),
                    lib.ffp_capture_close,
                )
            )

    @classmethod
    def from_arrays(
        cls,
        views: Sequence[View],
        patterns: Mapping[str, Array | None],
        *,
        black: str = "black",
        white: str = "white",
        held_out: Sequence[str] = (),
        intensity: npt.ArrayLike | None = None,
        centre: npt.ArrayLike = (0.0, 0.0, 0.0),
        radius: float = 0.0,
        name: str = "capture",
    ) -> Capture:
        """A capture of photographs in memory, which are copied and checked; errors name the view, pattern or field.

        Args:
            views: 1 to 512 views.
            patterns: the projected picture for each pattern name, of the projector's size (as in View); black and white
                may be None.
            black, white: names of these patterns.
            held_out: patterns for testing only, never used for a reconstruction unless requested by name.
            intensity: [3] or one number, the projector's radiant intensity at pattern value 1; None: estimated.
            centre, radius: a sphere around the object, world units; radius 0: estimated.
            name: of the capture.

        Raises:
            ArgumentError: an argument is wrong, or what a view or pattern contains; the error names it.
        """
        names, keep = list(patterns), Keep()
        for what in (black, white, *held_out):
            if what not in patterns:
                raise argument_error(f"no pattern '{what}'", "patterns")
        data = ffi.new("FfpCaptureData *")
        data.name, data.n_patterns, data.n_views = keep.text(name), len(names), len(views)
        data.black, data.white = names.index(black), names.index(white)
        data.patterns = keep(ffi.new("FfpPatternData[]", len(names)))
        for i, (pattern, picture) in enumerate(patterns.items()):
            data.patterns[i].name = keep.text(pattern)
            data.patterns[i].picture = picture_of(picture, keep, f"pattern {pattern}")[0]
            data.patterns[i].held_out = pattern in held_out
        data.views = keep(ffi.new("FfpViewData[]", len(views)))
        for i, view in enumerate(views):
            _fill_view(data.views[i], view, names, keep)
        data.intensity = [0.0] * 3 if intensity is None else three(intensity, "intensity")
        data.centre, data.radius = three(centre, "centre"), radius
        with Call() as call:
            return cls(
                call.take(lib.ffp_capture_from_memory(call.context, data, call.error), lib.ffp_capture_close)
            )

    def _view(self, view: str | int) -> int:
        return _index(view, self.view_ids, "view")

    def _pattern(self, pattern: str | int) -> int:
        return _index(pattern, self.pattern_names, "pattern")

    def _with_role(self, role: int) -> list[str]:
        return [n for n, r in zip(self.pattern_names, self._roles) if r == role]

    @property
    def black(self) -> str:
        """The black pattern's name."""
        return self._with_role(lib.FFP_PATTERN_BLACK)[0]

    @property
    def white(self) -> str:
        """The white pattern's name."""
        return self._with_role(lib.FFP_PATTERN_WHITE)[0]

    @property
    def held_out(self) -> tuple[str, ...]:
        """Names of the patterns for testing only."""
        return tuple(self._with_role(lib.FFP_PATTERN_HELD_OUT))

    def check(self, *, progress: ProgressOption = None, threads: int = 0) -> list[Finding]:
        """Looks for what is wrong with the photographs, the poses and the masks.

        Checks that were passed are among the findings, with severity "ok". A reconstruction of a capture with a
        finding of severity "fault" raises FaultError, unless it is forced.

        Raises:
            ArgumentError: an argument is wrong.
            CancelledError: the progress function returned False.
        """
        count = ffi.new("int *")
        with holding(self), Call(progress, threads) as call:
            found = call.take(lib.ffp_capture_check(call.context, self._pointer, count, call.error), lib.ffp_free)
        return [finding_of(found[i]) for i in range(count[0])]

    def camera(self, view: str | int = 0) -> Pinhole:
        """A view's camera. Raises ArgumentError or IndexError if there is no such view."""
        return self._devices(view)[0]

    def projector(self, view: str | int = 0) -> Pinhole:
        """A view's projector. Raises ArgumentError or IndexError if there is no such view."""
        return self._devices(view)[1]

    def _devices(self, view: str | int) -> tuple[Pinhole, Pinhole]:
        camera, projector = ffi.new("FfpPinhole *"), ffi.new("FfpPinhole *")
        with holding(self):
            lib.ffp_capture_view_devices(self._pointer, self._view(view), camera, projector)
        return devices.from_c(camera), devices.from_c(projector)

    def photograph(self, view: str | int, pattern: str | int) -> Floats | None:
        """[height,width,3] linear light over black; None if the view has no photograph under that pattern.
        Raises ArgumentError or IndexError if there is no such view or pattern."""
        return array_of(
            lib.ffp_capture_picture(self._pointer, self._view(view), self._pattern(pattern)), self
        )

    def pattern(self, pattern: str | int) -> Floats | None:
        """[height,width,3] linear, of the projector's size; None if the pattern has no picture.
        Raises ArgumentError or IndexError if there is no such pattern."""
        return array_of(lib.ffp_capture_picture(self._pointer, -1, self._pattern(pattern)), self)

    def coverage(self, view: str | int) -> Floats:
        """[height,width] the object's share of each pixel, in [0,1].
        Raises ArgumentError or IndexError if there is no such view."""
        out = array_of(lib.ffp_capture_coverage(self._pointer, self._view(view)), self)
        assert out is not None
        return out

    @property
    def intensity(self) -> Doubles:
        """[3] the projector's radiant intensity at pattern value 1, W/sr in world units; estimated if not given."""
        out = ffi.new("double[3]")
        lib.ffp_capture_intensity(self._pointer, out)
        return np.array(list(out))

    @property
    def centre(self) -> Doubles:
        """[3] centre of a sphere around the object, world units."""
        return self._bounds()[0]

    @property
    def radius(self) -> float:
        """Radius of a sphere around the object, world units."""
        return self._bounds()[1]

    def _bounds(self) -> tuple[Doubles, float]:
        centre, radius = ffi.new("double[3]"), ffi.new("double *")
        lib.ffp_capture_bounds(self._pointer, centre, radius)
        return np.array(list(centre)), float(radius[0])

    def save(self, folder: PathLike) -> None:
        """Writes a capture folder, completely or not at all; it must be new or empty.
        Raises FileFormatError if it is not, InputOutputError if it cannot be written."""
        keep = Keep()
        with holding(self), Call() as call:
            call.check(lib.ffp_capture_save(call.context, self._pointer, keep.path(folder), call.error))

    def __repr__(self) -> str:
        camera = self.camera(0)
        return (
            f"<Capture: {len(self.view_ids)} views of {camera.width} x {camera.height} pixels, "
            f"{len(self.pattern_names)} patterns>"
        )


@checked
def align(
    capture: Capture,
    pattern: str | None = None,
    *,
    focal_lengths: bool = False,
    gaussians: Gaussians | None = None,
    progress: ProgressOption = None,
    threads: int = 0,
) -> AlignStats:
    """Corrects the poses of a capture's cameras and projectors from its photographs, in place.

    Args:
        pattern: name of the structured-light pattern; None: the first that every view has.
        focal_lengths: also correct those of camera and projector, by the same factors in all views.
        gaussians: the object as it is known, in the capture's world: each view's camera and projector are found again
            by it, from that view's photographs alone. Not with focal_lengths; ``pattern`` is ignored.
        progress: see ffprocams.ProgressOption.
        threads: number of threads; 0: all processors.

    Raises:
        ArgumentError: an argument is wrong, or no view has that pattern.
        Error: the photographs do not determine the poses.
    """
    keep, stats = Keep(), ffi.new("FfpAlignmentStats *")
    with holding(capture, gaussians), Call(progress, threads) as call:
        options = ffi.new("FfpAlignment *", lib.ffp_alignment_defaults())
        options.gaussians = ffi.NULL if gaussians is None else gaussians._pointer
        options.pattern, options.focal_lengths = keep.text(pattern), focal_lengths
        call.check(lib.ffp_align_poses(call.context, capture._pointer, options, stats, call.error))
    out: AlignStats = record(AlignStats, stats)
    return out


def three(numbers: npt.ArrayLike, name: str) -> list[float]:
    """Three numbers, from as many or from one."""
    array = np.asarray(numbers, np.float64).reshape(-1)
    expects(array.size in (1, 3), name, "one or three numbers", array.size)
    return [float(x) for x in np.broadcast_to(array, 3)]


def _index(name: str | int, names: tuple[str, ...], what: str) -> int:
    if isinstance(name, str):
        if name not in names:
            raise argument_error(f"no {what} '{name}'", what)
        return names.index(name)
    if not -len(names) <= name < len(names):
        raise IndexError(f"{what} {name} of {len(names)}")
    return int(name) % len(names)


def _fill_view(c: Any, view: View, patterns: list[str], keep: Keep) -> None:
    c.id = keep.text(view.id)
    devices.fill(ffi.addressof(c, "camera"), view.camera)
    devices.fill(ffi.addressof(c, "projector"), view.projector)
    for name in view.photographs:
        if name not in patterns:
            raise argument_error(
                f"a photograph under '{name}', which is not among the patterns", f"view {view.id}"
            )
    photographs = keep(ffi.new("FfpPicture[]", len(patterns)))
    for i, name in enumerate(patterns):
        photographs[i] = picture_of(view.photographs.get(name), keep, f"view {view.id}: {name}")[0]
    c.photographs = photographs
    c.mask = picture_of(view.mask, keep, f"view {view.id}: mask")[0]
    c.masked = view.masked
    c.depth = picture_of(view.depth, keep, f"view {view.id}: depth")[0]
    c.correspondence = picture_of(view.correspondence, keep, f"view {view.id}: correspondence")[0]


@checked
def find_projector(
    capture: Capture, gaussians: Gaussians, *, progress: ProgressOption = None, threads: int = 0
) -> FoundProjector:
    """Finds place and lens of a projector that no calibration describes, in place, from its Gray codes on an object.

    Args:
        capture: of photographs under that projector alone, made with ``other_projector``; its cameras are right.
        gaussians: the object, in the capture's world.
        progress: see ffprocams.ProgressOption.
        threads: number of threads; 0: all processors.

    Raises:
        ArgumentError: an argument is wrong, or no view has Gray codes.
        Error: the codes do not determine the projector.
    """
    found = ffi.new("FfpFoundProjector *")
    with holding(capture, gaussians), Call(progress, threads) as call:
        call.check(lib.ffp_find_projector(call.context, capture._pointer, gaussians._pointer, found, call.error))
    out: FoundProjector = record(FoundProjector, found)
    return out
