"""The OpenGL renderer: cameras, sky and surfaces -> pictures, depths, labels."""

import math
from dataclasses import dataclass

import numpy as np

from bullet_sim.description.world import Light, Scene
from bullet_sim.errors import RenderError
from bullet_sim.pose import sensor_in_world
from bullet_sim.render.gl.context import Context, Targets
from bullet_sim.render.gl.meshes import Store
from bullet_sim.render.gl.scene import Stage
from bullet_sim.render.gl.shaders import Programs, frame_buffer, frame_bytes, light_rows
from bullet_sim.render.gl.shadows import Shadows
from bullet_sim.render.renderer import HORIZON, ZENITH, Pictures, check_body, check_link, links_of
from bullet_sim.render.request import DEFAULT
from bullet_sim.sensors.camera import view_matrix


def projection(horizontal_fov, aspect, near, far):
    """(4, 4) from the eye's axes to clip space, upside down, with depth 1 near and 0 far.

    Upside down, since OpenGL's first row is the lowest and a picture's the uppermost.

    Args:
        horizontal_fov: [rad].
        aspect: width / height.
        near, far: clip distances [m].
    """
    x = 1.0 / math.tan(horizontal_fov / 2.0)
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = x, -x * aspect
    matrix[2, 2], matrix[2, 3] = near / (far - near), near * far / (far - near)
    matrix[3, 2] = -1.0
    return matrix


def view(position, rotation):
    """(4, 4) from the world to the eye (x right, y up, looking along -z)."""
    return np.reshape(view_matrix(position, rotation), (4, 4)).T


def view_planes(clip):
    """The six planes of a view, (6, 4): distance of a point inside is positive [m].

    Args:
        clip: (4, 4) to clip space as `projection` has it (Gribb and Hartmann 2001).
    """
    sides = clip[3] + np.array([clip[0], -clip[0], clip[1], -clip[1]])
    planes = np.vstack([sides, clip[3] - clip[2], clip[2]])
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


def in_view(planes, centres, radii, ends=None):
    """Which spheres touch a view, (n,) bool.

    Args:
        planes: as view_planes gives them.
        centres: (n, 3) [m].
        radii: (n,) [m].
        ends: (n, 3) to which they are swept, or None.
    """
    distances = centres @ planes[:, :3].T + planes[:, 3]
    if ends is not None:
        distances = np.maximum(distances, ends @ planes[:, :3].T + planes[:, 3])
    return (distances > -radii[:, None]).all(axis=1)


def metres(buffer, near, far, out=None):
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


class Sky:
    """Draws the sky where nothing else is.

    Args:
        gl: moderngl.Context.
        program: shaders.Programs.sky.
    """

    def __init__(self, gl, program):
        corners = np.array([-1, -1, 3, -1, -1, 3], np.float32)
        self._program = program
        self._array = gl.vertex_array(program, [(gl.buffer(corners.tobytes()), "2f", "in_corner")])
        program["zenith"].value = tuple(value / 255.0 for value in ZENITH)
        program["horizon"].value = tuple(value / 255.0 for value in HORIZON)

    def draw(self, rotation, horizontal_fov, aspect):
        """Draw it.

        Args:
            rotation: (3, 3) of the camera in the world.
            horizontal_fov: [rad].
            aspect: width / height.
        """
        half = math.tan(horizontal_fov / 2.0)
        forward, left, up = rotation.T
        corner = np.array([forward, -half * left, half / aspect * up], np.float32)
        self._program["corner"].write(corner.tobytes())
        self._array.render()


FOGS = {"linear": 1, "exp": 2, "exp2": 3}


@dataclass(frozen=True)
class Lighting:
    """What a scene's lights are to the programs.

    Attributes:
        scene: Scene.
        sun: the directional Light that shines and casts shadows, or None.
        lights: the other Lights.
        has_shadows: whether the sun's shadows are drawn.
    """

    scene: Scene
    sun: Light | None
    lights: list
    has_shadows: bool

    @classmethod
    def of(cls, scene, shadows_wanted):
        """The Lighting of a Scene; its sun is the first one that casts shadows, or the first."""
        suns = [light for light in scene.lights if light.kind == "directional"]
        shining = [light for light in suns if light.cast_shadows] + suns
        sun = shining[0] if shining else None
        lights = [light for light in scene.lights if light is not sun]
        has_shadows = bool(shadows_wanted and scene.shadows and sun and sun.cast_shadows)
        return cls(scene, sun, lights, has_shadows)


class Surfaces:
    """The pass that draws surfaces.

    Args:
        gl: moderngl.Context.
        programs: Programs.
        stage: Stage.
        shadows: Shadows.
    """

    def __init__(self, gl, programs, stage, shadows):
        self._gl, self._programs, self._stage, self._shadows = gl, programs, stage, shadows

    def draw(self, lighting, seen, transparent, position):
        """Draw the opaque surfaces, or the transparent ones from far to near.

        Args:
            lighting: Lighting.
            seen: (n,) bool, the instances that may be seen.
            transparent: which ones.
            position: (3,) [m] of the camera in the world.
        """
        gl, stage = self._gl, self._stage
        batches = [batch for batch in stage.batches if batch.kind.transparent == transparent]
        if transparent:
            if not batches:
                return
            away = np.linalg.norm(stage.centres - position, axis=1)
            batches.sort(key=lambda batch: -away[batch.first])
            gl.depth_func = ">"
            gl.blend_func = gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA
        if lighting.has_shadows:
            self._shadows.fixed.texture.use(1)
            self._shadows.moving.texture.use(2)
        fog = FOGS[lighting.scene.fog.kind] if lighting.scene.fog else 0
        flags, shadowed = None, self._shadows.present if lighting.has_shadows else 0
        for batch in batches:
            selection = stage.select(batch, seen, "seen")
            if not selection:
                continue
            kind = batch.kind
            wanted = gl.DEPTH_TEST | (gl.BLEND if transparent else 0)
            wanted |= 0 if kind.double_sided else gl.CULL_FACE
            if wanted != flags:
                gl.enable_only(wanted)
                flags = wanted
            program = self._programs.surface(
                kind.textured,
                kind.shiny,
                kind.lit,
                lighting.sun is not None,
                shadowed,
                len(lighting.lights),
                fog,
            )
            if batch.look.texture is not None:
                batch.look.texture.use(0)
            stage.array(batch, selection, program).render(instances=selection.count)


GRID = 64.0  # [m] the origin of single-precision places is a multiple of it near the camera
SAMPLES = 4


class GlRenderer(Pictures):
    """Our own OpenGL renderer, with a context of its own: used by one thread.

    Args:
        quality: Quality.

    Attributes:
        device: the driver's name for what draws.
        software: whether that is the processor.
    """

    def __init__(self, quality=DEFAULT):
        self._context = Context()
        self.device, self.software = self._context.device, self._context.software
        gl = self._context.gl
        self._shadows_wanted = quality.shadows != "false"
        self._samples = self._samples_for(quality.antialias)
        anisotropy = 1.0 if self.software else min(gl.max_anisotropy, 16.0)
        self._programs = Programs(gl)
        self._store = Store(gl, anisotropy)
        self._stage = Stage(gl, self._store)
        self._shadows = Shadows(gl, self._programs.depth, 4096)
        self._sky = Sky(gl, self._programs.sky)
        self._targets = Targets(self._context)
        self._frame = frame_buffer(gl)
        self._surfaces = Surfaces(gl, self._programs, self._stage, self._shadows)
        self._sources = {}
        self._lighting = Lighting.of(Scene(), self._shadows_wanted)

    def _samples_for(self, antialias):
        wanted = not self.software if antialias == "auto" else antialias == "true"
        return min(SAMPLES, self._context.gl.max_samples) if wanted else 0

    # what is drawn ----------------------------------------------------------------------------
    def sync_sources(self, sources, scene=None):
        """Show these bodies.

        Args:
            sources: iterable of BodySource, the complete list.
            scene: Scene with the lights; None: as before.

        Raises:
            RenderError: what cannot be drawn, all in one message; the rest is drawn.
        """
        if scene is not None:
            self._lighting = Lighting.of(scene, self._shadows_wanted)
        wanted = {source.key: source for source in sources}
        if wanted == self._sources:
            return
        self._context.use()
        bodies, failures = {}, []
        for key, source in wanted.items():
            try:
                bodies[key] = links_of(source)
            except Exception as error:  # pylint: disable=broad-except
                failures.append(f"body {key} ({source.path}): {error}")
        self._sources = wanted
        fixed = {key for key, source in wanted.items() if source.fixed_base}
        failures += self._stage.set_bodies(bodies, fixed)
        self._context.collect()
        if failures:
            raise RenderError("not drawn: " + "; ".join(failures))

    def apply(self, snapshot):
        """Put every body where a Snapshot has it; bodies without a state stay."""
        self._stage.apply(snapshot)

    # pictures ---------------------------------------------------------------------------------
    def draw(self, snapshot, request):
        """The picture of a camera of a snapshot.

        Args:
            snapshot: Snapshot.
            request: CameraRequest.

        Returns:
            (H, W, 3) uint8 RGB, top row first.
        """
        self.apply(snapshot)
        return self.render(request, snapshot.step)

    @property
    def details(self):
        """What draws, in a few words."""
        shadows = "shadows" if self._shadows_wanted else "no shadows"
        samples = f"{self._samples} samples a pixel" if self._samples else "no antialiasing"
        return f"{self.device}, {shadows}, {samples}"

    def _look(self, request):
        """Prepare the stage for a camera.

        Returns:
            Its position (3,) [m] and rotation (3, 3), the matrix (4, 4) from places relative to the
            stage's origin to clip space, the planes of its view, and what may be seen, (n,) bool.
        """
        position, rotation = self.camera_pose(request)
        stage = self._stage
        self._context.use()
        stage.set_origin(np.round(position / GRID) * GRID)
        clip = projection(
            request.horizontal_fov, request.width / request.height, request.near, request.far
        ) @ view(position - stage.origin, rotation)
        planes = view_planes(clip)
        seen = in_view(planes, stage.centres - stage.origin, stage.radii)
        return position, rotation, clip, planes, seen

    def picture(self, request, rgb=None, depth=None):
        """See Pictures."""
        position, rotation, clip, planes, seen = self._look(request)
        stage, gl, lighting = self._stage, self._context.gl, self._lighting
        samples = 0 if request.depth else self._samples
        target = self._targets.get(request.width, request.height, samples)
        if lighting.has_shadows:
            away = np.array(lighting.sun.direction)
            centres = stage.centres - stage.origin
            ends = centres + stage.shadow_lengths(away)[:, None] * away
            casts = stage.casts & in_view(planes, centres, stage.radii, ends)
            focal = request.width / (2.0 * np.tan(request.horizontal_fov / 2.0))
            self._shadows.update(stage, casts, -away, position, focal)
        self._frame.write(
            frame_bytes(
                clip,
                position - stage.origin,
                lighting.scene,
                lighting.sun,
                light_rows(lighting.lights, stage.origin),
                self._shadows if lighting.has_shadows else None,
            )
        )
        self._frame.bind_to_uniform_block(0)
        self._begin(target, (*(lighting.scene.background or (0.0, 0.0, 0.0)), 1.0))
        self._surfaces.draw(lighting, seen, False, position)
        if lighting.scene.background is None:
            gl.enable_only(gl.DEPTH_TEST)
            gl.depth_func = ">="
            self._sky.draw(rotation, request.horizontal_fov, request.width / request.height)
        self._surfaces.draw(lighting, seen, True, position)
        rgb = target.colors(rgb)
        if request.depth:
            depth = metres(target.depth(), request.near, request.far, depth)
        return rgb, depth

    def label_picture(self, request):
        """See Pictures; glass and the holes of cut-out textures count as what they belong to."""
        _, _, clip, _, seen = self._look(request)
        stage, gl, program = self._stage, self._context.gl, self._programs.label
        target = self._targets.get(request.width, request.height, 0)
        self._begin(target, (0.0,) * 4)
        program["clip"].write(clip.T.astype(np.float32).tobytes())
        for batch in stage.batches:
            selection = stage.select(batch, seen, "seen")
            if selection:
                double = batch.kind.double_sided
                gl.enable_only(gl.DEPTH_TEST if double else gl.DEPTH_TEST | gl.CULL_FACE)
                stage.array(batch, selection, program).render(instances=selection.count)
        return target.labels()

    def _begin(self, target, color):
        """Draw to a target from now on, which is cleared; pictures are drawn upside down."""
        gl = self._context.gl
        target.draw.use()
        gl.front_face, gl.depth_func = "cw", ">"
        target.draw.clear(*color, depth=0.0)

    def camera_pose(self, request):
        """Position (3,) [m] and rotation (3, 3) of a request's camera in the world.

        Raises:
            RenderError: its body or link is not there.
        """
        if request.key is None:
            return sensor_in_world(np.zeros(3), (0.0, 0.0, 0.0, 1.0), request.pose)
        firsts = self._stage.kinematics.firsts
        check_body(request, firsts)
        check_link(request, self._stage.kinematics.counts[request.key])
        place = self._stage.kinematics.places[firsts[request.key] + request.link_index]
        local = sensor_in_world(np.zeros(3), (0.0, 0.0, 0.0, 1.0), request.pose)
        return place[:3, :3] @ local[0] + place[:3, 3], place[:3, :3] @ local[1]

    def close(self):
        """Release the context."""
        self._context.close()
