"""Plays the same clip with the player and its peers by turns, each in a guest of its own, and compares their cost.

players.py FOLDER PROGRAMS [ROUNDS]. Owns the measuring: processor seconds, peak memory, and the time from exec to the
first flip. PROGRAMS is the folder `bin` that `image-build/programs` makes. Never judges pace: a busy machine spoils it; the ratios carry over.

Processor seconds are those of the whole guest, counted by the machine that it runs on, less those of a guest that does
nothing. The guest's own figure will not do: its clock ticks a hundred times a second, and what works for 8 ms after
each vblank is billed 6.7 or 10 ms, as the ticks happen to fall. Wall time and memory
are taken inside, by `contestant.py`, starts by `starts.py`; `steady.py` keeps the machine the same for all.
"""

import json
import os
import re
import resource
import statistics
import subprocess
import sys

import steady

FRAMES = 1000
OURS = "dreams-player"
DECODING, MPV, KMSSINK = "decode only", "mpv --vo=drm", "gstreamer kmssink"
# For the starts only: no peer writes a line for each frame, and no unit does. In the guest's memory: what is written to
# the machine outside stops the whole guest.
TRACE = "/tmp/trace.jsonl"
HERE = os.path.dirname(os.path.abspath(__file__))


def commands(folder, programs):
    """One command line for each contestant, every decoder with one thread. Decoding alone has the player's own ffmpeg."""
    player, own = f"{programs}/dreams-player", f"{programs}/.."
    clip = f"{folder}/flock/clip.mp4"
    card = "/dev/dri/by-driver/vkms"
    return {
        DECODING: ["env", f"LD_LIBRARY_PATH={own}/lib/dreams-player", f"{own}/bench/decode-only", clip],
        OURS: [player, "--flock", f"{folder}/flock", "--screen", f"kms:{card}", "--threads", "1", "--seed", "1",
               "--clips", "1", "--status", "off", "--state", "/tmp/state"],
        MPV: ["mpv", "--no-config", "--really-quiet", "--vo=drm", f"--drm-device={card}", "--drm-mode=1280x720", "--no-audio",
              "--hwdec=no", "--vd-lavc-threads=1", clip],
        KMSSINK: ["gst-launch-1.0", "-q", "filesrc", f"location={clip}", "!", "qtdemux", "!", "h264parse", "!", "avdec_h264",
                  "max-threads=1", "!", "kmssink", "driver-name=vkms", "force-modesetting=true", "skip-vsync=true"],
    }


def in_guest(command):
    """Runs `command` in a fresh guest of one processor; returns the processor seconds of the whole guest.

    One processor: on two, a User-Mode kernel lets the threads of one program in by turns, and bills the waiting too.
    """
    guest = [f"{HERE}/../vkms/run", "--time", "real", "--cpus", "1", "--limit", "200", "--"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(guest + command, stdin=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def contest(folder, command):
    """One run of `command`: processor seconds of its guest, and what `contestant.py` tells."""
    answer = f"{folder}/contestant.json"
    cpu_s = in_guest(["python3", f"{HERE}/contestant.py", answer] + command)
    with open(answer) as told:
        return {"cpu_s": cpu_s, **json.load(told)}


def starts(folder, command, rounds):
    """Milliseconds from exec to the first flip: of a cold start, and of `rounds` more."""
    answer = f"{folder}/starts.json"
    in_guest(["python3", f"{HERE}/starts.py", answer, str(rounds), TRACE] + command + ["--trace", TRACE])
    with open(answer) as told:
        return json.load(told)


def must_be_whole(result):
    """Ends the measuring if the player did not show every frame, by the last line of its log."""
    flips = re.search(r"\bflips=(\d+)", result["said"])
    if not flips or int(flips[1]) != FRAMES:
        sys.exit(f"the player did not show {FRAMES} frames: {result['said']}")


def measure(folder, programs, rounds):
    """Medians over `rounds`, contestants by turns."""
    contestants = commands(folder, programs)
    runs = {name: [] for name in contestants}
    for turn in range(rounds):
        idle = contest(folder, ["true"])["cpu_s"]
        for name, command in contestants.items():
            result = contest(folder, command)
            result["cpu_s"] -= idle
            if name == OURS:
                must_be_whole(result)
            del result["said"]
            runs[name].append(result)
            print(f"round {turn + 1}: {name:20} {result['cpu_s']:7.2f} s", flush=True)
    median = {name: {key: statistics.median(r[key] for r in results) for key in results[0]} for name, results in runs.items()}
    runs["starts"] = starts(folder, contestants[OURS], rounds)
    median[OURS]["first_flip_ms"] = statistics.median(runs["starts"]["first_flip_ms"])
    return runs, median


def promises(runs, median):
    """What the project promises, as name, figure, bound.

    Processor time is compared within each round, and the median taken of those: what slows a machine down for a
    minute then weighs on both.
    """
    def over(peer):
        return statistics.median(our["cpu_s"] / their["cpu_s"] for our, their in zip(runs[OURS], runs[peer]))

    ours, mpv = median[OURS], median[MPV]
    return [
        ("processor time over decode only", over(DECODING), 1.15),
        ("processor time over mpv", over(MPV), 0.65),
        ("processor time over kmssink", over(KMSSINK), 0.6),
        ("peak memory over mpv's", ours["peak_mb"] / mpv["peak_mb"], 0.6),
        ("exec to first flip, ms", ours["first_flip_ms"], 300),
    ]


def main():
    folder, programs = sys.argv[1:3]
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    with steady.machine():
        runs, median = measure(folder, programs, rounds)
    print(f"\n{'median of ' + str(rounds):22}{'CPU s / 1,000 frames':>22}{'peak MB':>10}{'first flip ms':>15}")
    for name, row in median.items():
        first = f"{row['first_flip_ms']:.0f}" if "first_flip_ms" in row else "-"
        print(f"{name:22}{row['cpu_s']:>22.2f}{row['peak_mb']:>10.1f}{first:>15}")
    kept = promises(runs, median)
    print()
    for name, figure, bound in kept:
        print(f"{name:34}{figure:>8.2f}  at most {bound:<6} {'kept' if figure <= bound else 'MISSED'}")
    with open(f"{folder}/players.json", "w") as out:
        reach = [{"promise": n, "figure": f, "at_most": b, "kept": f <= b} for n, f, b in kept]
        json.dump({"frames": FRAMES, "rounds": rounds, "median": median, "runs": runs, "reach": reach}, out, indent=1)
    return 0 if all(figure <= bound for _, figure, bound in kept) else 1


if __name__ == "__main__":
    sys.exit(main())
