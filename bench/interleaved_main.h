// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception::bench {

/// Runs the registered benchmarks in rounds over all of them, in random order: what else the
/// machine does hits all alike. Flags of Google Benchmark on the command line come on top. Returns
/// the program's exit status.
inline int runInterleaved(int argc, char** argv) {
  // Defaults first: of a flag that is given twice, the last counts.
  std::vector<std::string> defaults = {"--benchmark_enable_random_interleaving=true",
                                       "--benchmark_repetitions=3", "--benchmark_min_time=0.05",
                                       "--benchmark_display_aggregates_only=true",
                                       "--benchmark_counters_tabular=true"};
  std::vector<char*> arguments = {argv[0]};
  for (std::string& flag : defaults) arguments.push_back(flag.data());
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::AddCustomContext("vector_level", vectorLevelName(vectorLevel()));
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

}  // namespace ladar_perception::bench
