"""What the readers of all sensors take from a <sensor> and its plugin."""

from dataclasses import dataclass

from bullet_sim.formats.plugin_names import Names
from bullet_sim.formats.xml_read import child_number

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
