"""All visuals of the world, as instances of meshes that are drawn together."""

from dataclasses import dataclass

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.meshes.read import GREY
from bullet_sim.render.gl.kinematics import Kinematics, pose_matrix

ROWS = 12  # numbers of an instance's place
WIDTH = ROWS + 20  # and with its colours: diffuse, ambient, specular, emissive, label
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


@dataclass(frozen=True)
class Kind:
    """What the instances of a batch have in common.

    Attributes:
        textured, shiny, lit: see shaders.Programs.
        double_sided: whether the inside is drawn, too.
        transparent: drawn after all others, from far to near.
    """

    textured: bool = False
    shiny: bool = False
    lit: bool = True
    double_sided: bool = False
    transparent: bool = False


class Selection:
    """Some instances of a batch in the graphics memory, for one purpose.

    Attributes:
        buffer: moderngl Buffer with room for all of them.
        arrays: program -> vertex array.
        count: of those in the buffer.
        held: bytes that tell which ones, or None when they may have moved.
    """

    def __init__(self, gl, room):
        self.buffer = gl.buffer(reserve=4 * WIDTH * room, dynamic=True)
        self.arrays, self.count, self.held = {}, 0, None


class Batch:
    """Instances of one mesh that are drawn together.

    Attributes:
        look: Look of the first.
        kind: Kind.
        first, end: its range in the stage's table.
        selections: purpose -> Selection.
    """

    def __init__(self, look, kind, first, end):
        self.look, self.kind, self.first, self.end = look, kind, first, end
        self.selections = {}


def attributes(program, buffer, layout, names, ending=""):
    """Content of a vertex array: what a program does not use is skipped.

    Args:
        layout: formats of the attributes, e.g. ("3f", "2f").
        names: of the attributes.
        ending: of the whole format: " /i" for one a instance.
    """
    kinds = [
        kind if name in program else f"{4 * int(kind[0])}x" for kind, name in zip(layout, names)
    ]
    return (buffer, " ".join(kinds) + ending, *[name for name in names if name in program])


def describe(key, row, moves, shape, look):
    """One instance's numbers, or None when it is invisible."""
    geometry, finish = shape.geometry, shape.finish
    size = _size(geometry)
    local = pose_matrix(shape.pose) @ np.diag([*size, 1.0])
    color = _color(shape, look.part, geometry.kind)
    alpha = color[3] * finish.opacity
    if alpha <= 0.0:
        return None
    specular = look.part.specular if finish.specular is None else finish.specular
    emissive = tuple(np.maximum(look.part.emissive, finish.emissive).tolist())
    ambient = color[:3] if finish.ambient is None else finish.ambient
    kind = Kind(
        textured=look.texture is not None,
        shiny=any(specular) or any(emissive),
        lit=finish.lit,
        double_sided=look.part.double_sided,
        transparent=alpha < 0.999 or look.clear,
    )
    return {
        "group": (look.mesh, look.texture, kind),
        "look": look,
        "row": row,
        "local": local,
        "middle": (*look.mesh.centre, 1.0),
        "half": (look.mesh.high - look.mesh.low) / 2.0,
        "radius": look.mesh.radius * max(size),
        "casts": finish.cast_shadows and alpha > 0.5,
        "still": not moves,
        "colors": [
            *color[:3],
            alpha,
            *ambient,
            finish.shininess,
            *specular,
            0.0,
            *emissive,
            0.0,
            *_label(key),
        ],
    }


def _size(geometry):
    """Factors (3,) from a solid of unit size."""
    if geometry.kind == "cylinder":
        radius, length = geometry.size
        return (radius, radius, length)
    if geometry.kind == "sphere":
        return (geometry.size[0],) * 3
    if geometry.kind == "mesh":
        return (1.0, 1.0, 1.0)
    return tuple(geometry.size) or (1.0, 1.0, 1.0)


def _color(shape, part, kind):
    """RGBA of an instance."""
    if shape.texture:
        return part.color
    if kind != "mesh":
        return shape.color or GREY
    if shape.painted or part.color == GREY:
        return shape.color or GREY
    return part.color


def _label(key):
    """Four numbers 0..1 that make the bytes of a body's key."""
    return [((key >> shift) & 255) / 255.0 for shift in (0, 8, 16)] + [1.0]


LONGEST_SHADOW = 60.0  # [m]
SUNK = 0.02  # [m] what stands on a floor may reach into it and throw no shadow on it


class Stage:
    """All instances, sorted by batch.

    Args:
        gl: moderngl.Context.
        store: Store.

    Attributes:
        batches: list of Batch, the transparent ones last.
        table: (n, WIDTH) float32 as the graphics memory has it, places relative to `origin`.
        centres (n, 3), radii (n,): spheres around the instances in the world [m].
        casts, still: (n,) bool: casts shadows on something else, never moves.
        kinematics: Kinematics.
        moving_version, still_version: count the changes of places: of any, of those that never
            move by themselves.
    """

    def __init__(self, gl, store):
        self._gl, self._store = gl, store
        self.origin = np.zeros(3)
        self.failures = {}
        self.moving_version = self.still_version = 0
        self.set_bodies({}, ())

    def set_bodies(self, bodies, fixed):
        """Show these bodies.

        Args:
            bodies: dict of key -> tuple of VisualLink.
            fixed: keys of those whose root never moves.

        Returns:
            List of sentences about visuals that cannot be drawn, each once for as long as the
            body is there.
        """
        before = getattr(self, "kinematics", None)
        self.kinematics = Kinematics(bodies)
        if before is not None:
            self.kinematics.keep_from(before)
        self._store.begin()
        found, failures = [], {}
        for key, chain in bodies.items():
            first = self.kinematics.firsts[key]
            moves = key not in fixed or any(link.kind != "fixed" for link in chain)
            for row, link in enumerate(chain, first):
                for shape in link.shapes:
                    try:
                        looks = self._store.looks(shape)
                    except ModelError as error:
                        failures[key, str(error)] = f"body {key}: {error}"
                        continue
                    found += [(key, row, moves, shape, look) for look in looks]
        self._store.drop_unused()
        self._fill(found)
        new = [text for place, text in failures.items() if place not in self.failures]
        self.failures = failures
        return new

    def _fill(self, found):
        described = [describe(*entry) for entry in found]
        described = [entry for entry in described if entry is not None]
        order = {}
        for number, entry in enumerate(described):
            order.setdefault(entry["group"], []).append(number)
        groups = sorted(order.items(), key=lambda item: item[0][2].transparent)
        entries = [described[number] for _, numbers in groups for number in numbers]
        self.batches, end = [], 0
        for (_, _, kind), numbers in groups:
            first, end = end, end + len(numbers)
            if kind.transparent:  # each by itself: they are sorted by distance
                self.batches += [
                    Batch(entries[i]["look"], kind, i, i + 1) for i in range(first, end)
                ]
            else:
                self.batches.append(Batch(entries[first]["look"], kind, first, end))
        self.table = np.zeros((len(entries), WIDTH), np.float32)
        self._rows = np.array([entry["row"] for entry in entries], int)
        self._locals = np.array([entry["local"] for entry in entries]).reshape(-1, 4, 4)
        self._middles = np.array([entry["middle"] for entry in entries]).reshape(-1, 4)
        self.radii = np.array([entry["radius"] for entry in entries])
        self._may_cast = np.array([entry["casts"] for entry in entries], bool)
        self.casts = self._may_cast
        self.still = np.array([entry["still"] for entry in entries], bool)
        if entries:
            self.table[:, ROWS:] = [entry["colors"] for entry in entries]
        self._places = np.zeros((len(entries), 4, 4))
        self._halves = np.array([entry["half"] for entry in entries]).reshape(-1, 3)
        self._low, self._high = np.zeros((2, len(entries)))  # of their lowest points [m]
        self.centres = np.zeros((len(entries), 3))
        self._place(np.arange(len(entries)))

    def apply(self, snapshot):
        """Put all instances where a Snapshot has their bodies."""
        self.kinematics.apply(snapshot)
        if len(self._rows):
            chosen = np.flatnonzero(self.kinematics.changed[self._rows])
            if len(chosen):
                self._place(chosen)

    def _place(self, chosen):
        if not len(chosen):
            return
        places = self.kinematics.places[self._rows[chosen]] @ self._locals[chosen]
        self._places[chosen] = places
        self.centres[chosen] = (places @ self._middles[chosen, :, None])[:, :3, 0]
        half = (np.abs(places[:, 2, :3]) * self._halves[chosen]).sum(axis=1)
        self._low[chosen], self._high[chosen] = (
            self.centres[chosen, 2] - half,
            self.centres[chosen, 2] + half,
        )
        self.casts = self._may_cast & (self._high > self._lowest_others() + SUNK)
        self._write(chosen, places)
        self.moving_version += 1
        self.still_version += int(self.still[chosen].any())

    def _lowest_others(self):
        """Height of the lowest point of all others, for each instance (n,) [m]."""
        if len(self._low) < 2:
            return np.full(len(self._low), np.inf)
        lowest = int(self._low.argmin())
        found = np.full(len(self._low), self._low[lowest])
        found[lowest] = np.delete(self._low, lowest).min()
        return found

    def shadow_lengths(self, away):
        """How far (n,) the instances' shadows reach at most, down to the lowest point [m].

        Args:
            away: (3,) from the sun.
        """
        if not len(self._low):
            return np.zeros(0)
        drop = self.centres[:, 2] - self._low.min()
        return np.minimum(drop / max(-away[2], 1e-3), LONGEST_SHADOW)

    def set_origin(self, origin):
        """Let the table's places be relative to a point (3,) of the world."""
        if not np.array_equal(origin, self.origin):
            self.origin = np.array(origin, float)
            self._write(np.arange(len(self._rows)), self._places)
            self.moving_version += 1
            self.still_version += 1

    def _write(self, chosen, places):
        rows = places[:, :3, :].copy()
        rows[:, :, 3] -= self.origin
        self.table[chosen, :ROWS] = rows.reshape(-1, ROWS)
        flags = np.zeros(len(self._rows), bool)
        flags[chosen] = True
        for batch in self.batches:
            if flags[batch.first : batch.end].any():
                for selection in batch.selections.values():
                    selection.held = None

    def select(self, batch, chosen, purpose):
        """The instances of a batch that `chosen`, (n,) bool of the table, says.

        Args:
            purpose: name; what one purpose has selected stays when another selects.

        Returns:
            Selection, or None when there is none of them.
        """
        wanted = chosen[batch.first : batch.end]
        selection = batch.selections.get(purpose)
        if selection is None:
            if not wanted.any():
                return None
            selection = batch.selections[purpose] = Selection(self._gl, batch.end - batch.first)
        held = wanted.tobytes()
        if held != selection.held:
            rows = self.table[batch.first : batch.end][wanted]
            selection.count, selection.held = len(rows), held
            if selection.count:
                selection.buffer.write(np.ascontiguousarray(rows))
        return selection if selection.count else None

    def array(self, batch, selection, program):
        """Vertex array of a Selection of a batch for a program."""
        if program not in selection.arrays:
            mesh = batch.look.mesh
            selection.arrays[program] = self._gl.vertex_array(
                program,
                [
                    attributes(program, mesh.vertices, CORNER, CORNER_NAMES),
                    attributes(program, selection.buffer, INSTANCE, INSTANCE_NAMES, " /i"),
                ],
                index_buffer=mesh.indices,
                index_element_size=4,
            )
        return selection.arrays[program]
