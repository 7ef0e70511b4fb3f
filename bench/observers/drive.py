"""drive: pictures, scans and /clock in windows of driving at real time."""

import time

from observers import graph


def main():
    """Each line "BEGIN END" (time.monotonic) on stdin is a window; answers its receipts."""
    graph.join()
    pictures, ticks = graph.record("/camera/image", 4), graph.record("/clock", 0)
    scans = graph.record("/scan", 4)
    graph.wait_for_controllers()
    outputs = graph.publishers()
    graph.start_circle(outputs)
    graph.say(ready=True)
    while True:
        begin, end = map(float, graph.hear())
        speed = 0.0
        while time.monotonic() < end:
            for publisher, value in outputs:
                publisher.publish(value)
            if not speed and time.monotonic() > (begin + end) / 2:
                speed = graph.car_speed()
            time.sleep(1 / 30)
        graph.say(
            pictures=[pair for pair in pictures if begin <= pair[0] < end],
            ticks=[pair for pair in ticks if begin <= pair[0] < end],
            scans=sum(begin <= pair[0] < end for pair in scans),
            speed=speed,
        )
