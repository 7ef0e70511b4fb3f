"""Libraries: those of users' plugins, and the one that has Gazebo's in this process."""

from __future__ import annotations

import ctypes
import functools
import os
from collections.abc import Iterator
from typing import Any

import rospkg
from bullet_sim.errors import SimError
from bullet_sim.formats.resolve import listed
from bullet_sim.plugins.cpp import Libraries

from bullet_bridge.resolve import exported_folders

OWN = "PADDOCK_GAZEBO_PLUGINS"  # names the folder of Gazebo's own, where the host was built
HOST = "libbullet_gazebo_host.so"
MISSING = (
    "Gazebo's libraries are not there: ./run add gazebo brings them, or install libgazebo11-dev "
    "where the system has it, and build the workspace again; it is left out"
)
SENSORS = "libbullet_gazebo_sensors.so"  # beside HOST
STEP = ctypes.CFUNCTYPE(None)
_NUMBERS = ctypes.POINTER(ctypes.c_double)
CAST = ctypes.CFUNCTYPE(
    None, _NUMBERS, _NUMBERS, ctypes.c_int, ctypes.c_double, ctypes.c_double, _NUMBERS
)
_ARGUMENTS: dict[str, tuple[Any, list[Any]]] = {
    "columns": (ctypes.c_char_p, []),
    "error": (ctypes.c_char_p, []),
    "version": (ctypes.c_char_p, []),
    "open": (ctypes.c_bool, [ctypes.c_char_p] * 2),
    "world": (ctypes.c_bool, [ctypes.c_char_p]),
    "tables": (None, [ctypes.c_void_p] * 4 + [ctypes.c_double]),
    "insert": (ctypes.c_bool, [ctypes.c_char_p]),
    "remove": (ctypes.c_bool, [ctypes.c_char_p]),
    "bind_link": (
        ctypes.c_bool,
        [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_void_p, ctypes.c_bool],
    ),
    "bind_joint": (ctypes.c_bool, [ctypes.c_char_p] * 2 + [ctypes.c_int] * 3),
    "next_joint": (ctypes.c_char_p, [ctypes.c_void_p]),
    "next_model": (ctypes.c_char_p, [ctypes.c_void_p] * 2),
    "bind_made": (None, [ctypes.c_int] * 4),
    "place": (ctypes.c_bool, [ctypes.c_char_p, ctypes.c_void_p]),
    "pull": (None, []),
    "load_plugin": (ctypes.c_bool, [ctypes.c_char_p] * 3),
    "calls": (None, [STEP, CAST, STEP]),
    "is_idle": (ctypes.c_bool, []),
    "step": (ctypes.c_bool, [ctypes.c_double] * 2 + [ctypes.c_int, ctypes.c_void_p]),
    "watched_collisions": (ctypes.c_char_p, []),
    "add_contacts": (
        ctypes.c_bool,
        [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_void_p, ctypes.c_int],
    ),
    "unload_faulty": (ctypes.c_char_p, []),
    "next_moved": (ctypes.c_char_p, [ctypes.c_void_p]),
    "gravity": (ctypes.c_bool, [ctypes.c_void_p]),
    "reset": (ctypes.c_bool, [ctypes.c_bool]),
    "close": (None, []),
}
_OF_SENSORS = {"load_sensor": (ctypes.c_bool, [ctypes.c_char_p] * 4)}


def library_folders(packages: rospkg.RosPack | None = None) -> Iterator[str]:
    """Folders in which Gazebo and the loader look for a plugin's library, in their order."""
    yield from listed("GAZEBO_PLUGIN_PATH")
    yield from exported_folders(packages or rospkg.RosPack(), "plugin_path")
    yield from listed("LD_LIBRARY_PATH")
    for prefix in listed("CMAKE_PREFIX_PATH"):
        yield os.path.join(prefix, "lib")
    yield from listed(OWN)


def find_host() -> str:
    """Path of HOST; '': it is not built."""
    folders = [*listed("LD_LIBRARY_PATH")]
    folders += [os.path.join(prefix, "lib") for prefix in listed("CMAKE_PREFIX_PATH")]
    paths = (os.path.join(folder, HOST) for folder in folders)
    return next((path for path in paths if os.path.exists(path)), "")


def users_libraries() -> Libraries:
    """Where plugins in C++ are, for bullet_sim.plugins.cpp; folders are searched once a name."""
    folders: list[str] = []

    @functools.lru_cache(maxsize=None)
    def folder_of(name: str) -> str:
        if not folders:
            folders.extend(library_folders())
        has = (each for each in folders if os.path.exists(os.path.join(each, f"lib{name}.so")))
        return next(has, "")

    return Libraries(folder_of, "" if find_host() else MISSING)


class HostLibrary:
    """The functions of HOST, `paddock_NAME` by their names; see src/bullet_gazebo_host/src/host.cc.

    Raises:
        SimError: it is not there, or cannot be loaded.
    """

    def __init__(self) -> None:
        path = find_host()
        if not path:
            raise SimError(f"{HOST} is in no folder of CMAKE_PREFIX_PATH: {MISSING}")
        self._folder = os.path.dirname(path)
        self._loaded: list[ctypes.CDLL] = []  # whose functions live as long as they do
        self._enter(path, _ARGUMENTS)

    def _enter(self, path: str, functions: dict[str, tuple[Any, list[Any]]]) -> None:
        try:  # global: plugins and Gazebo's libraries have types and functions of each other
            library = ctypes.CDLL(path, mode=ctypes.RTLD_GLOBAL)
        except OSError as error:
            raise SimError(f"{path} cannot be loaded: {error}") from error
        self._loaded.append(library)
        for name, (result, arguments) in functions.items():
            function = getattr(library, f"paddock_{name}")
            function.restype, function.argtypes = result, arguments
            setattr(self, name, function)

    def load_sensors(self) -> None:
        """Have the functions of SENSORS, with Gazebo's sensors, too; SimError: as above."""
        if "load_sensor" not in vars(self):
            self._enter(os.path.join(self._folder, SENSORS), _OF_SENSORS)

    def __getattr__(self, name: str) -> Any:  # those of _ARGUMENTS are set in _enter
        raise AttributeError(name)

    def check(self, succeeded: bool, what: str) -> None:
        """Raise SimError with what the library says where something has not succeeded."""
        if not succeeded:
            raise SimError(f"{what}: {self.error().decode(errors='replace')}")
