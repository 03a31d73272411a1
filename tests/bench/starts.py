"""Starts the player again and again in one guest, and tells how long each took from exec to the first flip.

starts.py ANSWER ROUNDS TRACE COMMAND... writes {"cold": ms, "first_flip_ms": [ms, ...]} as JSON; COMMAND must write its
trace to TRACE. The first start reads the libraries from the machine outside; a unit has them in its page cache after
the first start too, and boots from a file system made for it: so that one is told apart. Each run is ended by SIGTERM.
"""

import json
import os
import subprocess
import sys
import time


def first_flip_ms(trace, command):
    """Milliseconds from exec until the first frame was on the glass, by the player's own trace."""
    if os.path.exists(trace):
        os.remove(trace)
    began = time.monotonic_ns()
    player = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(2)
    player.terminate()
    if player.wait() != 0:
        sys.exit(f"{command} ended with {player.returncode}")
    with open(trace) as lines:
        flips = [event for event in map(json.loads, lines) if event["event"] == "flip"]
    return (flips[0]["t_ns"] - began) / 1e6


def main():
    answer, rounds, trace, command = sys.argv[1], int(sys.argv[2]), sys.argv[3], sys.argv[4:]
    cold, *warm = [first_flip_ms(trace, command) for _ in range(rounds + 1)]
    with open(answer, "w") as out:
        json.dump({"cold": cold, "first_flip_ms": warm}, out)


if __name__ == "__main__":
    main()
