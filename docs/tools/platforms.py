"""Checks what can be looked up of systems that Paddock is not tried on: names and wheels.

    ./run exec python docs/tools/platforms.py [PLATFORM ...]

For each platform: which Debian packages of config/apt*.txt its lists lack, and of which pins of
config/requirements.txt and of the tests' lists PyPI has no wheel for its Python. What is known to
be compiled there is named and is no error. It needs the network and a Debian mirror; exit status 1
if something is missing.

Ubuntu's lists are not asked: Ubuntu 22.04 was made from Debian between 11 and 12, so it has what
both have. That is a conclusion and no look at its lists.
"""

from __future__ import annotations

import argparse
import lzma
import pathlib
import re
import subprocess
import sys
import tempfile
import urllib.request
from dataclasses import dataclass

from packaging.requirements import Requirement

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from commands.bare import host  # noqa: E402

LISTS = tuple(
    f"apt{name}.txt"
    for name in (
        "-first",
        "",
        "-ros",
        "-desk-server",
        "-desk",
        "-desk-test",
        "-test",
        "-lint",
        "-gym",
    )
)
PINS = tuple(f"requirements{name}.txt" for name in ("", "-opencv", "-test", "-lint", "-gym"))
GLIBC = (5, 12, 17, 24, 26, 27, 28, 31, 34, 35)  # minor versions that wheels are made for
COMPILED = {  # package -> whether it is compiled for a version of Python on a machine
    "pybullet": lambda python, machine: machine == "aarch64" or python > (3, 11),
    "moderngl": lambda python, machine: machine == "aarch64" and python > (3, 11),
    "glcontext": lambda python, machine: machine == "aarch64" and python > (3, 11),
}


@dataclass(frozen=True)
class Platform:
    """A system.

    Attributes:
        suites: Of Debian; a package has to be in all of them.
        machine: As Python and wheels call it.
        python: Its version.
        glibc: Its version, 2.MINOR.
    """

    suites: tuple[str, ...]
    machine: str
    python: tuple[int, int]
    glibc: int


PLATFORMS = {
    f"{name}-{architecture}": Platform(suites, machine, python, glibc)
    for name, suites, python, glibc in (
        ("debian12", ("bookworm",), (3, 11), 36),
        ("debian13", ("trixie",), (3, 13), 41),
        ("ubuntu22.04", ("bullseye", "bookworm"), (3, 10), 35),
    )
    for architecture, machine in (("amd64", "x86_64"), ("arm64", "aarch64"))
}
ARCHITECTURES = {"x86_64": "amd64", "aarch64": "arm64"}


def main():
    """Prints a line for each platform and list; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("platforms", nargs="*", metavar="PLATFORM", help=", ".join(PLATFORMS))
    names = parser.parse_args().platforms or list(PLATFORMS)
    unknown = [name for name in names if name not in PLATFORMS]
    if unknown:
        parser.error(f"PLATFORM is {unknown[0]!r}; there are {', '.join(PLATFORMS)}")
    bad = 0
    for name in names:
        lacking = lacking_packages(PLATFORMS[name])
        wheels, compiled = lacking_wheels(PLATFORMS[name])
        bad += len(lacking) + len(wheels)
        print(f"{name}: no Debian package for: {', '.join(lacking) or 'none of them'}")
        print(f"{name}: no wheel for: {', '.join(wheels) or 'none of them'}")
        print(f"{name}: compiled: {', '.join(compiled) or 'nothing'}", flush=True)
    return 1 if bad else 0


def lacking_packages(platform):
    """Lists the entries of config/apt*.txt that one of a platform's lists has no name of."""
    known = [debian_names(suite, ARCHITECTURES[platform.machine]) for suite in platform.suites]
    lacking = []
    for path in LISTS:
        for line in (ROOT / "config" / path).read_text().splitlines():
            words = line.partition("#")[0].split()
            if words and not all(names.intersection(words[0].split("|")) for names in known):
                lacking.append(words[0])
    return lacking


def debian_names(suite, architecture, kept={}):  # noqa: B006 - asked once in a process
    """Returns the names of the packages of a suite's main."""
    if (suite, architecture) not in kept:
        url = f"{host.mirror()}/dists/{suite}/main/binary-{architecture}/Packages.xz"
        with urllib.request.urlopen(url, timeout=120) as answer:
            text = lzma.decompress(answer.read()).decode()
        kept[suite, architecture] = set(re.findall(r"^Package: (\S+)$", text, re.MULTILINE))
    return kept[suite, architecture]


def pins(platform):
    """Lists the pins of PINS that hold on a platform, without their markers."""
    version = "{}.{}".format(*platform.python)
    environment = {
        "python_version": version,
        "python_full_version": f"{version}.0",
        "platform_machine": platform.machine,
    }
    found = []
    for line in "".join((ROOT / "config" / name).read_text() for name in PINS).splitlines():
        if line.partition("#")[0].strip():
            pin = Requirement(line.partition("#")[0])
            if pin.marker is None or pin.marker.evaluate(environment):
                found.append(f"{pin.name}{pin.specifier}")
    return found


def lacking_wheels(platform):
    """Returns the pins without a wheel: (those that have to have one, those that are compiled)."""
    lacking, compiled = [], []
    for pin in pins(platform):
        compiles = COMPILED.get(pin.partition("==")[0], lambda *_: False)
        if compiles(platform.python, platform.machine):
            compiled.append(pin)
        elif not has_wheel(pin, platform):
            lacking.append(pin)
    return lacking, compiled


def has_wheel(pin, platform):
    """Returns whether pip finds a wheel of a pin on PyPI; it downloads it."""
    version = "{}{}".format(*platform.python)
    wanted = [
        f"manylinux_2_{minor}_{platform.machine}" for minor in GLIBC if minor <= platform.glibc
    ]
    wanted += [f"manylinux{year}_{platform.machine}" for year in ("1", "2010", "2014")]
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", folder]
            + ["--only-binary=:all:", "--implementation", "cp", "--python-version", version]
            + [word for abi in (f"cp{version}", "abi3", "none") for word in ("--abi", abi)]
            + [word for tag in wanted for word in ("--platform", tag)]
            + [pin],
            capture_output=True,
            text=True,
        )
    if done.returncode and "No matching distribution" not in done.stderr:
        sys.exit(f"pip download {pin} failed:\n{done.stderr}")
    return done.returncode == 0


if __name__ == "__main__":
    sys.exit(main())
