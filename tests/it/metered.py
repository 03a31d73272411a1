"""Runs programs and tells what each of them took.

metered.py SECONDS. Reads commands, each a line of JSON: a list of words. Runs one after the other, and answers each with a
line of JSON: `code` (below 0 for a signal), `peak_kib` (the most memory it had), `cpu_s`, and what it said as `stdout` and
`stderr`. A program that takes longer than SECONDS is killed. Its own memory is small, which counts: until a program is
started, the system takes what its parent has for its own.
"""

import json
import os
import signal
import sys
import tempfile

LIMIT = int(sys.argv[1])


def run(words):
    """Runs a program to its end."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        actions = [(os.POSIX_SPAWN_DUP2, out.fileno(), 1), (os.POSIX_SPAWN_DUP2, err.fileno(), 2)]
        child = os.posix_spawn(words[0], words, os.environ, file_actions=actions)
        signal.signal(signal.SIGALRM, lambda *_: os.kill(child, signal.SIGKILL))
        signal.alarm(LIMIT)
        _, status, usage = os.wait4(child, 0)
        signal.alarm(0)
        said = []
        for stream in (out, err):
            stream.seek(0)
            said.append(stream.read(1 << 20).decode(errors="replace"))
    return {
        "code": os.waitstatus_to_exitcode(status),
        "peak_kib": usage.ru_maxrss,
        "cpu_s": usage.ru_utime + usage.ru_stime,
        "stdout": said[0],
        "stderr": said[1],
    }


for line in sys.stdin:
    print(json.dumps(run(json.loads(line))), flush=True)
