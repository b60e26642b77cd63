"""The renderer as a layer of PyTorch, and what it takes to fit Gaussians with it. Needs ``torch``; nothing else in the
package does.

    import ffprocams
    from ffprocams import torch as layer

    splats = layer.Splats(ffprocams.reconstruct(capture, polish=0))
    pictures = layer.render(splats(), capture.camera(0), capture.projector(0), [pattern], capture.intensity)
    layer.photometric_loss(pictures[0], target).backward()

Tensors are float32 on the CPU. They are read where they are, and gradients are written where autograd finds them: nothing
is copied unless a tensor is not contiguous. Other Python threads run meanwhile.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Union

import torch
from torch import Tensor

from ._arguments import checked, expects, one_of
from ._call import Call, Handle, Keep, PathLike, holding
from ._library import ffi, lib
from .devices import Pinhole
from .errors import argument_error
from .gaussians import Gaussians, drawing_of
from .renderer import _MAPS
from .torch_network import Network, Parts, Prepared

__all__ = [
    "Devices", "Network", "Parts", "Perceptual", "Prepared", "SplatAdam", "Splats", "decode", "depth_loss", "distortion_loss", "encode", "l1_loss", "mask_loss", "normal_smooth_loss",
    "perceptual_loss", "photometric_loss", "psnr", "render", "roughness_smooth_loss", "se3_exp", "ssim",
]  # fmt: skip

_ROUGHNESS_FLOOR, _SIGMOID_LEAST = 0.05, 1e-4  # as in the library's own fits
_PARTS = len(Parts._fields)


@checked
@dataclass
class Devices:
    """Cameras or projectors of one size whose poses and focal lengths are tensors, for gradients with respect to them.

    Gradients of poses are those of rigid motions: let ``pose`` be se3_exp(xi) @ start and optimise xi.
    """

    width: int
    height: int
    pose: Tensor  #: [views,4,4] device to world, rigid
    focal: Tensor  #: [views,2] fx, fy in pixels
    centre: Tensor  #: [views,2] principal points in pixels; constants

    @classmethod
    def of(cls, pinholes: Sequence[Pinhole]) -> Devices:
        """Cameras or projectors of one size. Raises ArgumentError for none, or several sizes."""
        if not pinholes:
            raise argument_error("there are none", "devices")
        first = pinholes[0]
        for i, p in enumerate(pinholes):
            if (p.width, p.height) != (first.width, first.height):
                raise argument_error(
                    f"device {i} has {p.width} x {p.height} pixels, the first {first.width} x {first.height}",
                    "devices",
                )
        return cls(
            first.width,
            first.height,
            torch.stack([torch.as_tensor(p.pose, dtype=torch.float64) for p in pinholes]),
            torch.tensor([[p.fx, p.fy] for p in pinholes], dtype=torch.float64),
            torch.tensor([[p.cx, p.cy] for p in pinholes], dtype=torch.float64),
        )


AnyDevices = Union[Devices, Sequence[Pinhole], Pinhole]


@checked
def se3_exp(xi: Tensor) -> Tensor:
    """[...,4,4] rigid motions exp(xi) of [...,6] numbers: translation, then rotation in radians.
    Raises ArgumentError unless given a tensor."""
    rho, x, y, z = xi[..., :3], xi[..., 3], xi[..., 4], xi[..., 5]
    none = torch.zeros_like(x)
    rows = [torch.stack(row, -1) for row in ((none, -z, y), (z, none, -x), (-y, x, none))]
    top = torch.cat((torch.stack(rows, -2), rho.unsqueeze(-1)), -1)
    return torch.linalg.matrix_exp(torch.cat((top, torch.zeros_like(top[..., :1, :])), -2))


class _Canvas(Handle):
    """A renderer of the library, and whose patterns it holds."""

    def __init__(self, form: str, samples: int, threads: int) -> None:
        self.call = Call(threads=threads)
        self.patterns: Any = None
        drawing = drawing_of(form, samples)
        with self.call as call:
            super().__init__(
                call.take(lib.ffp_renderer_new(call.context, drawing, call.error), lib.ffp_renderer_close)
            )


_IDLE = 2  # canvases of a kind that are kept for the next drawing
_idle: dict[tuple[str, int, int], list[_Canvas]] = {}
_idle_lock = threading.Lock()


class _Lease:
    """A canvas until nothing refers to the lease any more: a graph's nodes keep theirs."""

    def __init__(self, *kind: Any) -> None:
        self._kind = kind
        with _idle_lock:
            idle = _idle.get(self._kind)
            canvas = idle.pop() if idle else None
        self.canvas = canvas or _Canvas(*kind)

    def __del__(self) -> None:
        canvas = getattr(self, "canvas", None)
        if canvas is None or _idle_lock is None:
            return
        if _idle_lock.acquire(blocking=False):  # the collector may run while this thread has it
            try:
                idle = _idle.setdefault(self._kind, [])
                if len(idle) < _IDLE:
                    idle.append(canvas)
            finally:
                _idle_lock.release()


def _floats(tensor: Tensor, name: str, shape: tuple[int, ...]) -> Tensor:
    expects(isinstance(tensor, Tensor), name, "a Tensor", tensor)
    if tensor.device.type != "cpu":
        raise argument_error(f"expected a tensor on the CPU, not on {tensor.device}", name)
    if tensor.dtype != torch.float32:
        raise argument_error(f"expected float32, not {tensor.dtype}", name)
    if tuple(tensor.shape) != shape:
        raise argument_error(f"shape {tuple(tensor.shape)} is not {shape}", name)
    return tensor.contiguous()


def _at(tensor: Tensor | None, kind: str = "float *") -> Any:
    return ffi.NULL if tensor is None else ffi.cast(kind, tensor.data_ptr())


def _arrays(parts: Sequence[Tensor | None]) -> dict[str, Any]:
    arrays: dict[str, Any] = {name: _at(t) for name, t in zip(Parts._fields, parts)}
    arrays["count"] = 0 if parts[0] is None else len(parts[0])
    return arrays


@dataclass
class _Job:
    """Arguments that autograd does not look at."""

    cameras: Devices
    projectors: Devices
    dark: list[bool]  # of each pattern
    maps: list[str]
    linear: bool
    lease: _Lease
    gradients: bool


def _pinholes(d: Devices, pose: Tensor, focal: Tensor) -> Any:
    out = ffi.new("FfpPinhole[]", len(pose))
    for p, m, f, c in zip(out, pose.reshape(-1, 16).tolist(), focal.tolist(), d.centre.tolist()):
        p.width, p.height, p.pose = d.width, d.height, m
        p.fx, p.fy, p.cx, p.cy = f[0], f[1], c[0], c[1]
    return out


def _same(canvas: _Canvas, patterns: Sequence[Tensor], dark: list[bool], projectors: Devices) -> bool:
    """True if the canvas has these patterns. It keeps references to those it has, so addresses are theirs alone; a
    version changes with the numbers."""
    marks = [(t.data_ptr(), t._version) for t in patterns]
    held = canvas.patterns
    canvas.patterns = (list(patterns), marks, dark, projectors.width, projectors.height)
    return held is not None and held[1:] == canvas.patterns[1:]


def _maps_at(tensors: dict[str, Tensor]) -> Any:
    table = ffi.new("float *[]", lib.FFP_MAP_COUNT)
    for name, tensor in tensors.items():
        table[_MAPS[name]] = _at(tensor)
    return table


def _draw(
    job: _Job, parts: Sequence[Tensor], intensity: Tensor, posed: Sequence[Tensor], patterns: Sequence[Tensor]
) -> list[Tensor]:
    canvas, cameras, projectors = job.lease.canvas, job.cameras, job.projectors
    views, height, width = len(posed[0]), cameras.height, cameras.width
    pictures = torch.empty(views, len(job.dark), height, width, 3)
    maps = {
        name: torch.empty(views, height, width, *((3,) if lib.ffp_map_channels(_MAPS[name]) == 3 else ()))
        for name in job.maps
    }
    batch = ffi.new("FfpRenderBatch *")
    shown, lit = ffi.new("FfpPicture[]", max(len(job.dark), 1)), iter(patterns)
    for picture, dark in zip(shown, job.dark):
        if not dark:
            picture.data = _at(next(lit), "void *")
            picture.width, picture.height, picture.channels = projectors.width, projectors.height, 3
            picture.type = lib.FFP_PIXELS_F32
    devices_ = _pinholes(cameras, posed[0], posed[1]), _pinholes(projectors, posed[2], posed[3])
    batch.gaussians = _arrays(parts)
    batch.n_views, batch.cameras, batch.projectors = views, devices_[0], devices_[1]
    batch.n_patterns, batch.patterns = len(job.dark), shown
    batch.intensity = intensity.tolist()
    batch.linear, batch.gradients = job.linear, job.gradients
    table = _maps_at(maps)
    with canvas._lock, canvas.call as call:
        batch.same_patterns = _same(canvas, patterns, job.dark, projectors)
        try:
            call.check(
                lib.ffp_renderer_forward(
                    call.context,
                    canvas._pointer,
                    batch,
                    _at(pictures),
                    pictures.numel(),
                    table,
                    len(table),
                    call.error,
                )
            )
        except BaseException:
            canvas.patterns = None
            raise
    return [pictures, *maps.values()]


def _pose_gradient(xi: Tensor, pose: Tensor) -> Tensor:
    """[views,4,4] whose product with d pose = hat(xi) pose is that of xi with its gradient [views,6]."""
    moved, turned, t = xi[:, :3], xi[:, 3:], pose[:, :3, 3].to(xi.dtype)
    x, y, z = (turned - torch.linalg.cross(t, moved)).unbind(1)
    none = torch.zeros_like(x)
    hat = torch.stack((none, -z, y, z, none, -x, -y, x, none), 1).view(-1, 3, 3)
    out = torch.zeros(len(xi), 4, 4, dtype=xi.dtype)
    out[:, :3, :3] = 0.5 * hat @ pose[:, :3, :3].to(xi.dtype)
    out[:, :3, 3] = moved
    return out


class _Render(torch.autograd.Function):
    """The attributes, intensity, pose and focal lengths of cameras and of projectors, then the patterns that are not dark."""

    @staticmethod
    def forward(ctx: Any, job: _Job, *given: Tensor) -> Any:
        ctx.job = job
        ctx.set_materialize_grads(False)
        ctx.save_for_backward(*given)
        return tuple(_draw(job, given[:_PARTS], given[_PARTS], given[_PARTS + 1 : _PARTS + 5], given[_PARTS + 5 :]))

    @staticmethod
    def backward(ctx: Any, *grads: Tensor | None) -> Any:
        if torch.is_grad_enabled():
            raise RuntimeError("ffprocams.torch.render has no second derivatives: create_graph must be False")
        given, job = ctx.saved_tensors, ctx.job
        wanted = ctx.needs_input_grad[1:]
        grads = tuple(g if g is None else g.contiguous() for g in grads)
        views, canvas, projectors = len(given[_PARTS + 1]), job.lease.canvas, job.projectors
        parts = [torch.empty_like(t) if want else None for t, want in zip(given[:_PARTS], wanted)]
        numbers = [
            torch.empty(3 if i == 0 else views * (6 if i % 2 else 2), dtype=torch.float64) if want else None
            for i, want in enumerate(wanted[_PARTS : _PARTS + 5])
        ]
        patterns = (
            torch.empty(len(job.dark), projectors.height, projectors.width, 3) if any(wanted[_PARTS + 5 :]) else None
        )
        out = ffi.new("FfpRenderGradients *")
        out.gaussians, out.patterns = _arrays(parts), _at(patterns)
        for name, tensor in zip(
            ("intensity", "cameras", "camera_focals", "projectors", "projector_focals"), numbers
        ):
            setattr(out, name, _at(tensor, "double *"))
        maps = _maps_at({name: g for name, g in zip(job.maps, grads[1:]) if g is not None})
        with canvas._lock, canvas.call as call:
            call.check(
                lib.ffp_renderer_backward(
                    call.context,
                    canvas._pointer,
                    _at(grads[0]),
                    0 if grads[0] is None else grads[0].numel(),
                    maps,
                    len(maps),
                    out,
                    call.error,
                )
            )
        rest: list[Any] = [numbers[0]]
        for i in (1, 3):
            pose, focal = numbers[i], numbers[i + 1]
            rest.append(None if pose is None else _pose_gradient(pose.view(-1, 6), given[_PARTS + i]))
            rest.append(None if focal is None else focal.view(-1, 2))
        lit = [p for p, dark in enumerate(job.dark) if not dark]
        shown = [patterns[p] if patterns is not None and want else None for p, want in zip(lit, wanted[_PARTS + 5 :])]
        rest = [g if g is None else g.to(t.dtype) for g, t in zip(rest, given[_PARTS : _PARTS + 5])]
        return (None, *parts, *rest, *shown)


def _devices_of(given: AnyDevices, name: str) -> Devices:
    d = given if isinstance(given, Devices) else Devices.of([given] if isinstance(given, Pinhole) else given)
    views = len(d.pose)
    if (
        tuple(d.pose.shape[1:]) != (4, 4)
        or tuple(d.focal.shape) != (views, 2)
        or tuple(d.centre.shape) != (views, 2)
    ):
        raise argument_error("expected pose [views,4,4], focal [views,2] and centre [views,2]", name)
    return d


@checked
def render(
    gaussians: Parts | Gaussians,
    cameras: AnyDevices,
    projectors: AnyDevices,
    patterns: Sequence[Tensor | None] | Tensor,
    intensity: Tensor | Sequence[float] | Any,
    *,
    maps: Sequence[str] = (),
    linear: bool = False,
    form: str = "ours",
    samples: int = 0,
    threads: int = 0,
) -> Any:
    """Pictures [views,patterns,height,width,3] of Gaussians over black, differentiable with respect to all tensors.

    Args:
        gaussians: tensors, or ffprocams.Gaussians, which then are constants.
        cameras: of one size, one for each view: pinholes, or Devices for gradients; or one pinhole without a list.
        projectors: likewise.
        patterns: each [height,width,3] of the projectors' size, float32, linear; None: a dark projector.
        intensity: [3] or one number, the projector's radiant intensity at pattern value 1.
        maps: G-buffers to return as well, by the names of Renderer.map.
        linear: linear radiance, premultiplied, not clipped; otherwise sRGB-encoded in [0,1].
        form, samples, threads: as for Renderer.

    Returns:
        The pictures; with ``maps``: the pictures and a dict of maps [views,height,width(,3)]. Of a camera without a list
        they have no axis of views.

    Constants of the backward pass are shadows, the size of a pixel's footprint in the pattern, and which splats a pixel
    sees in which order. Tensors that are written to between the forward and the backward pass raise an error.

    Raises:
        ArgumentError: an argument is wrong; the error names the tensor.
    """
    parts = Parts.of(gaussians) if isinstance(gaussians, Gaussians) else gaussians
    seen, lit = _devices_of(cameras, "cameras"), _devices_of(projectors, "projectors")
    if len(seen.pose) != len(lit.pose):
        raise argument_error(f"{len(seen.pose)} cameras but {len(lit.pose)} projectors", "cameras")
    for name in maps:
        one_of(_MAPS, name, "maps")
    count = len(parts.centre)
    scattered = torch.zeros(count, 3) if parts.scattered is None else parts.scattered
    widths = ((3,), (3,), (4,), (), (3,), (), (3,), (3,))
    arrays = [_floats(t, name, (count, *w)) for t, name, w in zip((*parts[:7], scattered), Parts._fields, widths)]
    shape = (lit.height, lit.width, 3)
    shown = [_floats(p, f"patterns[{i}]", shape) for i, p in enumerate(patterns) if p is not None]
    light = (
        torch.as_tensor(intensity, dtype=torch.float32) if not isinstance(intensity, Tensor) else intensity
    )
    light = light.expand(3) if light.dim() == 0 else light
    if tuple(light.shape) != (3,):
        raise argument_error(f"shape {tuple(light.shape)} is not (3,)", "intensity")
    given = (*arrays, light, seen.pose, seen.focal, lit.pose, lit.focal, *shown)
    gradients = torch.is_grad_enabled() and any(t.requires_grad for t in given)
    lease = _Lease(form, samples, threads)
    job = _Job(seen, lit, [p is None for p in patterns], list(dict.fromkeys(maps)), linear, lease, gradients)
    drawn = _Render.apply(job, *given)  # type: ignore[no-untyped-call]
    if isinstance(cameras, Pinhole):
        drawn = [t[0] for t in drawn]
    return (drawn[0], dict(zip(job.maps, drawn[1:]))) if maps else drawn[0]


def _logit(p: Tensor) -> Tensor:
    inside = p.clamp(_SIGMOID_LEAST, 1 - _SIGMOID_LEAST)
    return torch.log(inside / (1 - inside))


def _matrices(q: Tensor) -> Tensor:
    """[n,3,3] of unit quaternions."""
    w, x, y, z = q.unbind(1)
    rows = (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),
            1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x),
            1 - 2 * (x * x + y * y))  # fmt: skip
    return torch.stack(rows, 1).view(-1, 3, 3)


@checked
class Splats(torch.nn.Module):
    """Gaussians whose parameters are unbounded numbers, those of the library's own fits: logarithms of the scales, logits
    of opacity, albedo, ambient colour and roughness (from 0.05), roots of scattered light, quaternions, and the displacement of each centre from its
    start in the splat's own frame, in units of its largest scale. Called without arguments it gives Parts for render."""

    def __init__(self, gaussians: Gaussians | Parts) -> None:
        super().__init__()
        start = (
            Parts.of(gaussians)
            if isinstance(gaussians, Gaussians)
            else Parts(*(t.detach() for t in gaussians if t is not None))
        )
        frame = torch.nn.functional.normalize(start.rotation, dim=1)
        self.origin: Tensor
        self.frame: Tensor
        self.register_buffer("origin", start.centre.clone())
        self.register_buffer("frame", _matrices(frame) * start.scale.amax(1).view(-1, 1, 1))
        self.centre = torch.nn.Parameter(torch.zeros_like(start.centre))
        self.scale = torch.nn.Parameter(start.scale.clamp_min(1e-12).log())
        self.rotation = torch.nn.Parameter(frame)
        self.opacity = torch.nn.Parameter(_logit(start.opacity))
        self.albedo = torch.nn.Parameter(_logit(start.albedo))
        self.roughness = torch.nn.Parameter(
            _logit((start.roughness - _ROUGHNESS_FLOOR) / (1 - _ROUGHNESS_FLOOR))
        )
        self.ambient = torch.nn.Parameter(_logit(start.ambient))
        scattered = torch.zeros_like(start.ambient) if start.scattered is None else start.scattered
        self.scattered = torch.nn.Parameter(scattered.clamp_min(0).sqrt())  # 0 stays 0

    def forward(self) -> Parts:
        return Parts(
            torch.baddbmm(self.origin.unsqueeze(2), self.frame, self.centre.unsqueeze(2)).squeeze(2),
            self.scale.exp(),
            self.rotation,  # the renderer normalises
            self.opacity.sigmoid(),
            self.albedo.sigmoid(),
            _ROUGHNESS_FLOOR + (1 - _ROUGHNESS_FLOOR) * self.roughness.sigmoid(),
            self.ambient.sigmoid(),
            self.scattered.square(),
        )

    def rates(self, factor: float = 1.0) -> list[dict[str, Any]]:
        """Parameter groups for torch.optim.Adam with the learning rates of ffprocams.refine times ``factor``.
        Raises ArgumentError if that is not a number."""
        rates = {"centre": 0.02, "scale": 0.01, "rotation": 0.005, "opacity": 0.02, "albedo": 0.02,
                 "roughness": 0.0025, "ambient": 0.02, "scattered": 0.002}  # fmt: skip
        return [{"params": [getattr(self, name)], "lr": factor * rate} for name, rate in rates.items()]

    def gaussians(self) -> Gaussians:
        """The parameters' Gaussians, as those of the package."""
        with torch.no_grad():
            return Gaussians.from_arrays(*(t.numpy() for t in self()))


@checked
class SplatAdam(torch.optim.Adam):
    """Adam as ffprocams.refine takes its steps: rates that fall to a tenth, numbers that are drawn back towards their start
    after each step (``pull`` of 1), and a number that all roughness logits share, because a highlight is in few pixels.
    ``pull`` 0 leaves the splats free."""

    _PULLS: ClassVar = {
        "centre": 2,
        "scale": 2,
        "rotation": 2,
        "opacity": 2,
        "albedo": 0.4,
        "roughness": 2,
        "ambient": 0.4,
        "scattered": 0.4,
    }

    def __init__(self, splats: Splats, steps: int, pull: float = 1.0) -> None:
        """steps: how many step() will be called."""
        expects(steps > 0, "steps", "at least 1", steps)
        self._splats, self._steps, self._taken, self._pull = splats, steps, 0, pull
        self._shared = torch.nn.Parameter(torch.zeros(()))
        groups = [*splats.rates(), {"params": [self._shared], "lr": 0.05}]
        super().__init__(groups, betas=(0.9, 0.99), eps=1e-12, fused=True)
        self._rates = [group["lr"] for group in self.param_groups]
        self._start = {name: getattr(splats, name).detach().clone() for name in self._PULLS}

    @torch.no_grad()
    def step(self, closure: Any = None) -> Any:
        """One step; closure as for torch.optim.Adam. Raises what that raises."""
        for group, rate in zip(self.param_groups, self._rates):
            group["lr"] = rate * 0.1 ** min(self._taken / self._steps, 1)
        self._taken += 1
        roughness, before = self._splats.roughness, self._shared.clone()
        self._shared.grad = None if roughness.grad is None else roughness.grad.sum()
        out = super().step(closure)
        moved = self._shared - before
        roughness.add_(moved)
        self._start["roughness"] += moved
        for group, (name, pull) in zip(self.param_groups, self._PULLS.items()):
            getattr(self._splats, name).lerp_(self._start[name], min(group["lr"] * pull * self._pull, 1))
        return out


# --- Losses, on encoded pictures [...,height,width,3] in [0,1] and on maps. ---


@checked
def encode(linear: Tensor) -> Tensor:
    """Linear light in [0,1] as sRGB-encoded values in [0,1] (IEC 61966-2-1); values outside are clipped.
    Raises ArgumentError unless given tensors."""
    x = linear.clamp(0, 1)
    return torch.where(x <= 0.0031308, 12.92 * x, 1.055 * x.clamp_min(0.0031308) ** (1 / 2.4) - 0.055)


@checked
def decode(encoded: Tensor) -> Tensor:
    """sRGB-encoded values in [0,1] as linear light in [0,1]. Raises ArgumentError unless given tensors."""
    x = encoded.clamp(0, 1)
    return torch.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


@checked
def psnr(picture: Tensor, target: Tensor) -> Tensor:
    """dB, over all pixels and channels. Raises ArgumentError unless given tensors."""
    return -10 * torch.log10((picture - target).square().mean())


class _PictureLoss(torch.autograd.Function):
    """The library's loss of pictures (ffp_picture_loss); its gradient is found on the way."""

    @staticmethod
    def forward(
        ctx: Any, picture: Tensor, target: Tensor, l1: float, ssim: float, perceptual: float, network: Perceptual | None
    ) -> Tensor:
        if picture.dim() < 3 or picture.shape[-1] != 3 or picture.numel() == 0:
            raise argument_error(f"shape {tuple(picture.shape)} is not [...,height,width,3]", "picture")
        shape = tuple(picture.shape)
        given, wanted = _floats(picture, "picture", shape), _floats(target, "target", shape)
        gradient = torch.empty_like(given) if ctx.needs_input_grad[0] else None
        pictures, loss = ffi.new("FfpPictureLoss *"), ffi.new("double *")
        pictures.count, pictures.height, pictures.width = (
            given.numel() // (3 * shape[-2] * shape[-3]),
            *shape[-3:-1],
        )
        pictures.pictures, pictures.targets, pictures.gradients = _at(given), _at(wanted), _at(gradient)
        pictures.l1, pictures.ssim, pictures.perceptual = l1, ssim, perceptual
        pictures.network = ffi.NULL if network is None else network._pointer
        with holding(network), _call_of(torch.get_num_threads()) as call:
            call.check(lib.ffp_picture_loss(call.context, pictures, loss, call.error))
        ctx.gradient = gradient
        return torch.tensor(loss[0], dtype=picture.dtype)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, None, None, None, None, None]:
        gradient = ctx.gradient
        return gradient if gradient is None or float(grad) == 1 else gradient * grad, None, None, None, None, None


def _call_of(threads: int) -> Call:
    """One call a thread, which is made once."""
    calls: dict[Any, Call] = _calls.__dict__
    if threads not in calls:
        calls[threads] = Call(threads=threads)
    return calls[threads]


_calls = threading.local()


def _picture_loss(
    picture: Tensor, target: Tensor, l1: float, ssim: float, perceptual: float = 0, network: Perceptual | None = None
) -> Tensor:
    return _PictureLoss.apply(picture, target.detach(), l1, ssim, perceptual, network)  # type: ignore[no-any-return, no-untyped-call]


@checked
def l1_loss(picture: Tensor, target: Tensor) -> Tensor:
    """Mean absolute difference of pictures [...,height,width,3] (FF-ProCams, Eq. 18). The target is a constant.
    Raises ArgumentError for other tensors than float32 of one shape."""
    return _picture_loss(picture, target, 1, 0)


@checked
def ssim(picture: Tensor, target: Tensor) -> Tensor:
    """Mean structural similarity (Wang et al. 2004): 11 x 11 Gaussian, sigma 1.5, zero padding. The target is a
    constant. Raises ArgumentError for other tensors than float32 of one shape."""
    return 1 - _picture_loss(picture, target, 0, 1)


@checked
def photometric_loss(picture: Tensor, target: Tensor) -> Tensor:
    """0.8 L1 + 0.2 (1 - SSIM), as the paper and the library's fits have it. The target is a constant.
    Raises ArgumentError for other tensors than float32 of one shape."""
    return _picture_loss(picture, target, 0.8, 0.2)


@checked
class Perceptual(Handle):
    """Weights of the perceptual term: safetensors that ``python -m ffprocams.perceptual`` writes,
    LPIPS with AlexNet or SqueezeNet or VGG16 up to relu2_2."""

    @classmethod
    def open(cls, path: PathLike) -> Perceptual:
        """From safetensors. Raises MissingFileError or FileFormatError for a file that is missing or damaged."""
        keep = Keep()
        with Call() as call:
            made = lib.ffp_perceptual_open(call.context, keep.path(path), ffi.NULL, call.error)
            return cls(call.take(made, lib.ffp_perceptual_close))


@checked
def perceptual_loss(picture: Tensor, target: Tensor, network: Perceptual) -> Tensor:
    """Mean distance that the network finds between sRGB-encoded pictures [...,height,width,3]: LPIPS, or with VGG16 the
    squared distance of features at relu1_2 and relu2_2. The target is a constant.
    Raises ArgumentError for other tensors than float32 of one shape."""
    return _picture_loss(picture, target, 0, 0, 1, network)


@checked
def mask_loss(opacity: Tensor, mask: Tensor) -> Tensor:
    """Mean binary cross-entropy of the opacity map against the object's share of each pixel (FF-ProCams, Eq. 20).
    Raises ArgumentError unless given tensors."""
    o = opacity.clamp(1e-6, 1 - 1e-6)
    return -(mask * o.log() + (1 - mask) * (1 - o).log()).mean()


@checked
def depth_loss(depth: Tensor, truth: Tensor) -> Tensor:
    """Mean squared error of the depth map over pixels where both have a surface (0: none).
    Raises ArgumentError unless given tensors."""
    both = (truth > 0) & (depth > 0)
    return (depth - truth)[both].square().mean() if bool(both.any()) else depth.sum() * 0


@checked
def distortion_loss(distortion: Tensor) -> Tensor:
    """Mean of the distortion map (FF-ProCams, Eq. 22), in the world's unit of length: it pulls the splats at a pixel
    together along the ray. Raises ArgumentError unless given a tensor."""
    return distortion.mean()


def _neighbours(values: Tensor, mask: Tensor) -> Iterator[tuple[Tensor, Tensor]]:
    """[...,height,width,channels] to its neighbours below and on the right, and where both are foreground."""
    yield values[..., 1:, :, :] - values[..., :-1, :, :], (mask[..., 1:, :] > 0.5) & (mask[..., :-1, :] > 0.5)
    yield values[..., 1:, :] - values[..., :-1, :], (mask[..., 1:] > 0.5) & (mask[..., :-1] > 0.5)


@checked
def normal_smooth_loss(normal: Tensor, mask: Tensor) -> Tensor:
    """Mean |grad N|_1 of the normal map between neighbouring foreground pixels (FF-ProCams, Eq. 23).
    Raises ArgumentError unless given tensors."""
    there = mask * (normal.abs().sum(-1) > 0)
    pairs = [(step.abs().sum(-1) * both, both.sum()) for step, both in _neighbours(normal, there)]
    return sum(total.sum() for total, _ in pairs) / sum(n for _, n in pairs).clamp_min(1)  # type: ignore[return-value, union-attr]


@checked
def roughness_smooth_loss(roughness: Tensor, albedo: Tensor, mask: Tensor) -> Tensor:
    """Mean |grad R|_1 exp(-|grad A|_1) between neighbouring foreground pixels (FF-ProCams, Eq. 24); the albedo map is a
    constant. Raises ArgumentError unless given tensors."""
    steps = list(_neighbours(roughness.unsqueeze(-1), mask))
    trust = [torch.exp(-step.abs().sum(-1)) for step, _ in _neighbours(albedo.detach(), mask)]
    total = sum((step.abs().sum(-1) * t * both).sum() for (step, both), t in zip(steps, trust))
    return total / sum(both.sum() for _, both in steps).clamp_min(1)  # type: ignore[return-value, union-attr, operator]
