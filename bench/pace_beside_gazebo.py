"""Record how fast Gazebo is in the worlds of worlds/causes.py, for the section beside_gazebo.

    ./run exec python bench/pace_beside_gazebo.py FOLDER [--seen-as PATH] [--only NAME ...]

writes the worlds and run.sh to FOLDER and waits. Then, where Gazebo 11 with gazebo_ros and
gazebo_plugins is (on this machine, with nothing else running; FOLDER may have another path there,
see --seen-as):

    bash PATH/run.sh

starts one world after the other, each until it has been measured. The record has Gazebo's ratios to
bare stepping of the same machine alone, so that they hold for other machines, too.
"""

import argparse
import json
import os
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from figures import BenchError  # noqa: E402
from launching import Observer  # noqa: E402
from paddock_common.process import free_port  # noqa: E402
from pairs import PAIRS  # noqa: E402
from sections import beside_gazebo  # noqa: E402
from worlds import causes  # noqa: E402

SECONDS = 1.5  # of a round
POLL = 0.2  # [s]
RUN = """#!/bin/bash
# Starts each world in Gazebo until it has been measured. As {seen_as}/run.sh.
cd "$(dirname "$0")"
export ROS_MASTER_URI=http://127.0.0.1:{port} ROS_IP=127.0.0.1 GAZEBO_MODEL_DATABASE_URI=
export GAZEBO_MASTER_URI=http://127.0.0.1:{other}
unset ROS_HOSTNAME
for name in {names}; do
  touch "$name.started"
  roslaunch -p {port} gazebo_ros empty_world.launch gui:=false world_name:="$PWD/$name.world" &
  until [ -e "$name.done" ]; do sleep 0.2; done
  kill -TERM $!
  wait $!
done
"""


def main(arguments=None):
    """Record; returns the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--seen-as", metavar="PATH", help="the folder's path where Gazebo runs")
    parser.add_argument("--only", nargs="+", choices=causes.CAUSES, metavar="NAME")
    chosen = parser.parse_args(arguments)
    folder, names = chosen.folder.resolve(), chosen.only or list(causes.CAUSES)
    seen_as = chosen.seen_as or str(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        causes.write(folder, name, seen_as)
        for suffix in ("started", "done"):
            (folder / f"{name}.{suffix}").unlink(missing_ok=True)
    port = free_port()
    (folder / "run.sh").write_text(
        RUN.format(seen_as=seen_as, port=port, other=free_port(), names=" ".join(names))
    )
    print(f"now start Gazebo: bash {seen_as}/run.sh", flush=True)
    environment = dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
    environment.pop("ROS_HOSTNAME", None)
    found = beside_gazebo.recorded() if beside_gazebo.RECORD.exists() else {}
    failed = False
    for name in names:
        while not (folder / f"{name}.started").exists():  # the world before has gone
            time.sleep(POLL)
        observer = Observer(environment, sys.stderr, "paces.world", name)
        try:
            found[name] = beside_gazebo.measure_world(observer, SECONDS, PAIRS)
            print(f"{name}: {found[name]['ratio']['median']:.3f} of bare stepping", flush=True)
        except BenchError as error:
            failed = True
            print(f"pace_beside_gazebo: {name}: {error}", file=sys.stderr)
        finally:
            observer.close()
            (folder / f"{name}.done").touch()
        ordered = {name: found[name] for name in causes.CAUSES if name in found}
        beside_gazebo.RECORD.write_text(json.dumps({"worlds": ordered}, indent=1) + "\n")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
