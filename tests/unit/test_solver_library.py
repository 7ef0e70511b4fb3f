"""The compiled solver: loaded without numba, the same bits as numba's functions, faults."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bullet_sim.engine.quickstep import entries, library, sources, state
from bullet_sim.engine.quickstep.layout import G_KP
from bullet_sim.pose import Pose
from bullet_sim.world import World

TESTS = Path(__file__).resolve().parents[2] / "src" / "bullet_sim" / "test"
sys.path.append(str(TESTS))

import gazebo_states  # noqa: E402

# Started by itself: a car of meshes on a mesh, with a lidar's rays; prints the bits of its states,
# and whether numba was imported. An argument is where the library is looked for instead.
PROGRAM = """
import hashlib, json, sys
from pathlib import Path
from bullet_sim.engine.quickstep import sources
if len(sys.argv) > 2:
    sources.library_path = lambda: Path(sys.argv[2])
sys.path.append(sys.argv[1])
import numpy as np
import gazebo_states
from driving import drive_velocities
from bullet_sim.engine.api import Rays
from bullet_sim.pose import Pose
from bullet_sim.world import World

bits = hashlib.sha256()
rays = np.array([(np.cos(a), np.sin(a), 0.0) for a in np.linspace(-3.0, 3.0, 90)])
for name in ("meshes on a mesh", "wheels push a can", "steering by effort"):
    urdf, height, _ = gazebo_states.ROBOTS[name]
    world = World(solver="ode")
    for model, sdf in (("ground", gazebo_states.ground(name)), ("c", gazebo_states.crate(name))):
        if sdf:
            text = f'<sdf version="1.6">{sdf}</sdf>'.replace("{folder}", FOLDER)
            world.spawn_sdf(model, text, Pose(), lambda uri: uri[7:])
    model = world.spawn_urdf("bot", urdf.replace("{folder}", FOLDER), Pose((0, 0, height)),
                             lambda uri: uri[7:])
    world.spawn_sdf("ball", BALL, Pose((2.0, 0.3, 0.2)), str)
    drive_velocities(model.joints, model.joints.names, [5.0] * len(model.joints.names))
    for _ in range(5):
        world.step(60)
        bits.update(model.body.rows.tobytes())
        center = np.array((0.0, 0.0, 0.3))
        found = world.engine.cast_rays(Rays(center, rays, 0.1, 9.0))
        bits.update(found.tobytes())
    world.close()
print(json.dumps({"bits": bits.hexdigest(), "numba": "numba" in sys.modules}))
"""
BALL = (
    '<sdf version="1.6"><model name="ball"><link name="link"><inertial><mass>1</mass></inertial>'
    '<collision name="c"><geometry><sphere><radius>0.2</radius></sphere></geometry></collision>'
    "</link></model></sdf>"
)


def drive(folder, *arguments):
    """What PROGRAM prints."""
    gazebo_states.write_meshes(folder)
    program = PROGRAM.replace("FOLDER", repr(str(folder))).replace("BALL", repr(BALL))
    words = [sys.executable, "-c", program, str(TESTS), *map(str, arguments)]
    return json.loads(subprocess.check_output(words, text=True))


def test_steps_trees_and_rays_need_no_numba_and_have_its_bits(tmp_path):
    found = drive(tmp_path)
    assert found["numba"] is False
    wanted = drive(tmp_path, tmp_path / "nowhere.so")
    assert wanted["numba"] is True and found["bits"] == wanted["bits"]


def test_a_library_that_is_none_is_left_alone(tmp_path):
    broken = tmp_path / "broken.so"
    broken.write_bytes(b"\x7fELF")
    assert library._open(broken) is None and library._open(tmp_path / "nowhere.so") is None
    linked = tmp_path / "linked.so"
    subprocess.run(["cc", "-shared", "-o", linked, "-x", "c", "/dev/null"], check=True)
    assert library._open(linked) is None  # it has no such functions


@pytest.fixture
def one(monkeypatch):
    """A library has one function: all of them, which ./run setup compiles, take ten seconds."""
    name = "cast"
    monkeypatch.setattr(entries, "FUNCTIONS", {name: entries.FUNCTIONS[name]})
    monkeypatch.setattr(library, "CALLS", {name: state.CALLS[name]})
    return name


def test_a_library_is_made_and_takes_the_place_of_older_ones(tmp_path, one):
    older, mine, elsewhere = (tmp_path / f"quickstep-{k}.so" for k in range(3))
    for path in (older, elsewhere):
        path.touch()
    os.utime(older, (1e9, 1e9))  # of sources that have changed since; the other, of a processor
    entries.make_library(mine)
    assert sorted(tmp_path.iterdir()) == [mine, elsewhere]
    assert set(library._open(mine)) == {one}


def test_the_library_of_setup_has_every_function():
    made = library._open(sources.library_path())
    assert set(made) == set(entries.FUNCTIONS) == set(state.CALLS)


def test_another_processor_compiles_once(tmp_path, monkeypatch):
    """Its library is made where there are only others', though numba has compiled for one."""
    monkeypatch.setattr(entries, "CACHE", tmp_path)
    monkeypatch.setattr(library, "CACHE", tmp_path)
    monkeypatch.setattr(library, "_library", None)
    monkeypatch.setattr(library, "entries", entries, raising=False)
    made = []
    monkeypatch.setattr(entries, "make_library", made.append)
    (tmp_path / "solver.advance-1.nbi").touch()
    assert library.is_compiled()
    library.compile_once()
    assert not made
    (tmp_path / "quickstep-0.so").touch()
    assert not library.is_compiled()
    library.compile_once()
    assert made == [sources.library_path()]


@pytest.mark.usefixtures("one")
def test_without_a_linker_it_is_said(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(entries.shutil, "which", lambda name: None)
    monkeypatch.setattr(entries, "library_path", lambda: tmp_path / "quickstep-1.so")
    entries.main()
    told = capsys.readouterr().err
    assert "no library of the solver" in told and "none of cc, gcc, clang, g++" in told
    monkeypatch.setattr(entries.shutil, "which", lambda name: "/bin/false")
    entries.main()
    assert "/bin/false failed" in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_the_name_of_a_library_is_of_its_sources_and_processor(monkeypatch):
    name = sources.library_path().name
    monkeypatch.setattr(sources, "_processor", lambda: b"another one")
    other = sources.library_path().name
    monkeypatch.setattr(sources, "sources_hash", lambda: "other sources")
    assert len({name, other, sources.library_path().name}) == 3


def test_a_division_by_zero_ends_nothing():
    world = World(solver="ode")
    try:
        floor = "<plane><normal>0 0 1</normal></plane>"
        text = BALL.replace("<sphere><radius>0.2</radius></sphere>", floor)
        ground = text.replace('name="ball">', 'name="ground"><static>1</static>')
        world.spawn_sdf("ground", ground, Pose(), str)
        world.spawn_sdf("ball", BALL, Pose((0.0, 0.0, 0.19)), str)
        world.step()
        world.engine.arrays.state.scene.shapes[:, G_KP] = 0.0
        world.step()
        assert world.step_count == 2
    finally:
        world.close()


@pytest.mark.parametrize(
    ("array", "text"),
    [
        (np.zeros((4, 3, 3)), "corners is f8.3, must be f4.3"),
        (np.zeros((4, 9), np.float32), "corners is f4.2, must be f4.3"),
        (np.zeros((4, 3, 6), np.float32)[:, :, ::2], "corners is f4.3, not in C's order, must be"),
    ],
)
def test_an_array_of_another_kind_is_named(array, text):
    others = [np.zeros(1)] * 5
    with pytest.raises(TypeError, match=text.replace(".", r"\.")):
        state.make_table(state.Building(array, *others))


def test_setup_makes_it_again_when_a_source_is_newer(monkeypatch, tmp_path):
    from commands.bootstrap import workspace

    folder = tmp_path / "quickstep"
    (folder / "__pycache__").mkdir(parents=True)
    source, built = folder / "solver.py", folder / "__pycache__" / "sources.built"
    source.touch()
    monkeypatch.setattr(workspace, "SOLVER", str(folder))
    assert not workspace._is_compiled()
    built.touch()
    assert workspace._is_compiled()
    later = built.stat().st_mtime + 1
    os.utime(source, (later, later))
    assert not workspace._is_compiled()


def test_setup_compiles_nothing_where_only_dates_are_newer():
    from commands.bootstrap import workspace

    assert sources.library_path().is_file()
    check = f"{workspace.COMPILE}\nassert 'numba' not in sys.modules"
    subprocess.run([sys.executable, "-c", check, f"{workspace.SOURCES}/bullet_sim/src"], check=True)
