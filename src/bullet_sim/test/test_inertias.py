"""Inertias that joints move."""

import os
import subprocess
import sys

import pytest
from bullet_sim.description.lump import joint_inertias, lump
from bullet_sim.formats.urdf import parse_urdf
from urdf_texts import CONTROL, joint, link, robot

# A fork with a wheel 0.5 m ahead of its axis, and a slider, on a body of 8 kg.
LIMIT = '<limit lower="-3" upper="3" effort="10" velocity="300"/>'
URDF = robot(
    link("body", 8, 0.6), link("fork_link", 1, 0.02, center="0.2 0 0"),
    joint("fork", "revolute", "body", "fork_link", "1 0 0", "0 0 1", LIMIT),
    link("wheel_link", 2, 0.004),
    joint("wheel", "continuous", "fork_link", "wheel_link", "0.5 0 0"),
    link("slider_link", 2, 0.1),
    joint("slider", "prismatic", "body", "slider_link", axis="1 0 0", more=LIMIT), CONTROL,
)  # fmt: skip
JOINTS = ("fork", "wheel", "slider")
FORK = 0.02 + 1 * 0.2**2 + 0.004 + 2 * 0.5**2  # [kg m^2] about its own axis


def test_inertias_of_a_held_robot_are_those_beyond_the_joint():
    inertias = joint_inertias(lump(parse_urdf(URDF, str)), True, JOINTS)
    assert inertias == pytest.approx({"fork": FORK, "wheel": 0.004, "slider": 2.0})


def test_inertias_of_a_free_robot_are_the_reduced_ones():
    inertias = joint_inertias(lump(parse_urdf(URDF, str)), False, JOINTS)
    rest = 0.6 + 8 * 1.0 + 0.1 + 2 * 1.0  # body and slider about the fork's axis
    assert inertias["fork"] == pytest.approx(FORK * rest / (FORK + rest))
    assert inertias["slider"] == pytest.approx(2.0 * 11.0 / 13.0)


def test_the_last_bits_do_not_depend_on_the_hashes_of_names():
    """Sets of strings have another order in each process: sums must not follow it."""
    links = (
        link(f"l{n}", 0.1 + n / 7.0, (0.1 / (n + 3), 0.2 / (n + 3), 0.15 / (n + 3)))
        for n in range(9)
    )
    joints = (
        joint(f"j{n}", "continuous", f"l{n}", f"l{n + 1}", f"{n / 3.0} 0.1 0", "0 0 1")
        for n in range(8)
    )
    script = (
        "from bullet_sim.description.lump import joint_inertias, lump\n"
        "from bullet_sim.formats.urdf import parse_urdf\n"
        f"text = {robot(*links, *joints)!r}\n"
        "print(joint_inertias(lump(parse_urdf(text, str, 'r')), False, ['j2', 'j7']))"
    )
    seen = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": str(seed)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in (1, 2, 3)
    }
    assert len(seen) == 1
