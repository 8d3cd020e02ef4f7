"""What commands say while they work."""

import pytest

from ecfit.cli.terminal import LINES, bars


class Clock:
    """Seconds that pass when they are told to."""

    def __init__(self) -> None:
        self.seconds = 100.0

    def __call__(self) -> float:
        return self.seconds


def test_a_log_has_the_time_that_is_left_though_a_step_takes_an_hour(capsys: pytest.CaptureFixture[str]):
    clock = Clock()
    with bars(clock).stage("fits", 10) as advance:
        advance(4)  # found on disk: these say nothing of the speed
        for _ in range(3):
            clock.seconds += 3600.0
            advance(1)
    said = capsys.readouterr().err.splitlines()
    assert said[:3] == [
        "fits: 5 of 10, 5:00:00 left",
        "fits: 6 of 10, 4:00:00 left",
        "fits: 7 of 10, 3:00:00 left",
    ]


def test_a_log_has_no_line_for_every_step(capsys: pytest.CaptureFixture[str]):
    clock = Clock()
    with bars(clock).stage("fits", 1000) as advance:
        advance(0)
        for _ in range(1000):
            clock.seconds += 1.0
            advance(1)
    said = capsys.readouterr().err.splitlines()
    assert len([line for line in said if line.endswith("left")]) == int(999 / LINES)
    assert "1000/1000" in said[-1]
