"""Every section of the bench has its shape; efficiency refuses rounds that prove nothing."""

import importlib
import inspect
import json
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from paddock_gym.training.settings import Settings

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

from figures import BenchError  # noqa: E402
from pairs import Round, alternate  # noqa: E402
from report import Row, table  # noqa: E402
from sections import SECTIONS, efficiency, section  # noqa: E402
from usage import summarise  # noqa: E402
from worlds.car_description import describe  # noqa: E402

import bench  # noqa: E402


@pytest.mark.parametrize("name", SECTIONS)
def test_a_section_measures_and_tells(name):
    module = section(name)
    assert list(inspect.signature(module.measure).parameters)[0] == "quick"
    assert len(inspect.signature(module.measure).parameters) == 2
    assert list(inspect.signature(module.rows).parameters) == ["figures"]
    assert module.__doc__


def test_the_table_of_sections_is_that_of_the_folder():
    files = {path.stem for path in (BENCH / "sections").glob("*.py")} - {"__init__"}
    assert files == set(SECTIONS)


@pytest.mark.parametrize("path", sorted((BENCH / "observers").glob("*.py")), ids=lambda p: p.stem)
def test_an_observer_can_be_imported(path):
    importlib.import_module(f"observers.{path.stem}")


def spent(cpu, observer=1.0):
    """What usage.between gives for a round."""
    return {
        "seconds": 2.0,
        "cpu": {"bridge": cpu, "observer": observer},
        "others": 0.0,
        "stolen": 0.0,
        "threads": {
            name: {"cpu": value, "waited": 0.0, "switched_off": 0.0, "gave_up": 0.0}
            for name, value in (("simulation", cpu), ("reference", observer))
        },
    }


def bare(pace=40.0, speed=0.6, cpu=0.01):
    """A round of the reference; cpu: what the paused bridge took."""
    return {"pace": pace, "speeds": [speed], "spent": spent(cpu)}


def free(pace=20.0, speed=0.6, received=100, cpu=0.8):
    """A round of the bridge."""
    return {"pace": pace, "sim": 40.0, "speeds": [speed], "received": {"/clock": received},
            "spent": spent(cpu, 0.1)}  # fmt: skip


def test_cars_that_do_not_drive_alike_are_no_figure():
    assert efficiency._same_speeds([bare()], [free(speed=0.55)]) == [0.55]
    for its, mine in ((0.6, 0.3), (0.6, 0.9), (0.0, 0.0)):
        with pytest.raises(BenchError, match="not the same work"):
            efficiency._same_speeds([bare(speed=its)], [free(speed=mine)])


def test_a_silent_topic_is_no_figure():
    assert efficiency._received([free(received=100), free(received=60)]) == {"/clock": 2.0}
    with pytest.raises(BenchError, match="/clock"):
        efficiency._received([free(received=0)])


def test_a_graph_that_works_while_it_is_paused_is_no_figure():
    figures = {"paused_graph": efficiency._paused([bare(cpu=0.02)])}
    assert figures == {"paused_graph": 0.02}
    assert efficiency._beside_a_resting_graph(figures) == figures
    figures = {"paused_graph": efficiency._paused([bare(cpu=0.5)])}
    with pytest.raises(BenchError, match="paused graph took 0.50"):
        efficiency._beside_a_resting_graph(figures)


def test_own_time_counts_the_processor_time_of_both_threads():
    """20 simulated s in 0.8 of a processor against 40 in one whole: 25 / 40."""
    assert efficiency._own_time([bare()], [free()])["median"] == pytest.approx(25 / 40)


def test_the_rows_of_efficiency_tell_ratio_processors_and_comparison():
    figures = {}
    for name, pace in (("as_launched", 20.0), ("bridge_alone", 30.0)):
        rounds = [free(pace=pace)] * 3
        measured = alternate(
            lambda: Round(40.0, bare()), {"x": iter([Round(pace, t) for t in rounds]).__next__}, 3
        )["x"]
        figures[name] = {
            **measured.figures(),
            "own_time_ratio": efficiency._own_time([bare()], rounds[:1]),
            "spent": summarise([one_round["spent"] for one_round in rounds]),
            "reference_spent": summarise([bare()["spent"]]),
            "paused_graph": 0.01,
        }
    rows = {row.label: row for row in efficiency.rows(json.loads(json.dumps(figures)))}
    assert all(isinstance(row, Row) for row in rows.values())
    assert rows["free, as_launched"].value.median == 0.5
    assert "higher than as_launched" in rows["free, bridge_alone"].text
    assert "bridge 0.80" in rows["  processors"].text
    assert "paused graph 0.010" in rows["  beside the reference"].text


def test_the_rows_of_both_worlds_at_real_time_have_names_of_their_own():
    world = {
        "camera": {"rate_hz": 30.0, "gap_ms_p50": 33.0, "gap_ms_p99": 40.0, "gap_ms_max": 44.0},
        "scans_hz": 40.0,
        "real_time_factor": 1.0,
        "clock_lateness": {"late_ms_p50": 0.1, "late_ms_p999": 2.0, "late_ms_max": 3.0},
        "spent": summarise([spent(0.4)]),
    }
    found = list(section("driving").rows(dict(world, all_at_once=world)))
    merged = [row.label for row in found if row.value is not None]
    assert len(merged) == 6 and len(set(merged)) == 6
    assert any("40.00 scans a second" in row.text for row in found)


def test_a_section_that_fails_leaves_the_others(monkeypatch, tmp_path):
    class Failing:
        @staticmethod
        def measure(quick, log):
            raise BenchError("nothing came")

    class Half:
        @staticmethod
        def measure(quick, log):
            return {"quick_was": quick, "errors": {"part": "broke"}}

    modules = {"start": Failing, "camera": Half}
    monkeypatch.setattr(bench, "section", modules.__getitem__)
    with (tmp_path / "log").open("w") as log:
        result = bench.run(["start", "camera"], True, log)
    assert result["errors"] == {"start": "nothing came", "camera part": "broke"}
    assert result["camera"] == {"quick_was": True} and "start" not in result
    assert json.dumps(result)
    assert "start FAILED" in table({**result, "camera": {}})


def test_the_car_of_the_bench_worlds():
    robot = ElementTree.fromstring(
        describe(namespace="/a/b", topic="/a/scan", lidar_samples=1081, lidar_rate=40.0,
                 camera=False, efforts=True)
    )  # fmt: skip
    lidar = robot.find("gazebo/sensor[@type='ray']")
    assert lidar.findtext("update_rate") == "40.0"
    assert lidar.findtext("ray/scan/horizontal/samples") == "1081"
    assert lidar.findtext("plugin/topicName") == "/a/scan"
    assert robot.find("gazebo/sensor[@type='camera']") is None
    interfaces = {item.text for item in robot.iter("hardwareInterface")}
    assert interfaces == {"hardware_interface/EffortJointInterface"}
    assert len(robot.findall("transmission")) == 6
    plain = ElementTree.fromstring(describe(lidar=False))
    assert plain.find("gazebo/sensor[@type='ray']") is None
    assert plain.find("gazebo/sensor[@type='camera']") is not None


@pytest.mark.parametrize(
    "options, path, value",
    [
        ({"imu_rate": 1000.0}, "gazebo/sensor[@name='bench_imu']/update_rate", "1000.0"),
        ({"truth_rate": 500.0}, "gazebo/plugin[@name='bench_truth']/updateRate", "500.0"),
        (
            {"layers": 16},
            "gazebo/sensor[@name='bench_layers']/ray/scan/vertical/samples",
            "16",
        ),
    ],
)
def test_the_car_has_the_sensors_that_are_asked_for(options, path, value):
    assert ElementTree.fromstring(describe(**options)).findtext(path) == value
    assert ElementTree.fromstring(describe()).find(path) is None


def test_the_worlds_and_topics_of_the_variants_with_high_rates():
    for name in ("imu_1_khz", "ground_truth_1_khz", "ekf_and_imu_1_khz", "lidar_16_layers_10_hz"):
        variant = efficiency.VARIANTS[name]
        launch = ElementTree.parse(BENCH / "worlds" / variant.file)
        known = {item.get("name") for item in launch.iter("arg")}
        assert {item.partition(":=")[0] for item in variant.arguments} <= known
        assert variant.topics


@pytest.mark.parametrize("name", ["state", "lidar", "camera"])
def test_a_policy_that_lacks_is_trained_as_a_user_would(name, tmp_path, monkeypatch):
    gap = section("gym_gap")
    monkeypatch.setattr(gap, "FOLDER", tmp_path)
    table = gap.training(name)
    assert table.pop("folder") == str(tmp_path / name) and not table.pop("resume")
    settings = Settings(**table)
    assert settings.until_laps and settings.observation == (name,)
    assert settings.walls is (True if name == "lidar" else None)
    (tmp_path / name).mkdir()
    (tmp_path / name / "policy.onnx").touch()
    assert gap.policy_of(name, None) == tmp_path / name / "policy.onnx"


def test_a_lap_in_the_gym_and_over_ros_is_a_row_each(tmp_path):
    found = {"state": {"gym": 10.0, "ros": [10.0, 10.1, 10.2]}, "errors": {}}
    rows = {row.label: row for row in section("gym_gap").rows(found)}
    assert rows["state, lap in the gym"].value == 10.0
    assert rows["state, lap over ROS"].value.median == 10.1
    assert rows["state, over ROS longer by"].value.greatest == pytest.approx(2.0)
    assert rows["state, over ROS longer by"].unit == "%"
    path = tmp_path / "result.json"
    path.write_text(json.dumps({"starts": [{"outcome": "lap", "lap_time": 9.5}]}))
    assert section("gym_gap").lap_time(path) == 9.5
    path.write_text(json.dumps({"starts": [{"outcome": "off track", "lap_time": 0.0}]}))
    with pytest.raises(BenchError, match="no lap came of it: off track"):
        section("gym_gap").lap_time(path)
    with pytest.raises(BenchError, match="there was no result"):
        section("gym_gap").lap_time(tmp_path / "none.json")
