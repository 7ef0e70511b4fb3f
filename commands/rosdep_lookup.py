"""Asks rosdep's library which Debian packages rosdep's names stand for; needs no network.

Run by the system's Python, as rosdep2 is Debian's: reads a JSON list of names from stdin and prints
a JSON object with those that it knows. Its sources are the files named as arguments, the first
comes first, and what `rosdep update` has brought, if somebody has run it.
"""

import json
import os
import sys

import yaml
from rosdep2 import create_default_installer_context, sources_list
from rosdep2.lookup import ResolutionError, RosdepDefinition

OS_NAME, INSTALLERS = "debian", ["apt"]
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # that of C takes a tenth of the time


def sources(paths):
    """Returns the data of all sources: dicts from a name to its rules."""
    result = []
    for path in filter(os.path.isfile, paths):
        with open(path, encoding="utf-8") as stream:
            result.append(yaml.load(stream, LOADER) or {})
    if os.path.isfile(os.path.join(sources_list.get_sources_cache_dir(), sources_list.CACHE_INDEX)):
        result += [source.rosdep_data for source in sources_list.load_cached_sources_list()]
    return result


def resolve(names, data, codename):
    """Returns the Debian packages of names, by the first source that has a rule for Debian."""
    installer = create_default_installer_context().get_installer("apt")
    result = {}
    for name in names:
        for entry in data:
            if name in entry and name not in result:
                definition = RosdepDefinition(name, entry[name])
                try:
                    kind, rule = definition.get_rule_for_platform(
                        OS_NAME, codename, INSTALLERS, INSTALLERS[0]
                    )
                except ResolutionError:
                    continue
                if kind in INSTALLERS:
                    result[name] = installer.resolve(rule)
    return result


def main():
    answer = resolve(json.load(sys.stdin), sources(sys.argv[2:]), sys.argv[1])
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main()
