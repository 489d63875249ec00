"""Becomes another program within limits: launch.py PARENT DATA_BYTES COMMAND...

It is a program of its own because nothing but exec is safe after a fork of a process with threads.
The kernel ends the command when its parent ends, and gives it no more than DATA_BYTES of memory
of its own, which is the net below the limit that the parent watches over. Run with `-I -S`.
"""

import ctypes
import os
import resource
import signal
import sys

PR_SET_PDEATHSIG = 1


def main() -> None:
    parent, data_bytes = int(sys.argv[1]), int(sys.argv[2])
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before the kernel was told
        os._exit(1)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if data_bytes > 0:
        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        allowed = data_bytes if hard == resource.RLIM_INFINITY else min(data_bytes, hard)
        resource.setrlimit(resource.RLIMIT_DATA, (allowed, hard))
    try:
        os.execv(sys.argv[3], sys.argv[3:])
    except OSError as error:
        os.write(2, f"{sys.argv[3]}: {error.strerror}\n".encode())
        os._exit(126)


main()
