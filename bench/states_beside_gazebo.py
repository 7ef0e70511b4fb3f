"""States of small robots in Gazebo, step by step, for src/bullet_sim/test/test_gazebo_states.py.

    ./run exec python bench/states_beside_gazebo.py FOLDER          writes worlds, run.sh, a plugin
    bash FOLDER/run.sh          where Gazebo 11 and its headers are; the folder has the same path
    ./run exec python bench/states_beside_gazebo.py FOLDER --record   reads what run.sh has left

The record has numbers alone: where the base of each robot of gazebo_states.py is every 100 steps,
and where all links of its models are. NAMES="sphere springs" makes run.sh run these alone; what has
not run keeps its record.
They end before rounding has grown to a micrometer by the chaos of contacts.
"""

import argparse
import json
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "src" / "bullet_sim" / "test"))

import gazebo_states  # noqa: E402

WORLD = """<sdf version="1.6"><world name="default">
<physics type="ode"><max_step_size>0.001</max_step_size>
<real_time_update_rate>0</real_time_update_rate></physics>
%s<plugin name="trace" filename="{folder}/libtrace.so"/></world></sdf>
"""
RUN = """#!/bin/bash
# Builds the plugin and runs each world in Gazebo 11.
set -e
cd "$(dirname "$0")"
. /usr/share/gazebo/setup.sh
g++ -O1 -fPIC -shared -std=c++17 $(pkg-config --cflags gazebo) trace.cc -o libtrace.so \\
  $(pkg-config --libs gazebo)
export GAZEBO_MODEL_DATABASE_URI= TRACE_STEPS={steps} TRACE_EVERY={every}
for name in ${{NAMES:-$(ls *.ground | sed 's/[.]ground$//')}}; do
  if [ -e "$name.model" ]; then
    model=$(cat "$name.model")
  else
    model=$(gz sdf -p "$name.urdf" | sed -n '/<model /,/<\\/model>/p')
    pose="<pose>0 0 $(cat "$name.height") 0 0 0</pose>"
    model="${{model%%>*}}>$pose${{model#*>}}"
  fi
  {{ cat world.head "$name.ground"; echo "$model"; cat world.tail; }} >"$name.world"
  TRACE_OUT=$PWD/$name.out TRACE_COMMANDS=$PWD/$name.commands gzserver "$name.world"
done
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--record", action="store_true", help="read what run.sh has left")
    given = parser.parse_args()
    folder = given.folder.resolve()
    if given.record:
        record(folder)
        return
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(ROOT / "bench" / "states" / "trace.cc", folder)
    gazebo_states.write_meshes(folder)
    head, tail = WORLD.replace("{folder}", str(folder)).split("%s")
    (folder / "world.head").write_text(head)
    (folder / "world.tail").write_text(tail)
    (folder / "run.sh").write_text(RUN.format(steps=gazebo_states.STEPS, every=gazebo_states.EVERY))
    for name, (urdf, height, commands) in gazebo_states.ROBOTS.items():
        file = file_of(folder, name)
        file.with_suffix(".urdf").write_text(urdf.replace("{folder}", str(folder)))
        around = f"{gazebo_states.ground(name)}{gazebo_states.crate(name)}\n"
        file.with_suffix(".ground").write_text(around.replace("{folder}", str(folder)))
        file.with_suffix(".height").write_text(f"{height}\n")
        write_commands(file, commands)
    for name, (_, commands) in gazebo_states.ALL_MODELS.items():
        file = file_of(folder, name)
        file.with_suffix(".model").write_text(gazebo_states.model(name) + "\n")
        around = gazebo_states.ground(name) + gazebo_states.wind(name)
        file.with_suffix(".ground").write_text(around + "\n")
        write_commands(file, commands)


def write_commands(file, commands):
    """Write the commands that the plugin reads."""
    lines = [" ".join(map(str, command)) for command in commands]
    file.with_suffix(".commands").write_text("".join(f"{line}\n" for line in lines))


def file_of(folder, name):
    """A robot's file in a folder, without a suffix."""
    return folder / name.replace(" ", "_").replace(",", "")


def record(folder):
    """Write gazebo_states.json from the outputs in a folder."""
    found = {}
    for name in (*gazebo_states.ROBOTS, *gazebo_states.ALL_MODELS):
        found[name] = states = {}
        file = file_of(folder, name).with_suffix(".out")
        if not file.exists():  # what was recorded before stays
            found[name] = gazebo_states.recorded().get(name, {})
            continue
        for line in file.read_text().splitlines():
            head, *rest = line.split()
            if head == "S":
                step = rest[0]
                continue
            numbers = [float(f"{float(number):.10g}") for number in rest[1:8]]
            if name in gazebo_states.ALL_MODELS:
                states.setdefault(step, {})[rest[0]] = numbers
            elif rest[0] == "base":
                states[step] = numbers
    robots = []
    for name, states in found.items():
        rows = ",\n".join(f'  "{step}": {json.dumps(state)}' for step, state in states.items())
        robots.append(f" {json.dumps(name)}: {{\n{rows}\n }}")
    text = "{\n" + ",\n".join(robots) + "\n}\n"
    gazebo_states.RECORD.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
