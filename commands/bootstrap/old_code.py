"""What old C++ of users' packages lacks for the compilers and libraries of today.

Found by reading their sources before the build, so that no failure has to come first. Packages are
not changed: config/cmake/users_packages.cmake adds options to their targets.
"""

import glob
import itertools
import os
import re

from commands.bootstrap import left_out, ros
from commands.paths import BUILD, ROOT, read, write

HOOK = os.path.join(ROOT, "config", "cmake", "users_packages.cmake")
HEADERS = os.path.join(ROOT, "config", "include")
PLUGINLIB = os.path.join(ROOT, "config", "cmake", "pluginlib")
DEBIANS_PLUGINLIB = "/usr/share/pluginlib/cmake/pluginlibConfig.cmake"
HELP = os.path.join(BUILD, "users_packages.cmake")
SOURCES = (".c", ".cc", ".cpp", ".cxx", ".h", ".hh", ".hpp", ".hxx")
LARGEST = 1_000_000  # [bytes] of a source that is read
GLOG = "/usr/include/glog/logging.h"
# Boost's libraries that packages forget to link, as those of ROS brought them once
BOOST = ("date_time", "filesystem", "program_options", "regex", "serialization")
# Those of one header, and of a namespace of its name, which packages forget to include
HEADER = ("filesystem", "program_options")
OLDEST_STANDARD = 17  # that log4cxx 1.0, which ros/console.h includes, compiles with
# What the headers of a package bring into those that include them
PASSED = re.compile(r"placeholders|headers|ffmpeg|eigen|glog|include_.*")
_BARE = re.compile(r"\bbind\s*[(<][^;]*?[\s,(]_[1-9]\b")
_STD_PLACEHOLDERS = re.compile(r"using namespace std::placeholders|using std::placeholders")
_STANDARD = re.compile(
    r"std=(?:c|gnu)\+\+(?:98|03|0x|11|1y|14)\b|CXX_STANDARD\s+\"?(?:98|11|14)\b|cxx_std_(?:98|11|14)\b"
)
_BEFORE_FFMPEG_5 = re.compile(
    r"\bavcodec_get_context_defaults3\b|\bav(?:codec)?_register_all\b|\bAVLockOp\b|"
    r"(?<!const )\b(?:AVCodec|AVOutputFormat|AVInputFormat) ?\*"
)
_CUT_OFF = re.compile(  # as an index, not as what is cast or compared
    r"(?<![\w:])(?!(?:\w*int\w*|\w*size_t|unsigned|long|short|u?char|float|double|if|while|return)\b)"
    r"[A-Za-z_]\w*(?:\[\w+\])?\s*\(\s*(?:std::)?(?:round|floor|ceil|trunc)f?\("
)
_SINK = re.compile(r"\bgoogle::LogSink\b")
_TM = re.compile(r"\btm ?\*|\btm const ?\*")
_GAZEBO = re.compile(r"\bgazebo\b", re.I)
_COMMENT = re.compile(r"#.*")
BUILD_TAGS = ("depend", "build_depend", "buildtool_depend")  # by which catkin orders packages
WORDS = {
    "placeholders": "boost's placeholders _1, _2 ... in the global namespace",
    "glog": "glog's sinks of before 0.6",
    "headers": "headers under their old names",
    "eigen": "matrices of Eigen that floating-point numbers index",
    "ffmpeg": "names of FFmpeg before 5, and its codecs without const",
    "protobuf": "the Protocol Buffers of Gazebo's libraries, if they are there",
    "standard": f"C++ {OLDEST_STANDARD} in place of an older one, which log4cxx needs",
}


def needs_of(folder):
    """Tells what a package needs.

    Args:
        folder: Its folder.

    Returns:
        List of placeholders, headers, ffmpeg, eigen, glog, standard, protobuf, include_NAME,
        boost_NAME and pluginlib.
    """
    cmake, sources = texts(folder)
    result = []
    if any(map(_has_bare_placeholders, sources)) and not any(
        map(_STD_PLACEHOLDERS.search, sources)
    ):
        result.append("placeholders")
    if any(f"{name}>" in text or f'{name}"' in text for name in _lacking() for text in sources):
        result.append("headers")
    if any("libavcodec/" in text for text in sources) and any(
        map(_BEFORE_FFMPEG_5.search, sources)
    ):
        result.append("ffmpeg")
    if any("<Eigen/" in text for text in sources) and any(map(_CUT_OFF.search, sources)):
        result.append("eigen")
    if "LogMessageTime" in read(GLOG) and all(
        any(map(pattern.search, sources)) for pattern in (_SINK, _TM)
    ):
        result.append("glog")
    if _needs_standard() and _STANDARD.search(cmake):
        result.append("standard")
    if re.search(r"find_package\s*\(\s*protobuf\b", cmake, re.I) and _GAZEBO.search(cmake):
        result.append("protobuf")
    for name in BOOST:
        named = re.compile(rf"\bboost::{name}::")
        used = re.compile(rf"#\s*include\s*<boost/{name}(?:\.hpp|/)")
        is_used = any(map(used.search, sources))
        if name in HEADER and not is_used and any(map(named.search, sources)):
            result.append(f"include_{name}")
        if name not in cmake and (is_used or f"include_{name}" in result):
            result.append(f"boost_{name}")
    loads = any("<pluginlib/class_loader.hpp>" in text for text in sources)
    if loads and "include_filesystem" in result:  # which Noetic's pluginlib includes
        result.append("pluginlib")
    return result


def configured_first(packages, workspace):
    """Lists what cmake configures before a user's packages, which find it without asking for it in
    their package.xml, as what a ROS has: Paddock's own packages, and what these ask for.

    Args:
        packages: Those of the user: of each name the folder.
        workspace: The same of all packages that are built with them.
    """
    own = workspace.keys() - packages.keys()
    return sorted(own.union(*(_before(name, workspace) & workspace.keys() for name in own)))


def forgotten(name, packages):
    """Lists packages with messages that a package finds as components of catkin, and whose place
    before it in the build no package.xml asks for.

    Args:
        name: The package's name.
        packages: All packages of the workspace: of each name its folder.
    """
    asked = [package for package in left_out.components_of(packages[name]) if package in packages]
    before = _before(name, packages)
    return [
        package for package in asked if package not in before and _has_messages(packages[package])
    ]


def _before(name, packages):
    """Names of all that a package's package.xml asks to be built before it, and theirs."""
    before, result = set(), left_out.asked_for(packages[name], BUILD_TAGS)
    while result:
        before |= result
        result = {
            package
            for other in result & packages.keys()
            for package in left_out.asked_for(packages[other])
            if package not in before
        }
    return before


def with_headers(packages):
    """Tells what packages need, with what the headers need that they include of each other.

    Args:
        packages: Of each name the folder.

    Returns:
        Of each name a list, see needs_of().
    """
    own = {name: needs_of(folder) for name, folder in packages.items()}
    passed = {
        name: list(filter(PASSED.fullmatch, needs_of(os.path.join(packages[name], "include"))))
        for name, needs in own.items()
        if any(map(PASSED.fullmatch, needs))
    }
    result = {}
    for name, needs in own.items():
        before = _before(name, packages) if passed else set()
        more = {need for other in before & passed.keys() for need in passed[other]} - set(needs)
        if "placeholders" in more and any(map(_STD_PLACEHOLDERS.search, texts(packages[name])[1])):
            more.remove("placeholders")
        result[name] = needs + sorted(more)
    return result


def _has_messages(folder):
    return "generate_messages(" in _COMMENT.sub("", read(os.path.join(folder, "CMakeLists.txt")))


def texts(folder):
    """Returns the text of all CMakeLists.txt without comments, and of each source a text."""
    cmake, sources = [], []
    for directory, below, files in os.walk(folder):
        below[:] = sorted(name for name in below if not name.startswith("."))
        for name in sorted(files):
            path = os.path.join(directory, name)
            if name == "CMakeLists.txt":
                cmake.append(_COMMENT.sub("", read(path)))
            elif name.endswith(SOURCES) and os.path.getsize(path) <= LARGEST:
                with open(path, encoding="utf-8", errors="replace") as stream:
                    sources.append(stream.read())
    return "\n".join(cmake), sources


def _has_bare_placeholders(text):
    brought = "placeholders" in text or "boost/bind.hpp" in text
    return "bind" in text and not brought and bool(_BARE.search(text))


def _lacking():
    """Lists the old headers that the ROS lacks, as they are included."""
    above = f"{ros.prefix()}/include" if ros.prefix() else "/usr/include"
    result = []
    for package in sorted(os.listdir(HEADERS)):
        for name in sorted(os.listdir(os.path.join(HEADERS, package))):
            places = (f"{above}/{package}/{name}", f"{above}/{package}/{package}/{name}")
            if not any(os.path.exists(place) for place in places):
                result.append(f"{package}/{name}")
    return result


def _needs_standard():
    """Returns whether there is a log4cxx that older standards do not compile."""
    for above in filter(None, (ros.prefix(), "/usr")):
        text = read(f"{above}/include/log4cxx/log4cxx.h")
        major = re.search(r"LOG4CXX_VERSION_MAJOR (\d+)", text)
        if major:
            return int(major[1]) >= 1
    return False


def prepare(packages, workspace):
    """Writes what the build includes for packages.

    Args:
        packages: Of each name the folder.
        workspace: The same of all packages that are built with them.

    Returns:
        Lines that say what is helped.
    """
    first = ";".join(configured_first(packages, workspace))
    lines = [f'set(PADDOCK_HEADERS "{HEADERS}")\n', f'set(PADDOCK_CONFIGURED_FIRST "{first}")\n']
    said = []
    needed = with_headers(packages)
    for name, folder in sorted(packages.items()):
        missing = forgotten(name, {**workspace, name: folder})
        needs = needed[name] + [f"messages_{package}" for package in missing]
        if needs:
            lines.append(f'set("paddock_help_{folder}" "{";".join(needs)}")\n')
            if "pluginlib" in needs and os.path.exists(DEBIANS_PLUGINLIB):  # for all packages
                lines.append(f'set(pluginlib_DIR "{PLUGINLIB}")\n')
            words = [
                WORDS.get(need, f"lib{need}")
                for need in needs
                if not need.startswith(("messages_", "include_", "pluginlib"))
            ]
            if words:
                said.append(f"{name} is built with {', '.join(words)}")
            if missing:
                said.append(f"{name} uses {', '.join(missing)}: no build_depend of its package.xml")
    if read(HELP) != "".join(lines):
        write(HELP, "".join(lines))
    return said


def helpers():
    """Lists the files by which packages are helped, this one among them."""
    folders = (os.path.dirname(HOOK), HEADERS)
    found = [glob.glob(f"{folder}/**", recursive=True) for folder in folders]
    return [os.path.abspath(__file__), *sorted(itertools.chain(*found))]


def options():
    """Returns the arguments of cmake."""
    return [f"-DCMAKE_PROJECT_INCLUDE={HOOK}", f"-DPADDOCK_HELP={HELP}"]
