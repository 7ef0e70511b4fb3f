"""Topic and frame names of gazebo_ros plugins, resolved the way each plugin does it."""

from bullet_sim.formats.xml_read import child_text


def library(plugin):
    """Name of a plugin's library without folder, 'lib' and '.so': gazebo_ros_camera."""
    name = (plugin.get("filename") or "").strip().rsplit("/", 1)[-1]
    if name.endswith(".so"):
        name = name[:-3]
    return name[3:] if name.startswith("lib") else name


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
