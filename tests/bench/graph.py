"""Asks `dreams` and its peers for the shares of the same large flock, and `dreams` alone for everything else.

graph.py FOLDER FLOCK. Owns the measuring: processor seconds and peak memory of whole programs, from the file to the
answer. The peers are Python's: `peers.py` reads the file and asks scipy or networkx, each in a process of its own with
one thread. Reading is told apart from solving: the peers have no reader of their own, so theirs is as plain as can be.
Solving begins with the list of transitions: making a graph of it counts.
"""

import json
import os
import random
import re
import statistics
import subprocess
import sys

# The interpreter that Debian's packages of the peers are for, whatever `python3` is here.
PYTHON = "/usr/bin/python3"
HERE = os.path.dirname(os.path.abspath(__file__))
LARGE = {"sheep": 100_000, "exits": 10}
SMALL = {"sheep": 300, "exits": 4}
ROUNDS = 3


def write(folder, sheep, exits):
    """A ring with targets by chance, a few sheep far more often than the others; weights between 1/4 and 1."""
    os.makedirs(folder, exist_ok=True)
    path = f"{folder}/flock.toml"
    if os.path.exists(path):
        return
    by = random.Random(1)
    with open(path + ".new", "w") as out:
        out.write('format = 1\nname = "bench"\nsize = [1280, 720]\nfps = [30, 1]\n')
        for at in range(sheep):
            out.write(f'\n[[sheep]]\nid = "s{at}"\nframes = 768\nclip = "loops/{at}.mp4"\n')
        for at in range(sheep):
            to = {(at + 1) % sheep}
            while len(to) < exits:
                to.add(int(sheep * by.random() ** 2))
            for other in sorted(to):
                out.write(f'\n[[transition]]\nfrom = "s{at}"\nto = "s{other}"\nframes = 384\n'
                          f'clip = "transitions/{at}={other}.mp4"\nweight = {0.25 + 0.75 * by.random():.4f}\n')
    os.rename(path + ".new", path)


def measure(command, answer=os.devnull):
    """Processor seconds and peak megabytes of `command`, whose answer goes to a file. Fine or no, it must have answered."""
    with open(answer, "wb") as out, open(os.devnull, "wb") as told:
        child = subprocess.Popen(command, stdout=out, stderr=told, env={**os.environ, "OMP_NUM_THREADS": "1"})
        _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in (0, 1):
        sys.exit(f"{command} ended with {child.returncode}")
    return {"cpu_s": usage.ru_utime + usage.ru_stime, "peak_mb": usage.ru_maxrss / 1024}


def best(command, answer=os.devnull):
    """The quickest of several runs: a busy machine only adds."""
    return min((measure(command, answer) for _ in range(ROUNDS)), key=lambda run: run["cpu_s"])


def our_visits(answer):
    """The visits of the sheep, by id, from an answer too long to be parsed whole."""
    with open(answer) as text:
        sheep = text.read().split('"transitions"')[0]
    pairs = re.findall(r'"id": "([^"]+)",\s+"visits": ([^,]+),', sheep)
    return {name: float(visits) for name, visits in pairs}


def peer(folder, name, ours):
    """One peer's run on the large flock, and how far its shares are from ours, in total."""
    answer = f"{folder}/{name}.json"
    run = measure([PYTHON, f"{HERE}/peers.py", name, f"{folder}/large/flock.toml"], answer)
    with open(answer) as text:
        told = json.loads(text.read() or sys.exit(f"{name} gave no answer"))
    visits = told.pop("visits")
    return {**run, **told, "off": sum(abs(visits[sheep] - share) for sheep, share in ours.items())}


def solving(folder):
    """Our own reading and solving told apart, by the bench of the flock crate."""
    command = ["cargo", "bench", "--locked", "--quiet", "--package", "flock", "--bench", "shares", "--", folder]
    told = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)
    return {"read_s": told["read_s"], "solve_s": told["graph_s"] + told["shares_s"], "off_by": told["off_by"]}


def every_command(folder, flock):
    """What each command costs on a flock of 300 sheep, in milliseconds of processor time: medians."""
    small = f"{folder}/small"
    commands = {
        "share": ["share", small], "check": ["check", small], "balance": ["balance", small],
        "balance --suggest": ["balance", small, "--suggest", "5"],
        "walk": ["walk", small, "--seed", "1", "--steps", "72"],
        "simulate": ["simulate", small, "--seed", "1", "--steps", "1000"],
        "report": ["report", small, "--no-pictures", "--out", f"{folder}/small.html"],
        "want": ["want", small, "s7", "2"], "link": ["link", small, "s7", "s7"], "unlink": ["unlink", small, "s7", "s7"],
    }
    runs = {name: [] for name in commands}
    for _ in range(5):
        for name, words in commands.items():
            runs[name].append(1000 * measure([flock] + words)["cpu_s"])
    return {name: statistics.median(ms) for name, ms in runs.items()}


def promises(result):
    """What the project promises, as name, figure, bound, and whether the bound is the most or the least."""
    share, balance, networkx = result["share"], result["balance"], result["networkx"]
    slowest = max(result["every_command_ms"].items(), key=lambda item: item[1])
    return [
        ("shares, processor s", share["cpu_s"], 2, "most"),
        ("shares, peak MB", share["peak_mb"], 1000, "most"),
        ("balance, processor s", balance["cpu_s"], 10, "most"),
        ("balance, peak MB", balance["peak_mb"], 1000, "most"),
        ("networkx over ours, solving", networkx["solve_s"] / share["solve_s"], 20, "least"),
        (f"slowest of 300 sheep ({slowest[0]}), ms", slowest[1], 50, "most"),
    ]


def main():
    folder, flock = sys.argv[1:3]
    write(f"{folder}/large", **LARGE)
    write(f"{folder}/small", **SMALL)
    large, answer = f"{folder}/large", f"{folder}/share.json"
    result = {"share": best([flock, "share", large]), "share --json": best([flock, "share", large, "--json"], answer)}
    result["share"] |= solving(large)
    result["balance"] = measure([flock, "balance", large])
    ours = our_visits(answer)
    for name in ["scipy", "networkx"]:
        result[name] = peer(folder, name, ours)
    print(f"{'100,000 sheep':16}{'CPU s':>8}{'peak MB':>10}{'reading':>10}{'solving':>10}{'off ours':>10}")
    for name, row in result.items():
        read, solve, off = (f"{row[key]:{form}}" if key in row else "-" for key, form in
                            [("read_s", ".2f"), ("solve_s", ".2f"), ("off", ".1e")])
        print(f"{name:16}{row['cpu_s']:>8.2f}{row['peak_mb']:>10.0f}{read:>10}{solve:>10}{off:>10}")
    result["every_command_ms"] = every_command(folder, flock)
    print("\n300 sheep, ms:", ", ".join(f"{name} {ms:.0f}" for name, ms in result["every_command_ms"].items()), "\n")
    reach = []
    for name, figure, bound, kind in promises(result):
        kept = figure <= bound if kind == "most" else figure >= bound
        print(f"{name:36}{figure:>9.2f}  at {kind} {bound:<6} {'kept' if kept else 'MISSED'}")
        reach.append({"promise": name, "figure": figure, f"at_{kind}": bound, "kept": kept})
    with open(f"{folder}/graph.json", "w") as out:
        json.dump({**result, "reach": reach}, out, indent=1)
    return 0 if all(row["kept"] for row in reach) else 1


if __name__ == "__main__":
    sys.exit(main())
