"""Draws the surfaces of a stage in the light of a scene."""

from dataclasses import dataclass

import numpy as np

from bullet_sim.description.lights import Light, Scene

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
