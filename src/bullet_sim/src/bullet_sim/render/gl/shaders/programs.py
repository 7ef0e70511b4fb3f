"""The shader programs, made for what a batch needs: fewer features are faster."""

from functools import lru_cache

from bullet_sim.render.gl.frame import FRAME
from bullet_sim.render.gl.shaders import passes, surface


class Programs:
    """Programs of one context, made when first needed.

    Args:
        gl: moderngl.Context.
    """

    def __init__(self, gl):
        self._gl = gl
        self.surface = lru_cache(maxsize=None)(self._surface)
        self.depth = self._program(passes.DEPTH_VERTEX, passes.DEPTH_FRAGMENT)
        self.label = self._program(passes.LABEL_VERTEX, passes.LABEL_FRAGMENT)
        self.sky = self._program(passes.SKY_VERTEX, passes.SKY_FRAGMENT)

    def _program(self, vertex, fragment, head=""):
        start = f"#version 330 core\n{head}"
        return self._gl.program(vertex_shader=start + vertex, fragment_shader=start + fragment)

    def _surface(self, textured, shiny, lit, sun, shadowed, lights, fog):
        """Program that draws surfaces.

        Args:
            textured, shiny, lit: of the batch.
            sun: whether the scene has one.
            shadowed: whether something that stands still casts shadows (1) and something that
                moves (2), added up.
            lights: number of further lights.
            fog: 0 none, 1 linear, 2 exp, 3 exp2.
        """
        shiny, sun, lights = shiny and lit, sun and lit, lights if lit else 0
        values = {
            "TEXTURED": textured,
            "SHINY": shiny,
            "LIT": lit,
            "SUN": sun,
            "SHADOWED": shadowed if sun and lit else 0,
            "LIGHTS": lights,
            "FOG": fog,
            "NEEDS_NORMAL": shiny or lights,
            "NEEDS_PLACE": shiny or lights or fog,
        }
        head = "".join(f"#define {name} {int(value)}\n" for name, value in values.items())
        program = self._program(surface.VERTEX, surface.FRAGMENT, head + FRAME)
        for name, unit in (("picture", 0), ("fixed_map", 1), ("moving_map", 2)):
            if name in program:
                program[name].value = unit
        if "Frame" in program:
            program["Frame"].binding = 0
        return program
