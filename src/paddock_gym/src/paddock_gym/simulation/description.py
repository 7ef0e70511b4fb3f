"""The descriptions of a world: the car's URDF, the world file."""

import dataclasses
import functools
import pathlib

import xacro
from bullet_sim.formats.sdf import world as sdf

from track_model import source

CAMERA_SIZE = (160, 120)  # width, height [px]
LIDAR_RAYS = 64  # of the learner's lidar, over 300 degrees


def share_folder():
    """Folder of track_model's files: urdf, meshes."""
    return pathlib.Path(source.tracks_directory()).parent


@functools.lru_cache(maxsize=4)
def car_urdf(lidar_rays=LIDAR_RAYS):
    """URDF text of the car with a camera of CAMERA_SIZE and a lidar."""
    width, height = CAMERA_SIZE
    arguments = {
        "camera_width": str(width),
        "camera_height": str(height),
        "lidar_samples": str(lidar_rays),
    }
    path = share_folder() / "urdf" / "racecar.urdf.xacro"
    return xacro.process_file(str(path), mappings=arguments).toxml()


def world(time_step):
    """WorldDescription of track_model's launch files (solver, light, background), with a physics
    step [s] of one's own."""
    text = (share_folder() / "worlds" / "track.world").read_text(encoding="utf-8")
    return dataclasses.replace(sdf.parse_world(text, resolve), step=time_step)


def resolve(uri):
    """Path of a mesh's URI."""
    return uri.replace("package://track_model", str(share_folder())).replace("file://", "")
