#!/usr/bin/python3
"""Our training update and acting policy beside PyTorch's, in turn, on the same cores.

Usage: compare_torch.py [--rounds N] [--realtime] [--markdown] [CASE...]      cases as of peer_torch.py

Each round runs ours, then the peer, case by case, each pinned to as many cores as the case has threads. Prints a JSON line a case:
medians over the rounds, and the median, smallest and largest ratio of a round; --markdown prints a table of the same. On a machine
that others use the figures mean little, least those of two threads: --realtime (root) gives both sides the cores alone while they are
measured, for seconds at a time. The load average before and after is printed on standard error.
"""
import argparse
import json
import os
import platform
import re
import statistics
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
BIN = HERE.parents[1] / 'build' / os.environ.get('PRESET', 'release') / 'bin' / 'bench'
CASES = ['separate b64 t1', 'shared b64 t1', 'separate b256 t1', 'shared b256 t1', 'separate b64 t2', 'shared b64 t2',
         'separate b256 t2', 'act b1']
PAUSE_S = 2.0


def run(command, cores, realtime):
    """The JSON lines of a program pinned to the first `cores` cores that this process may use."""
    allowed = sorted(os.sched_getaffinity(0))[:cores]
    if len(allowed) < cores:
        sys.exit(f'error: {cores} threads need {cores} cores, here are {len(allowed)}')

    def prepare():
        os.sched_setaffinity(0, allowed)
        if realtime:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))

    output = subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True, preexec_fn=prepare).stdout
    if realtime:
        time.sleep(PAUSE_S)  # the others' turn
    return [json.loads(line) for line in output.splitlines()]


def measure(case, realtime):
    """Ours and the peer's figure, and ours as a fraction of the cores' peak."""
    threads = int((re.search(r' t(\d+)$', case) or [0, 1])[1])
    if case.startswith('act'):
        ours = run([BIN / 'act_latency'], threads, realtime)[0]  # six vehicles: the most work
    else:
        ours = run([BIN / 'learner_update', case], threads, realtime)[0]
    peer = run([HERE / 'peer_torch.py', '--seconds', '2', case], threads, realtime)[0]
    return ours['value'], peer['value'], ours['of_limit'], ours['unit']


def summary(case, rounds):
    ours, peers, of_peak, units = zip(*rounds)
    faster = [p / o if units[0] == 'us' else o / p for o, p in zip(ours, peers)]
    return {'bench': 'compare_torch', 'case': case, 'value': round(statistics.median(faster), 2), 'unit': 'times PyTorch',
            'smallest': round(min(faster), 2), 'largest': round(max(faster), 2), 'rounds': len(rounds),
            'ours': statistics.median(ours), 'ours_smallest': min(ours), 'ours_largest': max(ours),
            'peer': statistics.median(peers), 'peer_smallest': min(peers), 'peer_largest': max(peers),
            'figure': units[0], 'of_peak': statistics.median(of_peak)}


def machine():
    with open('/proc/cpuinfo') as info:
        model = re.search(r'model name\s*: (.*)', info.read())
    return f"{model[1] if model else platform.machine()}, {len(os.sched_getaffinity(0))} cores"


def load():
    return 'load average ' + ' '.join(f'{x:.1f}' for x in os.getloadavg())


def markdown(lines):
    print('| case | ours | PyTorch | ratio | of peak |')
    print('|---|---|---|---|---|')
    for r in lines:
        ours, peer = ('{%s:.4g} [{%s_smallest:.4g}, {%s_largest:.4g}]' % (who, who, who) for who in ('ours', 'peer'))
        row = '| {case} | ' + ours + ' {figure} | ' + peer + ' | {value} [{smallest}, {largest}] | {of_peak:.0%} |'
        print(row.format(**r))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('cases', nargs='*', metavar='CASE', default=CASES)
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--realtime', action='store_true')
    parser.add_argument('--markdown', action='store_true')
    options = parser.parse_args()
    if not (BIN / 'learner_update').exists():
        sys.exit(f'error: no benchmarks in {BIN}: cmake --preset release && cmake --build --preset release')
    print(f'{machine()}; {load()}', file=sys.stderr)
    rounds = {case: [] for case in options.cases}
    for i in range(options.rounds):
        for case in options.cases:
            rounds[case].append(measure(case, options.realtime))
            print(f'round {i + 1} {case}: {rounds[case][-1]}', file=sys.stderr)
    print(load(), file=sys.stderr)
    lines = [summary(case, rounds[case]) for case in options.cases]
    if options.markdown:
        markdown(lines)
    else:
        for line in lines:
            print(json.dumps(line))


if __name__ == '__main__':
    try:
        main()
    except (subprocess.SubprocessError, OSError) as error:
        sys.exit(f'error: {error}')
