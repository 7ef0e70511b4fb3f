"""The shader programs: their GLSL and their uniforms.

GLSL of the program that renders surfaces, in variants made for what a batch needs.

`Programs` defines the names of the #if lines, and puts `FRAME` before it. Light is added as
Gazebo Classic's per-pixel lighting does, in the colors' space, clamped at the end alone:
    texel * (ambient + emissive + sum of diffuse * cosine * shadow * attenuation) + highlights
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from bullet_sim.description.model import Light
from bullet_sim.description.world import Scene
from bullet_sim.errors import RenderError
from bullet_sim.pose import Array
from bullet_sim.render.gl import sky
from bullet_sim.render.gl.scene import BatchType
from bullet_sim.render.gl.shadows import Shadows

LABEL_VERTEX = """
uniform mat4 clip;
in vec3 in_position;
in vec4 in_row0;
in vec4 in_row1;
in vec4 in_row2;
in vec4 in_label;
flat out vec4 v_label;
void main() {
    vec4 local = vec4(in_position, 1.0);
    gl_Position = clip * vec4(dot(in_row0, local), dot(in_row1, local), dot(in_row2, local), 1.0);
    v_label = in_label;
}
"""
DEPTH_FRAGMENT = "void main() {}"
LABEL_FRAGMENT = """
flat in vec4 v_label;
out vec4 out_color;
void main() { out_color = v_label; }
"""


# What the first stage hands to the second, which defines VARYING as in; the first as out.
VARYINGS = """
flat VARYING vec4 v_color;
#if NEEDS_NORMAL
VARYING vec3 v_normal;
#endif
#if SUN
VARYING float v_facing;
#endif
#if NEEDS_HEIGHT
VARYING float v_height;
#endif
#if NEEDS_POSITION
VARYING vec3 v_position;
#endif
#if NEEDS_UV
VARYING vec2 v_uv;
#endif
#if LIT
flat VARYING vec3 v_ambient;
#endif
#if SHINY
flat VARYING vec4 v_specular;
#endif
#if REJECTS
flat VARYING float v_rejection;
#endif
#if SHADOWED & 1
VARYING vec3 v_fixed;
#endif
#if SHADOWED & 2
VARYING vec3 v_moving;
#endif
"""

VERTEX = """
in vec3 in_position;
in vec3 in_normal;
in vec2 in_uv;
in vec4 in_row0;
in vec4 in_row1;
in vec4 in_row2;
in vec4 in_color;
in vec4 in_ambient;   // w: shininess
in vec4 in_specular;  // w: rejection
in vec4 in_emissive;
void main() {
    vec4 local = vec4(in_position, 1.0);
    vec3 position = vec3(dot(in_row0, local), dot(in_row1, local), dot(in_row2, local));
    vec3 normal = vec3(dot(in_row0.xyz, in_normal), dot(in_row1.xyz, in_normal),
                       dot(in_row2.xyz, in_normal));
    gl_Position = clip * vec4(position, 1.0);
    v_color = in_color;
#if NEEDS_HEIGHT
    v_height = in_position.z;
#endif
#if SUN || SHADOWED
    vec3 outward = normalize(normal);
#endif
#if NEEDS_NORMAL
    v_normal = normal;
#endif
#if SUN
    v_facing = dot(outward, sun.xyz);
#endif
#if NEEDS_POSITION
    v_position = position;
#endif
#if NEEDS_UV
    v_uv = in_uv;
#endif
#if LIT
    v_ambient = ambient.rgb * in_ambient.rgb + in_emissive.rgb;
#endif
#if SHINY
    v_specular = vec4(in_specular.rgb, in_ambient.w);
#endif
#if REJECTS
    v_rejection = in_specular.w;
#endif
#if SHADOWED
    vec3 aside = outward * (0.1 + sqrt(max(1.0 - v_facing * v_facing, 0.0)));
#endif
#if SHADOWED & 1
    v_fixed = (fixed_shadow * vec4(position + sun.w * aside, 1.0)).xyz;
#endif
#if SHADOWED & 2
    v_moving = (moving_shadow * vec4(position + eye.w * aside, 1.0)).xyz;
#endif
}
"""

FRAGMENT = """
uniform sampler2D albedo;
uniform sampler2D layer0;
uniform sampler2D layer1;
uniform sampler2D layer2;
uniform mat3 layer_uv0;   // from v_uv to the layer's texture coordinates; last row: its blend
uniform mat3 layer_uv1;
uniform mat3 layer_uv2;
uniform sampler2D normals;
uniform sampler2DShadow fixed_map;
uniform sampler2DShadow moving_map;
#if SHADOWED
float sunlit(sampler2DShadow map, vec3 at) {
    vec2 off = abs(at.xy - 0.5);
    return max(off.x, off.y) < 0.5 ? texture(map, at) : 1.0;
}
#endif
#if NEEDS_HEIGHT
vec4 covered(vec4 below, vec4 texel, mat3 layer) {   // by height
    return mix(below, texel, clamp((v_height - layer[0][2]) * layer[1][2], 0.0, 1.0));
}
#endif
vec3 over(vec3 below, vec4 texel, int operation) {
    if (operation == 1) return below + texel.rgb;
    if (operation == 2) return texel.rgb;
    if (operation == 3) return mix(below, texel.rgb, texel.a);
    return below * texel.rgb;
}
#if BUMPY
vec3 bumped(vec3 normal) {   // axes of the texture from how it changes across the image
    vec3 right = dFdx(v_position), down = dFdy(v_position);
    vec2 right_uv = dFdx(v_uv), down_uv = dFdy(v_uv);
    vec3 tangent = right * down_uv.y - down * right_uv.y;
    tangent *= sign(right_uv.x * down_uv.y - down_uv.x * right_uv.y);
    tangent -= normal * dot(normal, tangent);
    float size = length(tangent);
    if (size == 0.0) return normal;
    tangent /= size;
    vec3 bump = texture(normals, v_uv).xyz * 2.0 - 1.0;
    return normalize(bump.x * tangent + bump.y * cross(normal, tangent) + bump.z * normal);
}
#endif
out vec4 out_color;
void main() {
    vec4 color = v_color;
#if TEXTURED
    vec4 texel = texture(albedo, v_uv);
    color *= texel;
#endif
#if LAYERS > 0
    vec4 texel0 = texture(layer0, (layer_uv0 * vec3(v_uv, 1.0)).xy);
#if OPERATION0 == 4
    texel = covered(texel, texel0, layer_uv0);
#else
    color.a *= texel0.a;
#endif
#endif
#if LAYERS > 1
    vec4 texel1 = texture(layer1, (layer_uv1 * vec3(v_uv, 1.0)).xy);
#if OPERATION1 == 4
    texel = covered(texel, texel1, layer_uv1);
#else
    color.a *= texel1.a;
#endif
#endif
#if LAYERS > 2
    vec4 texel2 = texture(layer2, (layer_uv2 * vec3(v_uv, 1.0)).xy);
#if OPERATION2 == 4
    texel = covered(texel, texel2, layer_uv2);
#else
    color.a *= texel2.a;
#endif
#endif
#if REJECTS
    if (color.a <= v_rejection) discard;
#endif
#if LIT
#if NEEDS_NORMAL
    vec3 normal = normalize(gl_FrontFacing ? v_normal : -v_normal);
#if BUMPY
    normal = bumped(normal);
#endif
#endif
    vec3 light = v_ambient;
#if NEEDS_POSITION
    vec3 back = eye.xyz - v_position;
    float away = length(back);
#endif
#if SHINY
    vec3 shine = vec3(0.0);
    vec3 view = back / away;
#endif
#if SUN
#if BUMPY
    float facing = max(dot(normal, sun.xyz), 0.0);
#else
    float facing = max(gl_FrontFacing ? v_facing : -v_facing, 0.0);
#endif
#if SHADOWED == 1
    facing *= sunlit(fixed_map, v_fixed);
#elif SHADOWED == 2
    facing *= sunlit(moving_map, v_moving);
#elif SHADOWED == 3
    facing *= min(sunlit(fixed_map, v_fixed), sunlit(moving_map, v_moving));
#endif
    light += facing * sun_diffuse.rgb * v_color.rgb;
#if SHINY
    if (facing > 0.0) {
        float mirrored = max(dot(normal, normalize(sun.xyz + view)), 0.0);
        shine += pow(mirrored, v_specular.w) * sun_specular.rgb * v_specular.rgb;
    }
#endif
#endif
#if LIGHTS
    for (int i = 0; i < LIGHTS; i++) {
        vec3 towards = lights[i].position.xyz - v_position;
        float far = length(towards);
        towards = lights[i].falloff.w > 0.5 ? towards / far : -lights[i].direction.xyz;
        float power = 1.0;
        vec4 falloff = lights[i].falloff;
        if (falloff.w > 0.5) {
            power = far > lights[i].position.w ? 0.0
                : 1.0 / (falloff.x + far * (falloff.y + far * falloff.z));
        }
        if (falloff.w > 1.5) {
            float inside = dot(-towards, lights[i].direction.xyz);
            float part = (inside - lights[i].direction.w)
                / max(lights[i].diffuse.w - lights[i].direction.w, 1e-4);
            power *= part <= 0.0 ? 0.0 : pow(min(part, 1.0), lights[i].specular.w);
        }
        float cosine = max(dot(normal, towards), 0.0);
        light += cosine * power * lights[i].diffuse.rgb * v_color.rgb;
#if SHINY
        if (cosine > 0.0) {
            float mirrored = max(dot(normal, normalize(towards + view)), 0.0);
            shine += pow(mirrored, v_specular.w) * power * lights[i].specular.rgb * v_specular.rgb;
        }
#endif
    }
#endif
#if TEXTURED
    color.rgb = light * texel.rgb;
#else
    color.rgb = light;
#endif
#endif
#if LAYERS > 0 && OPERATION0 != 4
    color.rgb = over(color.rgb, texel0, OPERATION0);
#endif
#if LAYERS > 1 && OPERATION1 != 4
    color.rgb = over(color.rgb, texel1, OPERATION1);
#endif
#if LAYERS > 2 && OPERATION2 != 4
    color.rgb = over(color.rgb, texel2, OPERATION2);
#endif
#if SHINY && GLOSSY
    color.rgb += shine * texel.a;
#elif SHINY
    color.rgb += shine;
#endif
#if FOG
#if !LIT
    float away = length(eye.xyz - v_position);
#endif
#if FOG == 1
    float clear = 1.0 - clamp((away - fog_reach.x) * fog_reach.y, 0.0, 1.0);
#elif FOG == 2
    float clear = exp(-away * fog_reach.z);
#else
    float clear = exp(-away * away * fog_reach.z * fog_reach.z);
#endif
    color.rgb = mix(fog.rgb, color.rgb, clear);
#endif
    out_color = color;
}
"""


LAYER_UNIT, NORMALS_UNIT = 3, 6  # texture units of the first layer, and of the normal map
UNITS = {
    "albedo": 0,
    "fixed_map": 1,
    "moving_map": 2,
    "layer0": LAYER_UNIT,
    "layer1": LAYER_UNIT + 1,
    "layer2": LAYER_UNIT + 2,
    "normals": NORMALS_UNIT,
}
# Layer.operation -> its number
OPERATIONS = {"modulate": 0, "add": 1, "replace": 2, "alpha_blend": 3, "height": 4}
MAX_LIGHTS = 16  # point and spot lights, and suns beyond the first
MATRICES, VECTORS, LIGHT = 3, 7, 5  # numbers of 4x4, of 4, and of 4 a light
LIGHT_TYPES = {"directional": 0.0, "point": 1.0, "spot": 2.0}
SIZE = 16 * MATRICES + 4 * VECTORS + 4 * LIGHT * MAX_LIGHTS

FRAME = """
struct Light { vec4 position; vec4 direction; vec4 diffuse; vec4 specular; vec4 falloff; };
layout(std140) uniform Frame {
    mat4 clip;            // from the origin's axes
    mat4 fixed_shadow;    // to texture coordinates and depth of the shadow maps
    mat4 moving_shadow;
    vec4 eye;             // camera; w: offset of shadows along the normal [m], moving map
    vec4 sun;             // towards it; w: the same, fixed map
    vec4 sun_diffuse;
    vec4 sun_specular;
    vec4 ambient;
    vec4 fog;             // color
    vec4 fog_reach;       // start, 1 / (end - start), density
    Light lights[16];
};
"""


def frame_bytes(
    clip: Array,
    eye: Array,
    scene: Scene,
    sun: Light | None,
    lights: Array,
    shadows: Shadows | None,
) -> bytes:
    """Content of the block (std140).

    Args:
        clip: (4, 4) from positions relative to the origin to clip space.
        eye: (3,) [m] of the camera relative to the origin.
        lights: (n, 5, 4) of the others, as light_rows returns them.
    """
    block = np.zeros(SIZE, np.float32)
    fixed = shadows.fixed.lookup() if shadows else np.eye(4)
    moving = shadows.moving.lookup() if shadows else np.eye(4)
    for index, matrix in enumerate((clip, fixed, moving)):
        block[16 * index : 16 * index + 16] = matrix.T.ravel()
    vectors = block[16 * MATRICES : 16 * MATRICES + 4 * VECTORS].reshape(VECTORS, 4)
    vectors[0] = (*eye, shadows.moving.offset if shadows else 0.0)
    if sun is not None:
        vectors[1] = (*(-np.array(sun.direction)), shadows.fixed.offset if shadows else 0.0)
        vectors[2, :3], vectors[3, :3] = sun.diffuse, sun.specular
    vectors[4, :3] = scene.ambient
    if scene.fog is not None:
        fog = scene.fog
        vectors[5, :3] = fog.color
        vectors[6, :3] = fog.start, 1.0 / max(fog.end - fog.start, 1e-6), fog.density
    rows = block[16 * MATRICES + 4 * VECTORS :].reshape(MAX_LIGHTS, LIGHT, 4)
    for row, light in zip(rows, lights):
        row[:] = light
    return block.tobytes()


def light_rows(lights: Sequence[Light], origin: Array) -> Array:
    """(n, 5, 4) of the lights in the block.

    Args:
        origin: (3,) [m] to which their positions are relative.

    Raises:
        RenderError: too many.
    """
    if len(lights) > MAX_LIGHTS:
        raise RenderError(f"the world has {len(lights)} lights, at most {MAX_LIGHTS} are rendered")
    rows = np.zeros((len(lights), LIGHT, 4), np.float32)
    for row, light in zip(rows, lights):
        row[0] = (*(np.array(light.position) - origin), light.reach)
        row[1] = (*light.direction, np.cos(light.outer / 2.0))
        row[2] = (*light.diffuse, np.cos(light.inner / 2.0))
        row[3] = (*light.specular, light.falloff)
        row[4] = (light.constant, light.linear, light.quadratic, LIGHT_TYPES[light.kind])
    return rows


class Programs:
    """Programs of one context, made when first needed.

    Args:
        gl: moderngl.Context.
    """

    def __init__(self, gl: Any) -> None:
        self._gl = gl
        self.surface = lru_cache(maxsize=None)(self._surface)
        self.depth = self._program(LABEL_VERTEX, DEPTH_FRAGMENT)
        self.label = self._program(LABEL_VERTEX, LABEL_FRAGMENT)
        self.sky = self._program(sky.VERTEX, sky.FRAGMENT)

    def _program(self, vertex: str, fragment: str, head: str = "") -> Any:
        start = f"#version 330 core\n{head}"
        return self._gl.program(vertex_shader=start + vertex, fragment_shader=start + fragment)

    def _surface(self, batch: BatchType, sun: bool, shadowed: int, lights: int, fog: int) -> Any:
        """Program that renders surfaces.

        Args:
            batch: Batch.variant of theirs.
            sun: whether the scene has one.
            shadowed: whether something that never moves casts shadows (1) and something that
                moves (2), added up.
            lights: number of further lights.
            fog: 0 none, 1 linear, 2 exp, 3 exp2.
        """
        lit, bumpy, layers = batch.lit, batch.bumpy, batch.layers
        shiny, sun, lights = batch.shiny and lit, sun and lit, lights if lit else 0
        values = {
            "TEXTURED": batch.textured,
            "SHINY": shiny,
            "LIT": lit,
            "REJECTS": batch.rejects,
            "SUN": sun,
            "SHADOWED": shadowed if sun and lit else 0,
            "LIGHTS": lights,
            "FOG": fog,
            "LAYERS": len(layers),
            "BUMPY": bumpy,
            "GLOSSY": batch.glossy,
            "NEEDS_HEIGHT": "height" in layers,
            "NEEDS_UV": batch.textured or layers != () or bumpy,
            "NEEDS_NORMAL": shiny or lights or bumpy,
            "NEEDS_POSITION": shiny or lights or fog or bumpy,
        }
        values.update({f"OPERATION{i}": OPERATIONS[name] for i, name in enumerate(layers)})
        head = "".join(f"#define {name} {int(value)}\n" for name, value in values.items())
        program = self._program(
            "#define VARYING out\n" + VARYINGS + VERTEX,
            "#define VARYING in\n" + VARYINGS + FRAGMENT,
            head + FRAME,
        )
        for name, unit in UNITS.items():
            if name in program:
                program[name].value = unit
        if "Frame" in program:
            program["Frame"].binding = 0
        return program
