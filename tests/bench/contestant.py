"""Runs one command in the guest, and tells what only the guest knows: wall seconds and peak memory.

contestant.py ANSWER COMMAND... writes the answer as JSON: `wall_s`, `peak_mb`, and `said`, whatever the command printed.
Exit status: 1 if the command fails, with what it said.
"""

import json
import os
import subprocess
import sys
import time


def main():
    answer, command = sys.argv[1], sys.argv[2:]
    began = time.monotonic_ns()
    with open("/tmp/said", "w+b") as said:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=said)
        _, status, usage = os.wait4(process.pid, 0)
        said.seek(0)
        words = said.read().decode()
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"{command} ended with {os.waitstatus_to_exitcode(status)}: {words}")
    wall = (time.monotonic_ns() - began) / 1e9
    with open(answer, "w") as out:
        json.dump({"wall_s": wall, "peak_mb": usage.ru_maxrss / 1024, "said": words}, out)


if __name__ == "__main__":
    main()
