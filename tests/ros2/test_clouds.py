"""Particles: none lost, in order, stamped with the simulated time, soon there."""

import pytest
from clouds import HZ, receive, share

STEP = 1.0 / HZ


@pytest.mark.parametrize("reliability", ["reliable", "best_effort"])
def test_5000_particles_at_60_hz_for_10_s_with_a_default_receiver(domain, reliability):
    got, node = receive(domain, "particles_5000.toml", {"step": STEP}, reliability, 10)
    print(f"5,000 points {reliability}: {100 * share(got):.2f} % of {got['count']}, latency median {got['median']:.2f} p99 {got['p99']:.2f} ms")
    assert got["widths"] == [5000] and got["whole"]
    assert got["numbers"] == sorted(set(got["numbers"])) and got["stamps"] == sorted(set(got["stamps"])), "in order, none twice"
    ticks = [s * 1e-9 / STEP for s in got["stamps"]]
    assert all(abs(t - round(t)) < 1e-5 for t in ticks), "stamps are simulated times of steps"
    # On a quiet machine none is lost and the median is below 2 ms (measure.py); here others may want the processor. Of clouds of
    # 10,000 points 61 % come even there.
    assert share(got) > 0.8
    assert got["median"] < 20.0


def test_100000_particles_in_tiles_with_a_default_receiver(domain):
    # 1e5 particles take a step in about 5 ms here; simulated time is slow so that the solver has one substep to do. 20 Hz are 400 messages
    # a second, which Python can take on a machine that others use too; measure.py does it at 60 Hz.
    factor, step = 1e-3, 1e-3 / 20
    parameters = {"step": step, "real_time_factor": factor, "particles.mode": "tiles", "particles.fields": "[id]"}
    got, node = receive(domain, "bar.toml", parameters, "best_effort", 6, ["--threads", "1"], depth=100)
    print(f"100,000 points in tiles at 20 Hz: {100 * share(got):.2f} %, {got['count'] / got['wall']:.0f} messages/s, "
          f"latency median {got['median']:.2f} p99 {got['p99']:.2f} ms")
    assert got["widths"] == [5000] and got["whole"] and got["stamps"] == sorted(got["stamps"])
    # On a quiet machine 98 % (measure.py, at 60 Hz): a receiver that must wait for the processor loses some.
    assert share(got) > 0.8 and got["median"] < 20.0


def test_100000_particles_whole_with_4_mib_to_receive(domain):
    factor = 1e-3
    parameters = {"step": STEP * factor, "real_time_factor": factor, "particles.mode": "whole", "particles.fields": "[id]"}
    got, node = receive(domain, "bar.toml", parameters, "best_effort", 8, buffer=True)
    whole = share(got)
    print(f"100,000 points whole: {100 * whole:.2f} %, {got['count'] / got['wall']:.0f} Hz, latency median {got['median']:.2f} ms")
    assert got["widths"] == [100_000] and got["whole"]
    assert whole > 0.7, "all on a quiet machine; without the receive buffer half of them (measure.py)"


def test_large_clouds_are_thinned_by_default_and_that_is_said_once(domain):
    got, node = receive(domain, "bar.toml", {"real_time_factor": 0.001, "step": 1e-5}, "reliable", 2)
    assert got["widths"] == [5000]
    assert node.said().count("~/particles has every 20th of 100000 particles") == 1
