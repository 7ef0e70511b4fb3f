"""Bringing a set of controllers up and down; knows no ROS."""


class Spawner:
    """Brings controllers up and down.

    Args:
        manager: ManagerClient, or anything with its load, unload and switch.
        log: called with a text for each step.
        warn: called with a text for each thing that went wrong.
    """

    def __init__(self, manager, log, warn):
        self._manager = manager
        self._log = log
        self._warn = warn
        self.loaded = []
        self.started = False

    def bring_up(self, controllers, start):
        """Loads controllers and starts those that loaded.

        Args:
            controllers: names.
            start: False leaves them stopped.

        Returns:
            Whether all of it worked.
        """
        for name in controllers:
            if self._manager.load(name):
                self.loaded.append(name)
            else:
                self._warn("Controller '%s' did not load; the simulator's log says why" % name)
        complete = len(self.loaded) == len(controllers)
        if not start or not self.loaded:
            return complete
        self.started = self._manager.switch(start=self.loaded)
        if not self.started:
            self._warn('Controllers did not start: %s' % ', '.join(self.loaded))
        return complete and self.started

    def take_down(self):
        """Stops and unloads what this spawner loaded, the last one first."""
        names, self.loaded = self.loaded, []
        if not names:
            return
        self._log('Stopping and unloading %s' % ', '.join(names))
        self._manager.switch(stop=names, strict=False)
        for name in reversed(names):
            if not self._manager.unload(name):
                self._warn("Controller '%s' did not unload" % name)
