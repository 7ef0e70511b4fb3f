"""Shows the world on a page in a browser: in 3-D, to look at, drive and change.

Beside a simulator that runs already (of any launch file) and has no page yet, it shows that one's
world. Otherwise it starts track, car, control and referee, without a window; launch arguments go to
page.launch.

Open the address that is printed, on a computer, a tablet or a phone; it has a token that is new at
each start. Any number of pages look, one drives. Ctrl-C ends it.

Only this machine gets in; from another one: ssh -L 7080:127.0.0.1:7080 HOST, then the same address.
--share lets other machines in directly, with the token and a password of at least 6 characters
(PADDOCK_WEB_PASSWORD, or asked for); nothing is encrypted then, so only in a network that you
trust.
"""

from commands import environment, launching, parsing
from commands.errors import CommandError, say
from commands.launching import LaunchFile

LAUNCH = LaunchFile("deepracer_teleop", "page.launch", fixed=("port", "share"))
BESIDE = LaunchFile("bullet_web", "web.launch", fixed=("port", "share"))
USAGE = "[--port N] [--share] [ARG:=VALUE ...]"
PASSWORD = "PADDOCK_WEB_PASSWORD"
SHORTEST = 6  # characters


def add_arguments(parser):
    """Declares the page's own options."""
    text = "for browsers (7080, or the next free)"
    parsing.add_options(parser, ("--port", "N", parsing.port, 0, text))
    parser.add_argument("--share", action="store_true", help="let other machines in, by password")


def run(options, rest):
    """Becomes roslaunch."""
    environ = environment.ready()
    beside = launching.simulator_runs(environ)
    if not beside:
        launching.refuse_second_world(environ)
    # Another node of that name would end it.
    if launching.page_comes(environ) or (beside and launching.page_runs(environ)):
        raise CommandError(
            f"the simulator on {environ['ROS_MASTER_URI']} has a page already, by its node /web",
            "Its address is printed where it was started. To start another one, end it first:",
            "./run exec rosnode kill /web",
        )
    launch = BESIDE if beside else LAUNCH
    arguments = launch.check(rest)
    if options.share:
        lengths = f"it must have {SHORTEST} or more"
        environ[PASSWORD] = parsing.asked_password(
            PASSWORD, "page", lengths, lambda text: len(text) >= SHORTEST
        )
    if beside:
        say(f"a page for the simulator on {environ['ROS_MASTER_URI']}")
    arguments += [f"port:={options.port}", f"share:={str(options.share).lower()}"]
    launching.become(launch, arguments, environ)
