"""Command line, model text and poses of spawn_model; no master needed."""

import math
import threading

import pytest
from gazebo_msgs.srv import SpawnModelResponse
from gazebo_ros import spawn_model


@pytest.mark.parametrize(
    "rpy, expected",
    [
        ((0, 0, 0), (0, 0, 0, 1)),
        ((math.pi, 0, 0), (1, 0, 0, 0)),
        ((0, math.pi, 0), (0, 1, 0, 0)),
        ((0, 0, math.pi / 2), (0, 0, math.sqrt(0.5), math.sqrt(0.5))),
        ((math.pi / 2, 0, math.pi / 2), (0.5, 0.5, 0.5, 0.5)),
    ],
)
def test_quaternion(rpy, expected):
    assert spawn_model.quaternion_from_rpy(*rpy) == pytest.approx(expected, abs=1e-12)


def test_any_encoding_becomes_text():
    text = '<?xml version="1.0" encoding="utf-8"?>\n<robot name="M\u00fcller"/>'
    for given in (text, text.encode("utf-8"), "\ufeff" + text, text.encode("utf-16")):
        assert spawn_model.checked(given, "x") == text
    assert spawn_model.checked(text.encode("latin-1"), "x") == text


@pytest.mark.parametrize(
    "text",
    [
        "<!-- mine --><?xml version='1.0'?><robot/>",
        "<robot><sensor:eye/></robot>",
        "<robot name=r/>",
        "<robot>a & b</robot>",
    ],
)
def test_what_gazebos_reader_takes_goes_on_as_it_is(text):
    assert spawn_model.checked(text, "x") == text


def test_package_to_model():
    text = '<robot>\n<mesh scale="1 1 1"\n filename="package://car/a.stl"/>'
    text += '<mesh filename="file:///b"/><a filename="package://car/c"/></robot>'
    assert spawn_model.checked(text, "x") == text
    changed = spawn_model.checked(text, "x", package_to_model=True)
    assert changed == text.replace("package://car/a", "model://car/a")


@pytest.mark.parametrize("text, message", [("", "is empty"), ("<robot>", "not well-formed XML")])
def test_bad_text_names_its_source(text, message):
    with pytest.raises(spawn_model.ModelTextError, match="parameter /p.*" + message):
        spawn_model.checked(text, "parameter /p")


def test_command_line_of_the_deepracer():
    opts = spawn_model.parse_options(
        "-urdf -param robot_description -model racecar -x 3 -y 0.6 -z 0.5 -Y -1.5"
        " -J left 0.2 -wait track".split(),
        "/ns/",
    )
    assert (opts.x, opts.y, opts.z, opts.Y) == (3.0, 0.6, 0.5, -1.5)
    assert opts.joints == [("left", 0.2)] and opts.wait == "track" and opts.urdf
    assert opts.robot_namespace == "/ns/" and opts.gazebo_namespace == "/gazebo"


@pytest.mark.parametrize(
    "line",
    [
        "-model a",
        "-urdf -model a",
        "-urdf -sdf -param p -model a",
        "-urdf -param p",
    ],
)
def test_wrong_command_line_is_exit_2(line):
    with pytest.raises(SystemExit) as error:
        spawn_model.parse_options(line.split())
    assert error.value.code == 2


def test_a_position_that_is_no_number_is_exit_1_as_upstream(capsys):
    with pytest.raises(SystemExit) as error:
        spawn_model.parse_options("-urdf -param p -model a -J left nine".split())
    assert error.value.code == 1 and "nine" in capsys.readouterr().err


class Service:
    """Stands in for rospy.ServiceProxy: answers with a given response."""

    def __init__(self, answer):
        self.answer = answer

    def __call__(self, _name, _kind):
        return lambda **_: self.answer


@pytest.mark.parametrize("success", [True, False])
def test_lines_of_the_log_are_upstreams(monkeypatch, tmp_path, success):
    (tmp_path / "r.urdf").write_text("<robot name='r'/>")
    answer = SpawnModelResponse(success=success, status_message="SpawnModel: the answer")
    lines = []
    monkeypatch.setattr(spawn_model.waiting, "wait_for_service", lambda *_: None)
    monkeypatch.setattr(spawn_model.rospy, "ServiceProxy", Service(answer))
    for level in ("loginfo", "logerr"):
        monkeypatch.setattr(spawn_model.rospy, level, lambda text, *rest: lines.append(text % rest))
    opts = spawn_model.parse_options(["-urdf", "-file", str(tmp_path / "r.urdf"), "-model", "m"])
    if success:
        spawn_model.spawn(opts, threading.Event())
    else:
        with pytest.raises(spawn_model.SpawnError, match="SpawnModel: the answer"):
            spawn_model.spawn(opts, threading.Event())
    assert lines == [
        f"Loading model XML from file {tmp_path}/r.urdf",
        "Waiting for service /gazebo/spawn_urdf_model",
        "Calling service /gazebo/spawn_urdf_model",
        "Spawn status: SpawnModel: the answer",
        *([] if success else ["Spawn service failed. Exiting."]),
    ]


def test_it_waits_without_limit_and_reads_the_text_after_that_as_upstream(monkeypatch):
    """A parameter may be set while it waits for another model."""
    order = []

    class Simulator:
        def __init__(self, _namespace, timeout):
            order.append(timeout)

        def wait_for_model(self, model):
            order.append(model)

        def call(self, service, *_, **values):
            order.append((service, values["model_xml"]))

    monkeypatch.setattr(spawn_model, "Simulator", Simulator)
    monkeypatch.setattr(spawn_model.rospy, "loginfo", lambda *_: None)
    monkeypatch.setattr(spawn_model, "read_model", lambda _: order.append("read") or "text")
    line = "-urdf -param robot_description -model car -wait house"
    spawn_model.spawn(spawn_model.parse_options(line.split()), threading.Event())
    assert order == [None, "house", "read", ("spawn_urdf_model", "text")]
    assert spawn_model.parse_options(f"{line} -timeout 5".split()).timeout == 5.0
