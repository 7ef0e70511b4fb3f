"""The DeepRacer of the bench: its URDF with other sensors, drives or names, and its commands.

As a program, for <param command=...>: car_description.py [OPTIONS]; prints the URDF.
"""

import argparse
import xml.etree.ElementTree as ElementTree

import rospkg
import xacro

# What every car of the bench does, a circle: wheels turn, hinges are at an angle.
WHEELS = [f"{side}_{end}_wheel" for side in ("left", "right") for end in ("rear", "front")]
HINGES = [f"{side}_steering_hinge" for side in ("left", "right")]
SPEED, ANGLE = 20.0, 0.25  # of the wheels [rad/s], of the hinges [rad]
WHEEL_RADIUS = 0.03  # [m]
COMMANDS = [(f"{name}_velocity_controller", SPEED) for name in WHEELS] + [
    (f"{name}_position_controller", ANGLE) for name in HINGES
]


IMU = """
<gazebo reference="base_link"><sensor name="bench_imu" type="imu"><update_rate>{rate}</update_rate>
<plugin name="bench_imu" filename="libgazebo_ros_imu_sensor.so"><topicName>/imu</topicName>
<bodyName>base_link</bodyName><frameName>base_link</frameName><gaussianNoise>0.01</gaussianNoise>
<updateRateHZ>{rate}</updateRateHZ></plugin></sensor></gazebo>
"""
TRUTH = """
<gazebo><plugin name="bench_truth" filename="libgazebo_ros_p3d.so"><topicName>/truth</topicName>
<bodyName>base_link</bodyName><updateRate>{rate}</updateRate></plugin></gazebo>
"""
LAYERS = """
<gazebo reference="base_link"><sensor name="bench_layers" type="ray"><update_rate>10</update_rate>
<pose>0 0 0.3 0 0 0</pose><ray><scan>
<horizontal><samples>1800</samples><min_angle>-3.14159</min_angle><max_angle>3.14159</max_angle>
</horizontal>
<vertical><samples>{layers}</samples><min_angle>-0.26</min_angle><max_angle>0.26</max_angle>
</vertical></scan>
<range><min>0.3</min><max>100</max></range></ray>
<plugin name="bench_layers" filename="libgazebo_ros_velodyne_laser.so">
<topicName>/points</topicName><frameName>base_link</frameName></plugin></sensor></gazebo>
"""


def describe(
    namespace="/racecar",
    topic="/scan",
    lidar_samples=600,
    lidar_rate=10.0,
    lidar=True,
    camera=True,
    efforts=False,
    transforms_rate=0,
    imu_rate=0.0,
    truth_rate=0.0,
    layers=0,
):
    """Give the URDF text.

    Args:
        lidar_samples: rays of a scan.
        lidar_rate: scans per second [Hz].
        efforts: all joints take efforts instead of velocities and positions.
        transforms_rate: of the joints' transforms [Hz]; 0: the simulator publishes none.
        imu_rate: of an IMU on /imu [Hz]; 0: none.
        truth_rate: of the ground truth on /truth [Hz]; 0: none.
        layers: of a lidar of 1800 points each on /points at 10 Hz; 0: none.
    """
    path = rospkg.RosPack().get_path("track_model") + "/urdf/racecar.urdf.xacro"
    text = xacro.process_file(
        path,
        mappings={
            "robot_namespace": namespace,
            "lidar": str(lidar).lower(),
            "lidar_topic": topic,
            "lidar_samples": str(lidar_samples),
            "transforms_rate": str(transforms_rate),
        },
    ).toxml()
    robot = ElementTree.fromstring(text)
    for block in robot.findall("gazebo"):
        if not camera and block.find("sensor[@type='camera']") is not None:
            robot.remove(block)
        for rate in block.findall("sensor[@type='ray']/update_rate"):
            rate.text = str(lidar_rate)
    if efforts:
        for interface in robot.findall("transmission/joint/hardwareInterface"):
            interface.text = "hardware_interface/EffortJointInterface"
    for wanted, block in (
        (imu_rate, IMU.format(rate=imu_rate)),
        (truth_rate, TRUTH.format(rate=truth_rate)),
        (layers, LAYERS.format(layers=layers)),
    ):
        if wanted:
            robot.append(ElementTree.fromstring(block))
    return ElementTree.tostring(robot, encoding="unicode")


def main():
    """Print the URDF that the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--namespace", default="/racecar")
    parser.add_argument("--topic", default="/scan")
    parser.add_argument("--lidar-samples", type=int, default=600)
    parser.add_argument("--lidar-rate", type=float, default=10.0)
    parser.add_argument("--no-lidar", dest="lidar", action="store_false")
    parser.add_argument("--no-camera", dest="camera", action="store_false")
    parser.add_argument("--efforts", action="store_true")
    parser.add_argument("--transforms-rate", type=float, default=0.0)
    parser.add_argument("--imu-rate", type=float, default=0.0)
    parser.add_argument("--truth-rate", type=float, default=0.0)
    parser.add_argument("--layers", type=int, default=0)
    print(describe(**vars(parser.parse_args())))


if __name__ == "__main__":
    main()
