"""PIDs: gains and terms, the update of a joint, and efforts that a step would not bear."""

from bullet_sim.controllers.pid.pid import Pid, PidGains, parse_pid

__all__ = ["Pid", "PidGains", "parse_pid"]
