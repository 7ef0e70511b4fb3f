"""Cameras: one render worker for all; the simulation thread waits for it only if asked to."""

import json
import threading

import rospy
from bullet_sim.errors import RenderError
from bullet_sim.render.client import RenderClient
from bullet_sim.render.request import DEFAULT
from std_msgs.msg import String

from bullet_bridge.transport.publishing import publisher


class Cameras:
    """All camera outputs and the worker that draws their pictures.

    Args:
        renderer: auto, gl or tiny.
        wait: True: wait for each due picture, as in lockstep: none is left out, and the physics
            waits for the renderer.
        quality: Quality of the OpenGL renderer.
        scene: function without arguments that gives the world's Scene.
    """

    def __init__(self, renderer, wait, quality=DEFAULT, scene=lambda: None):
        self._renderer, self._wait, self._quality = renderer, wait, quality
        self._scene = scene
        self._client, self._outputs = None, {}
        self._starter, self._starting, self._sending = None, threading.Lock(), threading.Lock()
        self._publishing = threading.Lock()
        self._ready = False
        self._sources = []
        self._failures = []
        self._names = self._legend = None

    def start(self):
        """Begin to start the worker unless that was done; called outside the simulation thread.

        Where each picture is waited for this returns when the worker is up or has failed;
        elsewhere at once, and pictures come when it is up.
        """
        with self._starting:
            if self._starter is None:
                self._client = RenderClient(
                    on_frame=self._publish_late,
                    on_error=rospy.logerr,
                    zero_copy=True,
                    quality=self._quality,
                )
                self._starter = threading.Thread(
                    target=self._start, name="render-start", daemon=True
                )
                self._starter.start()
        if self._wait:
            self._starter.join()

    def _start(self):
        try:
            chosen = self._client.start(self._renderer)
        except RenderError as error:
            rospy.logerr("cameras stay dark: %s", error)
            return
        rospy.loginfo(
            "cameras are rendered by '%s' (%s)%s",
            chosen.kind,
            chosen.details,
            f", since {chosen.reason}" if chosen.reason else "",
        )
        with self._sending:
            self._client.set_sources(self._sources, self._scene())
            self._ready = True

    def publish_labels(self, names):
        """Publish a label image for each camera, and the latched topic ~labels: what labels mean,
        as JSON {"label": "model's name"}.

        Args:
            names: function without arguments that gives them as a dict.
        """
        self._names = names
        self._legend = publisher(rospy.resolve_name("~labels"), String, latch=True)

    def add(self, output):
        """Add a camera output."""
        if self._legend is not None:
            output.add_labels()
        self._outputs[output.request.name] = output

    def remove(self, output):
        """Remove a camera output."""
        if self._outputs.get(output.request.name) is output:  # not a later one of the same name
            del self._outputs[output.request.name]

    def set_sources(self, sources):
        """Send the worker the present bodies."""
        if self._legend is not None:
            self._legend.publish(json.dumps(self._names()))
        with self._sending:
            self._sources = sources
            if self._ready:
                self._client.set_sources(sources, self._scene())

    def restart(self):
        """Discard pictures ordered before a reset: none is published once this has returned."""
        client = self._client
        if client is not None:
            with self._publishing:
                client.discard()

    def draw(self, world, outputs):
        """Order pictures of the due outputs (simulation thread)."""
        if not self._ready:
            self._failures = ["there is no renderer, pictures are missing"]
            return
        requests = [output.request for output in outputs]
        if not self._wait:
            self._client.submit(world.snapshot(), requests)
            return
        try:
            for frame in self._client.render_sync(world.snapshot(), requests):
                self._publish(frame)
        except RenderError as error:
            text = f"pictures at {world.time:.3f} s are missing: {error}"
            rospy.logerr_throttle(5.0, text)
            self._failures = self._failures[-2:] + [text]

    def take_failures(self):
        """Failures in lockstep since the last call, at most three sentences."""
        failures, self._failures = self._failures, []
        return failures

    def _publish_late(self, frame):
        """Publish a picture of the worker, unless there was a reset since it was ordered."""
        with self._publishing:
            if frame.epoch == self._client.epoch:
                self._publish(frame)

    def _publish(self, frame):
        output = self._outputs.get(frame.camera)
        if output is not None and not rospy.is_shutdown():
            try:
                output.publish_frame(frame)
                if frame.labels is not None:
                    output.publish_labels(frame)
            except rospy.ROSException:
                pass  # the topic was just unregistered

    def close(self):
        """End the worker."""
        self._ready = False
        if self._client is not None:
            self._client.close()
