"""Holds a machine still while something is measured on it.

Owns which processor the measured work runs on, and what the others do meanwhile. Never measures.

What a second costs depends on the neighbours. A User-Mode kernel of one processor is two processes of the machine
outside, the kernel and the program in it, which take turns at every fault and system call: on two processors that
sleep, each turn waits until one wakes (a start then takes three times as long, and differs by as much); on one it is a
change of task. Processors that share a core slow each other down: now and then, if the neighbour works now and then;
evenly, if it never rests. And a processor that sleeps between two frames may be lent to others meanwhile, with its
caches: what plays at a pace then pays for its rests (a fifth more, for a decoder that shows nothing), and what runs
through does not. So nothing sleeps here: where the measured work rests, idle work that yields to it at once takes over.
"""

import contextlib
import multiprocessing
import os


def _never_rest(processor, policy, employer):
    os.sched_setaffinity(0, {processor})
    os.sched_setscheduler(0, policy, os.sched_param(0))
    while os.getppid() == employer:
        for _ in range(1_000_000):
            pass


@contextlib.contextmanager
def machine():
    """What is started within runs on one processor, which never sleeps; the others have neighbours that never rest."""
    allowed = os.sched_getaffinity(0)
    *others, ours = sorted(allowed)
    work = [(other, os.SCHED_OTHER) for other in others] + [(ours, os.SCHED_IDLE)]
    neighbours = [multiprocessing.Process(target=_never_rest, args=(*what, os.getpid()), daemon=True) for what in work]
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
