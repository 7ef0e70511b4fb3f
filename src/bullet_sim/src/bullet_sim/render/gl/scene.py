"""All visuals of the world, as instances of meshes that are rendered together."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bullet_sim.description.model import RGB, RGBA, Light, Shape, VisualLink
from bullet_sim.errors import ModelError
from bullet_sim.kinematics import Kinematics, pose_matrix
from bullet_sim.meshes.looks import Look
from bullet_sim.meshes.solids import factors
from bullet_sim.pose import Array, Vector
from bullet_sim.render.gl.meshes import AssetCache, Surface
from bullet_sim.snapshot import Snapshot

ROWS = 12  # numbers of an instance's pose
WIDTH = ROWS + 20  # and with its colors: diffuse, ambient, specular, emissive, label
INSTANCE = ("4f",) * 8
INSTANCE_NAMES = (
    "in_row0",
    "in_row1",
    "in_row2",
    "in_color",
    "in_ambient",
    "in_specular",
    "in_emissive",
    "in_label",
)
CORNER, CORNER_NAMES = ("3f", "3f", "2f"), ("in_position", "in_normal", "in_uv")


class BatchType(NamedTuple):
    """What the instances of a batch have in common.

    Attributes:
        textured, shiny, lit: see shaders.Programs.
        double_sided: whether the inside is rendered, too.
        rejects: whether points with too low an alpha are left out.
        transparent: rendered after all others, from far to near.
        blend: Finish.blend of those.
        layers: operations of further images.
        bumpy: whether there is a normal map.
        glossy: Finish.gloss.
    """

    textured: bool
    shiny: bool
    lit: bool
    double_sided: bool
    rejects: bool
    transparent: bool
    blend: str
    layers: tuple[str, ...] = ()
    bumpy: bool = False
    glossy: bool = False


class Selection:
    """Some instances of a batch in the graphics memory, for one purpose.

    Attributes:
        buffer: moderngl Buffer with room for all of them.
        arrays: program -> vertex array.
        count: of those in the buffer.
        content: bytes that tell which ones, or None when they may have moved.
    """

    def __init__(self, gl: Any, room: int) -> None:
        self.buffer = gl.buffer(reserve=4 * WIDTH * room, dynamic=True)
        self.arrays: dict[Any, Any] = {}
        self.count = 0
        self.content: bytes | None = None


@dataclass(eq=False)
class Batch:
    """Instances of one mesh that are rendered together.

    Attributes:
        first, end: its range in the table of Instances.
        selections: by purpose.
        variant: its type without what the programs do not distinguish.
    """

    surface: Surface
    type: BatchType
    first: int
    end: int
    selections: dict[str, Selection] = field(default_factory=dict)
    variant: BatchType = field(init=False)

    def __post_init__(self) -> None:
        self.variant = self.type._replace(double_sided=False, transparent=False, blend="")


def attributes(
    program: Any, buffer: Any, layout: tuple[str, ...], names: tuple[str, ...], ending: str = ""
) -> tuple[Any, ...]:
    """Content of a vertex array: what a program does not use is skipped.

    Args:
        layout: formats of the attributes, e.g. ("3f", "2f").
        ending: of the full format: " /i" for one an instance.
    """
    formats = [
        item if name in program else f"{4 * int(item[0])}x" for item, name in zip(layout, names)
    ]
    return (buffer, " ".join(formats) + ending, *[name for name in names if name in program])


class Instance(NamedTuple):
    """One surface of one visual.

    Attributes:
        row: of its link in Kinematics.
        local: (4, 4) pose in the link, with its size.
        radius: of a sphere around it [m].
        casts, fixed: whether it casts shadows, never moves.
        colors: 20 numbers of the table.
        visibility: visibility_flags of the visual.
    """

    surface: Surface
    type: BatchType
    row: int
    local: Array
    radius: float
    casts: bool
    fixed: bool
    colors: list[float]
    visibility: int


WHITE: RGBA = (1.0, 1.0, 1.0, 1.0)
BLACK: RGB = (0.0, 0.0, 0.0)
NOTHING = Look()  # of a visual without material and color


def describe(key: int, row: int, fixed: bool, shape: Shape, surface: Surface) -> Instance | None:
    """Instance of a surface of a body's Shape, or None when it is invisible."""
    geometry, finish, look = shape.geometry, shape.finish, surface.look
    size = factors(geometry)
    if look is None or shape.painted or shape.texture:
        color = shape.color or WHITE
        ambient = color[:3] if finish.ambient is None else finish.ambient
        specular, shininess = finish.specular or BLACK, finish.shininess
        emissive = finish.emissive
        if not shape.painted and not shape.color:
            specular, shininess = NOTHING.specular, NOTHING.shininess
    else:
        color, ambient, shininess = look.diffuse, look.ambient, look.shininess
        specular = look.specular
        emissive = finish.emissive if any(finish.emissive) else look.emissive
    alpha = color[3] * finish.opacity
    if alpha <= 0.0:
        return None
    blend = finish.blend or ("alpha" if alpha < 0.999 else "")
    batch_type = BatchType(
        textured=surface.texture is not None,
        shiny=any(specular) and shininess > 0.0,
        lit=finish.lit,
        double_sided=finish.double_sided or (look is not None and look.double_sided),
        rejects=finish.rejection > 0.0,
        transparent=bool(blend),
        blend=blend,
        layers=tuple(operation for _, operation, _ in surface.layers),
        bumpy=surface.normals is not None and finish.lit,
        glossy=finish.gloss and surface.texture is not None,
    )
    return Instance(
        surface,
        batch_type,
        row,
        pose_matrix(shape.pose) @ np.diag([*size, 1.0]),
        surface.mesh.radius * max(size),
        finish.cast_shadows and alpha > 0.5,
        fixed,
        [
            *(*color[:3], alpha),
            *(*ambient, shininess),
            *(*specular, finish.rejection),
            *(*emissive, 0.0),
            *_label(key),
        ],
        shape.visibility,
    )


def _label(key: int) -> RGBA:
    """Four numbers 0..1 that make the bytes of a body's key."""
    red, green, blue = (((key >> shift) & 255) / 255.0 for shift in (0, 8, 16))
    return (red, green, blue, 1.0)


LONGEST_SHADOW = 60.0  # [m]
SUNK = 0.02  # [m] what is on a floor may extend into it and cast no shadow on it


class Instances:
    """All instances, sorted by batch.

    Args:
        gl: moderngl.Context.

    Attributes:
        batches: the transparent ones last.
        table: (n, WIDTH) float32 as the graphics memory has it, poses relative to `origin`.
        origin: (3,) [m] in the world.
        centers (n, 3), radii (n,): spheres around the instances in the world [m].
        casts, fixed: (n,) bool: casts shadows on something else, never moves.
        visibility: (n,) visibility_flags.
        moving_version, fixed_version: count the changes of poses: of any, of those that never
            move.
    """

    def __init__(self, gl: Any, assets: AssetCache) -> None:
        self._gl, self._assets = gl, assets
        self.origin = np.zeros(3)
        self._failures: dict[tuple[int, str], str] = {}
        self.moving_version = self.fixed_version = 0
        self._lights: list[tuple[int, Light]] = []  # and the rows of their links
        self.kinematics = Kinematics({})
        self._fill([])

    def set_bodies(
        self, bodies: Mapping[int, tuple[VisualLink, ...]], fixed: Collection[int]
    ) -> list[str]:
        """Show these bodies.

        Args:
            bodies: links by key.
            fixed: keys of those whose root never moves.

        Returns:
            Messages about visuals that cannot be rendered, each once for as long as the body is
            there.
        """
        before, self.kinematics = self.kinematics, Kinematics(bodies)
        self.kinematics.keep_from(before)
        self._assets.start_scene()
        instances: list[Instance] = []
        failures = {}
        self._lights = []
        for key, chain in bodies.items():
            first = self.kinematics.firsts[key]
            is_fixed = key in fixed and all(link.kind == "fixed" for link in chain)
            for row, link in enumerate(chain, first):
                self._lights += [(row, light) for light in link.lights]
                for shape in link.shapes:
                    try:
                        surfaces = self._assets.surfaces(shape)
                    except ModelError as error:
                        failures[key, str(error)] = f"body {key}: {error}"
                        continue
                    described = (describe(key, row, is_fixed, shape, part) for part in surfaces)
                    instances += [instance for instance in described if instance is not None]
        self._assets.drop_unused()
        self._fill(instances)
        new = [text for failure, text in failures.items() if failure not in self._failures]
        self._failures = failures
        return new

    def _fill(self, instances: list[Instance]) -> None:
        groups: dict[Any, list[Instance]] = {}
        for instance in instances:
            surface = instance.surface
            group = surface.mesh, surface.texture, surface.layers, surface.normals, instance.type
            groups.setdefault(group, []).append(instance)
        ordered: list[Instance] = []
        self.batches: list[Batch] = []
        for (*_, batch_type), members in sorted(
            groups.items(), key=lambda item: item[0][-1].transparent
        ):
            first = len(ordered)
            ordered += members
            # transparent ones are sorted by distance, so each is a batch
            count = 1 if batch_type.transparent else len(members)
            self.batches += [
                Batch(ordered[start].surface, batch_type, start, start + count)
                for start in range(first, len(ordered), count)
            ]
        meshes = [instance.surface.mesh for instance in ordered]
        self.table = np.zeros((len(ordered), WIDTH), np.float32)
        self._rows = np.array([instance.row for instance in ordered], int)
        self._locals = np.array([instance.local for instance in ordered]).reshape(-1, 4, 4)
        self._centers = np.array([(*mesh.center, 1.0) for mesh in meshes]).reshape(-1, 4)
        self._halves = np.array([(mesh.high - mesh.low) / 2.0 for mesh in meshes]).reshape(-1, 3)
        self.radii = np.array([instance.radius for instance in ordered])
        self._may_cast = np.array([instance.casts for instance in ordered], bool)
        self.casts = self._may_cast
        self.fixed = np.array([instance.fixed for instance in ordered], bool)
        self.visibility = np.array([instance.visibility for instance in ordered], np.int64)
        if ordered:
            self.table[:, ROWS:] = [instance.colors for instance in ordered]
        self._poses = np.zeros((len(ordered), 4, 4))
        self._low, self._high = np.zeros((2, len(ordered)))  # of their lowest points [m]
        self.centers = np.zeros((len(ordered), 3))
        self._move(np.arange(len(ordered)))

    def apply(self, snapshot: Snapshot) -> None:
        """Put all instances where a Snapshot has their bodies."""
        self.kinematics.apply(snapshot)
        if len(self._rows):
            self._move(np.flatnonzero(self.kinematics.changed[self._rows]))

    def _move(self, chosen: Array) -> None:
        """Put instances (their indices) where their links are."""
        if not len(chosen):
            return
        poses = self.kinematics.poses[self._rows[chosen]] @ self._locals[chosen]
        self._poses[chosen] = poses
        self.centers[chosen] = (poses @ self._centers[chosen, :, None])[:, :3, 0]
        half = (np.abs(poses[:, 2, :3]) * self._halves[chosen]).sum(axis=1)
        self._low[chosen] = self.centers[chosen, 2] - half
        self._high[chosen] = self.centers[chosen, 2] + half
        self.casts = self._may_cast & (self._high > self._lowest_others() + SUNK)
        self._write(chosen, poses)
        self.moving_version += 1
        self.fixed_version += int(self.fixed[chosen].any())

    def _lowest_others(self) -> Array:
        """Height of the lowest point of all others, for each instance (n,) [m]."""
        if len(self._low) < 2:
            return np.full(len(self._low), np.inf)
        lowest = int(self._low.argmin())
        heights = np.full(len(self._low), self._low[lowest])
        heights[lowest] = np.delete(self._low, lowest).min()
        return heights

    def lights(self) -> list[Light]:
        """The lights that links carry, in the world."""
        poses = self.kinematics.poses
        return [light.within(poses[row, :3, :3], poses[row, :3, 3]) for row, light in self._lights]

    def shadow_lengths(self, away: Vector) -> Array:
        """Maximum length (n,) of the instances' shadows, down to the lowest point [m].

        Args:
            away: (3,) from the sun.
        """
        if not len(self._low):
            return np.zeros(0)
        drop = self.centers[:, 2] - self._low.min()
        return np.minimum(drop / max(-away[2], 1e-3), LONGEST_SHADOW)

    def set_origin(self, origin: Array) -> None:
        """Make the table's poses relative to a point (3,) of the world."""
        if not np.array_equal(origin, self.origin):
            self.origin = np.array(origin, float)
            self._write(np.arange(len(self._rows)), self._poses)
            self.moving_version += 1
            self.fixed_version += 1

    def _write(self, chosen: Array, poses: Array) -> None:
        rows = poses[:, :3, :].copy()
        rows[:, :, 3] -= self.origin
        self.table[chosen, :ROWS] = rows.reshape(-1, ROWS)
        flags = np.zeros(len(self._rows), bool)
        flags[chosen] = True
        for batch in self.batches:
            if flags[batch.first : batch.end].any():
                for selection in batch.selections.values():
                    selection.content = None

    def select(self, batch: Batch, chosen: Array, purpose: str) -> Selection | None:
        """The instances of a batch that are `chosen`, (n,) bool of the table.

        Args:
            purpose: name; a selection stays when another purpose selects.

        Returns:
            Selection, or None when there is none of them.
        """
        members = chosen[batch.first : batch.end]
        selection = batch.selections.get(purpose)
        if selection is None:
            if not members.any():
                return None
            selection = batch.selections[purpose] = Selection(self._gl, batch.end - batch.first)
        content = members.tobytes()
        if content != selection.content:
            rows = self.table[batch.first : batch.end][members]
            selection.count, selection.content = len(rows), content
            if selection.count:
                selection.buffer.write(np.ascontiguousarray(rows))
        return selection if selection.count else None

    def render(self, batch: Batch, selection: Selection, program: Any) -> None:
        """Render a Selection of a batch with a program."""
        if program not in selection.arrays:
            mesh = batch.surface.mesh
            selection.arrays[program] = self._gl.vertex_array(
                program,
                [
                    attributes(program, mesh.vertices, CORNER, CORNER_NAMES),
                    attributes(program, selection.buffer, INSTANCE, INSTANCE_NAMES, " /i"),
                ],
                index_buffer=mesh.indices,
                index_element_size=4,
            )
        selection.arrays[program].render(instances=selection.count)
