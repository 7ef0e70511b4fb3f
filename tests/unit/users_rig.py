"""What users bring: packages of several kinds, clones and archives of them."""

import shutil
import subprocess
import tarfile

import pytest

MANIFEST = (
    '<package format="2"><name>{}</name><version>1.0.0</version><description>x</description>'
    '<license>BSD</license><maintainer email="a@example.org">a</maintainer>'
    "<buildtool_depend>catkin</buildtool_depend></package>\n"
)
HEAD = "cmake_minimum_required(VERSION 3.0.2)\nproject({})\nfind_package(catkin REQUIRED {})\n"
CMAKE = (
    "cmake_minimum_required(VERSION 3.0.2)\nproject({})\n"
    "find_package(catkin REQUIRED)\ncatkin_package()\n"
)
INDEXED = """thing git https://example.org/nowhere/thing.git noetic thing
packed git https://example.org/nowhere/packed.git noetic packed
"""


def git(folder, *words):
    """Runs git with a name of its own."""
    named = ("-c", "user.name=A", "-c", "user.email=a@example.org")
    subprocess.run(["git", *named, *words], cwd=folder, check=True, capture_output=True)


def commit(folder):
    """Commits all that is in a folder."""
    git(folder, "add", ".")
    git(folder, "commit", "-q", "-m", "all")


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """A folder with a bare clone, thing.git (branches main and noetic), and archives of packed."""
    folder = tmp_path_factory.mktemp("sources")
    work = folder / "work"
    work.mkdir()
    git(work, "init", "-q", "-b", "main")
    (work / "README").write_text("other branch\n")
    commit(work)
    git(work, "checkout", "-q", "-b", "noetic")
    for name in ("package.xml", "CMakeLists.txt"):
        text = MANIFEST if name == "package.xml" else CMAKE
        (work / name).write_text(text.format("thing"))
    commit(work)
    git(folder, "clone", "-q", "--bare", "work", "thing.git")
    packed = folder / "packed-noetic"
    packed.mkdir()
    (packed / "package.xml").write_text(MANIFEST.format("packed"))
    (packed / "CMakeLists.txt").write_text(CMAKE.format("packed"))
    with tarfile.open(folder / "packed-noetic.tar.gz", "w:gz") as archive:
        archive.add(packed, "packed-noetic")
    shutil.rmtree(packed)
    return folder


def of_type(folder, kind, *wanted):
    """Makes a package one of another build type, which asks for others."""
    path = folder / "package.xml"
    text = "".join(f"<depend>{name}</depend>" for name in wanted)
    end = f"{text}<export><build_type>{kind}</build_type></export></package>"
    path.write_text(path.read_text().replace("</package>", end))


def package(folder, name, cmake, **sources):
    """Writes a package with its sources in src/."""
    (folder / "src").mkdir(parents=True)
    (folder / "package.xml").write_text(MANIFEST.format(name))
    (folder / "CMakeLists.txt").write_text(cmake)
    for source, text in sources.items():
        (folder / "src" / f"{source}.cpp").write_text(text)
    return folder
