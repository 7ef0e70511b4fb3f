"""The sections of the benchmark: each starts what it needs and returns figures.

Every figure is a ratio or a latency taken in one run.
"""

import time

from figures import BenchError, gap_figures, lateness_figures, median, percentile, rate_of
from launching import Launch, cpu_seconds, memory_bytes
from static_mesh import measure

SETTLE = 1.5  # [s] between the start and a window
WHEEL_TOPICS = ("/racecar/joint_states", "/racecar/odom", "/tf", "/clock")
MB = 1e6


def start(quick, log):
    """e. roslaunch to the first joint state, the first picture and all controllers [s]."""
    found = []
    for number in range(1 if quick else 4):
        begin = time.monotonic()
        with Launch(log) as launch:
            answer = launch.observer("start", begin).answer()
        if quick or number:  # the first one fills the file cache
            found.append(answer)
    return {
        "launches": len(found),
        "warmed_up": not quick,
        **{f"{name}_s": median(item[name] for item in found) for name in found[0]},
    }


def efficiency(quick, log):
    """a, b. The bridge as fast as possible over PyBullet's stepping alone, in turn."""
    seconds, rounds = (2.0, 2) if quick else (4.0, 3)
    variants = {
        "plain": ((), ("lidar:=false",)),
        "without_robot_state_publisher": ((), ("lidar:=false", "state_publisher:=false")),
        "lidar_600_rays_10_hz": (("/scan",), ()),
        "camera_640x480_15_hz": (("/camera/image",), ("lidar:=false", "camera_rate:=15")),
        "camera_640x480_30_hz": (("/camera/image",), ("lidar:=false", "camera_rate:=30")),
    }
    return {
        name: _efficiency(log, seconds, rounds, topics, arguments)
        for name, (topics, arguments) in variants.items()
    }


def _efficiency(log, seconds, rounds, topics, arguments):
    bridge, bare, cpu, worker, speeds, heard = [], [], [], [], [], {}
    with Launch(log, ["real_time_factor:=0", *arguments]) as launch:
        observer = launch.observer("free", seconds, *WHEEL_TOPICS, *topics)
        step = observer.answer()["step"]
        pids = launch.bridge(), launch.render_worker()
        for _ in range(rounds):
            before = [cpu_seconds(pid) for pid in pids]
            ran = observer.ask("bridge")
            used = [cpu_seconds(pid) - spent for pid, spent in zip(pids, before)]
            cpu.append(used[0] / ran["sim"])
            worker.append(used[1] / (seconds + 0.3))
            bridge.append(ran["pace"])
            speeds.append(ran["speed"])
            for topic, count in ran["received"].items():
                heard[topic] = heard.get(topic, 0.0) + count / ran["sim"] / rounds
            bare.append(observer.ask("bare")["pace"])
    return {
        "step_s": step,
        "window_s": seconds,
        "rounds": rounds,
        "bridge_sim_s_per_s": median(bridge),
        "bare_sim_s_per_s": median(bare),
        "ratio": median(a / b for a, b in zip(bridge, bare)),
        "car_speed_m_s": median(speeds),
        "bridge_cpu_s_per_sim_s": median(cpu),
        "render_worker_cpu_share": median(worker),
        "received_per_sim_s": heard,
    }


def camera(quick, log):
    """c. Received pictures over bare getCameraImage, at rates that the renderer cannot keep."""
    sizes = {(640, 480): 100}  # (width, height): asked for [Hz]
    if not quick:
        sizes.update({(320, 240): 300, (160, 120): 1000, (1280, 720): 50})
    renderers = ("egl",) if quick else ("egl", "tiny")
    seconds = 2.0
    result = {}
    for renderer in renderers:
        for (width, height), rate in sizes.items():
            with Launch(
                log,
                [
                    f"camera_width:={width}",
                    f"camera_height:={height}",
                    f"camera_rate:={rate}",
                    f"renderer:={renderer}",
                    "lidar:=false",
                ],
            ) as launch:
                observer = launch.observer("frames", seconds, renderer)
                runs = [observer.ask("go") for _ in range(1 if quick else 2)]
            result[f"{renderer}_{width}x{height}"] = {
                "asked_hz": rate,
                "received_hz": median(run["received"] for run in runs),
                "bare_hz": median(run["bare"] for run in runs),
                "ratio": median(run["received"] / run["bare"] for run in runs),
            }
    return result


def driving(quick, log):
    """c. At real time with the camera on: rate, gaps, pace, lateness, processor time."""
    seconds = 6.0 if quick else 30.0
    with Launch(log, ["real_time_factor:=1.0", "lidar:=false"]) as launch:
        observer = launch.observer("drive")
        observer.answer()
        begin = time.monotonic() + SETTLE
        observer.tell(f"{begin} {begin + seconds}")
        pids = {
            "bridge": launch.bridge(),
            "relay": launch.relay(),
            "render_worker": launch.render_worker(),
        }
        time.sleep(max(0.0, begin - time.monotonic()))
        before = {name: cpu_seconds(pid) for name, pid in pids.items()}
        time.sleep(max(0.0, begin + seconds - time.monotonic()))
        used = {name: cpu_seconds(pid) - before[name] for name, pid in pids.items()}
        driven = observer.answer()
    factor = rate_of(driven["ticks"])
    return {
        "camera": gap_figures(driven["pictures"], seconds),
        "real_time_factor": factor,
        "car_speed_m_s": driven["speed"],
        "clock_lateness": lateness_figures(driven["ticks"]),
        "cpu_s_per_sim_s": {name: used[name] / (seconds * factor) for name in used},
    }


def latency(quick, log):
    """d. Command to the joint states that show it, at real time, with and without camera."""
    count = 20 if quick else 60
    result = {}
    for name in ("camera",) if quick else ("camera", "no_camera"):
        with Launch(log, ["real_time_factor:=1.0", "lidar:=false"], with_control=True) as launch:
            answer = launch.observer("latency", count, name).answer()
        for kind in ("hinge", "wheel"):
            found = [value * 1e3 for value in answer[kind]]
            if len(found) < 0.95 * answer["asked"]:
                raise BenchError(f"{len(found)} of {answer['asked']} commands were seen ({kind})")
            result[f"{kind}_{name}"] = {
                "samples": len(found),
                "publish_period_ms": answer["period"] * 1e3,
                "ms_p50": percentile(found, 0.5),
                "ms_p99": percentile(found, 0.99),
                "ms_max": max(found),
            }
    return result


def scale(quick, log):
    """f. 1 to 32 cars with a lidar each: pace, cost per car, memory per car."""
    counts = (1, 2, 4) if quick else (1, 2, 4, 8, 16, 32)
    rows = []
    with Launch(
        log,
        ["real_time_factor:=0"],
        package="gazebo_ros",
        file="empty_world.launch",
        parameters=True,
    ) as launch:
        observer = launch.observer("scale", 2.0 if quick else 5.0, *counts)
        for _ in counts:
            row = observer.answer()
            pid = launch.bridge()
            row["memory_mb"] = memory_bytes(pid) / MB
            row["wall_ms_per_sim_s_and_car"] = 1e3 / row["pace"] / row["cars"]
            rows.append(row)
            observer.tell("next")
    first = rows[0]["wall_ms_per_sim_s_and_car"]
    return {
        "rows": rows,
        "memory_mb_per_car": (rows[-1]["memory_mb"] - rows[0]["memory_mb"])
        / (rows[-1]["cars"] - rows[0]["cars"]),
        "cost_per_car_relative_to_one": [row["wall_ms_per_sim_s_and_car"] / first for row in rows],
    }


def growth(quick, log):
    """g. Memory and processor time of the bridge, idle and driving, over simulated minutes."""
    span = 30.0 if quick else 600.0  # simulated time of each phase [s]
    result = {}
    with Launch(log, ["real_time_factor:=0", "lidar:=false"]) as launch:
        observer = launch.observer("growth", span)
        for phase in ("idle", "driving"):
            samples = []
            while True:
                answer = observer.answer()
                if answer.get("done"):
                    break
                pid, worker = launch.bridge(), launch.render_worker()
                samples.append(
                    (
                        answer["sim"],
                        memory_bytes(pid) / MB,
                        cpu_seconds(pid),
                        memory_bytes(worker) / MB,
                    )
                )
                observer.tell("go")
            first = samples[max(1, len(samples) // 10)]  # after warming up
            last = samples[-1]
            result[phase] = {
                "sim_s": last[0] - samples[0][0],
                "memory_mb_first": first[1],
                "memory_mb_last": last[1],
                "growth_percent": 100.0 * (last[1] / first[1] - 1.0),
                "render_worker_mb": last[3],
                "cpu_s_per_sim_s": (last[2] - first[2]) / max(last[0] - first[0], 1e-9),
                "memory_mb": [round(sample[1], 2) for sample in samples],
                "at_sim_s": [round(sample[0], 1) for sample in samples],
            }
    return result


def meshes(quick, _log):
    """3. A step with ten times the triangles outside the car's neighbourhood; no ROS."""
    return measure(quick)


SECTIONS = {
    "start": start,
    "efficiency": efficiency,
    "driving": driving,
    "camera": camera,
    "latency": latency,
    "scale": scale,
    "growth": growth,
    "meshes": meshes,
}
