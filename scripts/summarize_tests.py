#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Counts the tests of JUnit reports and ends with 'N passed, N failed, N skipped'.

Arguments are report files, folders of them, and NAME=passed or NAME=failed for single checks. The
exit status is 0 only when something passed and nothing failed.
"""
import collections
import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def outcome(case):
    if case.find('failure') is not None or case.find('error') is not None:
        return 'failed'
    if case.find('skipped') is not None or case.get('status') in ('notrun', 'disabled'):
        return 'skipped'
    return 'passed'


def cases_of(report):
    """Yields (name, outcome) of every test case in a report file."""
    try:
        root = ElementTree.parse(report).getroot()
    except (ElementTree.ParseError, OSError) as error:
        yield f'{report}: {error}', 'failed'
        return
    for case in root.iter('testcase'):
        yield f"{case.get('classname', '')}.{case.get('name', '')} ({report.name})", outcome(case)


def all_cases(arguments):
    for argument in arguments:
        path = pathlib.Path(argument)
        if argument.endswith(('=passed', '=failed')):
            yield tuple(argument.rsplit('=', 1))
        elif path.is_dir():
            for report in sorted(path.rglob('*.xml')):
                yield from cases_of(report)
        else:
            yield from cases_of(path)


def main():
    counts = collections.Counter()
    for name, result in all_cases(sys.argv[1:]):
        counts[result] += 1
        if result == 'failed':
            print(f'FAILED: {name}')
    if counts['skipped']:
        print('skipped tests need real ladar data in $LADAR_DATA (default ../shared/data)')
    print(f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return 0 if counts['passed'] and not counts['failed'] else 1


if __name__ == '__main__':
    sys.exit(main())
