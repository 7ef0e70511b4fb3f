"""A film of a lap: the car from behind, with figures."""

import cv2
from paddock_common.films.writer import FilmWriter

from paddock_gym.evaluation.laps import drive


def film_lap(env, driver, start, path):
    """Drive once and film it.

    Args:
        env: DeepRacerEnv.
        driver: as of laps.drive.
        start: of the lap.
        path: of the mp4.

    Returns:
        Lap.

    Raises:
        OSError: the file cannot be written.
    """
    rate = env.metadata["render_fps"]
    film = FilmWriter(path, rate)

    def add():
        picture = env.onlooker_picture()[..., ::-1].copy()
        standing, motion = env.run.standing, env.run.motion
        words = (
            f"{standing.progress:3.0f} %  {standing.steps / rate:4.1f} s  {motion.forward:.2f} m/s"
        )
        for colour, width in (((0, 0, 0), 4), ((255, 255, 255), 1)):
            cv2.putText(
                picture, words, (12, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, width, cv2.LINE_AA
            )
        film.add(picture)

    try:
        return drive(env, driver, start, each=add)
    finally:
        film.close()
