"""A stick that is pulled again and again, until all of it was read: a real block device, which is gone each time.

pulled_stick.py DEVICES IMAGE BYTES PULLS COMMAND... Owns the stick: the kernel's network block devices, whose other end is
here. Each time it gives BYTES of the file IMAGE, an ext4, and is gone; after PULLS times it gives all. Runs COMMAND beside
it, whose last word must be where the stick is mounted, and tells of each attempt as a line of JSON: `status`, `given`
(bytes), and what it `said` on both streams. Needs root and devices of its own: a guest's.
"""

import fcntl
import json
import os
import socket
import struct
import subprocess
import sys
import threading
import time

SET_SOCK, SET_BLKSIZE, DO_IT, CLEAR_SOCK, SET_SIZE_BLOCKS, SET_FLAGS = (0xAB00 | n for n in (0, 1, 3, 4, 7, 10))
REQUEST, REPLY = 0x25609513, 0x67446698
READ, DISCONNECT = 0, 2
READ_ONLY = 1 << 1 | 1
BLOCK = 512


def received(peer, count):
    """So many bytes; fewer if nobody sends any more."""
    bytes_ = b""
    while len(bytes_) < count and (more := peer.recv(count - len(bytes_))):
        bytes_ += more
    return bytes_


class Stick:
    """One plugging in."""

    def __init__(self, device, image, most):
        self.given, self.most, self.image = 0, most, image
        self.device = os.open(device, os.O_RDWR)
        ours, theirs = socket.socketpair()
        for request, value in [(CLEAR_SOCK, 0), (SET_BLKSIZE, BLOCK), (SET_SIZE_BLOCKS, len(image) // BLOCK),
                               (SET_FLAGS, READ_ONLY), (SET_SOCK, theirs.fileno())]:
            fcntl.ioctl(self.device, request, value)
        self.ours, self.theirs = ours, theirs
        self.works = [threading.Thread(target=work, daemon=True) for work in (self.give, self.be)]
        for work in self.works:
            work.start()
        told = f"/sys/block/{os.path.basename(device)}"
        while open(f"{told}/size", encoding="ascii").read() == "0\n":
            time.sleep(0.001)
        # A stick that gives much at once can be pulled at few points.
        for limit in ("max_sectors_kb", "read_ahead_kb"):
            with open(f"{told}/queue/{limit}", "w", encoding="ascii") as most_at_once:
                most_at_once.write("4")

    def be(self):
        """Is there, until it is pulled."""
        try:
            fcntl.ioctl(self.device, DO_IT, 0)
        except OSError:
            pass
        fcntl.ioctl(self.device, CLEAR_SOCK, 0)

    def give(self):
        """Gives what is asked for, as long as it may."""
        while len(head := received(self.ours, 28)) == 28:
            _, kind, handle, at, count = struct.unpack(">IIQQI", head)
            if kind & 0xFFFF == DISCONNECT or self.given + count > self.most:
                break
            self.given += count
            self.ours.sendall(struct.pack(">IIQ", REPLY, 0, handle) + self.image[at:at + count])
        self.ours.shutdown(socket.SHUT_RDWR)

    def ended(self):
        """Pulls it if it is still in, and waits until it is gone."""
        try:
            self.ours.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        for work in self.works:
            work.join()
        for end in (self.ours, self.theirs):
            end.close()
        os.close(self.device)


def main():
    devices, image, most, pulls, command = int(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), sys.argv[5:]
    with open(image, "rb") as file:
        image = file.read()
    for pull in range(pulls + 1):
        device = f"/dev/nbd{pull % devices}"
        stick = Stick(device, image, most if pull < pulls else sys.maxsize)
        subprocess.run(["mount", "-t", "ext4", "-o", "ro", device, command[-1]], check=True)
        done = subprocess.run(command, capture_output=True, text=True)
        subprocess.run(["umount", command[-1]], check=True)
        stick.ended()
        print(json.dumps({"status": done.returncode, "given": stick.given, "said": done.stdout + done.stderr}), flush=True)


if __name__ == "__main__":
    main()
