"""What the readers of all <sensor> and <plugin> elements share: names, topics, noise, poses."""

from dataclasses import dataclass

from bullet_sim.xml_reader import child_number, child_text

PoseTuple = tuple[tuple[float, float, float], tuple[float, float, float]]
ZERO_POSE: PoseTuple = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def library(plugin):
    """Name of a plugin's library without folder, 'lib' and '.so': gazebo_ros_camera."""
    name = (plugin.get("filename") or "").strip().rsplit("/", 1)[-1]
    if name.endswith(".so"):
        name = name[:-3]
    return name[3:] if name.startswith("lib") else name


def plugin_label(plugin):
    """Name of a <plugin> element in messages."""
    return f"plugin '{plugin.get('filename')}'"


class Names:
    """Namespace of one plugin.

    Args:
        plugin: the <plugin> element.
        model: name of the model.
        default: namespace of a plugin without <robotNamespace>; the namespace of a spawn
            request has been written to that tag.

    Attributes:
        namespace: without slashes at its ends; empty: the root namespace.
    """

    def __init__(self, plugin, model, default=""):
        self._plugin = plugin
        found = plugin.find("robotNamespace")
        if found is None:
            text = default
        else:
            text = (found.text or "").strip() or model
        self.namespace = _squeezed(text)

    def topic(self, name, group="", absolute=True):
        """Full topic name.

        Args:
            name: as in the file; one with a leading slash is used unchanged.
            group: sub-namespace, e.g. a camera's name.
            absolute: False: a leading slash is ignored (libgazebo_ros_imu_sensor.so).
        """
        if name.startswith("/") and absolute:
            return "/" + _squeezed(name)
        return "/" + _squeezed("/".join([self.namespace, group, name]))

    def text_topic(self, tag, default, group=""):
        """Full topic name given in a tag."""
        return self.topic(child_text(self._plugin, tag, default), group)

    def frame(self, name, prefixed=True):
        """Frame name for headers: below the namespace unless it starts with a slash.

        Cameras and lasers use their namespace as tf_prefix (tf::resolve); other plugins do
        not (prefixed=False).
        """
        if name.startswith("/") or not prefixed or not self.namespace:
            return name.lstrip("/")
        return f"{self.namespace}/{name}"


def _squeezed(text):
    return "/".join(part for part in text.split("/") if part)


DEFAULT_RATE = 30.0  # [Hz] of cameras and lidars that name none: Gazebo goes as fast as it can


@dataclass(frozen=True)
class SensorElement:
    """One <sensor> with one of its plugins, names and the pose."""

    element: object
    plugin: object
    names: Names
    name: str
    link: str
    pose: tuple
    model: object

    def part(self, tag):
        """The sub-element with the sensor's numbers; without it they stand in the <sensor>."""
        found = self.element.find(tag)
        return self.element if found is None else found

    def rate(self, tag="updateRate", default=0.0):
        """The lower of the sensor's and the plugin's rate [Hz]; 0: neither gives one."""
        what = f"sensor '{self.name}'"
        rates = [
            child_number(self.element, "update_rate", what, 0.0),
            child_number(self.plugin, tag, what, default),
        ]
        return min((rate for rate in rates if rate > 0), default=0.0)

    def drawn_rate(self, tag="updateRate"):
        """As rate, for cameras and lidars: DEFAULT_RATE where none is given."""
        rate = self.rate(tag)
        if not rate:
            self.model.warn(
                f"sensor '{self.name}' has no update rate; it runs at {DEFAULT_RATE:g} Hz",
                f"sensors have no update rate and run at {DEFAULT_RATE:g} Hz",
                f"'{self.name}'",
            )
        return rate or DEFAULT_RATE


def noise_of(element, path, what):
    """(mean, standard deviation) of a Gaussian <noise>; zeros where there is none."""
    noise = element.find(path)
    if noise is None:
        return 0.0, 0.0
    return (child_number(noise, "mean", what, 0.0), abs(child_number(noise, "stddev", what, 0.0)))
