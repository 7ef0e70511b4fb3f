"""The OpenGL renderer: cameras, sky and surfaces -> images, depths, labels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bullet_sim.description.model import Light, VisualLink
from bullet_sim.description.world import Scene
from bullet_sim.errors import RenderError
from bullet_sim.pose import Array, Vector, sensor_in_world
from bullet_sim.render.gl.context import Context, Target, Targets
from bullet_sim.render.gl.meshes import AssetCache
from bullet_sim.render.gl.scene import Batch, Instances
from bullet_sim.render.gl.shaders import (
    LAYER_UNIT,
    NORMALS_UNIT,
    SIZE,
    Programs,
    frame_bytes,
    light_rows,
)
from bullet_sim.render.gl.shadows import Shadows
from bullet_sim.render.gl.sky import Sky
from bullet_sim.render.renderer import Renderer, check_body, check_link
from bullet_sim.render.request import DEFAULT, CameraRequest, Quality
from bullet_sim.sensors.camera import shown_intrinsics, view_matrix
from bullet_sim.snapshot import BodySource, Snapshot


def projection(shown: Array, width: int, height: int, near: float, far: float) -> Array:
    """(4, 4) from the eye's axes to clip space, upside down, with depth 1 near and 0 far.

    Upside down, since OpenGL's first row is the lowest and an image's the uppermost.

    Args:
        shown: (2, 3), see sensors.camera.shown_intrinsics.
        width, height: of the image [px].
        near, far: clip distances [m].
    """
    matrix = np.zeros((4, 4))
    scaled = 2.0 * shown / np.array([[width], [height]])
    matrix[:2, :3] = scaled * (1.0, -1.0, -1.0)  # the eye has y up, and looks along -z
    matrix[:2, 2] += 1.0
    matrix[2, 2], matrix[2, 3] = near / (far - near), near * far / (far - near)
    matrix[3, 2] = -1.0
    return matrix


def view_planes(clip: Array) -> Array:
    """The six planes of a view, (6, 4): distance of a point inside is positive [m].

    Args:
        clip: (4, 4) to clip space as `projection` has it (Gribb and Hartmann 2001).
    """
    sides = clip[3] + np.array([clip[0], -clip[0], clip[1], -clip[1]])
    planes = np.vstack([sides, clip[3] - clip[2], clip[2]])
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


def in_view(planes: Array, centers: Array, radii: Array, ends: Array | None = None) -> Array:
    """Which spheres touch a view, (n,) bool.

    Args:
        planes: as view_planes returns them.
        centers: (n, 3) [m].
        radii: (n,) [m].
        ends: (n, 3) to which they are swept, or None.
    """
    distances = centers @ planes[:, :3].T + planes[:, 3]
    if ends is not None:
        distances = np.maximum(distances, ends @ planes[:, :3].T + planes[:, 3])
    return (distances > -radii[:, None]).all(axis=1)


def meters(buffer: Array, near: float, far: float, out: Array | None = None) -> Array:
    """Distances along the optical axis of a reversed depth buffer.

    Args:
        buffer: (H, W) float32, 1 at the near plane ... 0 at the far plane and where nothing is.
        near, far: clip distances [m].
        out: array that takes the result; None: a new one.

    Returns:
        (H, W) float32 [m].
    """
    scale, shift = near * far / (far - near), near / (far - near)
    out = np.add(buffer, np.float32(shift), out=out)
    np.divide(np.float32(scale), out, out=out)
    out[buffer == 0.0] = far
    return out


# Finish.blend -> factors of what is rendered and of what is there.
BLENDS = {
    "alpha": ("SRC_ALPHA", "ONE_MINUS_SRC_ALPHA"),
    "add": ("ONE", "ONE"),
    "modulate": ("DST_COLOR", "ZERO"),
    "color": ("SRC_COLOR", "ONE_MINUS_SRC_COLOR"),
}
FOGS = {"linear": 1, "exp": 2, "exp2": 3}


@dataclass(frozen=True)
class Lighting:
    """What a scene's lights are to the programs.

    Attributes:
        sun: the directional light that shines and casts shadows, or None.
        lights: the others.
        shadow_sun: the sun if its shadows are rendered, else None.
    """

    scene: Scene
    sun: Light | None
    lights: list[Light]
    shadow_sun: Light | None

    @classmethod
    def of(cls, scene: Scene, shadows_enabled: bool) -> Lighting:
        """The Lighting of a Scene; its sun is the first one that casts shadows, or the first."""
        suns = [light for light in scene.lights if light.kind == "directional"]
        shining = [light for light in suns if light.cast_shadows] + suns
        sun = shining[0] if shining else None
        lights = [light for light in scene.lights if light is not sun]
        has_shadows = shadows_enabled and scene.shadows and sun and sun.cast_shadows
        return cls(scene, sun, lights, sun if has_shadows else None)


@dataclass(frozen=True)
class View:
    """What a camera sees.

    Attributes:
        position: (3,) [m] in the world.
        rotation: (3, 3) of the camera in the world.
        shown: (2, 3), see sensors.camera.shown_intrinsics.
        clip: (4, 4) from positions relative to the origin of the Instances to clip space.
        planes: (6, 4), see view_planes.
        visible: (n,) bool, the instances that may be visible.
    """

    position: Array
    rotation: Array
    shown: Array
    clip: Array
    planes: Array
    visible: Array


ROADS = 0  # key that no body has: labels show nothing there
GRID = 64.0  # [m] the origin of single-precision positions is a multiple of it near the camera


class GlRenderer(Renderer):
    """Our own OpenGL renderer, with a context of its own, used by one thread.

    Attributes:
        device: the driver's name for what renders.
        software: whether that is the processor.
    """

    def __init__(self, quality: Quality = DEFAULT) -> None:
        self._context = Context()
        self.device, self.software = self._context.device, self._context.software
        gl = self._context.gl
        self._shadows_enabled, antialias = (
            not self.software if switch == "auto" else switch == "true"
            for switch in (quality.shadows, quality.antialias)
        )
        self._samples = gl.max_samples if antialias else 0
        anisotropy = min(gl.max_anisotropy, 16.0)
        self._programs = Programs(gl)
        self._instances = Instances(gl, AssetCache(gl, anisotropy))
        self._shadows = Shadows(gl, self._programs.depth, 4096)
        self._sky = Sky(gl, self._programs.sky)
        self._targets = Targets(self._context)
        self._frame = gl.buffer(reserve=4 * SIZE, dynamic=True)
        self._sources: dict[int, BodySource] = {}
        self._lighting = Lighting.of(Scene(), self._shadows_enabled)

    # what is rendered -------------------------------------------------------------------------
    def sync_sources(self, sources: Iterable[BodySource], scene: Scene | None = None) -> None:
        """See Renderer."""
        if scene is not None:
            self._lighting = Lighting.of(scene, self._shadows_enabled)
        current = {source.key: source for source in sources}
        if self._lighting.scene.roads:
            roads = VisualLink(shapes=self._lighting.scene.roads)
            current[ROADS] = BodySource(ROADS, True, (roads,))
        if current == self._sources:
            return
        self._context.use()
        bodies = {key: source.links for key, source in current.items()}
        self._sources = current
        fixed = {key for key, source in current.items() if source.fixed_base}
        failures = self._instances.set_bodies(bodies, fixed)
        self._context.collect()
        if failures:
            raise RenderError("not rendered: " + "; ".join(failures))

    def apply(self, snapshot: Snapshot) -> None:
        """See Renderer."""
        self._instances.apply(snapshot)

    # images -----------------------------------------------------------------------------------
    def draw(self, snapshot: Snapshot, request: CameraRequest) -> Array:
        """The image of a camera of a snapshot, (H, W, 3) uint8 RGB, top row first."""
        self.apply(snapshot)
        return self.render(request, snapshot.step)

    @property
    def details(self) -> str:
        """What renders, in a few words."""
        shadows = "shadows" if self._shadows_enabled else "no shadows"
        samples = f"{self._samples} samples a pixel at most" if self._samples else "no antialiasing"
        return f"{self.device}, {shadows}, {samples}"

    def _samples_of(self, request: CameraRequest) -> int:
        """Samples a pixel, 0 for one; as in Gazebo none but those that the driver has."""
        wanted = request.samples
        return wanted if 1 < wanted <= self._samples and wanted & (wanted - 1) == 0 else 0

    def _view(self, request: CameraRequest) -> View:
        """Prepare the instances for a camera."""
        position, rotation = self.camera_pose(request)
        instances = self._instances
        self._context.use()
        instances.set_origin(np.round(position / GRID) * GRID)
        eye = np.reshape(view_matrix(position - instances.origin, rotation), (4, 4)).T
        size = request.width, request.height
        shown = shown_intrinsics(*size, request.horizontal_fov, request.intrinsics)
        clip = projection(shown, *size, request.near, request.far) @ eye
        planes = view_planes(clip)
        visible = in_view(planes, instances.centers - instances.origin, instances.radii)
        visible &= (instances.visibility & request.visibility) != 0
        return View(position, rotation, shown, clip, planes, visible)

    def image(
        self, request: CameraRequest, rgb: Array | None = None, depth: Array | None = None
    ) -> tuple[Array, Array | None]:
        """See Renderer."""
        view, instances, lighting = self._view(request), self._instances, self._lighting
        gl, scene, position = self._context.gl, lighting.scene, view.position
        lights = [*lighting.lights, *instances.lights()]
        samples = 0 if request.depth else self._samples_of(request)
        target = self._targets.get(request.width, request.height, samples)
        if lighting.shadow_sun is not None:
            away = np.array(lighting.shadow_sun.direction)
            centers = instances.centers - instances.origin
            ends = centers + instances.shadow_lengths(away)[:, None] * away
            casts = instances.casts & in_view(view.planes, centers, instances.radii, ends)
            self._shadows.update(instances, casts, -away, position, view.shown[0, 0])
        self._frame.write(
            frame_bytes(
                view.clip,
                position - instances.origin,
                scene,
                lighting.sun,
                light_rows(lights, instances.origin),
                self._shadows if lighting.shadow_sun else None,
            )
        )
        self._frame.bind_to_uniform_block(0)
        self._start(target, (*(scene.background or (0.0, 0.0, 0.0)), 1.0))
        self._render_surfaces(view, len(lights), transparent=False)
        if scene.background is None:
            gl.enable_only(gl.DEPTH_TEST)
            gl.depth_func = ">="
            self._sky.render(view.rotation, view.shown, target.size, scene.daytime)
        self._render_surfaces(view, len(lights), transparent=True)
        rgb = target.colors(rgb)
        if request.depth:
            self._fill_holes(view, target)
            depth = meters(target.depth(), request.near, request.far, depth)
        return rgb, depth

    def _fill_holes(self, view: View, target: Target) -> None:
        """Render the depths of cut-out surfaces where their images have holes, as in Gazebo."""
        target.framebuffer.use()
        self._context.gl.depth_func = ">"
        batches = [batch for batch in self._instances.batches if batch.type.rejects]
        self._render_shapes(view, batches, self._programs.depth)

    def _render_shapes(self, view: View, batches: Iterable[Batch], program: Any) -> None:
        """Render what surfaces cover, whatever their images are."""
        gl = self._context.gl
        for batch in batches:
            selection = self._instances.select(batch, view.visible, "visible")
            if selection:
                double = batch.type.double_sided
                gl.enable_only(gl.DEPTH_TEST if double else gl.DEPTH_TEST | gl.CULL_FACE)
                program["clip"].write(view.clip.T.astype(np.float32).tobytes())
                self._instances.render(batch, selection, program)

    def _render_surfaces(self, view: View, lights: int, transparent: bool) -> None:
        """Render the opaque surfaces, or the transparent ones from far to near."""
        gl, instances, lighting = self._context.gl, self._instances, self._lighting
        batches = [batch for batch in instances.batches if batch.type.transparent == transparent]
        if transparent:
            if not batches:
                return
            away = np.linalg.norm(instances.centers - view.position, axis=1)
            batches.sort(key=lambda batch: -away[batch.first])
            gl.depth_func = ">"
        shadowed = 0
        if lighting.shadow_sun:
            shadowed = self._shadows.present
            self._shadows.fixed.texture.use(1)
            self._shadows.moving.texture.use(2)
        fog = FOGS[lighting.scene.fog.kind] if lighting.scene.fog else 0
        flags = None
        for batch in batches:
            selection = instances.select(batch, view.visible, "visible")
            if not selection:
                continue
            features = gl.DEPTH_TEST | (gl.BLEND if transparent else 0)
            features |= 0 if batch.type.double_sided else gl.CULL_FACE
            if features != flags:
                gl.enable_only(features)
                flags = features
            if transparent:
                gl.blend_func = tuple(getattr(gl, name) for name in BLENDS[batch.type.blend])
            has_sun = lighting.sun is not None
            program = self._programs.surface(batch.variant, has_sun, shadowed, lights, fog)
            if batch.surface.texture is not None:
                batch.surface.texture.use(0)
            self._use_layers(batch, program)
            instances.render(batch, selection, program)

    def _use_layers(self, batch: Batch, program: Any) -> None:
        """Bind a batch's further images and its normal map."""
        for index, (texture, _, matrix) in enumerate(batch.surface.layers):
            texture.use(LAYER_UNIT + index)
            program[f"layer_uv{index}"].write(matrix)
        if batch.surface.normals is not None:
            batch.surface.normals.use(NORMALS_UNIT)

    def label_image(self, request: CameraRequest) -> Array:
        """See Renderer; glass and the holes of cut-out textures count as what they belong to."""
        view = self._view(request)
        target = self._targets.get(request.width, request.height, 0)
        self._start(target, (0.0,) * 4)
        self._render_shapes(view, self._instances.batches, self._programs.label)
        return target.labels()

    def _start(self, target: Target, color: tuple[float, ...]) -> None:
        """Render to a target from now on, which is cleared; images are rendered upside down."""
        gl = self._context.gl
        target.framebuffer.use()
        gl.front_face, gl.depth_func = "cw", ">"
        target.framebuffer.clear(*color, depth=0.0)

    def camera_pose(self, request: CameraRequest) -> tuple[Array, Array]:
        """Position (3,) [m] and rotation (3, 3) of a request's camera in the world.

        Raises:
            RenderError: its body or link does not exist.
        """
        local: tuple[Vector, Vector] = request.pose
        position, rotation = sensor_in_world((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), local)
        if request.key is None:
            return position, rotation
        kinematics = self._instances.kinematics
        check_body(request, kinematics.firsts)
        check_link(request, kinematics.counts[request.key])
        link = kinematics.poses[kinematics.firsts[request.key] + request.link_index]
        return link[:3, :3] @ position + link[:3, 3], link[:3, :3] @ rotation

    def close(self) -> None:
        """Release the context."""
        self._context.close()
