"""Holds the speed of the studio's page against what is promised.

studio.py FOLDER DREAMS TOLD adds to TOLD, what the bench `studio` printed, how long DREAMS takes to print its address, and
writes all to FOLDER/studio.json.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time

STARTS = 5

# Of a headless browser, a second.
REFRESHES = 60
# Of the difference of two times of the page's clock, each 0.1 ms coarse.
COARSE_MS = 0.2


def start_ms(dreams):
    """Milliseconds from exec to the printed address."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([dreams, "new", f"{folder}/flock"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        began = time.monotonic_ns()
        with subprocess.Popen([dreams, "studio", f"{folder}/flock", "--no-open"], stdout=subprocess.PIPE) as studio:
            studio.stdout.readline()
            took = (time.monotonic_ns() - began) / 1e6
            studio.kill()
        return took


def part(figures, of):
    """The figure that so many of a hundred do not exceed."""
    return sorted(figures)[min(len(figures) - 1, len(figures) * of // 100)]


def refreshes(frames_ms):
    """Milliseconds of frames, without the coarseness of the page's clock for those that took whole refreshes."""
    whole_ms = [round(ms * REFRESHES / 1000) * 1000 / REFRESHES for ms in frames_ms]
    return [whole if abs(ms - whole) <= COARSE_MS else ms for ms, whole in zip(frames_ms, whole_ms)]


def promises(told):
    """What the project promises, as name, figure, bound in milliseconds."""
    few, many = refreshes(told["scrolling_200_frames_ms"]), refreshes(told["scrolling_3000_frames_ms"])
    return [
        ("exec to the printed address", statistics.median(told["start_ms"]), 300),
        ("first paint, 200 sheep", statistics.median(told["first_paint_ms"]), 1000),
        ("key to mark, 95 of 100", part(told["key_to_mark_ms"], 95), 100),
        ("slider to figures, 300 sheep, 95 of 100", part(told["slider_300_ms"], 95), 100),
        ("slider to figures, 1,000 sheep, 95 of 100", part(told["slider_1000_ms"], 95), 300),
        ("frame while scrolling 200 sheep, 95 of 100", part(few, 95), 25),
        ("frame while scrolling 200 sheep, worst", max(few), 50),
        ("frame while scrolling 3,000 sheep, worst", max(many), 50),
    ]


def main():
    folder, dreams, file = sys.argv[1:4]
    with open(file) as text:
        told = json.load(text)
    told["start_ms"] = [start_ms(dreams) for _ in range(STARTS)]
    kept = promises(told)
    for name, figure, bound in kept:
        print(f"{name:44}{figure:>8.1f} ms  at most {bound:<6} {'kept' if figure <= bound else 'MISSED'}")
    told["reach"] = [{"promise": n, "figure_ms": f, "at_most_ms": b, "kept": f <= b} for n, f, b in kept]
    with open(f"{folder}/studio.json", "w") as out:
        json.dump(told, out, indent=1)
    return 0 if all(figure <= bound for _, figure, bound in kept) else 1


if __name__ == "__main__":
    sys.exit(main())
