"""Views of a world for the viewer: picklable values, made on request."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.description.world import Scene
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Array, sensor_in_world
from bullet_sim.sensors.lidar import Lidar
from bullet_sim.snapshot import BodySource, Snapshot

if TYPE_CHECKING:
    from bullet_sim.models.model import Model

MAX_RAYS = 240  # per lidar that are cast for the viewer


@dataclass(frozen=True)
class Rays:
    """Rays of one lidar: from origin (3,) to ends (n, 3), float32 [m] in the world frame."""

    origin: Array
    ends: Array


@dataclass(frozen=True)
class Contacts:
    """Contact points: positions (n, 3) [m], unit normals (n, 3), normal forces [N]; world."""

    places: Array
    normals: Array
    forces: Array


@dataclass(frozen=True)
class LinkFrames:
    """Frames of a model's links in the world: names, origins (n, 3) [m], rotations (n, 3, 3)."""

    names: tuple[str, ...]
    origins: Array
    rotations: Array


@dataclass(frozen=True)
class Entry:
    """A model: key of its body in the snapshot, name, whether it never moves."""

    key: int
    name: str
    static: bool


@dataclass(frozen=True)
class WorldView:
    """The world at one time.

    Attributes:
        sources: bodies for a mirror; None: as in the last view, as is the scene.
        rays: of the lidars with <visualize>.
        paused: whether simulated time does not advance.
        contacts: all contact points; None: not requested.
        frames: of the selected model; None: none is selected.
    """

    models: tuple[Entry, ...]
    sources: tuple[BodySource, ...] | None
    snapshot: Snapshot
    rays: tuple[Rays, ...]
    paused: bool
    scene: Scene | None = None
    contacts: Contacts | None = None
    frames: LinkFrames | None = None


class Observer:
    """Makes views of a world for one viewer; the world is not changed.

    Args:
        world: World. To be called in the thread that owns its engine.
    """

    def __init__(self, world: Any) -> None:
        self._world = world
        self._last_sources: tuple[tuple[BodySource, ...], Scene] | None = None
        self._selected, self._with_contacts = "", False
        # (key, index of the sensor) -> (Lidar, time of the rays [s], Rays)
        self._cast: dict[tuple[int, int], tuple[Lidar, float, Rays]] = {}

    def show(self, selected: str, contacts: bool) -> None:
        """Choose what else the next views have.

        Args:
            selected: name of the model whose link frames they have; '': none.
            contacts: whether they have the contact points.
        """
        self._selected, self._with_contacts = str(selected), bool(contacts)

    def view(self, paused: bool) -> WorldView:
        """View of the world now."""
        models = self._world.models.values()
        sources = tuple(self._world.sources())
        current = (sources, self._world.scene)
        changed = sources if current != self._last_sources else None
        self._last_sources = current
        return WorldView(
            tuple(Entry(model.source.key, model.name, model.is_static) for model in models),
            changed,
            self._world.snapshot(),
            tuple(self._rays(models)),
            bool(paused),
            self._world.scene,
            Contacts(*self._world.engine.all_contacts()) if self._with_contacts else None,
            self._frames(),
        )

    def _frames(self) -> LinkFrames | None:
        """LinkFrames of the selected model, or None."""
        model = self._world.models.get(self._selected)
        if model is None:
            return None
        poses = [model.link_state(name)[0] for name in model.link_names]
        origins = np.reshape([pose.position for pose in poses], (-1, 3))
        rotations = np.reshape([pose.matrix for pose in poses], (-1, 3, 3))
        return LinkFrames(tuple(model.link_names), origins, rotations)

    def _rays(self, models: "Iterable[Model]") -> Iterator[Rays]:
        """Rays of all visualised lidars, cast again when their next scan would be due."""
        now, before, self._cast = self._world.time, self._cast, {}
        for model in models:
            for index, spec in enumerate(model.description.sensors):
                if not isinstance(spec, RaySpec) or not spec.visualize:
                    continue
                key = (model.source.key, index)
                last = before.get(key)
                if last is None or not last[1] <= now < last[1] + 1.0 / spec.rate:
                    lidar = Lidar(spec) if last is None else last[0]
                    last = lidar, now, self._cast_rays(model, lidar)
                self._cast[key] = last
                yield last[2]

    def _cast_rays(self, model: "Model", lidar: Lidar) -> Rays:
        spec = lidar.spec
        link = model.link_state(spec.link)[0]
        origin, rotation = sensor_in_world(link.position, link.orientation, spec.pose)
        stride = -(-len(lidar.directions) // MAX_RAYS)
        rays = lidar.directions[::stride] @ rotation.T
        inner, outer = origin + spec.range_min * rays, origin + spec.range_max * rays
        fractions, _ = self._world.engine.rays.cast(inner, outer)
        ends = inner + np.asarray(fractions)[:, None] * (outer - inner)
        return Rays(origin.astype(np.float32), ends.astype(np.float32))
