"""The figures as a short table."""


def _rows(result):
    if "start" in result:
        start = result["start"]
        yield "start to first joint state", f"{start['first_joint_state_s']:.2f} s"
        yield "start to first picture", f"{start['first_image_s']:.2f} s"
        yield "start to 7 controllers", f"{start['controllers_s']:.2f} s"
    for name, row in result.get("efficiency", {}).items():
        yield (
            f"free, {name}",
            f"{row['ratio']:.2f} of bare stepping "
            f"({row['bridge_sim_s_per_s']:.1f} / "
            f"{row['bare_sim_s_per_s']:.1f} simulated s per s), worker "
            f"{row['render_worker_cpu_share']:.2f} CPU",
        )
    if "driving" in result:
        drive = result["driving"]
        camera, late, cpu = drive["camera"], drive["clock_lateness"], drive["cpu_s_per_sim_s"]
        yield (
            "camera at real time",
            (
                f"{camera['rate_hz']:.2f} Hz, gaps p50/p99/max "
                f"{camera['gap_ms_p50']:.1f} / {camera['gap_ms_p99']:.1f} / "
                f"{camera['gap_ms_max']:.1f} ms"
            ),
        )
        yield "real-time factor", f"{drive['real_time_factor']:.4f}"
        yield (
            "/clock late p50/p99.9/max*",
            (
                f"{late['late_ms_p50']:.2f} / "
                f"{late['late_ms_p999']:.2f} / "
                f"{late['late_ms_max']:.2f} ms"
            ),
        )
        yield (
            "CPU per simulated s",
            (
                f"bridge {cpu['bridge']:.3f} s, relay {cpu['relay']:.3f} s, "
                f"render worker {cpu['render_worker']:.3f} s"
            ),
        )
    for name, row in result.get("camera", {}).items():
        yield (
            f"pictures {name}",
            f"{row['ratio']:.2f} of bare ({row['received_hz']:.1f} / {row['bare_hz']:.1f} Hz)",
        )
    for name, row in result.get("latency", {}).items():
        yield (
            f"latency {name}",
            f"p50 {row['ms_p50']:.1f}, p99 {row['ms_p99']:.1f}, max "
            f"{row['ms_max']:.1f} ms (publish period "
            f"{row['publish_period_ms']:.0f} ms)",
        )
    for row in result.get("scale", {}).get("rows", ()):
        yield (
            f"{row['cars']} cars with lidar",
            f"{row['pace']:.2f} simulated s per s, "
            f"{row['wall_ms_per_sim_s_and_car']:.1f} ms per "
            f"simulated s and car, {row['memory_mb']:.0f} MB, "
            f"scans {row['scan_rate']:.2f} Hz",
        )
    for phase, row in result.get("growth", {}).items():
        yield (
            f"memory, {phase}",
            f"{row['memory_mb_first']:.1f} -> {row['memory_mb_last']:.1f} MB "
            f"({row['growth_percent']:+.2f} %) over {row['sim_s']:.0f} "
            f"simulated s, {row['cpu_s_per_sim_s']:.3f} CPU s per "
            "simulated s",
        )
    if "meshes" in result:
        meshes = result["meshes"]
        yield (
            "far triangles x 10",
            f"step time x {meshes['ratio']:.2f} "
            f"({meshes['triangles'][0]} -> {meshes['triangles'][1]})",
        )
    for name, error in result["errors"].items():
        yield f"{name} FAILED", error


def table(result):
    """Return the table's text."""
    load = "/".join(f"{value:.1f}" for value in result["load_average"])
    return "\n".join(
        [f"{name:36}{value}" for name, value in _rows(result)]
        + [
            "* a proxy for the physics thread, measured at a subscriber",
            f"load average before {load} on {result['machine']['cpus']} processors"
            + (", quick run" if result["quick"] else ""),
        ]
    )
