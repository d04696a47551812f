"""Threads and processes."""

from __future__ import annotations

import multiprocessing
import threading
import time

import numpy as np
import pytest
from conftest import beam, block

from matpoint import Simulation


def test_other_threads_run_while_a_step_does() -> None:
    sim = block(20).build()
    seconds = 0.0
    done = threading.Event()

    def work() -> None:
        nonlocal seconds
        try:
            start = time.perf_counter()
            sim.step(20 * sim.max_step)
            seconds = time.perf_counter() - start
        finally:
            done.set()

    thread = threading.Thread(target=work)
    thread.start()
    turns = 0
    while not done.is_set():
        turns += 1
        time.sleep(1e-4)
    thread.join(timeout=60)
    # one call, of 50 substeps; were the GIL held, there would be a turn before it and one after it
    assert seconds > 0.1 and turns > 100 * seconds, (seconds, turns)


def test_threads_that_share_a_simulation_wait_for_each_other() -> None:
    sim = beam().build()
    failures: list[BaseException] = []
    steps, threads = 50, 4

    def work(number: int) -> None:
        try:
            out = np.empty((64, 2))
            for _ in range(steps):
                sim.step(1e-3)
                sim["load/tip/traction"] = [0.0, float(number)]
                view = sim.get("particle/position", view=True)
                kept = view.copy()
                sim.get("particle/stress")
                sim.get("particle/position", out)
                sim.save()
                assert np.array_equal(view, kept)
                with pytest.raises(Exception, match="no variable"):
                    sim["nothing"]
        except BaseException as error:
            failures.append(error)

    running = [threading.Thread(target=work, args=(number,)) for number in range(threads)]
    for thread in running:
        thread.start()
    for thread in running:
        thread.join(timeout=60)
        assert not thread.is_alive()
    assert failures == []
    # none was lost, none was done twice
    assert abs(sim.time - steps * threads * 1e-3) < 1e-12


def test_reset_and_restore_from_two_threads_leave_a_state_that_steps() -> None:
    sim = beam().build()
    saved = sim.save()
    stop = threading.Event()

    def upset() -> None:
        while not stop.is_set():
            sim.reset()
            sim.restore(saved)

    thread = threading.Thread(target=upset)
    thread.start()
    for _ in range(100):
        sim.step(1e-2)
        assert np.isfinite(sim["particle/position"]).all()
    stop.set()
    thread.join()


def big_step(sim: Simulation) -> bytes:
    sim.step(0.01)
    return sim.save()


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_steps_on() -> None:
    sim = block(12).build()
    # enough particles for several threads, which the child does not inherit
    assert sim.describe().particles > 10_000
    sim.step(0.01)
    before = sim.save()
    context = multiprocessing.get_context("fork")
    with context.Pool(2) as pool:
        results = [pool.apply_async(big_step, (sim,)) for _ in range(3)]
        found = [result.get(timeout=60) for result in results]
    assert sim.save() == before
    sim.step(0.01)
    assert found == [sim.save()] * 3


def test_a_spawned_process_steps_on(sim: Simulation) -> None:
    sim.step(0.01)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        found = pool.apply(big_step, (sim,))
    sim.step(0.01)
    assert found == sim.save()
