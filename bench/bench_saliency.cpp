// SPDX-License-Identifier: BSD-3-Clause
// Measures sums over support volumes, labelling, insertion, and what other libraries take for the
// same.
//   bench_saliency [--benchmark_filter=REGEX] [other flags of Google Benchmark]
#include "bench_families.h"
#include "interleaved_main.h"

int main(int argc, char** argv) {
  namespace bench = ladar_perception::bench;
  const bench::SceneNames scenes = bench::presentSceneNames();
  bench::registerBoxSums(scenes);
  bench::registerLabeling(scenes);
  bench::registerInsertion(scenes);
  bench::registerOctomapInsertion(scenes);
  bench::registerPclNeighbourhoods(scenes);
  bench::registerNanoflannNeighbourhoods(scenes);
  return bench::runInterleaved(argc, argv);
}
