"""The lists of Debian packages in config/: what of one is missing here.

A line is a name, or NAME|OTHER where systems differ; !CODENAME behind it leaves it out on that
release of Ubuntu; '#' starts a comment.
"""

import os
import re
import subprocess

from commands.paths import ROOT, os_release, read


def main(name, ros):
    """Prints what is missing of a list, a line each: what ./run asks before and after an update.

    Args:
        name: Of the list.
        ros: Folder of the ROS 1 that is used; empty for Debian's.
    """
    for package in missing(wanted(name, ros)):
        print(package)


def wanted(name, ros=""):
    """Returns the entries of a list, sorted; of apt.txt also those of the lists that go with it."""
    files = [name]
    if name == "apt.txt":
        files += ["apt-first.txt", *([] if ros else ["apt-ros.txt"])]
    left_out = f"!{os_release().get('UBUNTU_CODENAME')}"
    # A ROS with a Python of its own does not see the modules of the system's.
    own_python = ros and os.access(f"{ros}/bin/python3", os.X_OK)
    result = set()
    for file in files:
        for line in read(os.path.join(ROOT, "config", file)).splitlines():
            entry, *but = line.partition("#")[0].split() or [""]
            if entry and left_out not in but and not (own_python and entry.startswith("python3-")):
                result.add(entry)
    return sorted(result)


def missing(entries):
    """Returns what is not installed, of NAME|OTHER the first that apt has or could install."""
    there = installed(name for entry in entries for name in entry.split("|"))
    result = []
    for entry in entries:
        first, *others = entry.split("|")
        known = filter(lambda name: available([name]), [first, *others]) if others else iter(())
        chosen = next(known, first)
        if chosen not in there:
            result.append(chosen)
    return result


def installed(names):
    """Returns which packages are installed."""
    form = "-f=${db:Status-Abbrev} ${Package}\n"
    said = _said("dpkg-query", "-W", form, *sorted(set(names)))
    return set(re.findall("^.i +(.*)$", said, re.MULTILINE))


def available(names):
    """Returns which packages apt could install; installed ones are in any case.

    Raises:
        OSError: There is no apt.
    """
    names = sorted(set(names))
    said = _said("apt-cache", "policy", *names) if names else ""
    _, *parts = re.split(r"^(\S+):\n", said, flags=re.MULTILINE)  # names, and what is said of each
    lines = zip(parts[::2], parts[1::2])
    return {name for name, text in lines if re.search("^  Candidate: [^(]", text, re.MULTILINE)}


def _said(*words):
    done = subprocess.run(
        words, env={**os.environ, "LC_ALL": "C"}, capture_output=True, text=True, check=False
    )
    return done.stdout
