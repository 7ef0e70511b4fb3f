"""Speed of the simulator as its users meet it: JSON on stdout and in out/bench.json."""

import argparse
import json
import os
import pathlib
import platform
import statistics
import sys
import time

from launching import Launch, cpu_seconds

ROOT = pathlib.Path(os.environ.get('PADDOCK_ROOT', pathlib.Path(__file__).resolve().parents[1]))
SETTLE = 1.5        # [s] between the start and a window


class BenchError(Exception):
    """A run that gave no figures."""


def percentile(values, part):
    """The value below which a part of them lies (nearest rank)."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(part * len(ordered)))]


def answer(process):
    """The next line of an observer."""
    line = process.stdout.readline()
    if not line:
        raise BenchError(f'an observer ended early (exit status {process.wait()})')
    return json.loads(line)


def tell(process, text=''):
    """A line to an observer."""
    process.stdin.write(f'{text}\n')
    process.stdin.flush()


def measure_start(log):
    """roslaunch to the first picture and to all controllers [s]."""
    begin = time.monotonic()
    with Launch(log) as launch:
        return answer(launch.observer('drive', begin))


def rate_of(pairs):
    """Simulated seconds per wall second of [(receipt, stamp)]."""
    return (pairs[-1][1] - pairs[0][1]) / (pairs[-1][0] - pairs[0][0])


def picture_figures(pictures, seconds):
    """Rate and gaps of the received pictures."""
    if len(pictures) < 3:
        raise BenchError(f'{len(pictures)} pictures in {seconds:g} s')
    gaps = [(b[0] - a[0]) * 1e3 for a, b in zip(pictures, pictures[1:])]
    return {'window_s': seconds, 'received': len(pictures),
            'rate_hz': (len(pictures) - 1) / (pictures[-1][0] - pictures[0][0]),
            'gap_ms_p50': percentile(gaps, 0.5), 'gap_ms_p99': percentile(gaps, 0.99),
            'gap_ms_max': max(gaps)}


def lateness_figures(ticks):
    """How late /clock arrives against the earliest offset between wall and stamp."""
    if len(ticks) < 3:
        raise BenchError(f'{len(ticks)} messages on /clock')
    offsets = [receipt - stamp for receipt, stamp in ticks]
    late = [(offset - min(offsets)) * 1e3 for offset in offsets]
    return {'kind': 'proxy: /clock as received by a subscriber in another process, '
                    'transport and scheduling of both sides included',
            'samples': len(late), 'late_ms_p50': percentile(late, 0.5),
            'late_ms_p99': percentile(late, 0.99), 'late_ms_p999': percentile(late, 0.999),
            'late_ms_max': max(late)}


def measure_drive(log, seconds):
    """Start, camera, pace, lateness and processor time while driving at real time."""
    begin = time.monotonic()
    with Launch(log, ['real_time_factor:=1.0']) as launch:
        driver, clock = launch.observer('drive', begin), launch.observer('clock')
        start = answer(driver)
        begin = time.monotonic() + SETTLE
        for observer in (driver, clock):
            tell(observer, f'{begin} {begin + seconds}')
        pids = {'bridge': launch.bridge(), 'render_worker': launch.render_worker()}
        time.sleep(max(0.0, begin - time.monotonic()))
        before = {name: cpu_seconds(pid) for name, pid in pids.items() if pid}
        time.sleep(max(0.0, begin + seconds - time.monotonic()))
        used = {name: cpu_seconds(pids[name]) - spent for name, spent in before.items()}
        driven, ticks = answer(driver), answer(clock)['ticks']
    lateness = lateness_figures(ticks)
    factor = rate_of(ticks)
    return start, {
        'camera': picture_figures(driven['pictures'], seconds),
        'real_time_factor': factor,
        'car_speed_m_s': driven['speed'],
        'clock_lateness': lateness,
        'cpu_s_per_sim_s': {name: used[name] / (seconds * factor) if name in used else None
                            for name in pids}}


def measure_free(log, seconds, rounds):
    """real_time_factor 0 without a camera subscriber against the bare core, in turn."""
    bridge, bare, cpu, speeds, bare_speeds = [], [], [], [], []
    with Launch(log, ['real_time_factor:=0']) as launch:
        observer = launch.observer('free', seconds, rounds)
        step = answer(observer)['step']
        pid = launch.bridge()
        for _ in range(rounds):
            before = cpu_seconds(pid)
            tell(observer)
            ran = answer(observer)
            cpu.append((cpu_seconds(pid) - before) / ran['sim'])
            bridge.append(ran['bridge'])
            speeds.append(ran['speed'])
            tell(observer)
            ran = answer(observer)
            bare.append(ran['bare'])
            bare_speeds.append(ran['speed'])
    return {'step_s': step, 'window_s': seconds, 'rounds': rounds,
            'bridge_sim_s_per_s': statistics.median(bridge),
            'bare_sim_s_per_s': statistics.median(bare),
            'ratio': statistics.median(a / b for a, b in zip(bridge, bare)),
            'car_speed_m_s': speeds, 'bare_car_speed_m_s': bare_speeds,
            'bridge_cpu_s_per_sim_s': statistics.median(cpu),
            'bare_is': 'bullet_sim World with the same world, track, car, joint controllers and '
                       'commands; no sensors, no ROS traffic'}


def machine():
    """What the figures were taken on."""
    model = next((line.split(':', 1)[1].strip() for line in open('/proc/cpuinfo')
                  if line.startswith('model name')), platform.machine())
    return {'cpu': model, 'cpus': len(os.sched_getaffinity(0)), 'kernel': platform.release(),
            'python': platform.python_version()}


def table(result):
    """The figures as short text."""
    drive, free, start = result['drive'], result['free'], result['start']
    camera, late, cpu = drive['camera'], drive['clock_lateness'], drive['cpu_s_per_sim_s']

    def text(value, unit=''):
        return 'not found' if value is None else f'{value:.3f} {unit}'.rstrip()
    rows = [
        ('start to first picture', text(start['first_image_s'], 's')),
        ('start to 7 controllers', text(start['controllers_s'], 's')),
        ('camera, driving', f"{camera['rate_hz']:.2f} Hz"),
        ('camera gaps p50/p99/max', f"{camera['gap_ms_p50']:.1f} / {camera['gap_ms_p99']:.1f} / "
                                    f"{camera['gap_ms_max']:.1f} ms"),
        ('real-time factor', text(drive['real_time_factor'])),
        ('/clock late p50/p99.9/max*', f"{late['late_ms_p50']:.2f} / {late['late_ms_p999']:.2f} / "
                                       f"{late['late_ms_max']:.2f} ms"),
        ('CPU of bridge, camera on', text(cpu['bridge'], 's per simulated s')),
        ('CPU of render worker', text(cpu['render_worker'], 's per simulated s')),
        ('bridge, unbounded', text(free['bridge_sim_s_per_s'], 'simulated s per s')),
        ('bare core, unbounded', text(free['bare_sim_s_per_s'], 'simulated s per s')),
        ('bridge / bare core', text(free['ratio']))]
    load = '/'.join(f'{value:.1f}' for value in result['load_average'])
    return '\n'.join([f'{name:28}{value}' for name, value in rows] + [
        '* a proxy for the physics thread, measured at a subscriber',
        f"load average before {load} on {result['machine']['cpus']} processors"
        + (', quick run' if result['quick'] else '')])


def run(quick, log):
    """All figures."""
    result = {'quick': quick, 'machine': machine(), 'load_average': os.getloadavg(),
              'date': time.strftime('%Y-%m-%dT%H:%M:%S%z')}
    starts = []
    if not quick:
        measure_start(log)      # fills the caches; not counted
        starts = [measure_start(log) for _ in range(2)]
    last, result['drive'] = measure_drive(log, 6.0 if quick else 30.0)
    starts.append(last)
    result['start'] = {
        'launches': len(starts), 'warmed_up': not quick,
        'first_image_s': statistics.median(start['first_image'] for start in starts),
        'controllers_s': statistics.median(start['controllers'] for start in starts)}
    result['free'] = measure_free(log, *((2.0, 2) if quick else (5.0, 5)))
    return result


def main():
    """Measure, write, tell."""
    parser = argparse.ArgumentParser(prog='./run bench --', description=__doc__)
    parser.add_argument('--quick', action='store_true',
                        help='under a minute: one start without warm-up, short windows')
    quick = parser.parse_args().quick
    (ROOT / 'out').mkdir(exist_ok=True)
    path = ROOT / 'out' / 'bench.log'
    with open(path, 'w') as log:
        try:
            result = run(quick, log)
        except BenchError as error:
            sys.exit(f'bench: {error}; see {path}')
    text = json.dumps(result, indent=2)
    (ROOT / 'out' / 'bench.json').write_text(text + '\n')
    print(text)
    print(table(result), file=sys.stderr)


if __name__ == '__main__':
    main()
