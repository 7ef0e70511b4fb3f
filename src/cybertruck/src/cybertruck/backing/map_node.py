"""The node `steering_map`: drives circles, fits them, writes the map and its picture, and ends."""

import math
import os
import sys

import rospy
from paddock_common.process import signals
from paddock_common.settings import from_table, read

from cybertruck.backing.commands import Driver
from cybertruck.backing.map_plan import MapSettings, measure, write_picture
from cybertruck.backing.state import StateSource
from cybertruck.trailer.geometry import Geometry, TrailerError, has_steady_towing
from cybertruck.trailer.steering import MeasuredSteering, write_map

START_LIMIT = 60.0  # wall time until the truck is up [s]
STEP_LIMIT = 20.0  # wall time without a new state after which the drive fails [s]
STUCK_FACTOR = 3.0  # limit of a stretch's time, in times of its planned time
PERIOD = 0.02  # simulated time between commands [s]


class MapDrive:
    """Measures one steering angle after the other."""

    def __init__(self):
        """Reads the private parameters.

        Raises:
            TrailerError: A parameter is wrong.
        """
        parameters = rospy.get_param("~", {})
        given = {
            name: value for name, value in parameters.get("map", {}).items() if value != []
        }  # an empty list stands for the default
        self._settings = from_table(MapSettings, given, "map", TrailerError)
        self._geometry = read(Geometry, parameters.get, prefix="")
        if rospy.get_param("~trailer", False):
            self._refuse_folding()
        self._file = str(rospy.get_param("~file"))
        self._picture = str(rospy.get_param("~picture", ""))
        self._source = StateSource(self._settings.odom_topic)
        self._driver = Driver()

    def _refuse_folding(self):
        """Raises a TrailerError when an angle would fold the trailer."""
        for angle in (*self._settings.angles, *self._settings.check_angles):
            if not has_steady_towing(math.tan(angle) / self._geometry.wheelbase, self._geometry):
                raise TrailerError(
                    f"angles: {math.degrees(angle):.1f} degrees would fold the "
                    "trailer; measure without it (trailer:=false)"
                )

    def run(self):
        """Drives, writes the map and prints the result.

        Raises:
            TrailerError: The truck does not answer, or a circle cannot be fitted.
        """
        if self._source.wait(None, START_LIMIT) is None:
            raise TrailerError(f"no odometry on {self._settings.odom_topic}")
        while self._driver.subscribers == 0 and not rospy.is_shutdown():
            rospy.sleep(0.05)
        measured = [self._drive(angle) for angle in self._settings.angles]
        checked = [self._drive(angle) for angle in self._settings.check_angles]
        self._driver.stop()
        angles = [item.angle for item in measured]
        curvatures = [item.curvature for item in measured]
        os.makedirs(os.path.dirname(os.path.abspath(self._file)), exist_ok=True)
        write_map(
            self._file,
            angles,
            curvatures,
            (
                "Steering map of the simulated truck: curvature of the rear axle's path over the",
                f"bicycle's steering angle, circles fitted at {self._settings.speed:g} m/s. "
                "Made by: ./run exec roslaunch cybertruck steering_map.launch",
            ),
        )
        steering = MeasuredSteering(angles, curvatures)
        for item in checked:
            error = float(steering.curvature(item.angle)) / item.curvature - 1.0
            rospy.loginfo(
                "check %.1f degrees: measured %.4f 1/m, the map is %.2f %% off",
                math.degrees(item.angle),
                item.curvature,
                100.0 * error,
            )
        if self._picture:
            write_picture(self._picture, measured, checked, steering, self._geometry.wheelbase)
        rospy.loginfo("written: %s %s", self._file, self._picture)

    def _drive(self, angle):
        """Drives at one steering angle and returns its Measured."""
        self._stretch(angle, self._settings.settle_distance)
        poses = self._stretch(angle, self._settings.distance(angle, self._geometry.wheelbase))
        item = measure(angle, poses)
        rospy.loginfo(
            "%.1f degrees: %.4f 1/m (tan/L %.4f), %d points, rms %.1f mm",
            math.degrees(angle),
            item.curvature,
            math.tan(angle) / self._geometry.wheelbase,
            len(poses),
            1000.0 * item.rms,
        )
        return item

    def _stretch(self, angle, distance):
        """Drives a distance [m] and returns the poses on the way."""
        state = self._next(None)
        start, last, driven, poses = state.stamp, state, 0.0, []
        limit = STUCK_FACTOR * distance / self._settings.speed + 5.0
        while driven < distance:
            self._driver.send(angle, self._settings.speed)
            state = self._next(state.stamp + PERIOD - 1e-6)
            driven += math.hypot(state.x - last.x, state.y - last.y)
            last = state
            poses.append((state.x, state.y, state.heading))
            if state.stamp - start > limit:
                raise TrailerError(
                    f"{math.degrees(angle):.1f} degrees: the truck drove "
                    f"{driven:.2f} m in {limit:.0f} s, not {distance:.2f} m"
                )
        return poses

    def _next(self, after):
        state = self._source.wait(after, STEP_LIMIT)
        if state is None or rospy.is_shutdown():
            raise TrailerError(f"no new odometry on {self._settings.odom_topic}")
        return state


def main():
    """Runs the drive; exit status 0 if the map was written."""
    signals.init_node("steering_map")
    try:
        MapDrive().run()
    except (TrailerError, KeyError, OSError, rospy.ROSException) as error:
        rospy.logfatal("steering_map: %s", error)
        sys.exit(1)
