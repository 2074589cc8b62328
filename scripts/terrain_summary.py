#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Waits until the terrain node has worked through a replay and prints what it did."""
import argparse
import sys
import time

import rospy
from ladar_perception.msg import TerrainStatistics


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--topic', default='statistics', help='of the TerrainStatistics')
    parser.add_argument('--start-timeout', type=float, default=60.0, metavar='S',
                        help='give up when no scan came within this time')
    parser.add_argument('--idle', type=float, default=4.0, metavar='S',
                        help='the replay has ended when no scan came for this time')
    return parser.parse_args(rospy.myargv()[1:])


def wait_for_end(arguments):
    """Returns the last statistics, or None if no scan ever came."""
    state = {'last': None, 'seen': 0, 'changed': time.monotonic()}

    def on_statistics(message):
        seen = message.scans + sum(drop.count for drop in message.scans_dropped)
        if seen != state['seen']:
            state.update(seen=seen, changed=time.monotonic())
        state['last'] = message

    rospy.Subscriber(arguments.topic, TerrainStatistics, on_statistics)
    begin = time.monotonic()
    while not rospy.is_shutdown():
        time.sleep(0.1)
        if state['seen'] == 0:
            if time.monotonic() - begin > arguments.start_timeout:
                return None
        elif time.monotonic() - state['changed'] > arguments.idle:
            break
    return state['last'] if state['seen'] else None


def listed(drops):
    parts = [f'{drop.reason} {drop.count}' for drop in drops if drop.count]
    return ', '.join(parts) if parts else 'none'


def print_summary(message):
    print(f'scans labelled   {message.scans} ({message.scan_rate_hz:.1f} Hz)')
    print(f'scans dropped    {listed(message.scans_dropped)}')
    print(f'points           {message.points_in}, {message.points_inserted} into the map')
    print(f'points per s     {message.points_per_second:.0f}')
    print(f'points dropped   {listed(message.points_dropped)}')
    print(f'latency          p50 {message.latency_p50_ms:.1f} ms, '
          f'p99 {message.latency_p99_ms:.1f} ms')
    print(f'map              {message.occupied_voxels} voxels, '
          f'{message.memory_bytes / 1e6:.1f} MB')
    total = sum(label.count for label in message.labels)
    shares = ', '.join(f'{label.name} {100.0 * label.count / max(total, 1):.1f} %'
                       for label in message.labels)
    print(f'classes          {shares}')


def main():
    arguments = parse_arguments()
    try:
        rospy.init_node('terrain_summary', anonymous=True, disable_signals=True)
        message = wait_for_end(arguments)
    except KeyboardInterrupt:
        return 130
    if message is None:
        print(f'terrain_summary: no scan was reported on {rospy.resolve_name(arguments.topic)} '
              f'within {arguments.start_timeout:.0f} s', file=sys.stderr)
        return 1
    print_summary(message)
    if message.scans == 0:
        print('terrain_summary: not one scan could be labelled', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
