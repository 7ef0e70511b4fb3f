"""Draws cameras' pictures of snapshots."""

import numpy as np

from bullet_sim.description.lights import Scene
from bullet_sim.errors import RenderError
from bullet_sim.render.gl.camera import in_view, metres, projection, view, view_planes
from bullet_sim.render.gl.context import Context
from bullet_sim.render.gl.frame import frame_buffer, frame_bytes, light_rows
from bullet_sim.render.gl.meshes.store import Store
from bullet_sim.render.gl.shaders.programs import Programs
from bullet_sim.render.gl.shadows import Shadows
from bullet_sim.render.gl.sky import Sky
from bullet_sim.render.gl.stage import Stage
from bullet_sim.render.gl.surfaces import Lighting, Surfaces
from bullet_sim.render.gl.targets import Targets
from bullet_sim.render.pictures import Pictures, check_body, check_link
from bullet_sim.render.request import DEFAULT
from bullet_sim.render.sources import links_of
from bullet_sim.sensors.frames import sensor_in_world

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
