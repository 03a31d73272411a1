"""Plays the same clip with the player and its peers by turns, and compares what they cost.

Runs inside the guest that `run` starts: players.py FOLDER PLAYER [ROUNDS]. Owns the measuring: processor seconds
(user and system: a guest reports all of it as system), peak memory, and the time from exec to the first flip.
Never judges pace: a busy machine spoils it; the ratios carry over.
"""

import glob
import json
import os
import statistics
import subprocess
import sys
import time

FRAMES = 1000


def commands(folder, player, trace):
    """One command line for each contestant, every decoder with one thread."""
    clip = f"{folder}/flock/clip.mp4"
    card = os.path.realpath("/dev/dri/by-driver/vkms")
    return {
        "ffmpeg decode only": ["ffmpeg", "-v", "error", "-nostdin", "-threads", "1", "-i", clip, "-f", "null", "-"],
        "mpv --vo=drm": ["mpv", "--no-config", "--really-quiet", "--vo=drm", f"--drm-device={card}", "--drm-mode=1280x720",
                         "--no-audio", "--hwdec=no", "--vd-lavc-threads=1", clip],
        "gstreamer kmssink": ["gst-launch-1.0", "-q", "filesrc", f"location={clip}", "!", "qtdemux", "!", "h264parse", "!",
                              "avdec_h264", "max-threads=1", "!", "kmssink", "driver-name=vkms", "force-modesetting=true",
                              "skip-vsync=true"],
        "dreams-player": [player, "--flock", f"{folder}/flock", "--screen", f"kms:{card}", "--threads", "1", "--seed", "1",
                          "--clips", "1", "--status", "off", "--state", "/tmp/state", "--trace", trace],
    }


def run(command):
    """Runs `command` to its end: processor seconds, wall seconds, peak MB, and when it was started (monotonic ns)."""
    began = time.monotonic_ns()
    with open("/tmp/said", "w+b") as said:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=said)
        _, status, usage = os.wait4(process.pid, 0)
        if os.waitstatus_to_exitcode(status) != 0:
            said.seek(0)
            sys.exit(f"{command} ended with {os.waitstatus_to_exitcode(status)}: {said.read().decode()}")
    wall = (time.monotonic_ns() - began) / 1e9
    return {"cpu_s": usage.ru_utime + usage.ru_stime, "wall_s": wall, "peak_mb": usage.ru_maxrss / 1024, "began_ns": began}


def first_flip_ms(trace, began_ns):
    """Milliseconds from exec to the first frame on the glass, after the player's own trace."""
    with open(trace) as lines:
        flips = [event for event in map(json.loads, lines) if event["event"] == "flip"]
    if len(flips) != FRAMES:
        sys.exit(f"the player showed {len(flips)} frames, wanted {FRAMES}")
    return (flips[0]["t_ns"] - began_ns) / 1e6


def measure(folder, player, rounds):
    """Medians over `rounds`, contestants by turns."""
    trace = "/tmp/trace"
    runs = {name: [] for name in commands(folder, player, trace)}
    for turn in range(rounds):
        for name, command in commands(folder, player, trace).items():
            result = run(command)
            if name == "dreams-player":
                result["first_flip_ms"] = first_flip_ms(trace, result["began_ns"])
                subprocess.run(["rm", "-rf", "/tmp/state", trace], check=True)
            del result["began_ns"]
            runs[name].append(result)
            print(f"round {turn + 1}: {name:20} {result['cpu_s']:7.2f} s", flush=True)
    median = {name: {key: statistics.median(r[key] for r in results) for key in results[0]} for name, results in runs.items()}
    return runs, median


def promises(median):
    """What the project promises, as name, figure, bound."""
    ours, ffmpeg = median["dreams-player"], median["ffmpeg decode only"]
    mpv, gst = median["mpv --vo=drm"], median["gstreamer kmssink"]
    return [
        ("processor time over decode only", ours["cpu_s"] / ffmpeg["cpu_s"], 1.10),
        ("processor time over mpv", ours["cpu_s"] / mpv["cpu_s"], 0.6),
        ("processor time over kmssink", ours["cpu_s"] / gst["cpu_s"], 0.6),
        ("peak memory, MB", ours["peak_mb"], 70),
        ("peak memory over mpv's", ours["peak_mb"] / mpv["peak_mb"], 1.0),
        ("exec to first flip, ms", ours["first_flip_ms"], 300),
    ]


def main():
    folder, player = sys.argv[1:3]
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    runs, median = measure(folder, player, rounds)
    print(f"\n{'median of ' + str(rounds):22}{'CPU s / 1,000 frames':>22}{'peak MB':>10}{'first flip ms':>15}")
    for name, row in median.items():
        first = f"{row['first_flip_ms']:.0f}" if "first_flip_ms" in row else "-"
        print(f"{name:22}{row['cpu_s']:>22.2f}{row['peak_mb']:>10.1f}{first:>15}")
    kept = promises(median)
    print()
    for name, figure, bound in kept:
        print(f"{name:34}{figure:>8.2f}  at most {bound:<6} {'kept' if figure <= bound else 'MISSED'}")
    with open(f"{folder}/players.json", "w") as out:
        reach = [{"promise": n, "figure": f, "at_most": b, "kept": f <= b} for n, f, b in kept]
        json.dump({"frames": FRAMES, "rounds": rounds, "median": median, "runs": runs, "reach": reach}, out, indent=1)
    return 0 if all(figure <= bound for _, figure, bound in kept) else 1


if __name__ == "__main__":
    sys.exit(main())
