#!/usr/bin/env python3
"""Says which tests were skipped, and fails unless the machine lacks what each of them misses.

usage: check_skips.py [--sanitized] RESULTS.xml...     RESULTS.xml: what `ctest --output-junit` wrote
"""
import argparse
import os
import re
import socket
import subprocess
import sys
import xml.etree.ElementTree as ElementTree


def cpu_has(feature):
    with open("/proc/cpuinfo", encoding="ascii", errors="replace") as cpuinfo:
        return re.search(rf"\b{feature}", cpuinfo.read()) is not None


def namespaces_work():
    command = ["unshare", "--net", "true"]
    return os.geteuid() == 0 and subprocess.run(command, stderr=subprocess.DEVNULL, check=False).returncode == 0


def mounts_work():
    command = ["unshare", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"]
    return os.geteuid() == 0 and subprocess.run(command, stderr=subprocess.DEVNULL, check=False).returncode == 0


def multicast_works():
    """A datagram sent to a group on loopback arrives."""
    group, loopback = socket.inet_aton("239.255.76.67"), socket.inet_aton("127.0.0.1")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver, \
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        try:
            receiver.bind(("239.255.76.67", 0))
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group + loopback)
            receiver.settimeout(1)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, loopback)
            sender.sendto(b"here", receiver.getsockname())
            return receiver.recv(16) == b"here"
        except OSError:
            return False


def seccomp_works():
    with open("/proc/self/status", encoding="ascii", errors="replace") as status:
        return "Seccomp:" in status.read()


# What a test may miss: its words, and whether the machine has the thing after all.
MACHINE = [
    (r"network namespaces", namespaces_work),
    (r"may mount", mounts_work),
    (r"multicast", multicast_works),
    (r"lacks avx512", lambda: cpu_has("avx512f")),
    (r"lacks avx2", lambda: cpu_has("avx2")),
    (r"seccomp", seccomp_works),
]


def reason_of(output):
    """The words of a skipped GoogleTest case: they follow the line that ends in "Skipped"."""
    found = re.search(r"Skipped\n(.+)", output)
    return found.group(1).strip() if found else "no reason given"


def skipped_tests(path):
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        if case.find("skipped") is not None:
            yield case.get("name"), reason_of(case.findtext("system-out") or "")


def is_allowed(reason, machine, sanitized):
    if sanitized and "sanitizer owns malloc" in reason:
        return True
    return any(re.search(words, reason) and not has_it() for words, has_it in machine)


def check(paths, machine, sanitized, out):
    """How many tests were skipped though the machine has what they miss."""
    refused = 0
    for path in paths:
        for name, reason in skipped_tests(path):
            allowed = is_allowed(reason, machine, sanitized)
            refused += not allowed
            print(f"skipped{'' if allowed else ', which it must not be here'}: {name}: {reason}", file=out)
    return refused


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sanitized", action="store_true", help="the tests ran under a sanitizer, which owns malloc")
    parser.add_argument("results", nargs="+")
    arguments = parser.parse_args()
    return 1 if check(arguments.results, MACHINE, arguments.sanitized, sys.stdout) else 0


if __name__ == "__main__":
    sys.exit(main())
