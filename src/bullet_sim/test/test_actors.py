"""Actors: persons that follow a script, seen by cameras, gpu_ray and the page."""

import math

import numpy as np
import pytest
from bullet_sim.description.actor import ActorMotion, Trajectory, person
from bullet_sim.errors import WorldError
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.models.actor import STRIDE, ActorPath, limbs
from bullet_sim.plugins.actors import PedestrianSpec, WalkerSpec
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose, quaternion_from_yaw
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.request import CameraRequest, Quality
from bullet_sim.sensors.lidar import Lidar
from bullet_sim.sensors.scenes import WorldViews
from bullet_sim.world import World

WAYPOINTS = (
    (0.0, 0.0, 0.0, 0.0),
    (2.0, 2.0, 0.0, 0.0),
    (3.0, 2.0, 0.0, 1.5708),
    (5.0, 2.0, 3.0, 1.5708),
)


def waypoints(points):
    return "".join(
        f"<waypoint><time>{time}</time><pose>{x} {y} 0 0 0 {yaw}</pose></waypoint>"
        for time, x, y, yaw in points
    )


def actor(script="", points=WAYPOINTS, more="", interpolate="true"):
    return (
        "<actor name='walker'><pose>5 5 0 0 0 0</pose><skin><filename>walk.dae</filename></skin>"
        "<animation name='walking'><filename>walk.dae</filename><interpolate_x>"
        f"{interpolate}</interpolate_x></animation><script>{script}<trajectory id='0' "
        f"type='walking'>{waypoints(points)}</trajectory></script>{more}</actor>"
    )


def described(text):
    return parse_world(f'<sdf version="1.7"><world name="w">{text}</world></sdf>', str)


def loaded(world, text):
    world.load(described(text))
    return world.models["walker"]


def at(model):
    x, y, _ = model.pose.position
    return x, y, model.pose.rpy[2]


def run_to(world, time):
    world.step(round((time - world.time) / world.time_step))


def test_it_is_at_its_waypoints_at_their_times(world):
    model = loaded(world, actor())
    for time, *place in WAYPOINTS[:-1]:
        run_to(world, time)
        assert at(model) == pytest.approx(tuple(place), abs=1e-3)
    run_to(world, 1.0)
    world.reset()
    run_to(world, 1.0)  # half the way: a cubic with tangents of 1 and 1 m
    assert at(model) == pytest.approx((1.0, 0.0, at(model)[2]), abs=0.01)


def test_it_is_put_on_twenty_times_a_second(world):
    model = loaded(world, actor())
    run_to(world, 1.0)
    one = model.pose
    run_to(world, 1.049)
    assert model.pose == one
    run_to(world, 1.05)
    assert model.pose != one and model.link_state("walker_pose")[1].tolist() == [0.0, 0.0, 0.0]


def test_it_begins_again_or_stays(world):
    model = loaded(world, actor("<loop>true</loop>"))
    run_to(world, 7.0)  # five seconds are a round
    assert at(model) == pytest.approx((2.0, 0.0, 0.0), abs=1e-3)
    world.delete("walker")
    other = loaded(World(), actor("<loop>false</loop>"))
    assert other.name == "walker"


def test_without_a_loop_it_stays_at_the_end(world):
    model = loaded(world, actor("<loop>false</loop>"))
    run_to(world, 9.0)
    assert at(model) == pytest.approx((2.0, 3.0, 1.5708), abs=0.05)  # at the last frame before it
    there = model.pose
    run_to(world, 10.0)
    assert model.pose == there


def test_it_waits(world):
    model = loaded(world, actor("<delay_start>2</delay_start>"))
    run_to(world, 1.9)
    assert at(model) == pytest.approx((5.0, 5.0, 0.0))
    run_to(world, 4.0)
    assert at(model) == pytest.approx((2.0, 0.0, 0.0), abs=1e-3)


def test_one_that_does_not_start_stands_where_its_pose_is(world):
    model = loaded(world, actor("<auto_start>false</auto_start>"))
    run_to(world, 3.0)
    assert at(model) == pytest.approx((5.0, 5.0, 0.0))


def test_trajectories_follow_each_other_by_their_ids(world):
    text = (
        "<actor name='walker'><animation name='a'/><script>"
        f"<trajectory id='2' type='a'>{waypoints([(0, 9, 0, 0), (1, 9, 1, 0)])}</trajectory>"
        f"<trajectory id='1' type='a'>{waypoints([(1, 0, 0, 0), (2, 4, 0, 0)])}</trajectory>"
        "<trajectory id='3' type='nothing'/></script></actor>"
    )
    model = loaded(world, text)
    assert at(model)[:2] == pytest.approx((0.0, 0.0))
    run_to(world, 1.0)
    assert at(model)[:2] == pytest.approx((0.0, 0.0))  # its first waypoint
    run_to(world, 2.5)
    assert at(model)[0] == pytest.approx(9.0)
    assert any("trajectory of type 'nothing'" in text for text in model.description.warnings)


def test_a_closed_way_has_no_corner_where_it_begins():
    corners = ((0, 0), (4, 0), (4, 4), (0, 4), (0, 0))
    poses = tuple(Pose((float(x), float(y), 0.0)) for x, y in corners)
    path = ActorPath(ActorMotion((Trajectory("a", 8.0, (0.0, 2.0, 4.0, 6.0, 8.0), poses),)))
    before, start, after = (np.array(path.at(time)[0].position) for time in (7.95, 8.0, 8.05))
    one, two = start - before, after - start
    assert one @ two / np.linalg.norm(one) / np.linalg.norm(two) > 0.99


def test_tension_makes_it_stop_at_a_waypoint():
    poses = tuple(Pose((float(x), 0.0, 0.0)) for x in (0, 2, 4))
    ways = []
    for tension in (0.0, 1.0):
        motion = ActorMotion((Trajectory("a", 4.0, (0.0, 2.0, 4.0), poses, tension),))
        path = ActorPath(motion)
        ways.append(path.at(2.05)[0].position[0] - path.at(1.95)[0].position[0])
    assert ways[0] == pytest.approx(0.1, rel=0.02) and ways[1] < 0.01


def test_it_turns_the_short_way_and_evenly_between_two_headings():
    poses = (Pose(), Pose((0.0, 0.0, 0.0), quaternion_from_yaw(math.radians(90.0))))
    path = ActorPath(ActorMotion((Trajectory("a", 2.0, (0.0, 2.0), poses),)))
    yaws = [path.at(time)[0].rpy[2] for time in np.arange(0.0, 2.0, 0.1)]
    assert np.diff(yaws).min() > 0.0 and yaws[10] == pytest.approx(math.radians(45.0), abs=0.02)


def test_limbs_swing_with_the_way_or_with_time():
    poses = (Pose(), Pose((4.0 * STRIDE, 0.0, 0.0)))
    script = (Trajectory("walk", 8.0, (0.0, 8.0), poses),)
    by_way = ActorPath(ActorMotion(script, by_distance=frozenset({"walk"})))
    pose, angles = by_way.at(4.0)
    assert angles == pytest.approx(limbs("walk", 2 * math.pi * pose.position[0] / STRIDE), abs=0.02)
    _, by_time = ActorPath(ActorMotion(script)).at(4.0)
    assert by_time == pytest.approx(limbs("walk", 2.0 * math.pi * 4.0 / 1.1))
    assert limbs("stand", 1.0) == {}
    one, other = limbs("walk", 1.0), limbs("walk", 1.0 + math.pi)
    assert one["LeftUpLeg"] == pytest.approx(other["RightUpLeg"])
    assert one["LeftUpLeg"] * one["LeftArm"] < 0.0
    assert one["LeftLeg"] == pytest.approx(0.5 * math.cos(1.0) + 0.05), "the shin swings forward"
    assert one["RightLeg"] == 0.05, "the other knee is stretched"


def test_a_person_stands_on_the_ground_and_is_as_tall_as_one():
    model = person("p", ActorMotion(scale=2.0))
    low, high = [], []
    world = World()
    loaded_model = world.spawn(model)
    for name, link in model.links.items():
        frame = Pose(*loaded_model.body.link_motion(name)[:2])
        for shape in link.visuals:
            half = shape.geometry.size[-1] / (1 if shape.geometry.kind == "sphere" else 2)
            height = (frame * shape.pose).position[2]
            low.append(height - half)
            high.append(height + half)
    assert min(low) == pytest.approx(0.02, abs=0.05) and max(high) == pytest.approx(3.54, abs=0.1)
    world.close()


def test_lidars_of_the_type_gpu_ray_see_it_and_others_do_not(world):
    loaded(world, actor("<auto_start>false</auto_start>"))
    spec = RaySpec("l", "l", samples=1, min_angle=0.0, max_angle=0.0, range_min=0.05)
    for scene, expected in ((world.visible, 5.0 - 0.11), (world.engine, math.inf)):
        seen = Lidar(spec).scan(scene, (0.0, 5.0, 1.25), (0.0, 0.0, 0.0, 1.0))
        assert seen.tolist() == pytest.approx([expected], abs=1e-5)


def test_cameras_see_it_where_it_walks(world):
    loaded(world, actor())
    renderer = GlRenderer(Quality("false", "false"))
    renderer.sync_sources(world.sources(), world.scene)
    asked = CameraRequest("eye", None, 0, ((-3.0, 0.0, 1.0), (0, 0, 0)), 160, 120, 1.2, 0.1, 30.0)
    heights = []
    for time in (0.0, 1.5, 5.5):  # 3, 4.5 and then 3 m and a bit away again
        run_to(world, time)
        picture = renderer.draw(world.snapshot(), asked).astype(int)
        differs = np.abs(picture - picture[0, 0]).max(axis=2) > 8
        heights.append(int(differs.any(axis=1).sum()))
    renderer.close()
    assert heights[0] > 60 and heights[1] < 0.8 * heights[0]
    assert heights[2] == pytest.approx(heights[0], rel=0.15)


def test_the_page_has_it_and_its_limbs(world):
    model = loaded(world, actor())
    views = WorldViews(world)
    (body,) = views.scene()["bodies"]
    assert (body["name"], body["static"]) == ("walker", False)
    assert [link["name"] for link in body["links"]][0] == "walker_pose" and len(body["links"]) == 9
    run_to(world, 1.0)
    (row,) = views.view()["bodies"]
    assert row[1:4] == pytest.approx(model.pose.position) and any(row[8:])


def test_it_is_a_model_that_nothing_moves(world):
    model = loaded(world, actor("<auto_start>false</auto_start>"))
    model.set_state(Pose((9.0, 9.0, 9.0)), (1.0, 0.0, 0.0))
    model.apply_wrench(model.root, (100.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    world.step(200)
    assert at(model) == pytest.approx((5.0, 5.0, 0.0))
    assert not model.is_static and list(world.models) == ["walker"]
    assert "LeftUpLeg_joint" in model.joints.names and len(model.body_motions()) == 9
    with pytest.raises(WorldError, match="is an actor"):
        world.attach("key", "walker", "walker_pose", "walker", "LeftLeg")


def test_states_and_resets_have_it(world):
    text = (
        "<model name='box'><link name='l'><collision name='c'><geometry><box><size>1 1 1</size>"
        "</box></geometry></collision></link></model>"
    )
    world.load(described(text + actor()))
    model, box = world.models["walker"], world.models["box"]
    run_to(world, 1.0)
    state, there, fallen = world.save_state(), model.pose, box.pose
    run_to(world, 2.0)
    world.restore_state(state)
    assert (model.pose, box.pose) == (there, fallen)
    world.start_over()
    run_to(world, 1.0)
    assert model.pose == there
    world.reset()
    run_to(world, 1.0)
    assert model.pose == there


@pytest.mark.parametrize(
    "links, name, place",
    [
        ("<link name='l'><pose>0 0 2 0 0 0</pose></link><link name='m'/>", "l", (2.0, 0.0, 2.0)),
        ("<link name='l'/><link name='m'><pose>0 1 0 0 0 0</pose></link>", "m", (2.0, 1.0, 0.0)),
        ("", "walker_pose", (2.0, 0.0, 0.0)),
    ],
)
def test_without_a_skin_its_links_follow_the_script_whatever_animation_it_names(
    world, links, name, place
):
    """As in Gazebo 11.1, where boxes are animated so."""
    script = f"<trajectory id='0' type='square'>{waypoints(WAYPOINTS)}</trajectory>"
    text = f"<actor name='walker'>{links}<script>{script}</script></actor>"
    assert described(text).warnings == []
    model = loaded(world, text)
    run_to(world, 2.0)
    assert at(model) == pytest.approx((2.0, 0.0, 0.0), abs=1e-3)
    assert model.link_motion(name)[0] == pytest.approx(place, abs=1e-3)


def test_what_of_it_is_not_read_is_told():
    more = "<plugin name='p' filename='libActorCollisionsPlugin.so'/><link name='l'/>"
    warnings = described(actor(more=more)).warnings
    assert any("skin 'walk.dae' and its animations are not read" in text for text in warnings)
    assert any("<plugin> 'p', which is ignored" in text for text in warnings)
    assert any("<link> 'l', which is ignored" in text for text in warnings)


def test_a_plugin_of_a_person_that_cannot_be_read_is_told():
    tags = "<trajectory><waypoint>1 here</waypoint></trajectory>"
    more = f"<plugin name='p' filename='libPedestrianSFMPlugin.so'>{tags}</plugin>"
    warnings = described(actor(more=more)).warnings
    assert any("'1 here'" in text and "plugin is left out" in text for text in warnings)


def test_a_walker_has_gazebos_parameters():
    tags = (
        "<target>1 2 1.2</target><target_weight>2</target_weight><obstacle_weight>3"
        "</obstacle_weight><ignore_obstacles><model>cafe</model><model>ground_plane</model>"
        "</ignore_obstacles>"
    )
    plugin = "<plugin name='p' filename='libActorPlugin.so'>{}</plugin>"
    found = described(actor(more=plugin.format(tags)))
    assert not any("<plugin>" in text for text in found.warnings)
    ((model, _),) = found.models
    assert model.sensors == [
        WalkerSpec("p", "walker_pose", (1.0, 2.0, 1.2), 2.0, 3.0, ("cafe", "ground_plane"))
    ]
    ((model, _),) = described(actor(more=plugin.format(""))).models
    assert model.sensors == [WalkerSpec("p", "walker_pose", (0.0, -5.0, 1.2138))]


def test_a_pedestrian_has_the_parameters_of_its_plugin():
    tags = (
        "<velocity>1.1</velocity><radius>0.4</radius><goal_weight>2.5</goal_weight>"
        "<obstacle_weight>80</obstacle_weight><social_weight>15</social_weight>"
        "<group_gaze_weight>1</group_gaze_weight><group_coh_weight>3</group_coh_weight>"
        "<group_rep_weight>4</group_rep_weight><people_distance>6</people_distance>"
        "<group><model>bob</model></group><ignore_obstacles><model>cafe</model>"
        "</ignore_obstacles><animation_factor>9</animation_factor>"
        "<trajectory><cyclic>true</cyclic><waypoint>1 2 1.2</waypoint>"
        "<waypoint>3 4 1.2</waypoint></trajectory>"
    )
    plugin = "<plugin name='p' filename='libPedestrianSFMPlugin.so'>{}</plugin>"
    ((model, _),) = described(actor(more=plugin.format(tags))).models
    assert model.sensors == [
        PedestrianSpec(
            "p", "walker_pose", ((1.0, 2.0), (3.0, 4.0)), True, 1.1, 0.4, 2.5, 80.0, 15.0, 1.0,
            3.0, 4.0, 6.0, ("bob",), ("cafe",), 2.0,
        )
    ]  # fmt: skip
    ((model, _),) = described(actor(more=plugin.format(""))).models
    assert model.sensors == [PedestrianSpec("p", "walker_pose")]
