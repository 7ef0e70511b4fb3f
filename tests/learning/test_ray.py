"""Trainings whose workers are Ray actors: they learn, and outlive their actors and nodes."""

import csv
import os
import signal

import psutil
import pytest
from paddock_gym.training.ray_actors import cpus_per_actor

LOOPBACK = ("127.0.0.1", "::1", "::ffff:127.0.0.1")
LOST = "a worker died and was replaced; its run is lost"


def below(parent, title="ray::"):
    """Processes below one whose title begins with some words."""
    return [
        child
        for child in psutil.Process(parent).children(recursive=True)
        if " ".join(child.cmdline()).startswith(title)
    ]


def complete(training, steps):
    """Check that a training's files tell of all its steps; returns the report."""
    report = training.report()
    assert report["steps"] == steps
    rows = list(csv.DictReader((training.folder / "episodes.csv").open()))
    driven = sum(int(float(row["length"])) for row in rows)
    assert 0.5 * steps < driven <= steps
    assert (training.folder / "policy.onnx").is_file()
    assert (training.folder / "best_lap.mp4").is_file()
    return report


def test_a_killed_actor_costs_its_run_only(training):
    process = training.start(steps=6144, workers=2, ray="auto")
    training.wait_for(process, " steps, ")
    actors = below(process.pid, "ray::Actor")
    assert len(actors) == 2
    listening = [
        connection.laddr.ip
        for child in psutil.Process(process.pid).children(recursive=True)
        for connection in child.connections("tcp")
        if connection.status == psutil.CONN_LISTEN
    ]
    assert listening and set(listening) <= set(LOOPBACK)
    os.kill(actors[0].pid, signal.SIGKILL)
    lines = training.wait_for(process, LOST)
    output = process.communicate(timeout=600.0)[0]
    assert process.returncode == 0, "".join(lines) + output
    assert complete(training, 6144)["workers_lost"] == 1


def test_a_killed_node_costs_its_runs_only(training, monkeypatch):
    monkeypatch.setenv("RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER", "0")  # listen on loopback
    monkeypatch.setenv("RAY_health_check_period_ms", "500")
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    try:
        node = cluster.add_node(num_cpus=1)
        process = training.start(steps=6144, workers=0, ray=cluster.address)
        lines = training.wait_for(process, " steps, ")
        assert "train: Ray with 2 nodes, 2 processors\n" in lines
        cluster.remove_node(node, allow_graceful=False)
        lines += training.wait_for(process, LOST)
        output = process.communicate(timeout=600.0)[0]
        assert process.returncode == 0, "".join(lines) + output
        report = complete(training, 6144)
        assert report["settings"]["workers"] == 2
        # 2: Ray has put the replacement on the node, too, before it knew
        assert report["workers_lost"] in (1, 2)
    finally:
        cluster.shutdown()


def test_an_address_without_a_cluster_is_one_sentence(training):
    process = training.start(steps=512, workers=1, ray="127.0.0.1:9")
    output, _ = process.communicate(timeout=300.0)
    assert process.returncode == 1
    assert "train: ray is '127.0.0.1:9'; it must be auto, or HOST:PORT of the head" in output
    assert "Traceback" not in output


@pytest.mark.parametrize(
    "nodes, count, share", [([2.0], 2, 1.0), ([2.0], 8, 0.25), ([3.0, 3.0], 7, 0.75)]
)
def test_every_actor_finds_a_place(nodes, count, share):
    found = cpus_per_actor(nodes, count)
    assert found == pytest.approx(share, rel=0.07)
    assert sum(int(processors / found) for processors in nodes) >= count
