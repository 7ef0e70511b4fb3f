"""Services about models: spawn, delete, state, properties, namespaces."""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import rospy
from bullet_sim.errors import SimError
from bullet_sim.formats.lights import parse_light
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.spawn_text import SpawnText
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Array, Pose
from bullet_sim.xml_reader import Node
from gazebo_msgs import srv
from gazebo_msgs.msg import ModelState

from bullet_bridge.services.entities import find_frame, find_model
from bullet_bridge.services.handlers import (
    NO_FRAME,
    Refusal,
    offer,
    refusing,
    topic_callback,
)
from bullet_bridge.transport.conversions import (
    pose_from_msg,
    pose_to_msg,
    stamp,
    twist_to_msg,
    vector,
)

if TYPE_CHECKING:
    from bullet_sim.description.model import ModelDescription
    from bullet_sim.models.model import Model
    from bullet_sim.world import Resolve, World

    from bullet_bridge.loop.jobs import JobQueue
    from bullet_bridge.loop.server import Server
    from bullet_bridge.robots import Robots


READING = 0.5  # wall time [s] for which time waits for the reading of a model, at most
SPAWN = "SpawnModel: "
UNKNOWN_FORMAT = (
    "GazeboRosApiPlugin SpawnModel Failure: input model_xml not SDF or URDF, or cannot be "
    "converted to Gazebo compatible format."
)
NOT_SPAWNED = (
    f"{SPAWN}Entity pushed to spawn queue, but spawn service timed out waiting for entity to "
    "appear in simulation under the name "
)


def remove_model(world: World, jobs: JobQueue, robots: Robots, name: str) -> None:
    """Delete a model with its plugins and controllers; outside the simulation thread.

    Raises:
        Refusal: there is none of that name.
    """

    def work() -> list[Any]:
        with refusing("DeleteModel: model does not exist"):
            joints = find_model(world, name).model.description.joints
            world.delete(name)
        for joint in joints:  # upstream clears by plain names, of all models
            world.forces.clear_joint(joint)
        return robots.disconnect(name)

    for part in jobs.call(work):
        part.close()
    gc.collect()  # rospy's topics refer to themselves and own a file descriptor each until then


class ModelServices:
    """Services that spawn, delete, move and query models.

    Args:
        missing_package: of the text of a URDF: a package that it names and that is not there, for
            which spawn_urdf_model fails as in gazebo_ros; None: there is none.
    """

    def __init__(
        self,
        prefix: str,
        world: World,
        jobs: JobQueue,
        robots: Robots,
        resolve: Resolve,
        server: Server,
        missing_package: Callable[[str], str | None] = lambda text: None,
    ) -> None:
        self._world, self._jobs, self._robots, self._resolve = world, jobs, robots, resolve
        self._missing_package = missing_package
        self._server, self._reading = server, threading.Lock()
        self._requests: dict[str, int] = {}
        offer(
            prefix,
            ("spawn_urdf_model", srv.SpawnModel, lambda r: self._spawn(r, urdf=True)),
            ("spawn_sdf_model", srv.SpawnModel, lambda r: self._spawn(r, urdf=False)),
            ("delete_model", srv.DeleteModel, self._delete),
            ("get_model_state", srv.GetModelState, self._get_state),
            ("set_model_state", srv.SetModelState, lambda r: self._set_state(r.model_state)),
            ("set_model_configuration", srv.SetModelConfiguration, self._set_configuration),
            ("get_world_properties", srv.GetWorldProperties, self._get_world),
            ("get_model_properties", srv.GetModelProperties, self._get_properties),
        )
        robots.received.subscribe(
            f"{prefix}/set_model_state", ModelState, topic_callback(self._set_state)
        )

    def _spawn(self, request: Any, urdf: bool) -> srv.SpawnModelResponse:
        """Spawn what a text describes, under the name of the request.

        Args:
            urdf: it has to be URDF, else the call fails.
        """
        pose, name = pose_from_msg(request.initial_pose), request.model_name
        text = SpawnText.read(request.model_xml, request.robot_namespace)
        if urdf:
            self._check_urdf(request, text)

        def check() -> Pose:
            with refusing(SPAWN + NO_FRAME.format("reference_frame", "link")):
                frame = find_frame(self._world, request.reference_frame).pose
            self._check(name, text)
            return frame * pose if text.takes_request else Pose()

        def add_light() -> None:
            check()
            self._add_light(name, text.light)

        def begin() -> float:
            check()
            return self._server.hold(READING)

        def spawn() -> tuple[Model, float]:
            model = self._world.spawn(described, check() * origin)
            return model, self._server.hold()

        spawned = srv.SpawnModelResponse(status_message=f"{SPAWN}Successfully spawned entity")
        if text.kind == "light":
            self._jobs.call(add_light)
            return spawned
        reading = self._jobs.read(begin)
        try:
            described, origin = self._read(name, text)
            model, hold = self._jobs.call(spawn)
        except Refusal:
            raise
        except SimError as error:  # Gazebo's client waits 10 s then
            raise SimError(f"{NOT_SPAWNED}{name}: {error}") from error
        finally:
            self._jobs.read(lambda: self._server.release(reading))
        self._connect(model, request.robot_namespace, hold)
        try:
            self._jobs.read(lambda: find_model(self._world, name))
        except SimError as error:  # for which Gazebo's client waits 10 s
            raise SimError(f"{NOT_SPAWNED}{name}: '{model.name}' is there; {error}") from error
        return spawned

    def _check_urdf(self, request: Any, text: SpawnText) -> None:
        """Raise a rospy.ServiceException where a text is no URDF, or names a missing package."""
        if text.kind != "urdf":
            error, name = f"{SPAWN}Failure - entity format is invalid.", request.model_name
            rospy.logerr("%s (the root of '%s' is <%s>, not <robot>)", error, name, text.tag)
            raise rospy.ServiceException(error)
        missing = self._missing_package(request.model_xml)
        if missing is not None:
            rospy.logfatal("Package[%s] does not have a path", missing)
            raise rospy.ServiceException(f"urdf reference package name does not exist: {missing}")

    def _read(self, name: str, text: SpawnText) -> tuple[ModelDescription, Pose]:
        """Description of a model and its own pose; its files are read, too, so that the simulation
        thread need not wait for them."""
        with self._reading:
            if text.kind == "urdf":
                massless = self._world.massless_links
                described = parse_urdf(text.text, self._resolve, name, massless)
                origin = described.origin
            else:
                described, origin = parse_model(text.text, self._resolve, f"SDF of '{name}'", name)
            self._world.prepare(described)
        return described, origin

    def _check(self, name: str, text: SpawnText) -> None:
        """Refuse a text of another format, and a name that is taken (simulation thread)."""
        if not text.kind:
            raise Refusal(UNKNOWN_FORMAT, f"the root of '{name}' is <{text.tag}>")
        lights = [light.name for light in self._world.scene.lights]
        if name in self._world.models or (text.kind == "light" and name in lights):
            taken = [*self._world.models, *(lights if text.kind == "light" else ())]
            raise Refusal(
                f"{SPAWN}Failure - entity already exists.",
                f"'{name}' exists already; there are {', '.join(taken)}",
            )

    def _add_light(self, name: str, element: Node) -> None:
        """Add a light where its own pose has it, as gazebo_ros does (simulation thread)."""
        if not name:
            raise SimError(f"{NOT_SPAWNED}: a light needs a name, this one is empty")
        light = replace(parse_light(element, "spawn request"), name=name)
        scene = self._world.scene
        self._world.scene = replace(scene, lights=(*scene.lights, light))
        for warning in element.document.warnings:
            rospy.logwarn("%s", warning)
        self._robots.show_scene()

    def _connect(self, model: Model, namespace: str, hold: float) -> None:
        """Give a new model its plugins and controllers; without them it does not stay."""
        try:
            self._robots.connect(model, namespace)
        except Exception:
            self._remove(model.name)  # so that no part of it remains
            raise
        finally:
            self._jobs.call(lambda: self._server.release(hold))

    def _remove(self, name: str) -> None:
        remove_model(self._world, self._jobs, self._robots, name)

    def _delete(self, request: Any) -> srv.DeleteModelResponse:
        self._remove(request.model_name)
        return srv.DeleteModelResponse(status_message="DeleteModel: successfully deleted model")

    def _get_state(self, request: Any) -> srv.GetModelStateResponse:
        def work() -> tuple[float, tuple[Pose, Array, Array]]:
            with refusing("GetModelState: model does not exist"):
                model = find_model(self._world, request.model_name)
            with refusing("GetModelState: " + NO_FRAME.format("relative_entity_name", "body")):
                frame = find_frame(self._world, request.relative_entity_name)
            return self._world.time, frame.inward(*model.state())

        time, (pose, linear, angular) = self._jobs.read(work)
        response = srv.GetModelStateResponse(
            pose=pose_to_msg(pose),
            twist=twist_to_msg(linear, angular),
            status_message="GetModelState: got properties",
        )
        self._requests[request.model_name] = self._requests.get(request.model_name, 0) + 1
        response.header.seq = self._requests[request.model_name]
        response.header.stamp = stamp(time)
        response.header.frame_id = request.relative_entity_name
        return response

    def _set_state(self, state: ModelState) -> srv.SetModelStateResponse:
        pose = pose_from_msg(state.pose)
        linear, angular = vector(state.twist.linear), vector(state.twist.angular)

        def work() -> None:
            with refusing("SetModelState: model does not exist"):
                model = find_model(self._world, state.model_name)
            with refusing("SetModelState: specified reference frame entity does not exist"):
                frame = find_frame(self._world, state.reference_frame).pose
            model.set_state(frame * pose, frame.matrix @ linear, frame.matrix @ angular)

        self._jobs.call(work)
        return srv.SetModelStateResponse(status_message="SetModelState: set model state done")

    def _set_configuration(self, request: Any) -> srv.SetModelConfigurationResponse:
        names, positions = request.joint_names, request.joint_positions

        def work() -> list[str]:
            with refusing("SetModelConfiguration: model does not exist"):
                joints = self._world.model(request.model_name).joints
            if len(names) != len(positions):
                raise Refusal(
                    "SetModelConfiguration: joint name and position list have different lengths",
                    f"joint_names has {len(names)} entries and joint_positions {len(positions)}",
                )
            scope = f"{request.model_name}::"
            plain = [name[len(scope) :] if name.startswith(scope) else name for name in names]
            values = dict(zip(plain, positions))
            joints.set_positions({name: values[name] for name in values if name in joints.names})
            return [name for name in values if name not in joints.names]

        unknown = self._jobs.call(work)
        if unknown:  # which Gazebo skips without a word
            rospy.logwarn(
                "set_model_configuration: joints %s of '%s' do not exist or do not move, and are "
                "skipped",
                ", ".join(unknown),
                request.model_name,
            )
        return srv.SetModelConfigurationResponse(status_message="SetModelConfiguration: success")

    def _get_world(self, _: Any) -> srv.GetWorldPropertiesResponse:
        time, names = self._jobs.read(lambda: (self._world.time, list(self._world.models)))
        return srv.GetWorldPropertiesResponse(
            sim_time=time,
            model_names=names,
            rendering_enabled=True,
            status_message="GetWorldProperties: got properties",
        )

    def _get_properties(self, request: Any) -> srv.GetModelPropertiesResponse:
        with refusing("GetModelProperties: model does not exist"):
            named = self._jobs.read(lambda: find_model(self._world, request.model_name))
        model, described = named.model, named.model.description
        own = set(named.own(described.links))
        return srv.GetModelPropertiesResponse(
            parent_model_name=named.parent,
            body_names=named.plain(model.bodies),
            geom_names=[
                collision.rpartition("::")[2]
                for (link, _), collision in model.collision_names.items()
                if link in own
            ],
            joint_names=named.plain(model.joint_names),
            child_model_names=named.children,
            is_static=model.is_static and not model.description.is_empty,
            status_message="GetModelProperties: got properties",
        )
