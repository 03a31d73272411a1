"""Holds a machine still while something is measured on it.

Owns which processor the measured work runs on, and what the others do meanwhile. Never measures.

What a second costs depends on the neighbours. A User-Mode kernel of one processor is two processes of the machine
outside, the kernel and the program in it, which take turns at every fault and system call: on two processors that
sleep, each turn waits until one wakes (a start then takes three times as long, and differs by as much); on one it is a
change of task. And processors that share a core slow each other down: now and then, if the neighbour works now and
then; evenly, if it never rests.
"""

import contextlib
import multiprocessing
import os


def _never_rest(processor, employer):
    os.sched_setaffinity(0, {processor})
    while os.getppid() == employer:
        for _ in range(1_000_000):
            pass


@contextlib.contextmanager
def machine():
    """What is started within runs on one processor; each of the others has a neighbour that never rests."""
    allowed = os.sched_getaffinity(0)
    *others, ours = sorted(allowed)
    neighbours = [multiprocessing.Process(target=_never_rest, args=(p, os.getpid()), daemon=True) for p in others]
    for neighbour in neighbours:
        neighbour.start()
    os.sched_setaffinity(0, {ours})
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)
        for neighbour in neighbours:
            neighbour.terminate()
            neighbour.join()
