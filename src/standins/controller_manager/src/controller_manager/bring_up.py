"""Bringing a set of controllers up and down, without ROS."""


class Spawner:
    """Brings controllers up and down.

    Args:
        manager: ManagerClient, or anything with its load, unload, switch and running.
        log: called with a text for each step.
        warn: called with a text for each failure.
    """

    def __init__(self, manager, log, warn):
        self._manager = manager
        self._log = log
        self.warn = warn
        self.loaded = []
        self.started = []

    def bring_up(self, controllers, start):
        """Loads controllers and starts those that loaded, all in one step.

        If one of them cannot start (for example its joint is taken), the others start without it.

        Args:
            controllers: names.
            start: False leaves them stopped.

        Returns:
            Whether everything succeeded.
        """
        for name in controllers:
            if self._manager.load(name):
                self.loaded.append(name)
            else:
                self.warn(f"Controller '{name}' did not load; the simulator's log says why")
        complete = len(self.loaded) == len(controllers)
        if not start or not self.loaded:
            return complete
        self.started = list(self.loaded)
        if not self._manager.switch(start=self.loaded):
            self._manager.switch(start=self.loaded, strict=False)
            running = self._manager.running()
            self.started = [name for name in self.loaded if name in running]
            self.warn(
                "Controllers did not start: {}; the simulator's log says why".format(
                    ", ".join(name for name in self.loaded if name not in running)
                )
            )
        return complete and len(self.started) == len(self.loaded)

    def take_down(self):
        """Stops and unloads the controllers that this spawner loaded, in reverse order."""
        names, self.loaded = self.loaded, []
        if not names:
            return
        self._log("Stopping and unloading {}".format(", ".join(names)))
        self._manager.switch(stop=names, strict=False)
        for name in reversed(names):
            if not self._manager.unload(name):
                self.warn(f"Controller '{name}' did not unload")
