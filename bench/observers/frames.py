"""frames SECONDS RENDERER: pictures received, and bare getCameraImage beside."""

import time

import pybullet
import rospy
from bullet_sim.description.specs import CameraSpec
from bullet_sim.engine import Engine
from bullet_sim.pose import Pose
from bullet_sim.render.mirror import Mirror
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors import camera
from std_srvs.srv import Empty

from observers import graph


def bare_frames(world, renderer, seconds):
    """Pictures per second of PyBullet's getCameraImage for the car's camera, and the renderer."""
    engine = Engine()
    chosen = engine.start_renderer(renderer)
    mirror = Mirror(engine, chosen)
    mirror.sync_sources(world.sources())
    mirror.apply(world.snapshot())
    car = world.model("racecar")
    spec = next(spec for spec in car.description.sensors if isinstance(spec, CameraSpec))
    index, offset = car.carrier(spec.link)
    pose = offset * Pose.from_xyz_rpy(*spec.pose)
    request = CameraRequest.from_spec(spec, car.source.key, index + 1, 1)
    request = CameraRequest(**dict(vars(request), pose=(pose.position, pose.rpy)))
    position, rotation = mirror._camera_pose(request)
    view = camera.view_matrix(position, rotation)
    projection = camera.projection_matrix(
        request.horizontal_fov, request.width / request.height, request.near, request.far
    )
    kind = pybullet.ER_BULLET_HARDWARE_OPENGL if chosen == "egl" else pybullet.ER_TINY_RENDERER
    count, begin = -1, time.monotonic()
    while count < 0 or time.monotonic() - begin < seconds:
        pybullet.getCameraImage(
            request.width,
            request.height,
            viewMatrix=view,
            projectionMatrix=projection,
            shadow=0,
            renderer=kind,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=engine._client,
        )
        count += 1
        if count == 0:
            begin = time.monotonic()  # the first one uploads textures
    rate = count / (time.monotonic() - begin)
    engine.close()
    return rate


def main(seconds, renderer):
    """Alternates: received rate with the bridge running, bare rate with it paused."""
    seconds = float(seconds)
    graph.join()
    pictures = graph.record("/camera/image", 4)
    graph.wait_for_controllers()
    graph.start_circle(graph.publishers())
    pause = rospy.ServiceProxy("/gazebo/pause_physics", Empty)
    unpause = rospy.ServiceProxy("/gazebo/unpause_physics", Empty)
    time.sleep(1.5)
    world = graph.bare_world()
    while True:
        graph.hear()
        begin = len(pictures)
        start = time.monotonic()
        time.sleep(seconds)
        rate = (len(pictures) - begin) / (time.monotonic() - start)
        pause()
        time.sleep(0.2)
        bare = bare_frames(world, renderer, seconds)
        unpause()
        time.sleep(0.3)
        graph.say(received=rate, bare=bare)
