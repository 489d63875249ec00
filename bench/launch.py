"""Runs one command and tells what the kernel says it took: launch.py DESCRIPTOR COMMAND...

A process inherits the peak memory of the one that started it, across exec. This one is small, so
what it measures is the command's own, if that is more than the few megabytes of a bare interpreter.
Writes `wall_s cpu_s peak_bytes` to the descriptor and ends as the command did. Run it with `python3
-I -S`, which leaves out what it does not need.
"""
import os
import sys
import time


def main():
    report = int(sys.argv[1])
    started = time.monotonic()
    # No vfork: the child's books begin with pages of this process, not with those of a larger one.
    child = os.fork()
    if child == 0:
        os.close(report)
        try:
            os.execvp(sys.argv[2], sys.argv[2:])
        except OSError as error:
            os.write(2, f"{sys.argv[2]}: {error.strerror}\n".encode())
        os._exit(127)
    _, status, usage = os.wait4(child, 0)
    wall_s = time.monotonic() - started
    os.write(
        report, f"{wall_s} {usage.ru_utime + usage.ru_stime} {usage.ru_maxrss * 1024}".encode()
    )
    code = os.waitstatus_to_exitcode(status)
    os._exit(code if code >= 0 else 128 - code)


main()
