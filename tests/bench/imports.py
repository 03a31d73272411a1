"""Measures what an import costs beside ffmpeg with the same settings of x264, and how much quicker all cores are.

imports.py FOLDER DREAMS CLIPS FRAMES. Owns the measuring: processor and wall seconds of whole programs. The clips are of
1280x720, as Electric Sheep's renderers leave them: MPEG-4 in AVI, with the colours of BT.601. ffmpeg encodes them one
after the other with one thread, as an import encodes each, and keeps their colours; an import also turns these to
BT.709, checks every clip with the unit's decoder and adds it to a flock. Answers in FOLDER/imports.json.
"""

import json
import os
import shutil
import subprocess
import sys
import time

# Different clips; the others are copies.
MODELS = 4
X264 = ["-c:v", "libx264", "-preset", "slow", "-crf", "17", "-profile:v", "high", "-threads", "1",
        "-x264-params", "repeat-headers=1:open-gop=0:8x8dct=1", "-movflags", "+faststart"]


def measure(*command):
    """Processor and wall seconds and peak megabytes of `command`, which must succeed."""
    before = time.monotonic()
    child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        sys.exit(f"{command} ended with {child.returncode}")
    wall = time.monotonic() - before
    return {"cpu_s": usage.ru_utime + usage.ru_stime, "wall_s": wall, "peak_mb": usage.ru_maxrss / 1024}


def make(folder, clips, frames):
    """Fills `folder` with a ring of loops of so many frames."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for at in range(clips):
        path = f"{folder}/00247={at:05}={at:05}={at:05}.avi"
        if at < MODELS:
            source = f"mandelbrot=size=1280x720:rate=30:start_scale={2.5 - at * 0.4}:end_scale={0.4 - at * 0.05}"
            measure("ffmpeg", "-v", "error", "-nostdin", "-y", "-f", "lavfi", "-i", source, "-frames:v", str(frames),
                    "-c:v", "mpeg4", "-q:v", "3", "-bf", "2", path)
        else:
            model = at % MODELS
            shutil.copy(f"{folder}/00247={model:05}={model:05}={model:05}.avi", path)


def by_ffmpeg(content, out):
    """What ffmpeg takes for every clip: the sum of seconds, the most megabytes."""
    os.makedirs(out)
    total = {"cpu_s": 0.0, "wall_s": 0.0, "peak_mb": 0.0}
    for name in sorted(os.listdir(content)):
        run = measure("ffmpeg", "-v", "error", "-nostdin", "-threads", "1", "-i", f"{content}/{name}", *X264,
                      f"{out}/{name[:-4]}.mp4")
        total = {key: total[key] + run[key] for key in ["cpu_s", "wall_s"]} | {
            "peak_mb": max(total["peak_mb"], run["peak_mb"])}
    return total


def by_us(dreams, content, flock, *words):
    """What an import into a new flock takes."""
    measure(dreams, "new", flock, "--size", "1280x720", "--fps", "30")
    return measure(dreams, "import", flock, content, *words)


def main():
    folder, dreams = sys.argv[1:3]
    clips, frames = map(int, sys.argv[3:])
    work = f"{folder}/imports"
    content = f"{work}/content"
    make(content, clips, frames)
    result = {"clips": clips, "frames": clips * frames, "cores": len(os.sched_getaffinity(0))}
    result["ffmpeg"] = by_ffmpeg(content, f"{work}/ffmpeg")
    result["one clip at a time"] = by_us(dreams, content, f"{work}/one", "--threads", "1")
    result["all cores"] = by_us(dreams, content, f"{work}/all")
    shutil.rmtree(work)
    print(f"{clips} clips of {frames} frames, {result['cores']} cores\n{'':20}{'CPU s':>10}{'wall s':>10}{'peak MB':>10}")
    for name in ["ffmpeg", "one clip at a time", "all cores"]:
        row = result[name]
        print(f"{name:20}{row['cpu_s']:>10.1f}{row['wall_s']:>10.1f}{row['peak_mb']:>10.0f}")
    cpu = result["all cores"]["cpu_s"] / result["ffmpeg"]["cpu_s"]
    wall = result["all cores"]["wall_s"] / result["one clip at a time"]["wall_s"]
    reach = []
    # With one core there is nothing to share.
    walls = [("wall over one clip at a time", wall, 0.6)] if result["cores"] > 1 else []
    for name, figure, bound in [("CPU over ffmpeg's", cpu, 1.15), *walls]:
        kept = figure <= bound
        print(f"{name:36}{figure:>9.2f}  at most {bound:<6} {'kept' if kept else 'MISSED'}")
        reach.append({"promise": name, "figure": figure, "at_most": bound, "kept": kept})
    with open(f"{folder}/imports.json", "w") as out:
        json.dump({**result, "reach": reach}, out, indent=1)
    return 0 if all(row["kept"] for row in reach) else 1


if __name__ == "__main__":
    sys.exit(main())
