"""Measures how fast a bundle is verified and what an update costs, beside b3sum, rsync and casync.

bundles.py FOLDER FLOCK UPDATER [ROUNDS]. Owns the measuring: seconds by the wall, bytes as each tool counts or stores
them; a unit's bytes are those that a web server sent it, every header included. The artist's side lies in memory where
there is room, the other side on the disk, and every copy ends with its bytes on that disk. Answers in
FOLDER/bundles.json.

The clips are a few grey frames with megabytes of noise behind them, which MP4 readers pass over: as incompressible as
film, and quickly made.
"""

import contextlib
import functools
import http.server
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time

# A ring, and one chord: 1,125 clips.
SHEEP = 562
CLIPS = 2 * SHEEP + 1
CLIP_BYTES = 1_800_000
# One clip in twenty changes.
EVERY = 20


def run(*words, **more):
    """Runs a command, which must succeed; returns its standard output."""
    return subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True, **more).stdout


def seconds(*words, **more):
    """How long a command takes by the wall."""
    before = time.monotonic()
    run(*words, **more)
    return time.monotonic() - before


def base(folder):
    """A clip of twelve grey frames."""
    path = f"{folder}/base.mp4"
    run("ffmpeg", "-v", "error", "-nostdin", "-y", "-f", "lavfi", "-i", "color=gray:64x64:r=30,format=yuv420p", "-vf",
        "setparams=range=tv:color_primaries=bt709:color_trc=bt709:colorspace=bt709",
        "-frames:v", "12", "-c:v", "libx264", "-profile:v", "high", "-x264-params", "open-gop=0", "-bsf:v",
        "dump_extra=freq=keyframe", "-movflags", "+faststart", "-colorspace", "bt709", "-color_primaries", "bt709",
        "-color_trc", "bt709", "-color_range", "tv", path)
    with open(path, "rb") as clip:
        return clip.read()


def clip(flock, number, edition, frames):
    """Writes clip `number`: the same frames in every edition, other noise. Returns its size."""
    noise = random.Random(number * 1000 + edition).randbytes(CLIP_BYTES)
    path = f"{flock}/{number}.mp4"
    with open(f"{path}.new", "wb") as out:
        out.write(frames + (len(noise) + 8).to_bytes(4, "big") + b"free" + noise)
    os.rename(f"{path}.new", path)
    return os.path.getsize(path)


def make(flock, frames):
    """A ring of sheep, and a chord; each clip is another file."""
    os.makedirs(flock)
    with open(f"{flock}/flock.toml", "w") as toml:
        toml.write('format = 1\nname = "bench"\nsize = [64, 64]\nfps = [30, 1]\n')
        for at in range(SHEEP):
            toml.write(f'[[sheep]]\nid = "{at}"\nframes = 12\nclip = "{at}.mp4"\n')
        for at in range(SHEEP + 1):
            ends = f'from = "{at % SHEEP}"\nto = "{(at + 1 + at // SHEEP) % SHEEP}"\n'
            toml.write(f'[[transition]]\n{ends}frames = 12\nclip = "{SHEEP + at}.mp4"\n')
    for number in range(CLIPS):
        clip(flock, number, 0, frames)


def stored(folder):
    """The bytes of all files under `folder`."""
    return sum(os.path.getsize(os.path.join(at, name)) for at, _, names in os.walk(folder) for name in names)


def processor():
    """Processor seconds of all commands so far."""
    told = resource.getrusage(resource.RUSAGE_CHILDREN)
    return told.ru_utime + told.ru_stime


def measured(*words, **more):
    """Seconds of a command, by the wall and of processors."""
    before = processor()
    wall = seconds(*words, **more)
    return {"wall_s": wall, "cpu_s": processor() - before}


def verifying(artist, flock, rounds):
    """The best run of `dreams verify` and of b3sum over the same bytes, by turns; both warm. The best: what else the
    machine does can only add."""
    objects = [os.path.join(at, name) for at, _, names in os.walk(f"{artist}/bundle/objects") for name in names]
    verify = [flock, "verify", "bundle", "--trust", "artist.pub"]
    runs = {"dreams verify": [], "b3sum": []}
    for _ in range(rounds + 1):
        runs["b3sum"].append(measured("b3sum", *objects))
        runs["dreams verify"].append(measured(*verify, cwd=artist, stderr=subprocess.DEVNULL))
    # The first round warms the page cache.
    best = {name: {key: min(run[key] for run in told[1:]) for key in told[0]} for name, told in runs.items()}
    return best, stored(f"{artist}/bundle/objects")


def synced(folder, *words, **more):
    """Seconds of a command and of bringing what it wrote to the disk."""
    return seconds(*words, **more) + seconds("sync", "-f", folder)


def rsync(artist, disk):
    """One edition by rsync, with its network algorithm: seconds, and bytes in both directions."""
    os.makedirs(f"{disk}/rsync", exist_ok=True)
    before = time.monotonic()
    told = run("rsync", "-a", "--no-whole-file", "--stats", f"{artist}/flock/", f"{disk}/rsync/")
    run("sync", "-f", disk)
    both = re.findall(r"Total bytes (?:sent|received): ([\d,.]+)", told)
    return {"seconds": time.monotonic() - before, "bytes": sum(int(re.sub(r"[,.]", "", count)) for count in both)}


def casync(artist, disk, edition):
    """One edition by casync: seconds of chunking and of extracting, and the bytes of the chunks that are new."""
    store, index = f"{artist}/chunks", f"{artist}/{edition}.caidx"
    os.makedirs(store, exist_ok=True)
    there = stored(store)
    chunking = seconds("casync", "make", f"--store={store}", index, f"{artist}/flock")
    new = stored(store) - there + os.path.getsize(index)
    seed = [f"--seed={disk}/casync.{edition - 1}"] if edition else []
    extract = ["casync", "extract", f"--store={store}", *seed, index, f"{disk}/casync.{edition}"]
    return {"seconds": synced(disk, *extract), "artist_seconds": chunking, "bytes": new}


def publish(artist, disk, flock):
    """One edition by `dreams pack` and `dreams publish`: seconds, and bytes written."""
    key = ["--key", "artist.key", "--passphrase-file", "passphrase"]
    packing = seconds(flock, "pack", "flock", "bundle", "--unit", "lobby", *key, cwd=artist)
    os.makedirs(f"{disk}/published", exist_ok=True)
    words = [flock, "publish", "bundle", f"{disk}/published", "--trust", "artist.pub", "--json"]
    before = time.monotonic()
    answer = json.loads(run(*words, cwd=artist))
    return {"seconds": time.monotonic() - before, "artist_seconds": packing, "bytes": answer["new_bytes"]}


class Counted:
    """What a server sends to one visitor, counted."""

    def __init__(self, to, heard):
        self.to, self.heard = to, heard

    def write(self, data):
        """Sends it."""
        self.heard["bytes"] += len(data)
        return self.to.write(data)

    def __getattr__(self, name):
        return getattr(self.to, name)


class Visit(http.server.SimpleHTTPRequestHandler):
    """One visitor of the server."""

    protocol_version = "HTTP/1.1"

    def setup(self):
        super().setup()
        self.wfile = Counted(self.wfile, self.server.heard)

    def log_message(self, *_):
        """Says nothing."""

    def log_request(self, *_):
        self.server.heard["requests"] += 1


@contextlib.contextmanager
def serving(folder):
    """A web server of what lies in `folder`: its address, and what it has heard and sent."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Visit, directory=folder))
    server.heard = {"requests": 0, "bytes": 0}
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}", server.heard
    finally:
        server.shutdown()
        server.server_close()


def unit(artist, disk, updater):
    """A unit looks at the web server once: what it did, seconds until all is on its disk, requests and bytes."""
    words = [updater, "--json", "--unit", "lobby", "--store", f"{disk}/store", "--keys", f"{artist}/artist.pub"]
    with serving(f"{disk}/published") as (address, heard):
        before = time.monotonic()
        answer = json.loads(run(*words, address, stderr=subprocess.DEVNULL))
        run("sync", "-f", disk)
        return {"outcome": answer["outcome"], "seconds": time.monotonic() - before, **heard}


def contest(artist, disk, flock, updater, frames):
    """Both editions by every tool, how many bytes are new in the second, and a look of a unit that has both."""
    os.makedirs(disk)
    make(f"{artist}/flock", frames)
    with open(f"{artist}/passphrase", "w") as out:
        os.chmod(out.name, 0o600)
        out.write("bench\n")
    run(flock, "keygen", "artist.key", "--passphrase-file", "passphrase", cwd=artist)
    tools = {"publish": [], "unit": [], "rsync": [], "casync": []}
    new = 0
    for edition in range(2):
        if edition:
            new = sum(clip(f"{artist}/flock", number, edition, frames) for number in range(0, CLIPS, EVERY))
        tools["publish"].append(publish(artist, disk, flock))
        tools["unit"].append(unit(artist, disk, updater))
        assert tools["unit"][-1]["outcome"] == "installed", tools["unit"]
        tools["rsync"].append(rsync(artist, disk))
        tools["casync"].append(casync(artist, disk, edition))
    look = unit(artist, disk, updater)
    assert look["outcome"] == "no-news", look
    return tools, new, look


def memory(wanted):
    """A folder in memory with so much room, or None."""
    status = os.statvfs("/dev/shm") if os.path.isdir("/dev/shm") else None
    return "/dev/shm" if status and status.f_bavail * status.f_frsize > wanted else None


def main():
    folder, flock, updater = sys.argv[1], os.path.abspath(sys.argv[2]), os.path.abspath(sys.argv[3])
    rounds = int(sys.argv[4]) if len(sys.argv) > 4 else 7
    disk = os.path.abspath(f"{folder}/bundles")
    shutil.rmtree(disk, ignore_errors=True)
    with tempfile.TemporaryDirectory(dir=memory(3 * CLIPS * CLIP_BYTES) or folder) as artist:
        tools, new, look = contest(artist, disk, flock, updater, base(artist))
        verify, verified = verifying(artist, flock, rounds)
    shutil.rmtree(disk)
    for name, figure in verify.items():
        print(f"{name:14}{verified / figure['wall_s'] / 1e9:8.2f} GB/s, {figure['cpu_s']:.2f} s of processors")
    print(f"\n{'':8}{'first, s':>10}{'MB':>10}{'update, s':>11}{'MB':>10}   of {new / 1e6:.1f} MB that are new")
    for name, (first, update) in tools.items():
        print(f"{name:8}{first['seconds']:>10.2f}{first['bytes'] / 1e6:>10.1f}", end="")
        print(f"{update['seconds']:>11.2f}{update['bytes'] / 1e6:>10.1f}")
    reach = [
        ("verifying, of b3sum's speed", verify["b3sum"]["wall_s"] / verify["dreams verify"]["wall_s"], ">=", 0.9),
        ("a unit's bytes, of what is new", tools["unit"][1]["bytes"] / new, "<=", 1.01),
        ("requests of a look without news", look["requests"], "<=", 1),
        ("kB of a look without news", look["bytes"] / 1000, "<=", 64),
    ]
    kept = [(figure >= bound) if sign == ">=" else (figure <= bound) for _, figure, sign, bound in reach]
    print()
    for (name, figure, sign, bound), held in zip(reach, kept):
        print(f"{name:34}{figure:>8.4f}  {sign} {bound:<6} {'kept' if held else 'MISSED'}")
    with open(f"{folder}/bundles.json", "w") as out:
        told = [{"promise": n, "figure": f, "bound": f"{s} {b}", "kept": k} for (n, f, s, b), k in zip(reach, kept)]
        json.dump({"clips": CLIPS, "bytes": verified, "rounds": rounds, "verify": verify, "new_bytes": new,
                   "look": look, "tools": tools, "reach": told}, out, indent=1)
    return 0 if all(kept) else 1


if __name__ == "__main__":
    sys.exit(main())
