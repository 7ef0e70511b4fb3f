"""Makes the pictures of the documents that show Paddock at work.

    ./run exec python docs/tools/pictures.py                # all but the next ones
    ./run exec python docs/tools/pictures.py page lap       # these
    ./run exec python docs/tools/pictures.py robots --from FOLDER --gazebo IMAGES
    ./run exec python docs/tools/pictures.py film           # film.mp4, one minute
    ./run exec python docs/tools/pictures.py navigation     # on the tutorial's map, out/yard.yaml
    ./run exec python docs/tools/pictures.py maps           # out/yard.yaml and out/track.yaml

FOLDER has clones of husky/husky, jackal/jackal and clearpathrobotics/LMS1xx (melodic-devel) and of
ROBOTIS-GIT/turtlebot3 (noetic), each by its name. IMAGES gets NAME.world and NAME.urdf for Gazebo:
spawn the robot 0.15 m high in its world and keep the image of /cam/image as NAME.png; the next call
puts Gazebo's images above Paddock's, without shadows, as Gazebo's are on a machine without a GPU.
rooms.py, solver_data.py and bench/paths_beside_gazebo.py draw the diagrams. Chromium comes with
`./run test web`, the screen of window and rviz with `./run desk`. Nothing else should run: the
pictures show the real-time factor.
"""

from __future__ import annotations

import argparse
import contextlib
import html
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import cv2
import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / name) for name in ("web", "desk", "ros")]

from deepracer_control.ackermann import Geometry  # noqa: E402
from deepracer_control.drivers.pursuit import Path, Pursuit  # noqa: E402
from paddock_common.process import free_port  # noqa: E402
from track_model.referee.referee import Car  # noqa: E402
from track_model.track import load_track  # noqa: E402

IMAGES = ROOT / "docs" / "images"
OUT = ROOT / "out"
LARGEST, LARGEST_FILM = 300_000, 1_500_000  # bytes of a picture, of the film
CAR, REAR_AXLE = Geometry(), Car().rear  # x of the rear axle in the car's frame [m]
LARGEST_ANGLE = math.radians(60.0)  # hinge angle of a full steering slider
HIDDEN = "for (const e of document.querySelectorAll('{}')) e.style.display = 'none';"
SLOWLY = "real_time_factor:=0.4"  # replays do not tell it: also a busy machine makes them
BLUE, WHITE = (40, 140, 255), (255, 255, 255)


def save(picture: np.ndarray, name: str) -> None:
    """Writes a picture, (H, W, 3) RGB, with as many colors as fit into LARGEST bytes."""
    path = IMAGES / name
    image = Image.fromarray(picture)
    image.save(path, optimize=True)
    if path.stat().st_size > LARGEST:
        image.quantize(256, Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG).save(
            path, optimize=True
        )
    told(path)


def told(path: pathlib.Path, largest: int = LARGEST) -> None:
    """Says what was written.

    Args:
        path: Of the file.
        largest: What it may have [bytes].

    Raises:
        SystemExit: It is too large.
    """
    size = path.stat().st_size
    print(f"{path.relative_to(ROOT)}: {size // 1000} kB", flush=True)
    if size > largest:
        raise SystemExit(f"{path} has more than {largest // 1000} kB")


@contextlib.contextmanager
def running(thing):
    """What has a close() or an end() is ended afterwards."""
    try:
        yield thing
    finally:
        (thing.close if hasattr(thing, "close") else thing.end)()


class Driver:
    """Drives the car on a page by its controls, along the center line.

    Args:
        browser: With the page.
        track: Of the world.
        speed: On straights [m/s].
    """

    def __init__(self, browser, track, speed):
        self._browser = browser
        self._pursuit = Pursuit(Path(track.centreline, closed=True), lookahead=0.5, max_speed=speed)
        browser.run("byId('top').value = arguments[0]; byId('top').oninput()", self.share(speed))

    def share(self, speed):
        """A speed [m/s] as the position of the slider for the top speed."""
        largest = self._browser.run("return page.topSpeed.speed")
        unit = self._browser.run("return page.topSpeed.unit")
        return min(1.0, speed / (largest * (1.0 if unit == "m/s" else CAR.wheel_radius)))

    def drive(self, seconds):
        """Drives for a time [s]; the world is not drawn meanwhile."""
        self._browser.run("page.world.render = () => {}")
        self._browser.key("KeyW", True)
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.steer()
        self._browser.run("delete page.world.render")

    def steer(self):
        """Turns the steering slider to where the path leads."""
        x, y, yaw = self._browser.run(
            "const b = page.world.body('racecar');"
            "return [b.state[1], b.state[2], page.world.yaw(b)]"
        )
        axle = x + REAR_AXLE * math.cos(yaw), y + REAR_AXLE * math.sin(yaw)
        _, curvature = self._pursuit.command(*axle, yaw)
        angle = -math.atan(CAR.wheelbase * curvature) / LARGEST_ANGLE
        self._browser.run(
            "byId('steer').value = arguments[0]; page.hands.update()", max(-1.0, min(1.0, angle))
        )


def open_page(web, **size):
    """A browser with the page of a world that can be driven."""
    from web_rig import Browser, wait

    browser = Browser(**size)
    browser.open(web.url)
    wait(lambda: browser.run("return page.topSpeed && page.topSpeed.speed"), "a topic to drive")
    return browser


def freeze(*browsers):
    """Pages show from now on what they know: drawing a picture takes a busy browser seconds."""
    for browser in browsers:
        browser.run("page.receive = () => {}")


def start_web(*words):
    """A world with its page."""
    from web_rig import Web

    camera = ("camera_width:=320", "camera_height:=240", "camera_rate:=10")
    return Web("web", "--port", str(free_port()), *camera, *words, master=free_port())


def page() -> None:
    """The page while somebody drives: camera, path and plots."""
    with running(start_web()) as web, running(open_page(web, width=1024, height=640)) as browser:
        for panel in ("look", "plots"):
            browser.run(f"document.querySelector('[data-panel={panel}]').click()")
        browser.run("byId('camera').selectedIndex = 1; byId('camera').onchange()")
        browser.run("byId('path').click()")
        driver = Driver(browser, load_track("default"), 0.6)
        driver.drive(32.0)
        freeze(browser)
        picture = browser.picture()
    save(picture, "web.png")


def classroom() -> None:
    """A projector with the track from above, and the phone that drives."""
    from web_rig import wait

    with running(start_web("track:=easy")) as web, contextlib.ExitStack() as stack:
        projector = stack.enter_context(running(open_page(web, width=1120, height=700)))
        phone = stack.enter_context(running(open_page(web, width=390, height=700, touch=True)))
        projector.run("page.world.render = () => {}")
        projector.run("document.querySelector('[data-view=above]').click()")
        projector.run("document.querySelector('[data-panel=plots]').click(); byId('path').click()")
        track = load_track("easy")
        line = np.array(track.centreline)
        middle = line.mean(axis=0)
        for index in (len(line) // 8, 3 * len(line) // 8, 5 * len(line) // 8):
            x, y = middle + 1.35 * (line[index] - middle)  # on the grass
            cone = {"kind": "cone", "x": float(x), "y": float(y), "z": 0}
            projector.run("page.act('spawn', arguments[0])", cone)
        Driver(phone, track, 0.5).drive(14.0)
        wait(lambda: projector.run("return document.body.dataset.driver") == "other", "who drives")
        freeze(projector, phone)
        projector.run("delete page.world.render")
        seen = projector.picture(), phone.picture()
    both = np.hstack([seen[0], np.full((700, 30, 3), 255, np.uint8), seen[1]])
    save(cv2.resize(both, None, fx=0.7, fy=0.7, interpolation=cv2.INTER_AREA), "classroom.png")


def on_desk(size, words, shown):
    """A picture of the desk with a command.

    Args:
        size: Of the screen.
        words: Behind ./run desk.
        shown: Whether a picture, (H, W, 3), has what is waited for.
    """
    from desk_rig import Desk
    from vnc_client import VncClient
    from web_rig import wait

    with running(Desk("--size", size, *words, master=free_port())) as desk:
        screen = VncClient(desk.url.replace("http:", "ws:") + "websockify")
        wait(lambda: shown(screen.picture()), "the windows")
        screen.pointer(screen.width - 1, screen.height - 1)
        time.sleep(5.0)  # until the real-time factor is that of driving, and all displays are there
        return screen.picture()


def window() -> None:
    """The window, with the camera's image in its middle."""
    picture = on_desk(
        "600x440", ("track:=easy", "referee:=true"), lambda seen: seen[170:400, 130:570].std() > 40
    )
    save(picture, "../tutorials/images/window.png")


def rviz() -> None:
    """rviz with the truck, its trailer and what their lidars meet, in red."""

    def scans(seen):
        red = (seen[..., 0] > 200) & (seen[..., 1] < 90) & (seen[..., 2] < 90)
        return np.count_nonzero(red[80:670, 366:1180]) > 100

    save(on_desk("1200x700", ("truck",), scans), "rviz.png")


def open_replay(path, width, height):
    """A browser with a replay that stands still, without its controls."""
    from web_rig import Browser

    browser = Browser(width, height)
    browser.open(f"file://{path}")
    browser.run("page.play(false)")
    browser.run(HIDDEN.format("header, footer, aside, #notices"))
    return browser


class Above:
    """A track from above.

    Args:
        name: Of the track.
        height: Of the picture [px].
    """

    def __init__(self, name, height):
        found = load_track(name)
        picture = cv2.cvtColor(cv2.imread(found.texture), cv2.COLOR_BGR2RGB)
        width = round(picture.shape[1] * height / picture.shape[0])
        self._picture = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
        xmin, xmax, _, ymax = found.extent
        self._origin, self._pixels = np.array([xmin, ymax]), width / (xmax - xmin)  # [px/m]

    def with_path(self, path):
        """Gives the picture with a path, (N, 2) [m], and the car at its end."""
        points = ((path - self._origin) * (self._pixels, -self._pixels) * 16).astype(np.int32)
        drawn = self._picture.copy()
        cv2.polylines(drawn, [points], False, BLUE, 2, cv2.LINE_AA, shift=4)
        cv2.circle(drawn, tuple(int(v) for v in points[-1]), 5 * 16, WHITE, -1, cv2.LINE_AA, 4)
        return drawn


def run(*words, refused=False) -> str:
    """Runs a command of ./run to its end, which may be a refusal; gives what it prints."""
    environ = dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}")
    done = subprocess.run(
        [str(ROOT / "run"), *words], env=environ, stdout=subprocess.PIPE, text=True, check=False
    )
    if done.returncode and not refused:
        raise SystemExit(f"./run {' '.join(words)}: exit status {done.returncode}")
    return done.stdout


def lap() -> None:
    """A lap by the line follower, four times as fast: the car from behind, and its path."""
    run("lap", "--driver", "line", SLOWLY)
    height, every, pace = 240, 0.72, 180  # [px], [s] of the lap, [ms] of the film
    above, path, frames = Above("default", height), [], []
    with running(open_replay(OUT / "lap" / "replay.html", 320, height)) as browser:
        length = browser.run("return page.length")
        steps = round(length / every) * 6
        browser.run("page.world.render = () => {}")
        for index in range(steps + 1):
            browser.run("page.at = arguments[0]; return page.show()", length * index / steps)
            path.append(browser.run("const p = page.world.body('racecar').root.position;"
                                    "return [p.x, p.y]"))  # fmt: skip
            if index and index % 6 == 0:
                browser.run("delete page.world.render")
                seen = browser.picture()
                browser.run("page.world.render = () => {}")
                frames.append(Image.fromarray(np.hstack([seen, above.with_path(np.array(path))])))
    target = IMAGES / "lap.webp"
    style = {"duration": pace, "loop": 0, "quality": 40, "method": 6}
    frames[0].save(target, save_all=True, append_images=frames[1:], **style)
    told(target)


TERMINAL = """<body style="margin:0;background:#1e2329;color:#dfe5ea;padding:14px 18px">
<pre style="font:13px/1.38 'DejaVu Sans Mono',monospace;margin:0;white-space:pre-wrap">
<b style="color:#8fd18f">$ {command}</b>
{text}</pre></body>"""


def packages_to_check():
    """Lets ./run find the packages of tests/drop_in."""
    folder = ROOT / "tests" / "drop_in"
    os.environ["ROS_PACKAGE_PATH"] = f"{folder}:{os.environ.get('ROS_PACKAGE_PATH', '')}"


def check() -> None:
    """The report of ./run check, and the replay that it writes."""
    from web_rig import Browser

    words = ("check", "campus_rover", "campus.launch")
    packages_to_check()
    report = run(*words, refused=True).strip()
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "report.html")
        file.write_text(
            TERMINAL.format(command=" ".join(("./run", *words)), text=html.escape(report))
        )
        with running(Browser(860, 900)) as browser:
            browser.driver.get(f"file://{file}")
            box = "return document.querySelector('pre').getBoundingClientRect()"
            text = shot(browser)[: math.ceil(browser.run(f"{box}.bottom")) + 14]
    with running(
        open_replay(OUT / "check" / "campus_rover" / "campus.html", 440, len(text))
    ) as browser:
        browser.run("page.at = page.length; return page.show()")
        seen = browser.picture()
    save(np.hstack([text, seen]), "check.png")


def shot(browser):
    """A page without a world, (H, W, 3) RGB."""
    import base64
    import io

    data = base64.b64decode(browser.call("Page.captureScreenshot")["data"])
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))


PLACE = 9.0, -4.5  # of the goal [m]
LAYERS = ("/map", "/particlecloud", "/plan", "/global_costmap/costmap")
TICK = """const box = [...byId('layers').querySelectorAll('input')]
  .find((each) => each.value.endsWith(arguments[0]));
if (box && !box.checked) box.click();
return box && page.world.layers.has(box.value)"""


def navigation() -> None:
    """The page while the truck drives to a goal: map, costmap, plan and particles.

    What it wants is in docs/tutorials/map_and_navigate.md: the packages from source, and the map.
    """
    from web_rig import Web, wait

    launch = ("exec", "roslaunch", "paddock_navigation", "navigate.launch", "web:=true")
    words = (f"map:={OUT / 'yard.yaml'}", "real_time_factor:=0.5")
    with running(Web(*launch, *words, master=free_port())) as web, running(
        open_page(web, width=1024, height=640)
    ) as browser:
        browser.run("page.panels.look('above'); page.world.render = () => {}")
        browser.run("document.querySelector('[data-panel=look]').click()")
        for layer in LAYERS:
            if layer == "/plan":
                wait(lambda: not browser.run("return byId('goal').hidden"), "move_base")
                browser.run("page.act('goal', {x: arguments[0], y: arguments[1], z: 0})", *PLACE)
            wait(lambda name=layer: browser.run(TICK, name), layer)
        x = "return page.world.followed ? page.world.followed.state[1] : 0"
        wait(lambda: browser.run(x) > PLACE[0] / 3, "the truck on its way")
        freeze(browser)
        browser.run("delete page.world.render; byId('layers').scrollIntoView()")
        picture = browser.picture()
    save(picture[:560, 424:], "navigation.png")  # so much can be read on a phone


def with_scale(picture, cell):
    """A map with a bar of a meter.

    Args:
        picture: (H, W, 3).
        cell: What a pixel is of the ground [m].
    """
    drawn, low, length = np.array(picture), len(picture) - 16, round(1.0 / cell)
    cv2.rectangle(drawn, (16, low - 8), (16 + length, low), (40, 40, 40), -1)
    cv2.putText(drawn, "1 m", (16, low - 18), cv2.FONT_HERSHEY_SIMPLEX, 0.9, (40, 40, 40), 2)
    return drawn


def maps() -> None:
    """The maps of the tutorial, a cell two pixels."""
    import yaml

    for name in ("yard", "track"):
        about = yaml.safe_load((OUT / f"{name}.yaml").read_text())
        cells = cv2.imread(str(OUT / about["image"]))
        rows, columns = np.nonzero(cells[..., 0] != cells[0, 0, 0])  # the rest is unknown
        seen = cells[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
        large = seen.repeat(2, axis=0).repeat(2, axis=1)
        save(with_scale(large, about["resolution"] / 2.0), f"map_{name}.png")


YARD = """<sdf version="1.6"><world name="yard">
  <scene><ambient>0.75 0.75 0.75 1</ambient><background>0.8 0.88 0.97 1</background></scene>
  <light name="sun" type="directional"><cast_shadows>1</cast_shadows><pose>0 0 10 0 0 0</pose>
    <diffuse>1 1 1 1</diffuse><specular>0.4 0.4 0.4 1</specular><direction>-0.5 0.3 -0.8</direction>
  </light><include><uri>model://ground_plane</uri></include></world></sdf>"""
SEEN = (480, 340)  # image of a robot [px]
CAMERA = f"""<model name="cam"><static>1</static><pose>{{pose}}</pose><link name="link">
  <sensor type="camera" name="camera"><update_rate>5</update_rate><camera>
    <horizontal_fov>0.9</horizontal_fov><clip><near>0.02</near><far>100</far></clip>
    <image><width>{SEEN[0]}</width><height>{SEEN[1]}</height><format>R8G8B8</format></image></camera>
  <plugin name="camera" filename="libgazebo_ros_camera.so"><cameraName>cam</cameraName>
    <imageTopicName>image</imageTopicName></plugin></sensor></link></model>"""
ROBOTS = {  # name -> (package, xacro file, its arguments, camera's place and target [m])
    "Husky": ("husky_description", "urdf/husky.urdf.xacro", (), (1.25, -1.1, 0.8), (0, 0, 0.16)),
    "TurtleBot3": (
        "turtlebot3_description",
        "urdf/turtlebot3_waffle_pi.urdf.xacro",
        (),
        (0.33, -0.32, 0.24),
        (-0.06, 0, 0.06),
    ),
}


def robots(folder, gazebo) -> None:
    """Published robots as Gazebo's cameras see them (above) and as Paddock's do (below).

    Args:
        folder: With their clones.
        gazebo: Folder with Gazebo's images, NAME.png; it gets what Gazebo needs to make them.
    """
    from bullet_sim.formats.sdf.world import parse_world
    from bullet_sim.render.gl.renderer import GlRenderer
    from bullet_sim.render.request import CameraRequest, Quality
    from bullet_sim.world import World

    from bullet_sim import Pose

    os.environ["ROS_PACKAGE_PATH"] = f"{folder}:{os.environ.get('ROS_PACKAGE_PATH', '')}"
    gazebo.mkdir(parents=True, exist_ok=True)
    theirs, ours = [], []
    for name, (package, file, arguments, eye, target) in ROBOTS.items():
        path = found_package(package) / file
        urdf = subprocess.run(
            ["xacro", str(path), *arguments], stdout=subprocess.PIPE, text=True, check=True
        ).stdout
        away = np.subtract(target, eye)
        turn = (0.0, -math.atan2(away[2], math.hypot(*away[:2])), math.atan2(away[1], away[0]))
        camera = CAMERA.format(pose=" ".join(map(str, (*eye, *turn))))
        (gazebo / f"{name}.world").write_text(YARD.replace("</world>", f"{camera}</world>"))
        (gazebo / f"{name}.urdf").write_text(urdf)
        world, renderer = World(), GlRenderer(Quality("false", "true"))
        with running(world), running(renderer):
            described = parse_world(YARD, in_packages, "yard")
            world.load(described)
            world.spawn_urdf(name, urdf, Pose((0.0, 0.0, 0.15)), in_packages)
            world.step(2000)
            renderer.sync_sources(world.sources(), described.scene)
            renderer.apply(world.snapshot())
            request = CameraRequest(name, None, 0, (eye, turn), *SEEN, 0.9, 0.02, 100.0)
            ours.append(captioned(renderer.render(request), "Paddock"))
        image = cv2.imread(str(gazebo / f"{name}.png"))
        if image is None:
            raise SystemExit(f"no {name}.png in {gazebo}: make it in Gazebo, of {name}.world")
        theirs.append(captioned(image[..., ::-1], "Gazebo"))
    save(np.vstack([np.hstack(theirs), np.hstack(ours)]), "robots.png")


def found_package(name) -> pathlib.Path:
    """The folder of a package."""
    import rospkg

    return pathlib.Path(rospkg.RosPack().get_path(name))


def in_packages(uri):
    """The path of a file in a package, by its URI."""
    scheme, package, rest = re.fullmatch(r"(\w+)://([^/]*)/(.*)", uri).groups()
    return f"/{rest}" if scheme == "file" else str(found_package(package) / rest)


SMALL = ("camera_width:=160", "camera_height:=120")  # nobody looks at these images
SHOTS = (  # title, command, its replay, seconds of it per second of the film, shown [s]
    ("A lap by the line follower", ("lap", "--driver", "line"), "lap/replay.html", 2.0, 14.0),
    (
        "Pure pursuit on another track",
        ("lap", "--driver", "pursuit", "--track", "hard", *SMALL),
        "lap/replay.html",
        2.0,
        12.0,
    ),
    ("A truck parks its trailer", ("truck", "--back", "park"), "back_park.html", 2.0, 14.0),
    ("A truck backs along an S", ("truck", "--back", "s"), "back_s.html", 2.5, 12.0),
    (
        "./run check of a package",
        ("check", "campus_rover", "campus.launch"),
        "check/campus_rover/campus.html",
        1.0,
        4.0,
    ),
)
PURPOSE = (  # at the end of the film: size of the letters, lines
    (1.6, "Paddock"),
    (0.8, "ROS 1 robots in the place of"),
    (0.8, "Gazebo Classic: your URDF, launch"),
    (0.8, "files, controllers and nodes,"),
    (0.8, "without Gazebo, GPU or screen"),
)


def captioned(picture, title):
    """A picture with a title at its lower edge, white on black."""
    drawn = np.array(picture)
    for color, width in ((0, 0, 0), 6), (WHITE, 2):
        place = (24, drawn.shape[0] - 28)
        cv2.putText(drawn, title, place, cv2.FONT_HERSHEY_SIMPLEX, 0.9, color, width, cv2.LINE_AA)
    return drawn


def purpose(width, height):
    """A picture of PURPOSE, white on black."""
    drawn, low = np.zeros((height, width, 3), np.uint8), 100
    for size, line in PURPOSE:
        cv2.putText(drawn, line, (48, low), cv2.FONT_HERSHEY_SIMPLEX, size, WHITE, 2, cv2.LINE_AA)
        low += round(50 + 20 * (size > 1.0))
    return drawn


def replays() -> list[pathlib.Path]:
    """The replays of SHOTS; those that out/film/ has are not made again."""
    packages_to_check()
    folder = OUT / "film"
    folder.mkdir(parents=True, exist_ok=True)
    found = []
    for index, (_, words, name, _, _) in enumerate(SHOTS):
        target = folder / f"{index}.html"
        if not target.exists():
            slowly = () if words[0] == "check" else (SLOWLY,)
            run(*words, *slowly, refused=words[0] == "check")
            (OUT / name).replace(target)
        found.append(target)
    return found


def film() -> None:
    """A film of a minute of replays, film.mp4."""
    import av

    size, rate = (640, 360), 15  # [px], [Hz]
    made, target = OUT / "film.mp4", IMAGES / "film.mp4"
    shots = list(zip(SHOTS, replays()))
    with av.open(str(made), "w", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=rate)
        stream.width, stream.height = size
        stream.pix_fmt, stream.options = "yuv420p", {"crf": "30", "preset": "veryslow"}
        for (title, _, _, pace, longest), replay in shots:
            with running(open_replay(replay, *size)) as browser:
                seconds = min(longest, browser.run("return page.length") / pace)
                for index in range(round(rate * seconds)):
                    browser.run("page.at = arguments[0]; return page.show()", index * pace / rate)
                    image = captioned(browser.picture(), title)
                    frame = av.VideoFrame.from_ndarray(image, format="rgb24")
                    container.mux(stream.encode(frame))
            print(f"{title}: {seconds:.1f} s", flush=True)
        for _ in range(4 * rate):
            frame = av.VideoFrame.from_ndarray(purpose(*size), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    made.replace(target)
    told(target, LARGEST_FILM)


PICTURES = {each.__name__: each for each in (page, classroom, window, rviz, lap, check)}
ASKED = {each.__name__: each for each in (film, navigation, maps)}  # made only when they are named


def main() -> int:
    """Makes what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", choices=[*PICTURES, *ASKED, "robots", []])
    parser.add_argument("--from", dest="folder", help="clones of published robots")
    parser.add_argument("--gazebo", type=pathlib.Path, help="Gazebo's images of them")
    options = parser.parse_args()
    for name in options.names or PICTURES:
        if name == "robots":
            robots(os.path.abspath(options.folder), options.gazebo)
        else:
            {**PICTURES, **ASKED}[name]()
    return 0


if __name__ == "__main__":
    sys.exit(main())
